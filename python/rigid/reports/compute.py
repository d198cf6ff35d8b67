"""Error against run time: the call of a report."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import finite_float
from .._checks.progress import PERCENT, Interrupted, ProgressOption, reporting
from ..model.scene import Scene
from ..model.seed import seed_from
from ..solve.methods import EXACT, run_methods
from .ensemble import ensemble_of, probe, same_steps
from .reference import Horizon, find_horizons
from .result import Report
from .scheme import Scheme
from .spec import ReportSpec, make_spec
from .sweep import ANGLES, Sweep, lengthen, sweep_methods, time_sweeps

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


SECONDS, LONG_SECONDS = 30.0, 120.0
"""Time limits (s) of a report until ``t_end`` and of one over revolutions."""

SEARCH = 0.15
"""Share of the time that the search for references may take."""

SWEEP = 0.2
"""Share of the time for one run of all steps. In the rest all steps are timed again, several
times."""


def report(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t_end: float | None = None,
    revolutions: ArrayLike | None = None,
    methods: Iterable[str | Scheme] | None = None,
    bodies: int | None = None,
    errors: ArrayLike = ReportSpec.errors,
    seconds: float | None = None,
    progress: ProgressOption = None,
    rng: int | np.random.Generator | np.random.SeedSequence | None = ReportSpec.seed,
    unit: str = ReportSpec.unit,
    title: str | None = None,
    partial: bool = False,
) -> Report:
    """Measure error against run time of all methods that can move a body from this start.

    Either after a short time, with ``t_end``, or over many revolutions.

    Until ``t_end``, each method is run with shorter and shorter steps, from about a radian a step.
    A method ends when its error is below the smallest requested error, the rounding error or the
    error of the reference, or at the time limit. An ensemble of bodies fills the registers: the
    given start, and starts whose rates differ by about 1e-3, relatively.

    The error of the state at ``t_end`` is measured against the closed form if the bodies have one.
    Else the reference is the method with the highest order, with a step so short that half the step
    changes the state only by rounding. The uncertainty of the reference is stated; smaller errors
    are not reported.

    Time is processor time of the process around :func:`rigid.simulate` on one thread. The overhead
    of a call is some 0.2 ms. To make it small, the motion continues beyond ``t_end`` until a call
    takes 4 ms; the time of a call with one step, measured alternately, is subtracted. A closed form
    is evaluated for 1024 bodies and compared with one step of 1024 bodies; some 10 ns remain
    uncertain.

    Over ``revolutions`` the report shows how errors of energy, momentum and phase grow. Each method
    is run with steps in which the body turns by 16 rad, 8 rad and so on, down to 1/16 rad, until
    shorter steps make no error smaller. All methods run over the first number of revolutions, then
    over the next one, the cheapest first, as far as the time goes. A step with an energy that is
    off by more than 1e-3 after the first revolutions is omitted. Energy and momentum are compared
    at 256 times of a run, the phase at its end: with the closed form, else with the method of the
    highest order, as far as that one is known to be right; not for long where the motion is
    chaotic. The largest error of all bodies counts, and each run is timed once.

    Ctrl-C raises :class:`Interrupted`, a ``KeyboardInterrupt`` with the report of the runs done.

    Parameters
    ----------
    scene : FreeBody or HeavyTop
        The body with its weight, applied torque and damping.
    omega, attitude : array_like, shape (3,) and (4,)
        Start of one body, as in :func:`rigid.simulate`.
    t_end : float
        Horizon, in units of time of the scene.
    revolutions : array_like, shape (m,)
        Horizons instead of ``t_end``, from short to long. A revolution takes ``2 pi / |omega|`` at
        the start.
    methods : sequence of str and Scheme, optional
        ``"exact"``, which has no steps whose errors grow over revolutions, and names of
        :func:`rigid.methods`; by default all. Own schemes, made by :func:`rigid.scheme`, stand
        beside them. A method that does not
        accept the scene is listed in ``refused`` with its reason. Methods that make the same steps,
        bit for bit, are measured once, under the name of the highest order; ``same`` lists the
        other names.
    bodies : int
        Bodies in the ensemble; a multiple of 32 fills all registers. By default 64, and 32 over
        revolutions.
    errors : array_like, shape (m,)
        Errors, for each of which the cheapest method is found.
    seconds : float
        Approximate time limit (s), by default 30, and 120 over revolutions.
    progress : None, bool or callable
        As in :func:`rigid.stability_map`; a callable gets a :class:`Progress` in hundredths of the
        work, with the runs that failed.
    rng : int, numpy.random.Generator or SeedSequence, optional
        The seed of the ensemble, or its source.
    unit : str
        Name of the unit of time.
    title : str, optional
        For tables and plots.
    partial : bool
        Return the report of the runs done after Ctrl-C, instead of raising :class:`Interrupted`.

    Returns
    -------
    Report

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
    >>> book = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3))
    >>> result = rigid.report(
    ...     book, [0.1, 10.0, 0.1], t_end=0.5, methods=["exact", "rk4"], errors=[1e-3, 1e-5],
    ...     seconds=1.0,
    ... )
    >>> result.reference.method, round(result.order("rk4"))
    ('exact', 4)
    >>> result.cost("rk4", 1e-5) > result.cost("rk4", 1e-3)
    True
    >>> rigid.Report.from_json(result.to_json()) == result
    True
    >>> result = rigid.report(
    ...     rigid.Body((1.0, 1.5, 2.0)), [1.0, 0.2, 0.3], revolutions=[10, 100, 1000],
    ...     methods=["rk4", "splitting"],
    ... )
    >>> def growth(method):
    ...     _, before, after = result.growth(result.of(method)[-1])
    ...     return after.energy_drift / before.energy_drift
    >>> growth("rk4") > 5, growth("splitting") > 5
    (True, False)
    """
    spec = make_spec(
        scene,
        omega,
        attitude,
        t_end=t_end,
        revolutions=revolutions,
        methods=methods,
        bodies=bodies,
        errors=errors,
        seed=seed_from(rng),
        unit=unit,
        title=title,
    )
    return run_report(spec, seconds=seconds, progress=progress, partial=partial)


def run_report(
    spec: ReportSpec,
    *,
    seconds: float | None = None,
    progress: ProgressOption = None,
    partial: bool = False,
) -> Report:
    """The report of a specification, with the options of :func:`rigid.report`."""
    if seconds is None:
        seconds = LONG_SECONDS if spec.revolutions else SECONDS
    limit = finite_float("seconds", seconds, positive=True)
    begun = time.perf_counter()

    def spent() -> float:
        return (time.perf_counter() - begun) / limit

    def until(share: float) -> Callable[[float], bool]:
        return lambda more: spent() + more / limit < share

    first = ensemble_of(spec, spec.time_of(spec.revolutions[0]) if spec.revolutions else None)
    usable, refused = probe(first, dict.fromkeys([*spec.methods, *run_methods()]))
    usable = [method for method in usable if method not in spec.schemes]
    refused = {method: why for method, why in refused.items() if method in spec.methods}
    if spec.revolutions and EXACT in spec.methods:
        refused[EXACT] = "makes no steps, whose errors grow"
    able = [method for method in spec.methods if method not in refused]
    if not able:
        reasons = "; ".join(f"{method}: {why}" for method, why in refused.items())
        raise ValueError(f"methods = {list(spec.methods)}: none integrates the scene: {reasons}")
    same = same_steps(first, able)
    sweeps = [Sweep(method) for method in same]
    horizons: list[Horizon] = []
    complete = False

    with hundredths(progress, begun, len(refused)) as told:
        swept = 1.0

        def tell() -> None:
            told(min(swept, spent()))

        try:
            horizons = find_horizons(spec, usable, until(SEARCH), tell)
            if not spec.revolutions:
                swept = spent() + SWEEP
            sweep_methods(horizons[0], sweeps, until(swept), tell)
            if spec.revolutions:
                lengthen(horizons, sweeps, until, tell)
            else:
                ensemble, rest = horizons[0].ensemble, 1.0 - swept
                time_sweeps(ensemble, sweeps, until(1.0), lambda done: told(swept + rest * done))
            complete = True
            told(1.0)
        except KeyboardInterrupt:
            if not any(sweep.runs for sweep in sweeps):
                raise
    if complete and spec.revolutions:
        lost = f"no step down to {ANGLES[-1]} rad that there was time for keeps the energy"
        refused |= {sweep.method: lost for sweep in sweeps if not sweep.kept()}
    result = Report(
        spec=spec,
        rows=tuple(row for sweep in sweeps for row in sweep.rows(horizons)),
        same={method: others for method, others in same.items() if others},
        references=tuple(horizon.reference for horizon in horizons),
        refused=refused,
        ended={sweep.method: sweep.ended or "interrupted" for sweep in sweeps},
        machine=machine(),
        complete=complete,
        rounds=min((len(run.times) for one in sweeps for run, *_ in one.kept()), default=0),
        elapsed=time.perf_counter() - begun,
    )
    if not complete and not partial:
        raise Interrupted(
            f"{sum(len(sweep.runs) for sweep in sweeps)} runs are done; "
            "the attribute 'partial' of this exception is their report",
            result,
        )
    return result


@contextmanager
def hundredths(
    progress: ProgressOption, begun: float, refused: int
) -> Iterator[Callable[[float], None]]:
    """The function to call with the completed share of the work; the share never decreases."""
    done = 0

    def words(count: int) -> str:
        return f"{count} methods do not apply" if count > 1 else "1 method does not apply"

    with reporting(progress, 100, unit=PERCENT, begun=begun, failed=words) as tell:

        def told(share: float) -> None:
            nonlocal done
            hundredths = min(100, int(100.0 * share))
            if hundredths > done:
                done = hundredths
                tell(done, refused)

        yield told


def machine() -> dict[str, str]:
    """The machine and the versions, which determine the times."""
    build = _core.build_info()
    return {
        "cpu": _cpu(),
        "isa": str(build["isa"]),
        "system": platform.system(),
        "rigid": str(build["version"]),
        "commit": str(build["commit"] or "unknown"),
        "python": platform.python_version(),
        "numpy": np.__version__,
    }


def _cpu() -> str:
    """The name of the processor, if the system provides one."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            names = [line.partition(":")[2] for line in lines if line.startswith("model name")]
    except OSError:
        names = []
    known = [name.strip() for name in (*names[:1], platform.processor(), platform.machine())]
    return next((name for name in known if name), "unknown")
