"""The long run: how well methods keep energy, momentum and phase over many revolutions."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import finite_float, numbers
from .._checks.progress import Interrupted, ProgressOption
from ..model.scene import Scene
from ..model.seed import seed_from
from ..solve.methods import EXACT, order_of, run_methods
from ..solve.run import Run
from ..solve.simulate import simulate
from ..solve.status import ARRIVED
from .compute import hundredths, machine
from .ensemble import Ensemble, attitude_angle, ensemble_of
from .long_data import LongRow, at_common_time
from .reference import Reference, find_reference
from .result import LongRun
from .same_steps import same_steps
from .spec import ReportSpec, make_spec
from .sweep import probe

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["REVOLUTIONS", "long_run", "run_long"]

Floats = NDArray[np.float64]

REVOLUTIONS = (1e3, 1e4, 1e5, 1e6)

BODIES = 32
"""Bodies of the ensemble: they fill one group of lanes, which takes no longer than one body."""

OUTPUT_TIMES = 256
"""Number of times of a run at which its errors are measured."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
"""Its multiples, modulo 1, shift the output times, so that these keep step with no period of the
motion."""

ANGLES = tuple(2.0**-k for k in range(-4, 5))
"""Angles (rad) turned in a step, from long steps to short ones."""

LOST_ENERGY = 1e-3
"""A row with a larger error of the energy after the first revolutions is omitted."""

LOST = 1.0
"""Errors, and angles (rad) between two attitudes, above this limit count as infinite."""

ROUNDING = 1e-13
"""Errors of energy and momentum below this limit are rounding; shorter steps do not reduce them."""

REFERENCE_ANGLE = 0.125
"""Angle (rad) turned in a step of a reference without a closed form."""

TRIAL = 10.0
"""Revolutions of the first search for a reference."""

SEARCH, GROWTH = 0.15, 0.6
"""Shares of the time within which references are looked for, and the rows that take the common time
are run."""

MOST_REVOLUTIONS = 1e9
"""Most revolutions; after more, a phase in float64 has no digits left to compare."""


def long_run(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    revolutions: ArrayLike = REVOLUTIONS,
    methods: Iterable[str] | None = None,
    seconds: float = 120.0,
    progress: ProgressOption = None,
    rng: int | np.random.Generator | np.random.SeedSequence | None = ReportSpec.seed,
    unit: str = ReportSpec.unit,
    title: str | None = None,
    partial: bool = False,
) -> LongRun:
    """Measure errors of energy, momentum and phase of the methods over very many revolutions.

    :func:`rigid.report` measures the error after a short time; a long run shows how errors grow.
    Each method is run with steps in which the body turns by 16 rad, 8 rad and so on, down to 1/16
    rad, until shorter steps make no error smaller. All methods run over the first number of
    revolutions, then over the next one, the cheapest first, as far as the time goes. A step with an
    energy that is off by more than 1e-3 after the first revolutions is omitted.

    An ensemble of 32 bodies is run, as in :func:`rigid.report`, and the largest error of all bodies
    is reported: of energy and momentum the largest at 256 times of the run, of the phase the error
    at its end. The phase is compared with the closed form, else with the method of the highest
    order, as far as that one is known to be right: not for long where the motion is chaotic.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body with its weight, applied torque and damping.
    omega, attitude : array_like, shape (3,) and (4,)
        Start of one body, as in :func:`rigid.simulate`. A revolution takes ``2 pi / |omega|``.
    revolutions : array_like, shape (m,)
        Lengths of the runs, from short to long.
    methods : sequence of str, optional
        Names of :func:`rigid.methods`; by default all. Methods that make the same steps, bit for
        bit, are measured once, as in :func:`rigid.report`.
    seconds : float
        Approximate time limit (s), without the first runs.
    progress : None, bool or callable
        As in :func:`rigid.report`.
    rng : int, numpy.random.Generator or SeedSequence, optional
        The seed of the ensemble, or its source.
    unit : str
        Name of the unit of time.
    title : str, optional
        For tables and plots.
    partial : bool
        Return the runs done after Ctrl-C, instead of raising :class:`Interrupted`.

    Returns
    -------
    LongRun

    Raises
    ------
    Interrupted
        After Ctrl-C, unless ``partial`` is set.
    KeyboardInterrupt
        After Ctrl-C before the end of the first run.
    ValueError
        Naming the argument, its value and the rule; or if no method accepts the scene.

    Examples
    --------
    >>> import rigid
    >>> result = rigid.long_run(
    ...     rigid.Body((1.0, 1.5, 2.0)), [1.0, 0.2, 0.3], revolutions=[10, 100, 1000],
    ...     methods=["rk4", "splitting"],
    ... )
    >>> def growth(row):
    ...     return row.energy[2] / row.energy[1]
    >>> growth(result.of("rk4")[-1]) > 5, growth(result.of("splitting")[-1]) > 5
    (True, False)
    """
    spec = make_spec(
        scene,
        omega,
        attitude,
        t_end=1.0,
        methods=methods,
        seed=seed_from(rng),
        unit=unit,
        title=title,
    )
    return run_long(
        spec, revolutions=revolutions, seconds=seconds, progress=progress, partial=partial
    )


def run_long(
    spec: ReportSpec,
    *,
    revolutions: ArrayLike = REVOLUTIONS,
    seconds: float = 120.0,
    progress: ProgressOption = None,
    partial: bool = False,
) -> LongRun:
    """The long run of a scene and start, with the options of :func:`rigid.long_run`.

    Horizon, bodies and errors of the specification belong to a report, and are not used.
    """
    seconds = finite_float("seconds", seconds, positive=True)
    lengths = _checked_revolutions(revolutions)
    rate = math.hypot(*spec.omega)
    if rate == 0.0:
        raise ValueError(
            f"omega = {list(spec.omega)}: must not be zero; a long run counts revolutions"
        )
    begun = time.perf_counter()

    def until(share: float) -> Callable[[float], bool]:
        return lambda more: time.perf_counter() + more < begun + share * seconds

    def of(t_end: float) -> Ensemble:
        return ensemble_of(dataclasses.replace(spec, t_end=t_end, bodies=BODIES))

    # Only names, reasons and bits are needed here, with steps that every method takes.
    short = of(ANGLES[-1] / rate)
    usable, refused = probe(short, dict.fromkeys([EXACT, *spec.methods, *run_methods()]))
    same = same_steps(short, [name for name in spec.methods if name in usable and name != EXACT])
    refused = {name: why for name, why in refused.items() if name in spec.methods and name != EXACT}
    if not same:
        reasons = "".join(f"; {method}: {why}" for method, why in refused.items())
        raise ValueError(
            f"methods = {list(spec.methods)}: none integrates the scene by steps{reasons}"
        )
    legs: list[Leg] = []
    tracks: list[Track] = []
    complete = False
    with hundredths(progress, begun, lambda: 0) as told:

        def tell() -> None:
            told(min(1.0, (time.perf_counter() - begun) / seconds))

        try:
            for count in (min(TRIAL, lengths[0]), *lengths):
                legs.append(_leg(of(math.tau * count / rate), count, usable, legs, until(SEARCH)))
                tell()
            del legs[0]  # it showed what a reference costs
            for method in same:
                for track in _first_tracks(method, legs[0], until(1.0)):
                    tracks.append(track)
                    tell()
            shown = {(row.method, row.angle) for row in at_common_time([t.row() for t in tracks])}
            first = [track for track in tracks if (track.method, track.angle) in shown]
            _lengthen(first, legs, until(GROWTH), tell)
            _lengthen(tracks, legs, until(1.0), tell)
            complete = True
            told(1.0)
        except KeyboardInterrupt:
            if not tracks:
                raise
    moved = {track.method for track in tracks}
    if complete:
        lost = f"no step down to {ANGLES[-1]} rad that there was time for keeps the energy"
        refused |= {method: lost for method in same if method not in moved}
    result = LongRun(
        spec=legs[-1].ensemble.spec,
        revolutions=lengths,
        rows=tuple(track.row() for track in tracks),
        same={method: others for method, others in same.items() if others and method in moved},
        references=tuple(leg.reference for leg in legs if leg.reference is not None),
        refused=refused,
        machine=machine(),
        complete=complete,
        elapsed=time.perf_counter() - begun,
    )
    if not complete and not partial:
        raise Interrupted(
            f"{len(tracks)} steps of methods are run; "
            "the attribute 'partial' of this exception is their long run",
            result,
        )
    return result


def _checked_revolutions(revolutions: ArrayLike) -> tuple[float, ...]:
    array = numbers("revolutions", revolutions)
    if array.ndim != 1 or not array.size:
        raise ValueError(
            f"revolutions: expected shape (m,) with at least one number, got {array.shape}"
        )
    values: list[float] = array.tolist()
    for k, value in enumerate(values):
        before = values[k - 1] if k else 0.0
        if not before < value <= MOST_REVOLUTIONS:
            raise ValueError(
                f"revolutions[{k}] = {value}: must be above {before:g} and at most "
                f"{MOST_REVOLUTIONS:g}"
            )
    return tuple(values)


class Leg(NamedTuple):
    """A number of revolutions, and the true motion over these as far as it is known."""

    ensemble: Ensemble
    revolutions: float
    reference: Reference | None = None
    truth: Run | None = None
    seconds: float = 0.0
    """Time that the search for the true motion took."""


@dataclass(slots=True)
class Track:
    """A method with a step over ever more revolutions.

    Attributes
    ----------
    method, angle, nanoseconds
        As in :class:`LongRow`.
    errors : list
        Energy, momentum and phase over each number of revolutions.
    """

    method: str
    angle: float
    nanoseconds: float = 0.0
    errors: list[tuple[float, float, float]] = field(default_factory=list)

    @property
    def expected(self) -> float:
        """Seconds of processor time per revolution."""
        return 1e-9 * BODIES * self.nanoseconds

    def run(self, leg: Leg) -> None:
        """Run the method over the revolutions of a leg, unless all is lost already."""
        energy, momentum, _ = self.errors[-1] if self.errors else (0.0, 0.0, 0.0)
        if not energy < LOST:
            self.errors.append((math.inf, math.inf, math.inf))
            return
        run = _run(leg, self.method, self.angle)
        self.nanoseconds = run.nanoseconds / (BODIES * leg.revolutions)
        with np.errstate(all="ignore"):  # some have flown apart
            momenta = _momentum_errors(leg.ensemble.spec.scene, run)
        # Output times of a longer run are sparser: what was seen before was there too.
        now = max(energy, _worst(run.energy_drift)), max(momentum, _worst(momenta))
        self.errors.append((*now, _phase_error(run, leg)))

    def row(self) -> LongRow:
        """The row of a result."""
        energy, momentum, phase = zip(*self.errors, strict=True)
        return LongRow(
            method=self.method,
            angle=self.angle,
            nanoseconds=self.nanoseconds,
            energy=energy,
            momentum=momentum,
            phase=phase,
        )


def _first_tracks(method: str, leg: Leg, allowed: Callable[[float], bool]) -> Iterator[Track]:
    """The tracks of a method, with shorter and shorter steps, until they make no error smaller."""
    least = np.full(3, np.inf)
    track = Track(method, 0.0)
    for angle in ANGLES:
        if not allowed(2.0 * track.expected * leg.revolutions):
            return
        track = Track(method, angle)
        try:
            track.run(leg)
        except ValueError:  # so long a step would be unstable
            continue
        errors = np.maximum(track.errors[0], (ROUNDING, ROUNDING, 0.0))
        if errors[0] < LOST_ENERGY:
            yield track
            if not (errors < 0.5 * least).any():
                return
            least = np.minimum(least, errors)


def _lengthen(
    tracks: Sequence[Track],
    legs: Sequence[Leg],
    allowed: Callable[[float], bool],
    tell: Callable[[], object],
) -> None:
    """Run the tracks over the other legs, the cheapest run first, while there is time."""

    def cost(track: Track) -> float:
        return track.expected * legs[len(track.errors)].revolutions

    while short := [track for track in tracks if len(track.errors) < len(legs)]:
        track = min(short, key=cost)
        if not allowed(cost(track)):
            return
        track.run(legs[len(track.errors)])
        tell()


def _run(leg: Leg, method: str, angle: float) -> Run:
    """The ensemble over a leg in equal steps, with states at the ends of some of them."""
    spec = leg.ensemble.spec
    steps = math.ceil(math.tau * leg.revolutions / angle)
    k = np.arange(OUTPUT_TIMES)
    seen = np.unique(np.rint(steps * (k + GOLDEN * k % 1.0) / OUTPUT_TIMES))
    step = spec.t_end / steps
    return simulate(
        spec.scene,
        leg.ensemble.omega,
        spec.attitude,
        t=[*(step * seen[seen < steps]), spec.t_end],
        method=method,
        # Times are rounded, and must not need one step more.
        step=step * (1.0 + 1e-9),
        check=False,
        max_steps=2**62,
        threads=1,
    )


def _leg(
    ensemble: Ensemble,
    count: float,
    usable: Sequence[str],
    before: Sequence[Leg],
    allowed: Callable[[float], bool],
) -> Leg:
    """So many revolutions after shorter legs.

    The true motion is the closed form, or a run by the method of the highest order, compared with
    one of twice the step. It is unknown if it was lost before, or there is no time to find it.
    """
    if EXACT in usable:
        return Leg(ensemble, count, *find_reference(ensemble, [EXACT], allowed))
    leg = Leg(ensemble, count)
    if before:
        last = before[-1]
        is_lost = last.reference is None or last.reference.worst >= LOST
        if is_lost or not allowed(last.seconds * count / last.revolutions):
            return leg
    begun = time.perf_counter()
    best = max(usable, key=order_of)
    coarse = _run(leg, best, 2.0 * REFERENCE_ANGLE)
    truth = _run(leg, best, REFERENCE_ANGLE)
    apart = np.maximum(_angles(coarse, truth), ensemble.rounding())
    reference = Reference(best, int(truth.steps.max()), float(np.median(apart)), float(apart.max()))
    return Leg(ensemble, count, reference, truth, time.perf_counter() - begun)


def _momentum_errors(scene: Scene, run: Run) -> Floats:
    """Largest error of the angular momentum of each body: see :class:`LongRow`."""
    if scene.forces:
        return run.momentum_drift
    weight = np.linalg.norm(scene.weight)
    in_body, momentum = run.momentum(), run.momentum("space")
    conserved = [momentum]
    if weight:
        conserved = [momentum[..., 2:]]
        axis = scene.body.symmetry_axis
        if axis is not None and abs(scene.weight[axis - 1]) == weight:
            conserved.append(in_body[..., axis - 1 : axis])
    scale = np.linalg.norm(momentum[:, 0], axis=-1) + math.sqrt(weight * max(scene.body.moments))
    errors = [np.linalg.norm(one - one[:, :1], axis=-1).max(axis=1) for one in conserved]
    worst: Floats = np.maximum.reduce(errors) / scale
    return worst


def _phase_error(run: Run, leg: Leg) -> float:
    """Largest angle between the last attitudes and the true ones; infinite if it is unknown."""
    if leg.truth is None or leg.reference is None:
        return math.inf
    return _worst(np.maximum(_angles(run, leg.truth), leg.reference.worst))


def _angles(run: Run, truth: Run) -> Floats:
    """Angle between the last attitudes of each body; infinite if one did not arrive."""
    assert run.attitude is not None
    assert truth.attitude is not None
    with np.errstate(all="ignore"):
        angles = attitude_angle(run.attitude[:, -1], truth.attitude[:, -1])
    arrived = np.isin(run.status, ARRIVED) & np.isin(truth.status, ARRIVED) & np.isfinite(angles)
    return np.where(arrived, angles, np.inf)


def _worst(errors: Floats) -> float:
    """The largest error; infinite from :data:`LOST` on, and if one is unknown."""
    return float(np.where(errors < LOST, errors, np.inf).max())
