"""Random maps against truths of their own: measures, horizons and limits, judged states.

Each subject makes its own random requests, and counts what it tried. A number that is wrong and not
said to be unsure is *undetected*.
"""

from collections.abc import Callable, Iterable
from dataclasses import MISSING, dataclass, field, fields
from functools import partial
from typing import Any

import numpy as np

import rigid
from fine_motion import FineMotion, Floats, Truths, unit
from physics import angle_between, rotated
from rigid.maps.data import COLUMNS
from rigid.model.bounds import AngleWithin, PointingWithin
from rigid.model.criterion import CRITERIA, Criterion
from rigid.model.measures import Measure
from rigid.model.scene import Scene

BODIES = 3
"""Bodies of a map whose motions are integrated by SciPy."""

MEASURING = ("auto", "auto", "dop853")
"""Methods that know the motion inside their steps."""

JUDGING = ("auto", "auto", "auto", "taylor16", "dop853")


@dataclass
class Tally:
    """What became of the numbers that a subject tried."""

    tried: int = 0
    right: int = 0
    flagged: int = 0
    refused: int = 0
    undetected: int = 0
    notes: list[str] = field(default_factory=list)

    def count(self, is_right: bool, note: str) -> None:
        """A number that is right or wrong; the note says which."""
        self.tried += 1
        if is_right:
            self.right += 1
        else:
            self.undetected += 1
            self.notes.append(note)

    def flag(self, number: int = 1) -> None:
        """Numbers that the map calls unsure."""
        self.tried += number
        self.flagged += number

    def refuse(self) -> None:
        """A request that is refused in words."""
        self.tried += 1
        self.refused += 1

    def __str__(self) -> str:
        return (
            f"{self.tried} tried, {self.right} right, {self.flagged} flagged, "
            f"{self.refused} refused, {self.undetected} undetected"
        )


# Requests


def direction(rng: np.random.Generator) -> Floats:
    """A random unit vector."""
    vector = rng.normal(size=3)
    out: Floats = vector / np.linalg.norm(vector)
    return out


def any_scene(rng: np.random.Generator) -> Scene:
    """A top or a free body, with or without what acts on it."""
    halves = rng.uniform(0.2, 1.5, 3)
    body = rigid.Body(halves.sum() - halves)
    is_top = rng.random() < 0.55
    acting: dict[str, Any] = {}
    if rng.random() < 0.3:
        factor = 0.15 * rng.normal(size=(3, 3))
        square = factor @ factor.T
        acting["damping"] = 0.5 * (square + square.T)
    if rng.random() < 0.15:
        acting["drag"] = rng.uniform(0.0, 0.1, 3)
    pushes = []
    if rng.random() < 0.25:
        pushes.append(rigid.Torque.body(0.2 * rng.normal(size=3)))
    if rng.random() < 0.2:
        pushes.append(rigid.Torque.space(0.2 * rng.normal(size=3)))
    if is_top:
        if pushes:
            acting["torque"] = sum(pushes[1:], pushes[0])
        com = (0.0, 0.0, 1.0) if rng.random() < 0.3 else direction(rng)
        return rigid.HeavyTop(body, mgl=float(rng.uniform(0.2, 2.0)), com=com, **acting)
    if rng.random() < 0.2:
        normal = direction(rng)
        periapsis = np.cross(normal, direction(rng))
        periapsis /= np.linalg.norm(periapsis)
        rate, e = float(rng.uniform(0.1, 1.0)), float(rng.choice([0.0, rng.uniform(0.0, 0.8)]))
        acting["orbit"] = rigid.Orbit(rate, e, 1.0, normal, periapsis)
    if pushes:
        acting["torque"] = sum(pushes[1:], pushes[0])
    if rng.random() < 0.2:
        acting["rotor"] = 0.5 * rng.normal(size=3)
    if rng.random() < 0.2:
        acting["dissipation"] = rigid.EnergySink(rng.uniform(0.0, 0.03, 3))
    return rigid.FreeBody(body, **acting)


def any_start(rng: np.random.Generator, scene: Scene) -> rigid.Start:
    """A start about some axis, with large or small perturbations."""
    options: dict[str, Any] = {"tilt": float(rng.uniform(0.0, 2.0 if scene.directions else 0.5))}
    if scene.rates_need_attitude:
        options["attitude_noise"] = rigid.normal(0.3)
    noise = rigid.normal(float(rng.choice([1e-3, 0.1, 1.0])))
    return rigid.Start(spin=1.0, axis=int(rng.integers(1, 4)), noise=noise, **options)


def any_axis(rng: np.random.Generator) -> int:
    """A body axis or its opposite."""
    return int(rng.choice([-3, -2, -1, 1, 2, 3]))


# Measures


def any_measures(rng: np.random.Generator, scene: Scene) -> list[Any]:
    """Flips and mean rates of all axes, and tilts."""
    chosen: list[Any] = [rigid.flips(k) for k in (1, 2, 3)]
    chosen += [rigid.mean_rate(k * int(rng.choice([-1, 1]))) for k in (1, 2, 3)]
    axis = any_axis(rng)
    if scene.directions:
        chosen.append(rigid.largest_tilt(axis=axis, reference="vertical"))
    if not scene.forces:
        other = abs(axis) % 3 + 1
        chosen.append(rigid.largest_tilt(axis=other, reference="start"))
    return [*chosen, rigid.time_to_leave(), rigid.drift()]


def any_limit(rng: np.random.Generator, scene: Scene) -> Criterion:
    """No flip, or a tilt below some angle."""
    if rng.random() < 0.5:
        return rigid.no_flip(int(rng.integers(1, 4)))
    axis, angle = any_axis(rng), float(rng.uniform(0.1, 3.0))
    if scene.directions:
        return rigid.tilt_below(angle, axis=axis, reference="vertical")
    return rigid.tilt_below(angle, axis=axis, reference="start")


def leaving(stable: Any) -> Callable[[FineMotion], float]:
    """The time at which a motion leaves a criterion."""
    if stable.name == "no_flip":
        return lambda motion: motion.flips(stable.axis)[1]
    return lambda motion: motion.time_beyond(stable.angle, stable.axis, stable.reference)


def measures(seed: int, count: int) -> dict[str, Tally]:
    """Values of bodies of so many maps, and the numbers of their histograms."""
    rng = np.random.default_rng(seed)
    names = ("flips", "mean_rate", "largest_tilt", "time_to_leave", "statistics")
    tallies = {name: Tally() for name in names}
    for case in range(count):
        scene = any_scene(rng)
        start, chosen, stable = (
            any_start(rng, scene),
            any_measures(rng, scene),
            any_limit(rng, scene),
        )
        options: dict[str, Any] = {
            "axes": {"spin": [float(rng.uniform(0.5, 4.0))]},
            "start": start,
            "t_end": float(rng.uniform(2.0, 12.0)),
            "measure": chosen,
            "stable": stable,
            "method": str(rng.choice(MEASURING)),
            "samples": 40,
            "rng": int(rng.integers(2**62)),
            "progress": False,
        }
        where = f"case {case} of seed {seed}, {options['method']}"
        try:
            result = rigid.stability_map(scene, **options)
        except ValueError:
            tallies["time_to_leave"].refuse()
            continue
        found = result.outcomes(range(40), pixel=0)
        _statistics(tallies["statistics"], result, found.measures, where)
        _values(tallies, result, found, f"{where}, {stable}")
    return tallies


def _values(tallies: dict[str, Tally], result: Any, found: Any, where: str) -> None:
    """The values of the first bodies of a map."""
    scene, spec = result.spec.grid.scene[0], result.spec
    starts = result.starts(range(BODIES), pixel=0)
    leaves = leaving(spec.stable)
    for body in range(BODIES):
        truths = Truths(scene, starts.omega[body], starts.attitude[body], spec.t_end)
        drift = float(found.measures["drift"][body])
        for measure in spec.measure:
            if measure.name in ("flips", "mean_rate", "largest_tilt"):
                got = _compared(measure, float(found.measures[str(measure)][body]))
                note = f"{where}: {measure} of body {body}"
                # A tilt is compared by a number whose slope is at most two.
                stated = float(result.measures[str(measure)].error[0])
                stated *= 2.0 if measure.name == "largest_tilt" else 1.0
                _judge(
                    tallies[measure.name],
                    truths,
                    got,
                    partial(_of, measure),
                    errors=(drift, stated),
                    note=note,
                )
        if found.outcome[body] in ("undecided", "failed"):
            tallies["time_to_leave"].flag()
            continue
        left = float(found.measures["time_to_leave"][body])
        got = left if found.outcome[body] == "unstable" else np.inf
        note = f"{where}: time of leaving of body {body}"
        errors = drift, float(result.measures["time_to_leave"].error[0])
        _judge(tallies["time_to_leave"], truths, got, leaves, errors=errors, note=note)


def _of(measure: Measure, motion: FineMotion) -> float:
    return _compared(measure, motion.value(measure))


def _compared(measure: Measure, value: float) -> float:
    """Of tilts ``4 sin²(angle/2)``, as they are observed: near pi an angle has half the digits."""
    return 4.0 * float(np.sin(0.5 * value)) ** 2 if measure.name == "largest_tilt" else value


def _judge(
    tally: Tally,
    truths: Truths,
    got: float,
    of: Callable[[FineMotion], float],
    *,
    errors: tuple[float, float],
    note: str,
) -> None:
    """A value of a body: flagged if it is none, or off by no more than a map says.

    The errors are the drift of the invariants, and the stated error of the worst body.
    """
    drift, stated = errors
    is_right = truths.agrees(got, of)
    is_told = abs(got - of(truths.motion)) <= 1.01 * stated
    if np.isnan(got) or (not is_right and (is_told or truths.agrees(got, of, error=drift))):
        tally.flag()
    else:
        tally.count(is_right, f"{note} is {got}, not {of(truths.motion)}")


def _statistics(tally: Tally, result: Any, values: dict[str, Floats], where: str) -> None:
    """The numbers of the histograms, by NumPy from the values of all bodies."""
    for name, measured in result.measures.items():
        known = values[name][np.isfinite(values[name])]
        expected: dict[str, tuple[Any, Any, float]] = {
            "count": (measured.count[0], known.size, 0.0)
        }
        if known.size:
            expected["least"] = (measured.least[0], known.min(), 0.0)
            expected["largest"] = (measured.largest[0], known.max(), 0.0)
            # NumPy sums with some roundings of the largest.
            rounding = 4e-15 * float(np.abs(known).max())
            expected["mean"] = (measured.mean[0], known.mean(), rounding)
            for q in (0.0, 0.05, 0.5, 0.77, 1.0):
                exact = float(np.quantile(known, q, method="inverted_cdf"))
                expected[f"quantile {q}"] = (measured.quantile(q)[0], exact, abs(exact) / 64)
        if known.size > 1:
            expected["std"] = (measured.std[0], known.std(ddof=1), rounding)
        for what, (got, exact, error) in expected.items():
            tally.count(
                abs(got - exact) <= error,
                (f"{where}: {what} of {name} is {got}, not {exact}"),
            )


# Horizons and limits


NEEDED = {"low": 0.05, "after": 0.4, "rate": 0.5}
"""What criteria need besides their limit."""


def criterion_of(name: str, limit: float, axis: int) -> Criterion:
    """The criterion of this name in the table of the library, or joined ones, with a limit."""
    if name == "joined":
        return rigid.tilt_below(limit) & rigid.no_flip(axis) | rigid.near_start(0.5)
    numbers: dict[str, Any] = {}
    for own in fields(CRITERIA[name]):  # type: ignore[arg-type]
        if own.default is MISSING:
            numbers[own.name] = NEEDED.get(own.name, limit)
        elif own.name == "axis":
            numbers[own.name] = axis
    return CRITERIA[name](**numbers)


def horizons(seed: int, count: int) -> Tally:
    """Each pixel of random maps with axes ``t_end`` and ``limit`` is that of a map without them."""
    rng, tally = np.random.default_rng(seed), Tally()
    for case in range(count):
        scene = any_scene(rng)
        of_orbit = PointingWithin, AngleWithin
        known = [
            name
            for name, made in CRITERIA.items()
            if "orbit" in scene.forces or not issubclass(made, of_orbit)
        ]
        name = str(rng.choice([*known, "joined"]))
        make = partial(criterion_of, name, axis=int(rng.integers(1, 4)))
        ends = rng.permutation(np.sort(rng.uniform(0.5, 9.0, 3)))[:2].tolist()
        limits = np.sort(rng.uniform(0.1, 3.0, 2)).tolist()
        values: dict[str, list[float]] = {"spin": [1.0, 2.0], "t_end": ends}
        if make(1.0).limited is not None:
            values["limit"] = limits
        order = rng.permutation([*values]).tolist()
        options: dict[str, Any] = {
            "start": any_start(rng, scene),
            "rng": int(rng.integers(2**62)),
            "measure": [rigid.mean_rate(1), rigid.flips(3), rigid.time_to_leave()],
            "progress": False,
        }
        if rng.random() < 0.3:
            options["half_width"] = 0.2
        else:
            options["samples"] = int(rng.integers(1, 60))
        if rng.random() < 0.3:
            options["check"] = float(rng.choice([0.0, 0.5, 1.0]))
        try:
            whole = rigid.stability_map(
                scene, axes={one: values[one] for one in order}, stable=make(limits[0]), **options
            )
        except ValueError:
            tally.refuse()
            continue
        for t_end in ends:
            for limit in values.get("limit", limits[:1]):
                single = rigid.stability_map(
                    scene,
                    axes={"spin": values["spin"]},
                    stable=make(limit),
                    t_end=t_end,
                    **options,
                )
                chosen = {"t_end": ends.index(t_end), "limit": limits.index(limit)}
                at = tuple(chosen.get(one, slice(None)) for one in reversed(order))
                tally.count(
                    all(_equal(one[at], other) for one, other in _numbers(whole, single)),
                    (f"case {case} of seed {seed}: {name}, t_end {t_end}, limit {limit}"),
                )
    return tally


def _equal(one: Floats, other: Floats) -> bool:
    return bool(np.array_equal(one, other, equal_nan=True))


def _numbers(whole: Any, single: Any) -> Iterable[tuple[Floats, Floats]]:
    """All numbers of both maps that do not depend on the machine."""
    for column in COLUMNS:
        if column.reproducible:
            yield whole.columns[column.name], single.columns[column.name]
    for name in ("share", "lower", "upper", "samples"):
        yield getattr(whole, name), getattr(single, name)
    for one, other in zip(whole.measures.values(), single.measures.values(), strict=True):
        for name in ("count", "mean", "std", "least", "largest"):
            yield getattr(one, name), getattr(other, name)


def known_classes(seed: int, count: int) -> Tally:
    """Counts along ``t_end`` and ``limit`` where a line of NumPy tells the class from the start.

    The rate of a body with ``I = (1, 1, 2)`` about axis 1 is ``cos(omega3 t)`` times its start, if
    axis 2 begins at rest. A top hardly moves in a microsecond.
    """
    rng, tally = np.random.default_rng(seed), Tally()
    for case in range(count):
        samples, ends = int(rng.integers(50, 400)), np.sort(rng.uniform(0.2, 6.0, 4))
        disc = rigid.stability_map(
            rigid.FreeBody(rigid.Body((1.0, 1.0, 2.0))),
            axes={"omega1": [1.0, 2.0], "t_end": ends},
            start=rigid.Start(omega=(1.0, 0.0, 0.0), noise=rigid.normal([0.0, 0.0, 1.0])),
            stable=rigid.no_flip(1),
            method=str(rng.choice(["auto", "exact", "dop853"])),
            samples=samples,
            rng=int(rng.integers(2**62)),
            progress=False,
        )
        spin = np.abs(disc.starts(range(samples)).omega[..., 2])
        kept = (spin * ends[:, None, None] < 0.5 * np.pi).sum(axis=-1)
        limits, axis = np.sort(rng.uniform(0.05, 3.0, 4)), any_axis(rng)
        top = rigid.stability_map(
            rigid.HeavyTop(rigid.Body((1.0, 1.3, 0.7)), mgl=1.0),
            axes={"limit": limits, "attitude_kappa": [0.5, 5.0]},
            start=rigid.Start(spin=1.0, attitude_noise=rigid.von_mises_fisher(1.0)),
            stable=rigid.tilt_below(1.0, axis=axis),
            t_end=1e-9,
            samples=samples,
            rng=int(rng.integers(2**62)),
            progress=False,
        )
        upward = rotated(top.starts(range(samples)).attitude, unit(axis))
        tilt = angle_between(upward, np.broadcast_to(unit(3), upward.shape))
        below = (tilt < limits[:, None]).sum(axis=-1)
        for result, expected in ((disc, kept), (top, below)):
            sure = result.undecided == 0
            tally.flag(int((~sure).sum()))
            for at in np.argwhere(sure):
                index = tuple(at)
                tally.count(
                    int(result.stable[index]) == int(expected[index]),
                    (
                        f"case {case} of seed {seed}: {result!r} has {result.stable[index]} at "
                        f"{index}, not {expected[index]}"
                    ),
                )
    return tally


# Judged bodies


def judged_states(seed: int, count: int) -> Tally:
    """The states that a function is given, of both runs, against SciPy's."""
    rng, tally = np.random.default_rng(seed), Tally()
    for case in range(count):
        scene = any_scene(rng)
        seen: list[rigid.States] = []

        def look(states: rigid.States, seen: list[rigid.States] = seen) -> Any:
            seen.append(states)
            return np.ones(len(states.omega), dtype=bool)

        times = np.sort(rng.uniform(0.1, 10.0, 5))
        times[0] *= rng.random() < 0.5
        of = str(rng.choice(["attitude", "axis", "rates"]))
        try:
            result = rigid.stability_map(
                scene,
                axes={"spin": [1.0, 2.0]},
                start=any_start(rng, scene),
                stable=rigid.judged(look, times, of=of),
                method=str(rng.choice(JUDGING)),
                samples=2,
                rng=int(rng.integers(2**62)),
                progress=False,
            )
        except ValueError:
            tally.refuse()
            continue
        starts = result.starts(range(2))
        omega, attitude = starts.omega.reshape(-1, 3), starts.attitude.reshape(-1, 4)
        for body in range(len(omega)):
            truths = Truths(scene, omega[body], attitude[body], float(times[-1]))
            for number, states in enumerate(seen):
                tally.count(
                    _agree(states, body, truths, scene, of),
                    (f"case {case} of seed {seed}: body {body}, run {number}, of={of!r}"),
                )
    return tally


def _agree(states: rigid.States, body: int, truths: Truths, scene: Scene, of: str) -> bool:
    """Whether the states of a body are its motion, and what is not computed is None."""
    has_gamma = of in ("axis", "attitude")
    if (states.gamma is not None) != has_gamma:
        return False
    if (states.attitude is not None) != (of == "attitude"):
        return False
    good = [truths.agrees(states.omega[body], lambda one: one.at(states.t)[:3].T)]
    if states.attitude is not None:
        attitude = states.attitude[body]
        true = truths.motion.attitude(states.t)
        sign = np.sign((attitude * true).sum(axis=-1, keepdims=True))
        good.append(truths.agrees(sign * attitude, lambda one: one.attitude(states.t)))
    if states.gamma is not None:
        good.append(truths.agrees(states.gamma[body], lambda one: one.gamma(states.t)))
    return all(good)
