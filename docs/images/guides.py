"""Draw the pictures of the guides: ``python docs/images/guides.py [NAME ...]``.

Each function draws the picture of its name from a short run of the library. Without names all are
drawn, in some minutes.
"""

import ctypes
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from twins import save_twins

import rigid
from rigid.drawing.colours import CLASSES, FACE, FAINT, HUES, NEUTRAL, SHARE_MAP, SURFACE, on_ground

RATES = tuple(HUES[name] for name in ("blue", "green", "vermilion"))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
LEANING = [0.9, 0.3, 0.2, 0.1]


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
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        axes={"I2/I1": np.linspace(1.05, 1.95, 37), "noise": np.geomspace(1e-3, 0.1, 25)},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(1e-2)),
        stable=rigid.no_flip(),
        t_end=20.0,
        samples=64,
        rng=2026,
        progress=False,
    )
    row, column = 9, 26
    figure, (bodies, share, picture) = blank(3.4, 3)
    for sample in range(24):
        replay = result.replay((row, column), sample, t=np.linspace(0.0, 20.0, 201))
        word = "regular" if replay.outcome == "stable" else "chaotic"
        colour = on_ground(bodies, CLASSES[word])
        bodies.plot(replay.run.t, replay.run.omega[:, 1], color=colour, linewidth=0.7)
    bodies.axhline(0.0, color=on_ground(bodies, NEUTRAL), linewidth=0.8, linestyle="dashed")
    bodies.set(xlabel="t (s)", ylabel=r"rate about axis 2 (rad/s)")
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
    body = rigid.Body((0.3, 1.7, 2.0))
    debris = rigid.FreeBody(body, dissipation=rigid.EnergySink(0.01))
    t = np.linspace(0.0, 3000.0, 6001)
    run = rigid.simulate(debris, [3.0, 0.02, 0.01], t=t)
    figure, (rates, angle) = blank(3.4, 2)
    lines_of(rates, t, run.omega, r"\omega")
    rates.set(xlabel="t (s)", ylabel="rate in the body (rad/s)")
    rates.legend(loc="upper right")
    momentum = run.omega * np.array(body.moments)
    size = np.linalg.norm(momentum, axis=1)
    tilt = np.degrees(np.arccos(np.clip(np.abs(momentum[:, 0]) / size, 0.0, 1.0)))
    angle.plot(t, tilt, color=on_ground(angle, RATES[0]), linewidth=1.2)
    angle.set(xlabel="t (s)", ylabel="angle of the long axis from L (°)", yticks=[0, 30, 60, 90])
    return figure


def criteria() -> Figure:
    """The tilt of one top, two criteria, and what their joins make of them."""
    top = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
    attitude = rigid.rotations.euler_to_quaternion([0.0, 0.25, 0.0])
    t = np.linspace(0.0, 12.0, 1201)
    run = rigid.simulate(top, [0.0, 0.12, 3.6], attitude, t=t)
    tilt = np.arccos(np.clip(run.gamma[:, 2], -1.0, 1.0))
    spin = np.linalg.norm(run.omega, axis=1)
    low, limit = 0.6, float(np.quantile(spin, 0.88))
    first = {"a": t[np.argmax(tilt > low)], "b": t[np.argmax(spin > limit)]}
    figure = Figure(figsize=(8.0, 4.6), layout="constrained")
    above, middle, below = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 1.0, 0.9))
    blue = on_ground(above, HUES["blue"])
    for ax, values, line, words in (
        (above, tilt, low, "tilt (rad)"),
        (middle, spin, limit, "$|\\omega|$ (rad/s)"),
    ):
        ax.plot(t, values, color=blue)
        ax.axhline(line, color=on_ground(ax, HUES["vermilion"]), linestyle="dashed", linewidth=1.2)
        ax.set_ylabel(words)
    above.set_title(f"$a$: tilt_below({low:g})", loc="left", fontsize="medium")
    middle.set_title(f"$b$: ~spin_above({limit:.3g})", loc="left", fontsize="medium")
    rows = (
        ("a", first["a"]),
        ("b", first["b"]),
        ("a & b", min(first.values())),
        ("a | b", max(first.values())),
    )
    for place, (_, end) in enumerate(reversed(rows)):
        kept, left = (on_ground(below, CLASSES[word]) for word in ("regular", "chaotic"))
        below.add_patch(Rectangle((0.0, place - 0.3), end, 0.6, color=kept))
        below.add_patch(Rectangle((end, place - 0.3), t[-1] - end, 0.6, color=left))
        below.text(end, place, f" left at {end:.1f} s", color=figure.get_facecolor(), va="center")
    below.set(
        yticks=range(len(rows)), yticklabels=[name for name, _ in reversed(rows)], xlabel="t (s)"
    )
    below.set(ylim=(-0.5, len(rows) - 0.5), xlim=(0.0, t[-1]))
    return figure


def torque_and_damping() -> Figure:
    """A motor brings a wheel up to speed for five seconds; then friction slows it down."""
    motor = rigid.Torque.body([(0, 0, 2), (0, 0, 2), (0, 0, 0), (0, 0, 0)], times=[0, 5, 5, 60])
    wind = rigid.Torque.space((0.05, 0.0, 0.0))
    scene = rigid.FreeBody(
        rigid.Body((1.0, 1.0, 1.8)), torque=motor + wind, damping=(0.0, 0.0, 0.1)
    )
    t = np.linspace(0.0, 60.0, 1201)
    run = rigid.simulate(scene, [0.0, 0.0, 1.0], t=t, accuracy=1e-9)
    figure, (rates, energy) = blank(3.4, 2)
    lines_of(rates, t, run.omega, r"\omega")
    rates.axvspan(0.0, 5.0, color=on_ground(rates, FAINT), alpha=0.3, linewidth=0.0)
    rates.text(5.5, rates.get_ylim()[1] * 0.92, "motor on for 5 s")
    rates.set(xlabel="t (s)", ylabel="rate in the body (rad/s)")
    rates.legend(loc="center right")
    work = np.asarray(run.work)
    energy.plot(t, run.energy(), color=on_ground(energy, HUES["blue"]), label="energy $E$")
    energy.plot(t, work, color=on_ground(energy, HUES["vermilion"]), label="work $W$")
    energy.plot(
        t,
        run.energy() - work,
        color=on_ground(energy, HUES["black"]),
        linestyle="dashed",
        label="$E - W$, constant",
    )
    energy.set(xlabel="t (s)", ylabel="(J)")
    energy.legend(loc="upper right")
    return figure


@cache
def detumbled() -> rigid.StabilityMap:
    """Satellites that a torque in Python brakes, which takes two minutes."""
    doubles = ctypes.POINTER(ctypes.c_double)

    @ctypes.CFUNCTYPE(None, ctypes.c_double, doubles, doubles, doubles, doubles)
    def brake(t, omega, attitude, data, torque):  # type: ignore[no-untyped-def]
        for k in range(3):
            torque[k] = max(-data[1], min(data[1], -data[0] * omega[k]))

    def scene(gain: NDArray[np.float64]) -> rigid.FreeBody:
        data = np.stack([gain, np.full_like(gain, 2e-3)], -1)
        torque = rigid.Torque.call(brake, data, fastest=0.5)
        return rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), torque=torque)

    return rigid.stability_map(
        scene,
        axes={"gain": np.linspace(2e-3, 3e-2, 12), "spin": np.linspace(0.05, 0.45, 12)},
        t_end=600.0,
        stable=~rigid.spin_above(0.01),
        start=rigid.Start(spin=0.2, axis=3),
        samples=1,
        rng=2026,
        progress=False,
    )


def detumbling() -> Figure:
    """Which satellites are slow after ten minutes, over the gain and the first rate."""
    figure, (ax,) = blank(4.6)
    detumbled().plot(ax=ax)
    # About axis 3 the rate falls linearly to 2e-3 / k, and from there on as exp(-k t / I3).
    gain = np.linspace(2e-3, 3e-2, 200)
    knee = np.maximum(2e-3 / gain, 0.01)
    rest = 600.0 - 2.0 / gain * np.log(knee / 0.01)
    fastest = np.where(rest > 0.0, knee + 1e-3 * rest, 0.01 * np.exp(0.5 * gain * 600.0))
    ax.plot(gain, fastest, color="black", linewidth=3.4)
    ax.plot(gain, fastest, color="white", linewidth=1.6, label="by hand")
    ax.set_ylim(0.032, 0.468)
    ax.set_title("Is the satellite slow after ten minutes?", loc="left", fontsize="medium")
    ax.set(xlabel="gain k (N m s)", ylabel="spin at the start (rad/s)")
    return figure


def events() -> Figure:
    """Two kinds of events of a box that turns over."""
    box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    t = np.linspace(0.0, 60.0, 1201)
    run = rigid.simulate(
        box,
        [0.01, 1.0, 0.01],
        t=t,
        events=[rigid.crosses("omega2"), rigid.turns("omega1", -1)],
    )
    figure, (ax,) = blank(3.2)
    for k, ink in ((0, "blue"), (1, "green")):
        ax.plot(t, run.omega[:, k], color=on_ground(ax, HUES[ink]), label=rf"$\omega_{k + 1}$")
    ax.axhline(0.0, color=on_ground(ax, FAINT), linewidth=0.8)
    flips, largest = run.events
    dots = {"ls": "", "zorder": 4, "ms": 7.0}
    ax.plot(
        flips.t,
        flips.omega[:, 1],
        "o",
        color=on_ground(ax, HUES["vermilion"]),
        label='crosses("omega2")',
        **dots,
    )
    ax.plot(
        largest.t,
        largest.omega[:, 0],
        "^",
        color=on_ground(ax, HUES["purple"]),
        label='turns("omega1", -1)',
        **dots,
    )
    for time in flips.t:
        ax.annotate(f"{time:.2f} s", (time, 0.0), (6, 6), textcoords="offset points")
    ax.set(xlabel="t (s)", ylabel="rate in the body (rad/s)")
    ax.set_ylim(-1.75, 1.15)
    ax.legend(loc="lower center", ncols=4)
    return figure


def results() -> Figure:
    """Rates in the body and the tip of an axis in space, of a thrown phone."""
    phone = rigid.Body.box(0.15, 0.07, 0.008, mass=0.2)
    run = rigid.simulate(phone, [0.05, 12.0, 0.05], t=np.linspace(0.0, 2.0, 801))
    figure, (rates, energy) = blank(3.4, 2)
    lines_of(rates, run.t, run.omega, r"\omega")
    rates.set(xlabel="t (s)", ylabel="rate in the body (rad/s)")
    rates.set_title("run.omega", loc="left", fontsize="medium", family="monospace")
    rates.legend(loc="lower left")
    momentum = run.momentum("space")
    lines_of(energy, run.t, momentum, "L")
    energy.set(xlabel="t (s)", ylabel="angular momentum in space (kg m²/s)")
    energy.set_title('run.momentum("space")', loc="left", fontsize="medium", family="monospace")
    energy.legend(loc="center left")
    return figure


def measurements() -> Figure:
    """A fit of the moments to measured rates, and what it leaves."""
    t = np.arange(600) / 10.0
    truth = rigid.simulate(rigid.Body((1.0, 1.5, 2.0)), [0.1, 1.0, 0.2], t=t)
    measured = truth.omega + 0.01 * np.random.default_rng(7).normal(size=truth.omega.shape)
    guess = rigid.Body((1.0, 1.4, 2.1))
    found = rigid.fit(guess, t, omega=measured, sigma=0.01, free=("I2/I1", "I3/I1", "omega"))
    ratios = found.values[:2]
    fine = np.linspace(0.0, 60.0, 1201)
    fitted = rigid.Body((1.0, *ratios.tolist()))
    start = found.values[2:5]
    curve = rigid.simulate(fitted, start, t=fine)
    left = measured - rigid.simulate(fitted, start, t=t).omega
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
    for k, colour in enumerate(RATES):
        ink = on_ground(above, colour)
        above.plot(t, measured[:, k], ".", color=ink, ms=2.5)
        above.plot(fine, curve.omega[:, k], color=ink, linewidth=1.0, label=rf"$\omega_{k + 1}$")
        below.plot(t, left[:, k], ".", color=ink, ms=2.5)
    words = ", ".join(
        f"{name} = {value:.4f} ± {std:.4f}"
        for name, value, std in zip(found.names[:2], ratios, found.std[:2], strict=True)
    )
    above.set_title(f"measured (dots) and fitted (lines): {words}", loc="left", fontsize="medium")
    above.set(ylabel="rate (rad/s)", ylim=(-1.5, 1.1))
    above.legend(loc="lower right", ncols=3)
    for sigma in (-0.01, 0.01):
        below.axhline(sigma, color=on_ground(below, NEUTRAL), linewidth=0.8, linestyle="dashed")
    below.set(xlabel="t (s)", ylabel="left over (rad/s)")
    return figure


def own_bodies() -> Figure:
    """A bracket of two plates: its centre of mass and its principal axes."""
    plates = (((0.12, 0.06, 0.01), (0.06, 0.0, 0.005)), ((0.01, 0.06, 0.09), (0.005, 0.0, 0.055)))
    parts = [
        rigid.solids.box(*sides, mass=2700.0 * float(np.prod(sides))).placed(centre)
        for sides, centre in plates
    ]
    whole = rigid.inertia.compose(parts)
    body, axes = rigid.Body.from_tensor(whole.tensor)
    figure, (ax,) = blank(4.4)
    for (a, _, c), (x, _, z) in plates:
        ax.add_patch(
            Rectangle(
                (x - 0.5 * a, z - 0.5 * c),
                a,
                c,
                facecolor=FACE,
                alpha=0.5,
                edgecolor=on_ground(ax, NEUTRAL),
            )
        )
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
    t = np.linspace(0.5, 100.0, 400)
    growth = rigid.lyapunov(TOP, [[0.3, 0.4, 1.0], [0.1, 0.0, 20.0]], LEANING, t=t)
    starts = np.array([[0.3, 0.4, 1.0], [0.3, 0.4, 1.0 + 1e-8]])
    close = np.linspace(0.0, 60.0, 1201)
    runs = rigid.simulate(TOP, starts, [LEANING, LEANING], t=close)
    apart = np.linalg.norm(runs.omega[1] - runs.omega[0], axis=-1)
    figure, (left, right) = blank(3.4, 2)
    for values, verdict in zip(growth.log_growth, growth.verdict.tolist(), strict=True):
        ink = on_ground(left, CLASSES[verdict])
        left.plot(t, values, color=ink, label=verdict)
    left.set(xlabel="t (s)", ylabel=r"logarithm of the growth, $\Lambda$", ylim=(0.0, None))
    left.set_title("growth of a small deviation", loc="left", fontsize="medium")
    left.legend(loc="upper left")
    right.semilogy(close, apart, color=on_ground(right, CLASSES["chaotic"]))
    right.set(xlabel="t (s)", ylabel="distance of the rates (rad/s)")
    right.set_title("two chaotic tops, 10⁻⁸ rad/s apart", loc="left", fontsize="medium")
    return figure


def stop_at(share: float) -> Callable[[rigid.Progress], None]:
    """A progress callback that ends the call, as Ctrl-C does, once a share is done."""

    def show(progress: rigid.Progress) -> None:
        if progress.done >= share * progress.total:
            raise KeyboardInterrupt

    return show


@cache
def stopped_maps() -> list[rigid.StabilityMap]:
    """A stored map that was stopped twice and went on, after each stop and at its end."""
    with tempfile.TemporaryDirectory() as folder:
        return [
            rigid.stability_map(
                rigid.Body.box(0.25, 0.08, 0.01, mass=0.3),
                axes={"b": np.linspace(0.012, 0.248, 80), "noise": np.geomspace(1e-3, 1.0, 60)},
                samples=256,
                t_end=1.0,
                stable=rigid.no_flip(),
                start=rigid.Start(spin=10.0, axis=2, noise=rigid.normal(1e-3)),
                method="rk4",
                rng=2026,
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
        *(maps_steps, reliability, satellites, criteria, torque_and_damping, detumbling),
        *(events, results, measurements, own_bodies, chaos, running_maps),
    )
}


def main(names: list[str]) -> None:
    """Write these pictures beside this file."""
    for name in names or PICTURES:
        save_twins(name, PICTURES[name])


if __name__ == "__main__":
    main(sys.argv[1:])
