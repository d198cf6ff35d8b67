"""Draw the figure of ``docs/how_it_works.md``: ``python docs/images/how_it_works.py``."""

from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

THREADS = ("#4c78a8", "#f2a65a")
QUIET = "#e8e8e8"
EDGE = "#555555"


def samples(ax: Axes) -> None:
    """Pixels, their samples in one row, a call, and its blocks on two threads."""
    ax.set_title("1  A map is a row of samples, cut into calls and blocks", loc="left")
    for pixel in range(8):
        ax.add_patch(Rectangle((4 * pixel, 2.2), 4, 0.8, fc="white", ec=EDGE, lw=0.8))
        ax.text(4 * pixel + 2, 2.6, f"pixel {pixel}", ha="center", va="center")
    for sample in range(32):
        ax.add_patch(Rectangle((sample, 1.5), 1, 0.5, fc=QUIET, ec="white", lw=0.8))
    ax.text(32.4, 2.6, "…", va="center")
    ax.text(32.4, 1.75, "samples, pixel by pixel", va="center")
    for block, thread in enumerate((0, 1, 1, 0)):
        ax.add_patch(Rectangle((5 * block, 0.5), 5, 0.8, fc=THREADS[thread], ec="white", lw=1.5))
        ax.text(5 * block + 2.5, 0.9, f"block {block}", ha="center", va="center", color="white")
    ax.annotate("", (0, 0.2), (20, 0.2), arrowprops={"arrowstyle": "<->", "color": EDGE})
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
                ax.add_patch(Rectangle((lane, y), 0.92, 0.8, fc=QUIET, ec="none"))
    ax.add_patch(Rectangle((12, -0.1), 0.92, 9, fc="none", ec=THREADS[1], lw=2))
    ax.text(12.4, -0.35, "one lane = one body", ha="center", va="top", color="#b8661a")
    ax.add_patch(Rectangle((16, 7.9), 7.96, 1, fc=THREADS[0], alpha=0.35, ec=THREADS[0], lw=2))
    ax.text(32.6, 8.4, "one AVX-512 register = 8 lanes", va="center", color=THREADS[0])
    ax.text(32.6, 6.9, "(AVX2: 4 lanes; plain code: 1)", va="center", color=THREADS[0])
    ax.set(xlim=(-5, 49), ylim=(-1.4, 9.4))


def steps(ax: Axes) -> None:
    """Lanes over blocks of steps: samples end between blocks, and lanes are refilled there."""
    ax.set_title(
        "3  A kernel advances all lanes by 16 steps; then finished lanes get the next sample",
        loc="left",
    )
    lengths = ((5, 3, 2), (2, 6, 2), (8, 2), (1, 4, 5), (3, 3, 4))
    for lane, runs in enumerate(lengths):
        begin = 0
        for number, run in enumerate(runs):
            box = Rectangle(
                (begin + 0.03, -lane), run - 0.06, 0.75, fc=THREADS[(lane + number) % 2]
            )
            ax.add_patch(box)
            if number + 1 < len(runs):
                ax.plot(begin + run, 0.375 - lane, "o", mfc="white", mec="black", ms=6, zorder=3)
            begin += run
        ax.text(-0.2, 0.375 - lane, f"lane {lane}", ha="right", va="center")
    for edge in range(11):
        ax.axvline(edge, color=EDGE, lw=0.6, ls=":")
    ax.annotate("", (2, 1.05), (3, 1.05), arrowprops={"arrowstyle": "<->", "color": EDGE})
    ax.text(2.5, 1.15, "16 steps", ha="center", va="bottom")
    ax.plot(10.35, 0.375, "o", mfc="white", mec="black", ms=6)
    ax.text(10.6, 0.375, "decided, or at the horizon:\nthe lane takes the next sample", va="center")
    ax.text(
        10.6, -1.9, "one bar = one sample\n(its bits do not depend on\nits neighbours)", va="center"
    )
    ax.set(xlim=(-1.2, 14.6), ylim=(-4.3, 1.7))


def main() -> None:
    """Write the figure beside this file."""
    with rc_context({"svg.hashsalt": "rigid", "font.size": 9}):
        figure = Figure(figsize=(9.2, 8.4))
        axes = figure.subplots(3, 1, height_ratios=(1.0, 1.6, 1.5))
        for draw, ax in zip((samples, group, steps), axes, strict=True):
            draw(ax)
            ax.axis("off")
        figure.tight_layout()
        figure.savefig(Path(__file__).with_suffix(".svg"), metadata={"Date": None})


if __name__ == "__main__":
    main()
