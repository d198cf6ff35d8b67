"""Draw the figure of ``docs/how_it_works.md``: ``python docs/images/how_it_works.py``."""

from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from rigid.drawing.colours import FAINT, HUES, NEUTRAL, on_ground

THREADS = (HUES["blue"], HUES["vermilion"])


def box(ax: Axes, x: float, y: float, wide: float, high: float, face: str, **style: Any) -> None:
    """A filled rectangle with an edge in the colour of the ground."""
    given = {"fc": on_ground(ax, face), "ec": ax.figure.get_facecolor()} | style
    ax.add_patch(Rectangle((x, y), wide, high, **given))


def measure(ax: Axes, left: float, right: float, y: float) -> None:
    """An arrow with two heads."""
    style = {"arrowstyle": "<->", "color": on_ground(ax, NEUTRAL)}
    ax.annotate("", (left, y), (right, y), arrowprops=style)


def samples(ax: Axes) -> None:
    """Pixels, their samples in one row, a call, and its blocks on two threads."""
    ax.set_title("1  A map is a row of samples, cut into calls and blocks", loc="left")
    for pixel in range(8):
        box(ax, 4 * pixel, 2.2, 4, 0.8, NEUTRAL, fill=False, ec=on_ground(ax, NEUTRAL), lw=0.8)
        ax.text(4 * pixel + 2, 2.6, f"pixel {pixel}", ha="center", va="center")
    for sample in range(32):
        box(ax, sample, 1.5, 1, 0.5, FAINT, alpha=0.4, lw=0.8)
    ax.text(32.4, 2.6, "…", va="center")
    ax.text(32.4, 1.75, "samples, pixel by pixel", va="center")
    for block, thread in enumerate((0, 1, 1, 0)):
        box(ax, 5 * block, 0.5, 5, 0.8, THREADS[thread], lw=1.5)
        ink = ax.figure.get_facecolor()
        ax.text(5 * block + 2.5, 0.9, f"block {block}", ha="center", va="center", color=ink)
    measure(ax, 0, 20, 0.2)
    ax.text(
        10,
        -0.05,
        "call: about 0.3 s of work; then Python shows the progress",
        ha="center",
        va="top",
    )
    ax.text(20.6, 0.9, "at most 1024 samples each; a free thread takes the next block", va="center")
    ax.set(xlim=(-0.5, 44), ylim=(-0.6, 3.2))


def group(ax: Axes) -> None:
    """Rows of variables, columns of lanes, and a register of eight lanes."""
    ax.set_title(
        "2  A group holds 32 bodies: a row for each variable, a lane for each body", loc="left"
    )
    rows = ("omega 1", "omega 2", "omega 3", "gamma 1", "…", "moment 1", "…", "step", "step count")
    for k, name in enumerate(rows):
        y = len(rows) - 1 - k
        ax.text(-0.4, y + 0.4, name, ha="right", va="center")
        if name != "…":
            for lane in range(32):
                box(ax, lane, y, 0.92, 0.8, FAINT, alpha=0.4)
    first, second = (on_ground(ax, ink) for ink in THREADS)
    box(ax, 12, -0.1, 0.92, 9, THREADS[1], fill=False, ec=second, lw=2)
    ax.text(12.4, -0.35, "one lane = one body", ha="center", va="top", color=second)
    box(ax, 16, 7.9, 7.96, 1, THREADS[0], alpha=0.35, ec=first, lw=2)
    ax.text(32.6, 8.4, "one AVX-512 register = 8 lanes", va="center", color=first)
    ax.text(32.6, 6.9, "(AVX2: 4 lanes; plain code: 1)", va="center", color=first)
    ax.set(xlim=(-5, 49), ylim=(-1.4, 9.4))


def steps(ax: Axes) -> None:
    """Lanes over blocks of steps: samples end between blocks, and lanes are refilled there."""
    ax.set_title(
        "3  A kernel advances all lanes by 16 steps; then finished lanes get the next sample",
        loc="left",
    )
    ink = on_ground(ax, HUES["black"])
    dot = {"mfc": ax.figure.get_facecolor(), "mec": ink, "ms": 6, "zorder": 3}
    lengths = ((5, 3, 2), (2, 6, 2), (8, 2), (1, 4, 5), (3, 3, 4))
    for lane, runs in enumerate(lengths):
        begin = 0
        for number, run in enumerate(runs):
            box(ax, begin + 0.03, -lane, run - 0.06, 0.75, THREADS[(lane + number) % 2], lw=0.0)
            if number + 1 < len(runs):
                ax.plot(begin + run, 0.375 - lane, "o", **dot)
            begin += run
        ax.text(-0.2, 0.375 - lane, f"lane {lane}", ha="right", va="center")
    for edge in range(11):
        ax.axvline(edge, color=on_ground(ax, NEUTRAL), lw=0.6, ls=":")
    measure(ax, 2, 3, 1.05)
    ax.text(2.5, 1.15, "16 steps", ha="center", va="bottom")
    ax.plot(10.35, 0.375, "o", **dot)
    ax.text(10.6, 0.375, "decided, or at the horizon:\nthe lane takes the next sample", va="center")
    ax.text(
        10.6, -1.9, "one bar = one sample\n(its bits do not depend on\nits neighbours)", va="center"
    )
    ax.set(xlim=(-1.2, 14.6), ylim=(-4.3, 1.7))


def main() -> None:
    """Write the figure beside this file; the style of the site inverts it on dark pages."""
    with rc_context({"svg.hashsalt": "rigid", "font.size": 9}):
        figure = Figure(figsize=(9.2, 8.4))
        axes = figure.subplots(3, 1, height_ratios=(1.0, 1.6, 1.5))
        for draw, ax in zip((samples, group, steps), axes, strict=True):
            draw(ax)
            ax.axis("off")
        figure.tight_layout()
        target = Path(__file__).with_name("how_it_works.svg")
        figure.savefig(target, metadata={"Date": None})


if __name__ == "__main__":
    main()
