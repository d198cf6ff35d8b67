"""Save a picture twice, for light and for dark pages: ``NAME.png`` and ``NAME-dark.png``."""

from collections.abc import Callable
from io import BytesIO
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure
from PIL import Image

from rigid.drawing.colours import DARK_STYLE

FOLDER = Path(__file__).parent


def save_twins(name: str, draw: Callable[[], Figure], folder: Path = FOLDER) -> None:
    """Write the two pictures of a figure, which ``draw`` draws."""
    for suffix, style in (("", {}), ("-dark", DARK_STYLE)):
        with rc_context(style):
            content = BytesIO()
            draw().savefig(content, format="png", dpi=150)
        # With 256 colours it has a third of the size.
        picture = Image.open(content).convert("RGB").quantize(256, dither=Image.Dither.NONE)
        picture.save(folder / f"{name}{suffix}.png", optimize=True)
