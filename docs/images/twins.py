"""Save a picture twice, for light and for dark pages: ``NAME.png`` and ``NAME-dark.png``.

``python docs/images/twins.py docs/reports/*.png`` makes the dark twins of pictures whose numbers
are not kept, such as reports: light becomes dark, and the hues stay.
"""

import sys
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

from rigid.figures.colours import DARK_STYLE

FOLDER = Path(__file__).parent


def save_twins(name: str, draw: Callable[[], Figure], folder: Path = FOLDER) -> None:
    """Write the two pictures of a figure, which ``draw`` draws."""
    for suffix, style in (("", {}), ("-dark", DARK_STYLE)):
        with rc_context(style):
            content = BytesIO()
            draw().savefig(content, format="png", dpi=150)
        _save(Image.open(content).convert("RGB"), folder / f"{name}{suffix}.png")


def save_dark_twin(path: Path) -> None:
    """Write the dark twin of a picture: white becomes the dark ground, and black nearly white."""
    light = Image.open(path).convert("RGB")
    rgb = np.asarray(light) / 255.0
    # The lightness of each colour, in the sense of HSL, becomes one less it.
    middle = 0.5 * (rgb.max(axis=-1, keepdims=True) + rgb.min(axis=-1, keepdims=True))
    turned = np.clip(rgb + 1.0 - 2.0 * middle, 0.0, 1.0)
    ground = np.array(to_rgb(DARK_STYLE["figure.facecolor"]))
    dark = ground + (0.9 - ground) * turned
    _save(Image.fromarray(np.uint8(np.round(255.0 * dark))), path.with_stem(f"{path.stem}-dark"))
    _save(light, path)


def _save(picture: Image.Image, path: Path) -> None:
    """Write a picture with 256 colours, a third of its size."""
    picture.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    for given in map(Path, sys.argv[1:]):
        if not given.stem.endswith("-dark"):
            save_dark_twin(given)
