"""Films as moving pictures: GIF, WebP and MP4."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._checks.progress import ProgressOption, reporting
from ..drawing.colours import NEUTRAL
from ..drawing.figure import new_figure
from .film import Film
from .raster import frame_picture

if TYPE_CHECKING:
    from PIL.Image import Image


SUFFIXES = (".gif", ".webp", ".mp4")

LONGEST = 655.0
"""Longest time of a GIF frame (s), a limit of the format."""

Ints = NDArray[np.int64]


def moving_picture(
    films: Sequence[Film], suffix: str, *, fps: float, size: int, progress: ProgressOption
) -> bytes:
    """The bytes of a picture that shows the films side by side."""
    shown = films[0].shown
    due = np.append(0.0, np.cumsum(shown))
    if suffix == ".mp4":
        command = _encoder()
        frames = np.searchsorted(due[:-1], np.arange(0.0, due[-1], 1.0 / fps) + 1e-9, "right") - 1
        return _encoded(command, _images(films, frames, size, progress), fps, size * len(films))
    frames = _thinned(due, fps)
    hundredths = np.diff(np.rint(100.0 * due[np.append(frames, len(shown))])).astype(np.int64)
    if (hundredths > 100.0 * LONGEST).any():
        k = int(frames[hundredths.argmax()])
        raise ValueError(
            f"t: frame {k} of a picture would be shown for {hundredths.max() / 100.0:g} s: must be "
            f"at most {LONGEST:g} s; choose other times or another speed"
        )
    images = _images(films, frames, size, progress)
    content = BytesIO()
    options = {"save_all": True, "duration": (10 * hundredths).tolist(), "loop": 0}
    if suffix == ".gif":
        images = [_few_colours(image) for image in images]
        images[0].save(content, "GIF", append_images=images[1:], **options)
    else:
        images[0].save(content, "WEBP", append_images=images[1:], quality=85, method=2, **options)
    return content.getvalue()


def _thinned(due: NDArray[np.float64], fps: float) -> Ints:
    """The frames that follow one another by no less than ``1 / fps``."""
    kept = [0]
    for k in range(1, len(due) - 1):
        room = min(due[k] - due[kept[-1]], due[-1] - due[k])
        if room >= (1.0 - 1e-6) / fps:
            kept.append(k)
    return np.array(kept)


def _images(
    films: Sequence[Film], frames: Ints, size: int, progress: ProgressOption
) -> list[Image]:
    """The pictures of the frames; equal neighbours are drawn once."""
    new_figure()  # a picture needs Matplotlib's font and Pillow, which Matplotlib installs
    from matplotlib.font_manager import findfont
    from PIL import Image, ImageDraw, ImageFont

    font = findfont("DejaVu Sans")
    large, small = (ImageFont.truetype(font, round(share * size / 480)) for share in (15, 11))
    images: list[Image.Image] = []
    with reporting(progress, len(frames), unit=" frames") as report:
        for done, k in enumerate(frames.tolist(), 1):
            if done > 1 and k == frames[done - 2]:
                images.append(images[-1])
                continue
            image = Image.new("RGB", (size * len(films), size), "white")
            for place, film in enumerate(films):
                pixels, names = frame_picture(film, k, size)
                image.paste(Image.fromarray(pixels), (place * size, 0))
                pen = ImageDraw.Draw(image)
                for part, (x, y) in names:
                    at, ink = (place * size + x, y), part.colours[0]
                    pen.text(at, part.label, ink, large, "mm", stroke_width=2, stroke_fill="white")
            pen = ImageDraw.Draw(image)
            pen.text((8, 6), fill(films[0].story, 72 * len(films)), NEUTRAL, small)
            clock = f"t = {films[0].t[k]:.{films[0].digits}f} s"
            pen.text((8, size - 8), clock, NEUTRAL, small, "ls")
            images.append(image)
            report(done)
    return images


def _few_colours(image: Image) -> Image:
    """The picture with 256 colours: white, 63 for all hues, 192 for the shades of large faces."""
    import PIL.Image

    none = PIL.Image.Dither.NONE
    hues = image.quantize(63, PIL.Image.Quantize.FASTOCTREE, dither=none).getpalette() or []
    shades = image.quantize(192, PIL.Image.Quantize.MEDIANCUT, dither=none).getpalette() or []
    palette = PIL.Image.new("P", (1, 1))
    palette.putpalette(([255] * 3 + hues + shades)[: 3 * 256])
    return image.quantize(palette=palette, dither=none)


def _encoder() -> str:
    """The command ffmpeg."""
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        import imageio_ffmpeg
    except ImportError:
        raise ImportError(
            "a video needs ffmpeg: install it, or pip install imageio-ffmpeg"
        ) from None
    command: str = imageio_ffmpeg.get_ffmpeg_exe()
    return command


def _encoded(command: str, images: Sequence[Image], fps: float, width: int) -> bytes:
    """The images as H.264 with the pixels that every player knows."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "film.mp4"
        height = images[0].height
        given = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps:g} -i -".split()
        wanted = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-pix_fmt", "yuv420p"]
        done = subprocess.run(
            [command, "-loglevel", "error", *given, *wanted, str(target)],
            input=b"".join(image.tobytes() for image in images),
            capture_output=True,
            check=False,
        )
        if done.returncode:
            raise OSError(f"{command} failed: {done.stderr.decode(errors='replace').strip()}")
        return target.read_bytes()
