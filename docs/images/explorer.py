"""Take the two pictures of the explorer: ``python docs/images/explorer.py``; needs Playwright.

The page is the one that readers try, with a top a little below the bound of the sleeping top.
"""

import sys
import tempfile
from io import BytesIO
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "docs"), str(ROOT / "tests/shared")]

from generated_pages import write_explorer  # noqa: E402
from twins import FOLDER  # noqa: E402

from browsers import Opened, chromium  # noqa: E402

SHOWN = "#pixel=18,19&body=12"
FRAME = 0.21  # of the film: the top is near its largest tilt


def main() -> None:
    """Write ``explorer.png`` and ``explorer-dark.png``."""
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        page = Path(folder) / "explorer.html"
        write_explorer(page)
        for suffix, scheme in (("", "light"), ("-dark", "dark")):
            opened = Opened(browser, page, address=SHOWN, width=1100, height=680, scheme=scheme)
            opened.page.wait_for_selector("canvas.stage")
            opened.page.evaluate(f"explorer.player.seek({FRAME} * explorer.player.slider.max | 0)")
            opened.settle()
            picture = Image.open(BytesIO(opened.page.screenshot())).convert("RGB")
            few = picture.quantize(256, dither=Image.Dither.NONE)
            few.save(FOLDER / f"explorer{suffix}.png", optimize=True)
            opened.close()


if __name__ == "__main__":
    main()
