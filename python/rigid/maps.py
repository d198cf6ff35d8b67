"""Monte Carlo stability maps: the request and the chunk loop."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import positive_int, resolve_threads
from .bodies import Body
from .criteria import Criterion
from .grid import make_axes
from .mapresult import COUNTS, FAILURES, STORED, StabilityMap
from .mapspec import MAX_STEPS, MapSpec, core_job, seed_from
from .methods import AUTO
from .progress import Pace, Progress, ProgressOption, Work, interruptible, reporting
from .scenes import FreeBody, HeavyTop, Scene
from .starts import Start, normal

__all__ = ["run_map", "stability_map"]


def stability_map(
    scene: Scene | type[FreeBody] | type[HeavyTop],
    *,
    axes: Mapping[str, ArrayLike],
    samples: int,
    t_end: float,
    stable: Criterion,
    start: Start | None = None,
    method: str | None = None,
    step: float | None = None,
    check: float = 1.0,
    rng: int | np.random.Generator | np.random.SeedSequence | None = None,
    threads: int | None = None,
    progress: ProgressOption = None,
    chunk: int | None = None,
    max_steps: int = MAX_STEPS,
    title: str | None = None,
) -> StabilityMap:
    """Monte Carlo stability map: a cloud of perturbed bodies in every pixel of a parameter grid.

    Nothing is kept per body: memory grows with the pixels, not with the samples or the horizon. The
    same request gives the same bits for any number of threads and any chunking. Ctrl-C ends the run
    within a fraction of a second and returns the partial map of the chunks done.

    Parameters
    ----------
    scene : FreeBody, HeavyTop, or one of these classes
        The class stands for ``FreeBody(Body((1.0, 1.5, 2.0)))`` or
        ``HeavyTop(Body((1.0, 1.0, 0.5)), mgl=1.0)``.
    axes : dict of str to array_like, shape (n,)
        One or two parameters and their values, increasing or decreasing; x first, then y. They
        replace what scene and start say. Names: ``I1``, ``I2``, ``I3``; ratios such as ``I2/I1``
        (which sets ``I2``); sides ``a``, ``b``, ``c`` and ``mass`` of a box; ``mgl`` of a top;
        ``spin``, ``tilt``, ``omega1``, ``omega2``, ``omega3``; ``noise``, ``attitude_noise``: the
        size of the perturbation that the start names; ``damping1``, ``damping2``, ``damping3``
        (N m s): damping of the rates about the axes.
    samples : int
        Bodies per pixel.
    t_end : float
        Horizon in s: *stable* means stable until then.
    stable : NoFlip or TiltBelow
        The criterion, :func:`no_flip` or :func:`tilt_below`.
    start : Start, optional
        By default a free body spins with 1 rad/s about the axis of its middle moment with
        ``noise=normal(1e-3)``, a top with 5 rad/s about axis 3, ``attitude_noise=normal(1e-3)``.
    method : str, optional
        ``"auto"``, the default: each body by closed form where it has one for this criterion, else
        ``"rk4"``. ``"exact"``: closed forms only. Or one of :func:`rigid.methods`.
    step : float, optional
        Time step of the bodies that are integrated, s; by default chosen for each body from a bound
        of its rates.
    check : float
        Share of each pixel's bodies to judge again, in [0, 1]: by ``taylor16`` in steps of its own,
        and never more than half of ``step`` (by ``method="taylor16"`` itself in half its steps). A
        body on which the two disagree is undecided. Closed forms need no second opinion.
    rng : int, numpy.random.Generator or SeedSequence, optional
        The seed, or where to take its 128 bits from; by default fresh entropy. It is stored in
        ``result.spec.seed``.
    threads : int, optional
        By default ``RIGID_NUM_THREADS``, else the processors this process may use.
    progress : None, bool or callable
        ``None``: a tqdm bar if tqdm is installed and stderr is a terminal; ``False``: silence; a
        callable gets a :class:`Progress` after each chunk.
    chunk : int, optional
        Bodies per chunk; by default adapted to about 0.3 s.
    max_steps : int
        A body that needs more steps counts as failed.
    title : str, optional
        For plots and files.

    Returns
    -------
    StabilityMap

    Raises
    ------
    ValueError
        For an unknown name (the nearest is suggested), a name without meaning for this scene and
        start, a value out of range, or ``"exact"`` where a body has no closed form. Impossible
        bodies inside the grid are no error: they get a ``status``.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody,
    ...     axes={"I2/I1": np.linspace(1.1, 1.9, 5), "noise": np.geomspace(1e-3, 0.1, 3)},
    ...     samples=64, t_end=100.0, stable=rigid.no_flip(), rng=2026,
    ... )
    >>> result.share.shape, result.complete
    ((3, 5), True)
    >>> result.replay(pixel=(2, 3), sample=0).outcome
    'unstable'
    >>> result.plot().get_ylabel()
    'perturbation of the rates (rad/s)'
    """
    scene = _scene(scene)
    spec = MapSpec(
        scene=scene,
        start=_default_start(scene) if start is None else start,
        axes=make_axes(axes),
        stable=stable,
        t_end=t_end,
        samples=samples,
        method=AUTO if method is None else method,
        step=step,
        check=check,
        max_steps=max_steps,
        seed=seed_from(rng),
        title=title,
    )
    return run_map(spec, threads=threads, progress=progress, chunk=chunk)


def run_map(
    spec: MapSpec,
    *,
    threads: int | None = None,
    progress: ProgressOption = None,
    chunk: int | None = None,
) -> StabilityMap:
    """Compute the map of a specification; the options are those of :func:`stability_map`."""
    workers = resolve_threads(threads)
    size = None if chunk is None else positive_int("chunk", chunk)
    job = core_job(spec)
    counted = _empty(job.status)
    work = Work(job.status == 0, spec.samples)
    pace = Pace(workers)
    done = failures = 0
    begun = time.perf_counter()
    with reporting(progress, work.total) as report, interruptible() as stop:
        try:
            while done < work.total and not stop.is_set():
                until = min(done + (size or pace.size), work.total)
                before = time.perf_counter()
                part = job.run(work.flat(done), work.flat(until), workers, stop.is_set)
                if part is None:
                    break
                seconds = time.perf_counter() - before
                _merge(counted, part)
                pace.note(until - done, seconds, _costliest(part))
                done = until
                failures += int(part["failed"].sum())
                report(
                    Progress(
                        done=done,
                        total=work.total,
                        elapsed=time.perf_counter() - begun,
                        failures=failures,
                    )
                )
        except KeyboardInterrupt:
            pass
    elapsed = time.perf_counter() - begun
    return StabilityMap.from_arrays(spec, counted, elapsed=elapsed, threads=workers)


def _scene(scene: object) -> Scene:
    if scene is FreeBody:
        return FreeBody(Body((1.0, 1.5, 2.0)))
    if scene is HeavyTop:
        return HeavyTop(Body((1.0, 1.0, 0.5)), mgl=1.0)
    if isinstance(scene, (FreeBody, HeavyTop)):
        return scene
    raise TypeError(f"scene = {scene!r}: must be a rigid.FreeBody or rigid.HeavyTop")


def _default_start(scene: Scene) -> Start:
    if isinstance(scene, HeavyTop):
        return Start(spin=5.0, attitude_noise=normal(1e-3))
    middle = int(np.argsort(scene.body.moments, kind="stable")[1]) + 1
    return Start(spin=1.0, axis=middle, noise=normal(1e-3))


def _empty(status: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
    counted: dict[str, NDArray[Any]] = {
        name: np.zeros(status.shape, dtype) for name, dtype in STORED.items()
    }
    counted["status"] = status
    counted["earliest"] = np.full(status.shape, np.inf)
    counted["energy_drift"] = np.full(status.shape, np.nan)
    counted["momentum_drift"] = np.full(status.shape, np.nan)
    counted["nanoseconds"] = np.zeros(status.shape)
    return counted


def _merge(counted: dict[str, NDArray[Any]], part: Mapping[str, Any]) -> None:
    window = slice(part["first"], part["first"] + len(part["stable"]))
    for name in (*COUNTS, *FAILURES, "steps", "exact", "nanoseconds"):
        counted[name][window] += part[name]
    for name in ("energy_drift", "momentum_drift"):
        np.fmax(counted[name][window], part[name], out=counted[name][window])
    np.minimum(counted["earliest"][window], part["earliest"], out=counted["earliest"][window])


def _costliest(part: Mapping[str, Any]) -> float:
    """Largest mean processor time of a body over the pixels of a chunk, s."""
    bodies = sum(part[name] for name in COUNTS[:4])
    seconds = 1e-9 * part["nanoseconds"][bodies > 0] / bodies[bodies > 0]
    return float(seconds.max(initial=0.0))
