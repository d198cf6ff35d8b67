"""Draw the pictures of the guides: ``python docs/images/guides.py [NAME ...]``.

Each function draws the picture of its name from what the code of its page computes before it.
Without names all are drawn, in half a minute.
"""

import doctest
import os
import re
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from twins import save_twins

import rigid
from rigid.drawing.colours import CLASSES, FACE, FAINT, HUES, NEUTRAL, SHARE_MAP, SURFACE, on_ground

RATES = tuple(HUES[name] for name in ("blue", "green", "vermilion"))
DOCS = Path(__file__).parents[1]


@cache
def computed(page: str, until: str) -> dict[str, Any]:
    """The names that the code of a page defines before a text of the page."""
    before, found, _ = (DOCS / page).read_text(encoding="utf-8").partition(until)
    assert found, f"{page} has no {until}"
    names: dict[str, Any] = {"__name__": page}
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for block in re.findall(r"^```python\n(.*?)^```", before, re.MULTILINE | re.DOTALL):
                code = block
                if ">>>" in block:
                    examples = doctest.DocTestParser().get_examples(block)
                    code = "".join(example.source for example in examples)
                exec(compile(code, page, "exec"), names)
        finally:
            os.chdir(here)
            plt.close("all")
    return names


def blank(height: float, panels: int = 1) -> tuple[Figure, list[Axes]]:
    """A figure 8 inches wide with panels side by side."""
    figure = Figure(figsize=(8.0, height), layout="constrained")
    return figure, [figure.add_subplot(1, panels, 1 + k) for k in range(panels)]


def lines_of(ax: Axes, t: NDArray[np.float64], values: NDArray[np.float64], name: str) -> None:
    """Three components over time, named at the right end."""
    for k, (line, colour) in enumerate(zip(values.T, RATES, strict=True), start=1):
        ax.plot(t, line, color=on_ground(ax, colour), linewidth=1.4, label=f"${name}_{k}$")


def maps_steps() -> Figure:
    """The bodies of a pixel, their share, and the map."""
    names = computed("maps.md", "## Look at one body again")
    result, (row, column) = names["result"], names["pixel"]
    figure, (bodies, share, picture) = blank(3.4, 3)
    for sample in range(24):
        replay = result.replay((row, column), sample, t=np.linspace(0.0, 40.0, 401))
        word = "regular" if replay.outcome == "stable" else "chaotic"
        colour = on_ground(bodies, CLASSES[word])
        tilt = np.arccos(np.clip(replay.run.gamma[:, 2], -1.0, 1.0))
        bodies.plot(replay.run.t, tilt, color=colour, linewidth=0.5)
    bodies.axhline(0.5, color=on_ground(bodies, HUES["black"]), linewidth=1.2, linestyle="dashed")
    bodies.set(xlabel="t (s)", ylabel="tilt (rad)", xlim=(0.0, 20.0), ylim=(0.0, None))
    bodies.set_title("1  The bodies of a pixel", loc="left", fontsize="medium")
    values = np.array(
        [axis.values[k] for axis, k in zip(result.spec.axes, (column, row), strict=True)]
    )
    stable = int(result.stable[row, column])
    for colour, count, left, word in (
        (CLASSES["regular"], stable, 0, "stable"),
        (CLASSES["chaotic"], 64 - stable, stable, "unstable"),
    ):
        share.bar(["64 bodies"], count, bottom=left, color=on_ground(share, colour), width=0.35)
        share.text(0.25, left + 0.5 * count, f"{count}\n{word}", va="center")
    low, high = 64.0 * result.lower[row, column], 64.0 * result.upper[row, column]
    share.errorbar(
        [0.0],
        [stable],
        yerr=[[stable - low], [high - stable]],
        color=on_ground(share, HUES["black"]),
        capsize=5.0,
    )
    words = f"share {stable / 64:.2f}\n95 %: {low / 64:.2f}\nto {high / 64:.2f}"
    share.text(-0.25, stable, words, ha="right", va="center")
    share.set(xlim=(-1.8, 1.5), ylim=(0.0, 64.0), yticks=[0, 16, 32, 48, 64])
    share.set_title("2  Their share", loc="left", fontsize="medium")
    result.plot(ax=picture)
    picture.set_ylabel("push (rad)")
    picture.set_title("3  The map", loc="left", fontsize="medium")
    picture.plot(*values, "s", mfc="none", mec="white", ms=9.0, mew=2.5)
    picture.plot(*values, "s", mfc="none", mec="black", ms=9.0, mew=1.0)
    legend = picture.get_legend()
    if legend is not None:
        legend.remove()
    return figure


def reliability() -> Figure:
    """True errors against estimated errors, of tops whose motion has a closed form."""
    generator = np.random.default_rng(2026)
    figure, (ax,) = blank(5.0)
    figure.set_size_inches(6.0, 5.0)
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    inks = ("blue", "vermilion", "green", "purple")
    beyond = bodies = 0
    for method, ink in zip(("dop853", "rk4", "taylor16", "pmlf6"), inks, strict=True):
        true, said = [], []
        for _ in range(60):
            omega = generator.normal(size=3) * np.array([0.5, 0.5, 4.0])
            attitude = generator.normal(size=4)
            attitude /= np.linalg.norm(attitude)
            step = float(10.0 ** generator.uniform(-2.0, -0.3))
            t = [2.0, 5.0, 10.0]
            run = rigid.simulate(top, omega, attitude, t=t, method=method, step=step)
            exact = rigid.simulate(top, omega, attitude, t=t, method="exact")
            rates = np.linalg.norm(run.omega - exact.omega, axis=-1).max()
            rates /= np.linalg.norm(exact.omega, axis=-1).max()
            turned = (run.rotation() * exact.rotation().inv()).magnitude().max()
            true.append(max(float(rates), float(turned), 1e-16))
            said.append(float(run.error))
        beyond += int((np.array(true) > np.array(said)).sum())
        bodies += len(true)
        ax.plot(said, true, "o", color=on_ground(ax, HUES[ink]), ms=3.5, label=method)
    ends = np.array([1e-15, 3.0])
    ax.plot(ends, ends, color=on_ground(ax, NEUTRAL), linewidth=1.0)
    ax.fill_between(ends, ends, 10.0, color=on_ground(ax, FAINT), alpha=0.25, linewidth=0.0)
    ax.text(1e-10, 1e-5, "larger than estimated", rotation=0.0, ha="center")
    ax.set(xscale="log", yscale="log", xlim=ends, ylim=(1e-16, 3.0))
    ax.set(xlabel="estimated error", ylabel="true error, from the closed form")
    words = "none" if beyond == 0 else str(beyond)
    ax.set_title(f"{words} of {bodies} errors is larger than estimated", fontsize="medium")
    ax.legend(loc="lower right")
    return figure


def satellites() -> Figure:
    """A spin about the long axis ends in a flat spin."""
    run = computed("forces.md", "](images/satellites.png)")["run"]
    figure, (velocity, angle) = blank(3.4, 2)
    lines_of(velocity, run.t, run.omega, r"\omega")
    velocity.set(xlabel="t (s)", ylabel="angular velocity (rad/s)")
    velocity.legend(loc="upper right")
    momentum = run.momentum()
    tilt = np.degrees(np.arccos(np.abs(momentum[:, 0]) / np.linalg.norm(momentum, axis=1)))
    angle.plot(run.t, tilt, color=on_ground(angle, RATES[0]), linewidth=1.2)
    angle.set(xlabel="t (s)", ylabel="angle of the long axis from L (°)", yticks=[0, 30, 60, 90])
    return figure


def torque_and_damping() -> Figure:
    """A motor brings a wheel up to speed for five seconds; then friction slows it down."""
    run = computed("forces.md", "](images/torque-and-damping.png)")["run"]
    figure, (velocity, energy) = blank(3.4, 2)
    lines_of(velocity, run.t, run.omega, r"\omega")
    velocity.axvspan(0.0, 5.0, color=on_ground(velocity, FAINT), alpha=0.3, linewidth=0.0)
    velocity.text(5.5, velocity.get_ylim()[1] * 0.92, "motor on for 5 s")
    velocity.set(xlabel="t (s)", ylabel="angular velocity (rad/s)")
    velocity.legend(loc="center right")
    for values, ink, style, label in (
        (run.energy(), "blue", "solid", "energy $E$"),
        (run.work, "vermilion", "solid", "work $W$"),
        (run.energy() - run.work, "black", "dashed", "$E - W$, constant"),
    ):
        colour = on_ground(energy, HUES[ink])
        energy.plot(run.t, values, color=colour, linestyle=style, label=label)
    energy.set(xlabel="t (s)", ylabel="(J)")
    energy.legend(loc="upper right")
    return figure


def events() -> Figure:
    """Two kinds of events of a box that turns over."""
    names = computed("runs.md", "](images/events.png)")
    t = np.linspace(0.0, 60.0, 1201)
    curve = names["run"].at(t)
    figure, (ax,) = blank(3.2)
    for k, ink in ((0, "blue"), (1, "green")):
        ax.plot(t, curve.omega[:, k], color=on_ground(ax, HUES[ink]), label=rf"$\omega_{k + 1}$")
    ax.axhline(0.0, color=on_ground(ax, FAINT), linewidth=0.8)
    for found, k, mark, ink, words in (
        (names["flips"], 1, "o", "vermilion", 'crosses("omega2")'),
        (names["largest"], 0, "^", "purple", 'turns("omega1", -1)'),
    ):
        colour = on_ground(ax, HUES[ink])
        ax.plot(found.t, found.omega[:, k], mark, color=colour, label=words, zorder=4, ms=7.0)
    for time in names["flips"].t:
        ax.annotate(f"{time:.2f} s", (time, 0.0), (6, 6), textcoords="offset points")
    ax.set(xlabel="t (s)", ylabel="angular velocity (rad/s)", ylim=(-1.75, 1.15))
    ax.legend(loc="lower center", ncols=4)
    return figure


def results() -> Figure:
    """Angular velocity in the body and angular momentum in space, of a thrown phone."""
    names = computed("runs.md", "](images/results.png)")
    run, momentum = names["run"], names["in_space"]
    figure, (velocity, constant) = blank(3.4, 2)
    lines_of(velocity, run.t, run.omega, r"\omega")
    velocity.set(xlabel="t (s)", ylabel="angular velocity (rad/s)", xlim=(0.0, 2.0))
    velocity.set_title("run.omega", loc="left", fontsize="medium", family="monospace")
    velocity.legend(loc="lower left")
    lines_of(constant, run.t, momentum, "L")
    constant.set(xlabel="t (s)", ylabel="angular momentum (kg m²/s)", xlim=(0.0, 2.0))
    constant.set_title('run.momentum("space")', loc="left", fontsize="medium", family="monospace")
    constant.legend(loc="center left")
    return figure


def measurements() -> Figure:
    """A fit of the moments to a measured motion, and what remains."""
    names = computed("bodies.md", "](images/measurements.png)")
    t, measured, found = (names[name] for name in ("t", "measured", "found"))
    fine = np.linspace(0.0, 60.0, 1201)
    curve = rigid.simulate(found.scene, found.omega, t=fine)
    left = measured - rigid.simulate(found.scene, found.omega, t=t).omega
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
    for k, colour in enumerate(RATES):
        ink = on_ground(above, colour)
        above.plot(t, measured[:, k], ".", color=ink, ms=2.5)
        above.plot(fine, curve.omega[:, k], color=ink, linewidth=1.0, label=rf"$\omega_{k + 1}$")
        below.plot(t, left[:, k], ".", color=ink, ms=2.5)
    words = ", ".join(
        f"{name} = {value:.4f} ± {std:.4f}"
        for name, value, std in zip(found.names[:2], found.values[:2], found.std[:2], strict=True)
    )
    above.set_title(f"measured (dots) and fitted (lines): {words}", loc="left", fontsize="medium")
    above.set(ylabel="angular velocity (rad/s)", ylim=(-1.5, 1.1))
    above.legend(loc="lower right", ncols=3)
    for sigma in (-0.01, 0.01):
        below.axhline(sigma, color=on_ground(below, NEUTRAL), linewidth=0.8, linestyle="dashed")
    below.set(xlabel="t (s)", ylabel="remains (rad/s)")
    return figure


def own_bodies() -> Figure:
    """A bracket of two plates: its centre of mass and its principal axes."""
    names = computed("bodies.md", "](images/own-bodies.png)")
    whole, body, axes = (names[name] for name in ("whole", "bracket", "axes"))
    figure, (ax,) = blank(4.4)
    for corner, width, height in (((0.0, 0.0), 0.12, 0.01), ((0.0, 0.01), 0.01, 0.09)):
        ink = on_ground(ax, NEUTRAL)
        ax.add_patch(Rectangle(corner, width, height, facecolor=FACE, alpha=0.5, edgecolor=ink))
    x, _, z = whole.centre
    for k, colour in enumerate(RATES):
        ink = on_ground(ax, colour)
        along = axes[:, k]
        words = f"axis {k + 1}: {1e6 * body.moments[k]:.0f} kg mm²"
        if abs(along[1]) > 0.9:
            ax.plot(x, z, "o", mfc="none", mec=ink, ms=16.0, mew=1.8)
            ax.annotate(words, (x, z), (14, -22), textcoords="offset points", color=ink)
            continue
        tip = 0.045 * along[[0, 2]] * (1.0 if along[2] > 0.0 else -1.0)
        ax.annotate(
            "",
            (x + tip[0], z + tip[1]),
            (x, z),
            arrowprops={"arrowstyle": "-|>", "color": ink, "lw": 2.0},
        )
        ax.annotate(words, (x + tip[0], z + tip[1]), (5, 3), textcoords="offset points", color=ink)
    ax.plot(x, z, "o", color=on_ground(ax, HUES["black"]), ms=5.0)
    ax.annotate("centre of mass", (x, z), (-12, -14), textcoords="offset points", ha="right")
    ax.set(xlabel="x (m)", ylabel="z (m)", xlim=(-0.03, 0.16), ylim=(-0.015, 0.11), aspect="equal")
    return figure


def chaos() -> Figure:
    """How a deviation vector grows in a regular and in a chaotic motion."""
    names = computed("chaos.md", "](images/chaos.png)")
    growth = names["growth"]
    figure, (ax,) = blank(3.4)
    for values, verdict in zip(growth.log_growth, growth.verdict.tolist(), strict=True):
        ink = on_ground(ax, CLASSES[verdict])
        ax.plot(growth.t, values, color=ink)
        place = (100.0, values[199])
        ax.annotate(verdict, place, (-8, 8), ha="right", textcoords="offset points", color=ink)
    ax.set(xlabel="t (s)", ylabel=r"logarithm of the growth, $\Lambda$", ylim=(0.0, None))
    return figure


def stop_at(share: float) -> Callable[[rigid.Progress], None]:
    """A progress callback that ends the call, as Ctrl-C does, once a share is done."""

    def show(progress: rigid.Progress) -> None:
        if progress.done >= share * progress.total:
            raise KeyboardInterrupt

    return show


@cache
def stopped_maps() -> list[rigid.StabilityMap]:
    """The map of the page when it was stopped twice and went on, after each stop and at its end.

    Its closed form is so fast that a stop would come too late: here it is integrated.
    """
    spec = computed("large_maps.md", "](images/running-maps.png)")["result"].spec
    with tempfile.TemporaryDirectory() as folder:
        return [
            rigid.stability_map(
                spec.replace(method="rk4"),
                threads=1,
                store=Path(folder) / "run.rigid",
                progress=stop_at(share),
                partial=True,
            )
            for share in (0.06, 0.25, 2.0)
        ]


def running_maps() -> Figure:
    """What a stored map shows after two stops and at its end."""
    figure = Figure(figsize=(8.0, 2.9), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True)
    for ax, state in zip(panels, stopped_maps(), strict=True):
        width, noise = (axis.values for axis in state.spec.axes)
        shown = ax.pcolormesh(
            1e3 * np.array(width),
            noise,
            state.share,
            vmin=0.0,
            vmax=1.0,
            cmap=SHARE_MAP,
            shading="nearest",
        )
        # Light on dark pages too: dark blue is no colour of a dark ground.
        ax.set(yscale="log", xlabel="side b (mm)", facecolor=SURFACE)
        known = 100.0 * np.mean(~np.isnan(state.share))
        ax.set_title(f"{known:.0f} % of the pixels", fontsize="medium")
    panels[0].set_ylabel("perturbation (rad/s)")
    figure.colorbar(shown, ax=panels, label="share without a flip", pad=0.01)
    return figure


PICTURES: dict[str, Callable[[], Figure]] = {
    draw.__name__.replace("_", "-"): draw
    for draw in (
        *(maps_steps, reliability, satellites, torque_and_damping),
        *(events, results, measurements, own_bodies, chaos, running_maps),
    )
}


def main(names: list[str]) -> None:
    """Write these pictures beside this file."""
    for name in names or PICTURES:
        save_twins(name, PICTURES[name])


if __name__ == "__main__":
    main(sys.argv[1:])
