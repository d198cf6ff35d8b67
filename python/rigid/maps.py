"""Monte Carlo stability maps: the specification, the chunk loop, and the result."""

from __future__ import annotations

import json
import math
import operator
import os
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._check import finite_float, one_of, positive_int, resolve_threads
from .bodies import Body
from .criteria import Criterion, NoFlip, TiltBelow, criterion_from_dict
from .grid import Axis, check_applicable, grid_shape, make_axes, pixels
from .methods import method_names
from .progress import Pace, Progress, ProgressOption, Work, interruptible, reporting
from .scenes import FreeBody, HeavyTop, Scene, scene_from_dict
from .simulate import Run, replay_steps, simulate
from .starts import Start, normal

if TYPE_CHECKING:
    from pathlib import Path

    import xarray
    from matplotlib.axes import Axes

    from .theory import Theory

__all__ = ["MapSpec", "Replay", "StabilityMap", "run_map", "stability_map"]

MAX_STEPS = 100_000_000
STATUS = ("possible", "not finite", "not positive", "triangle inequality broken")

COUNTS = ("stable", "unstable", "undecided", "failed", "checked")
STORED: Mapping[str, type[np.generic]] = {
    **dict.fromkeys(COUNTS, np.int64),
    "energy_drift": np.float64,
    "momentum_drift": np.float64,
    "earliest": np.float64,
    "steps": np.int64,
    "status": np.uint8,
}
"""The arrays of a saved map that the others follow from, with their types."""

_Z95 = 1.959963984540054


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSpec:
    """Everything that the numbers of a map depend on; round-trips through JSON.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
    start : Start
    axes : tuple of Axis
        x first, then y.
    stable : NoFlip or TiltBelow
        The criterion, with no default left open.
    t_end : float
        Horizon in s.
    samples : int
        Bodies per pixel.
    method : str
    step : float or None
        Time step in s; None: the core picks one for each body from a bound of its rates.
    check : float
        Share of each pixel's bodies that is repeated with half the step, in [0, 1].
    max_steps : int
        A body that needs more steps counts as failed.
    seed : int
        Key of the random numbers, 0 <= seed < 2**128.
    title : str or None
    version : str
        Version of rigid.
    """

    scene: Scene
    start: Start
    axes: tuple[Axis, ...]
    stable: Criterion
    t_end: float
    samples: int
    seed: int
    method: str = "rk4"
    step: float | None = None
    check: float = 1.0
    max_steps: int = MAX_STEPS
    title: str | None = None
    version: str = field(default_factory=lambda: str(_core.build_info()["version"]))

    def __post_init__(self) -> None:
        def put(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        if not isinstance(self.start, Start):
            raise TypeError(f"start = {self.start!r}: must be a rigid.Start")
        if not isinstance(self.stable, (NoFlip, TiltBelow)):
            raise TypeError(
                f"stable = {self.stable!r}: must be a criterion, rigid.no_flip() or "
                "rigid.tilt_below(angle)"
            )
        check_applicable(self.scene, self.start, self.axes)
        put("stable", self.stable.resolved(self.scene, self.start))
        put("t_end", finite_float("t_end", self.t_end, positive=True))
        put("samples", positive_int("samples", self.samples))
        put("max_steps", positive_int("max_steps", self.max_steps))
        for name, count in (
            ("samples", self.samples * math.prod(self.shape)),
            ("max_steps", self.max_steps),
        ):
            if count >= 2**63:
                raise ValueError(f"{name} = {getattr(self, name)}: too many to count")
        if self.step is not None:
            put("step", finite_float("step", self.step, positive=True))
        put("check", finite_float("check", self.check, nonnegative=True))
        if self.check > 1.0:
            raise ValueError(f"check = {self.check}: must lie in [0, 1]")
        one_of("method", self.method, method_names())
        put("seed", _checked_seed(self.seed))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays: ``(ny, nx)`` or ``(nx,)``."""
        return grid_shape(self.axes)

    @property
    def checked_samples(self) -> int:
        """How many bodies of each pixel are repeated with half the step."""
        return math.ceil(self.check * self.samples)

    @property
    def criterion(self) -> str:
        """Criterion and horizon in words."""
        return f"{self.stable} until t = {self.t_end:g} s"

    def to_dict(self) -> dict[str, Any]:
        """The specification as a JSON-able dictionary; :meth:`from_dict` is its inverse."""
        return {
            "scene": self.scene.to_dict(),
            "start": self.start.to_dict(),
            "axes": [{"name": axis.name, "values": list(axis.values)} for axis in self.axes],
            "stable": self.stable.to_dict(),
            "t_end": self.t_end,
            "samples": self.samples,
            "method": self.method,
            "step": self.step,
            "check": self.check,
            "max_steps": self.max_steps,
            "seed": self.seed,
            "title": self.title,
            "version": self.version,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> MapSpec:
        """The specification that :meth:`to_dict` described."""
        values = dict(data)
        values["scene"] = scene_from_dict(values["scene"])
        values["start"] = Start.from_dict(values["start"])
        values["axes"] = make_axes({axis["name"]: axis["values"] for axis in values["axes"]})
        values["stable"] = criterion_from_dict(values["stable"])
        return cls(**values)

    def to_json(self) -> str:
        """The specification as JSON text; floats keep all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> MapSpec:
        """The specification that :meth:`to_json` wrote."""
        return cls.from_dict(json.loads(text))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Replay:
    """One body of a map, computed again alone: bit for bit the one that was counted.

    Attributes
    ----------
    pixel : tuple of int
        Index in the arrays of the map, ``[y, x]`` or ``[x]``.
    sample : int
    parameters : dict
        Values of the axes at this pixel.
    omega, attitude : ndarray, shapes (3,), (4,)
        Where the body started: rad/s in the body; quaternion (w, x, y, z).
    outcome : str
        ``"stable"``, ``"unstable"``, ``"undecided"`` or ``"failed"``.
    status : str
        How the integration ended.
    flips : int
        Sign changes seen until it ended.
    left : float
        Time at which it left stability, s; NaN if it did not.
    tilt : float
        Largest angle seen in rad, NaN if it was not watched.
    energy_drift, momentum_drift : float
    step : float
        Time step in s.
    steps : int
    run : Run
        The trajectory until the horizon, with the same method and step.
    """

    pixel: tuple[int, ...]
    sample: int
    parameters: dict[str, float]
    omega: NDArray[np.float64]
    attitude: NDArray[np.float64]
    outcome: str
    status: str
    flips: int
    left: float
    tilt: float
    energy_drift: float
    momentum_drift: float
    step: float
    steps: int
    run: Run


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StabilityMap:
    """Result of :func:`stability_map`: named arrays of grid shape, indexed ``[y, x]`` or ``[x]``.

    Attributes
    ----------
    spec : MapSpec
        Everything the numbers depend on.
    status : ndarray of uint8
        0 possible body; 1 a moment is not finite; 2 not positive; 3 triangle inequality broken.
    stable, unstable, undecided, failed : ndarray of int64
        Bodies of each class. Undecided: the class changes when the step is halved.
    checked : ndarray of int64
        Bodies repeated with half the step.
    samples : ndarray of int64
        Bodies done, the sum of the four classes.
    share : ndarray
        ``stable / (stable + unstable)``, NaN if there are none.
    lower, upper : ndarray
        95 % Wilson interval of the share, widened by the undecided: they count as unstable for
        ``lower`` and as stable for ``upper``.
    energy_drift, momentum_drift : ndarray
        Worst relative drift of the conserved quantities in each pixel.
    earliest : ndarray
        First time at which a body left stability, s; inf if none did.
    steps : ndarray of int64
        Time steps taken.
    nanoseconds : ndarray
        Processor time spent. A measurement of this machine: not saved, NaN in a loaded map.
    elapsed : float
        Wall time in s; NaN in a loaded map.
    threads : int
        Threads used; 0 in a loaded map.
    """

    spec: MapSpec
    status: NDArray[np.uint8]
    stable: NDArray[np.int64]
    unstable: NDArray[np.int64]
    undecided: NDArray[np.int64]
    failed: NDArray[np.int64]
    checked: NDArray[np.int64]
    samples: NDArray[np.int64]
    share: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    energy_drift: NDArray[np.float64]
    momentum_drift: NDArray[np.float64]
    earliest: NDArray[np.float64]
    steps: NDArray[np.int64]
    nanoseconds: NDArray[np.float64]
    elapsed: float
    threads: int

    @classmethod
    def from_arrays(
        cls,
        spec: MapSpec,
        arrays: Mapping[str, NDArray[Any]],
        *,
        elapsed: float = math.nan,
        threads: int = 0,
    ) -> StabilityMap:
        """The result that follows from the counted arrays, those named in :data:`STORED`."""
        shaped = {name: array.reshape(spec.shape) for name, array in arrays.items()}
        shaped.setdefault("nanoseconds", np.full(spec.shape, np.nan))
        stable, unstable, undecided, failed = (shaped[name] for name in COUNTS[:4])
        decided = stable + unstable
        share = np.full(spec.shape, np.nan)
        np.divide(stable, decided, out=share, where=decided > 0)
        judged = decided + undecided
        return cls(
            spec=spec,
            samples=judged + failed,
            share=share,
            lower=wilson(stable, judged)[0],
            upper=wilson(stable + undecided, judged)[1],
            elapsed=elapsed,
            threads=threads,
            **shaped,
        )

    @property
    def complete(self) -> bool:
        """Whether every possible body was computed."""
        return bool((self.samples[self.status == 0] == self.spec.samples).all())

    def theory(self) -> Theory | None:
        """The prediction for this map, or None where no theory is known."""
        from .theory import predict

        return predict(self.spec)

    def disagreement(self, theory: Theory | None = None) -> NDArray[np.bool_]:
        """Pixels whose predicted share lies outside [lower, upper].

        A 95 % interval misses a true prediction in up to one pixel of twenty by chance.

        Parameters
        ----------
        theory : Theory, optional
            By default that of :meth:`theory`; without one no pixel disagrees.

        Returns
        -------
        ndarray of bool, grid shape
        """
        theory = theory or self.theory()
        if theory is None:
            return np.zeros(self.spec.shape, dtype=np.bool_)
        outside: NDArray[np.bool_] = (theory.share < self.lower) | (theory.share > self.upper)
        return outside

    def replay(
        self, pixel: int | tuple[int, ...], sample: int, t: ArrayLike | None = None
    ) -> Replay:
        """Compute one body of the map again, alone, with its trajectory.

        Parameters
        ----------
        pixel : int or tuple of int
            Index in the arrays, ``[y, x]`` or ``[x]``; one integer counts in C order.
        sample : int
            Number of the body in its pixel, from 0.
        t : array_like, optional
            Times of the trajectory in s, reached by steps no longer than those of the map. By
            default about 500 ends of the very steps that were taken, until ``t_end``. Of a body
            that was not run, because of ``max_steps`` say, there is only the start.

        Returns
        -------
        Replay

        Raises
        ------
        IndexError
            If there is no such pixel or sample.
        ValueError
            If the body of this pixel is impossible.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
        ...     stable=rigid.no_flip(), rng=2026,
        ... )
        >>> body = result.replay(pixel=1, sample=3)
        >>> body.parameters, body.outcome, 0.0 < body.left < 50.0
        ({'spin': 2.0}, 'unstable', True)
        >>> body.run.omega.shape
        (501, 3)
        """
        index = _pixel_index(pixel, self.spec.shape)
        number = operator.index(sample)
        if not 0 <= number < self.spec.samples:
            raise IndexError(f"sample = {sample}: must lie in 0 .. {self.spec.samples - 1}")
        if self.status[index]:
            raise ValueError(
                f"pixel = {index}: no such body is possible: {STATUS[self.status[index]]}"
            )
        spec = self.spec
        flat = int(np.ravel_multi_index(index, spec.shape))
        rows = pixels(spec.scene, spec.start, spec.axes)
        record = _job(spec).sample(flat, number)
        i1, i2, i3 = rows.moments[flat].tolist()
        body = Body((i1, i2, i3))
        scene = (
            HeavyTop(body, mgl=float(rows.mgl[flat]), com=spec.scene.com)
            if isinstance(spec.scene, HeavyTop)
            else FreeBody(body)
        )
        begin, step = (record["omega"], record["attitude"]), float(record["step"])
        if not math.isfinite(step):  # it was not run: only its start is known
            run = simulate(scene, *begin, t=[0.0], method=spec.method)
        elif t is None:
            total = round(min(spec.t_end / step, spec.max_steps))
            ends = np.linspace(0, total, min(total, 500) + 1).astype(np.int64)
            strides = np.diff(ends, prepend=0).tolist()
            run = replay_steps(scene, *begin, method=spec.method, step=step, strides=strides)
        else:
            run = simulate(scene, *begin, t=t, method=spec.method, step=step)
        values = dict(record)
        values["outcome"] = values.pop("class")
        return Replay(
            pixel=index,
            sample=number,
            parameters={
                axis.name: axis.values[position]
                for axis, position in zip(spec.axes, reversed(index), strict=True)
            },
            run=run,
            **values,
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the map; see :func:`rigid.plotting.plot_map`.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw; by default on a new figure that needs no display.

        Returns
        -------
        matplotlib Axes
            ``plot().figure.savefig("map.png")`` writes a picture.

        Raises
        ------
        ImportError
            Without matplotlib.
        """
        from .plotting import plot_map

        return plot_map(self, ax=ax)

    def to_xarray(self) -> xarray.Dataset:
        """The map as an xarray Dataset.

        Dimensions carry the names of the axes with ``_over_`` for ``/``, because netCDF allows no
        slash; coordinates have units; the attributes hold the specification as JSON.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        ImportError
            Without xarray.
        """
        from .mapfile import map_dataset

        return map_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the map to one data-only ``.npz`` file; :func:`load_map` reads it.

        It holds the arrays and the specification as JSON, under the name ``spec.json``. Times of
        this machine are left out, so the same seed gives the same bytes everywhere.

        Parameters
        ----------
        path : path-like
            Taken as it is: no suffix is added.

        Returns
        -------
        Path
            What was written.
        """
        from .mapfile import write_map

        return write_map(self, path)

    def summary(self) -> str:
        """What was computed, the worst error, the undecided, and how theory compares."""
        spec = self.spec
        done = int(self.samples.sum())
        possible = int((self.status == 0).sum())
        step = "step chosen for each body" if spec.step is None else f"step {spec.step:g} s"
        checked = {0.0: "none", 1.0: "all"}.get(spec.check, f"{spec.checked_samples}")
        lines = [
            ("scene", _scene_words(spec)),
            ("start", spec.start.describe([axis.name for axis in spec.axes])),
            *((letter, str(axis)) for letter, axis in zip("xy", spec.axes, strict=False)),
            ("stable", spec.criterion),
            ("method", f"{spec.method}, {step}"),
            (
                "samples",
                f"{spec.samples} per pixel, {checked} repeated with half the step; "
                f"seed {spec.seed}",
            ),
            ("bodies", self._bodies(done, possible)),
            ("classes", self._classes(done)),
            (
                "worst drift",
                f"energy {self.energy_drift.max():.1e}, momentum {self.momentum_drift.max():.1e} "
                "(relative)",
            ),
            ("theory", self._theory_line()),
        ]
        if spec.title:
            lines.insert(0, ("map", spec.title))
        return "\n".join(f"{name:<12}{text}" for name, text in lines)

    def _bodies(self, done: int, possible: int) -> str:
        text = f"{done:,}"
        if not self.complete:
            text += f" of {possible * self.spec.samples:,} (stopped early)"
        impossible = self.status.size - possible
        return f"{text}; {impossible:,} impossible pixels" if impossible else text

    def _classes(self, done: int) -> str:
        counts = {name: int(getattr(self, name).sum()) for name in COUNTS[:4]}
        return ", ".join(
            f"{count:,} {name}" + (f" ({count / done:.2%})" if done else "")
            for name, count in counts.items()
        )

    def _theory_line(self) -> str:
        theory = self.theory()
        if theory is None:
            return "none is known for this map"
        compared = int((~np.isnan(theory.share) & ~np.isnan(self.lower)).sum())
        disagree = int(self.disagreement(theory).sum())
        text = f"{theory.label}: {disagree:,} of {compared:,} pixels outside their 95 % interval"
        return text + (f" ({disagree / compared:.1%}; up to 5 % by chance)" if compared else "")


def stability_map(
    scene: Scene | type[FreeBody] | type[HeavyTop],
    *,
    axes: Mapping[str, ArrayLike],
    samples: int,
    t_end: float,
    stable: Criterion,
    start: Start | None = None,
    method: str = "rk4",
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
    at the next chunk and returns the partial map.

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
        size of the perturbation that the start names.
    samples : int
        Bodies per pixel.
    t_end : float
        Horizon in s: *stable* means stable until then.
    stable : NoFlip or TiltBelow
        The criterion, :func:`no_flip` or :func:`tilt_below`.
    start : Start, optional
        By default a free body spins with 1 rad/s about the axis of its middle moment with
        ``noise=normal(1e-3)``, a top with 5 rad/s about axis 3, ``attitude_noise=normal(1e-3)``.
    method : {"rk4", "splitting"}
        Classical Runge-Kutta of order 4, or the symplectic splitting of order 2.
    step : float, optional
        Time step in s; by default chosen for each body from a bound of its rates.
    check : float
        Share of each pixel's bodies to repeat with half the step, in [0, 1]. A body whose class
        changes is undecided.
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
        start, or a value out of range. Impossible bodies inside the grid are no error: they get a
        ``status``.

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
        method=method,
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
    job = _job(spec)
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
                part = job.run(work.flat(done), work.flat(until), workers)
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


def wilson(
    successes: NDArray[np.int64], trials: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """95 % Wilson interval of a share; NaN without trials.

    E. B. Wilson, *J. Am. Stat. Assoc.* 22 (1927) 209.
    """
    n = np.where(trials > 0, trials, np.nan)
    share = successes / n
    square = _Z95 * _Z95
    centre = share + square / (2.0 * n)
    half = _Z95 * np.sqrt(share * (1.0 - share) / n + square / (4.0 * n * n))
    scale = 1.0 + square / n
    # Exactly 0 and 1 at the ends, where rounding would leave a certain prediction outside.
    lower = np.where(successes == 0, 0.0 * n, (centre - half) / scale)
    upper = np.where(successes == trials, 1.0 + 0.0 * n, (centre + half) / scale)
    return lower, upper


def seed_from(rng: int | np.random.Generator | np.random.SeedSequence | None) -> int:
    """The 128-bit key of the random numbers that ``rng`` stands for."""
    if rng is None:
        rng = np.random.SeedSequence()
    if isinstance(rng, np.random.SeedSequence):
        low, high = rng.generate_state(2, np.uint64).tolist()
    elif isinstance(rng, np.random.Generator):
        low, high = rng.integers(2**64, size=2, dtype=np.uint64).tolist()
    else:
        return _checked_seed(rng)
    return int(low) | int(high) << 64


def _checked_seed(seed: object) -> int:
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)):
        raise TypeError(
            f"rng = {seed!r}: must be a whole number, a numpy Generator or SeedSequence, or None"
        )
    if not 0 <= int(seed) < 2**128:
        raise ValueError(f"rng = {seed}: must lie in 0 .. 2**128 - 1")
    return int(seed)


def _scene(scene: object) -> Scene:
    if scene is FreeBody:
        return FreeBody(Body((1.0, 1.5, 2.0)))
    if scene is HeavyTop:
        return HeavyTop(Body((1.0, 1.0, 0.5)), mgl=1.0)
    if isinstance(scene, (FreeBody, HeavyTop)):
        return scene
    raise TypeError(f"scene = {scene!r}: must be a rigid.FreeBody or rigid.HeavyTop")


def _scene_words(spec: MapSpec) -> str:
    varied = {axis.name.partition("/")[0] for axis in spec.axes}

    def numbers(values: Iterable[tuple[str, float]]) -> str:
        return ", ".join("varied" if name in varied else f"{value:g}" for name, value in values)

    body = spec.scene.body
    if body.sides is not None:
        sides, mass = numbers(zip("abc", body.sides, strict=True)), [("mass", body.mass or 0.0)]
        words = f"box with sides ({sides}) m and mass {numbers(mass)} kg"
    else:
        moments = numbers(zip(("I1", "I2", "I3"), body.moments, strict=True))
        words = f"moments ({moments})"
    if isinstance(spec.scene, HeavyTop):
        com = ", ".join(f"{part:g}" for part in spec.scene.com)
        return f"heavy top, {words}, mgl {numbers([('mgl', spec.scene.mgl)])}, com ({com})"
    return f"free body, {words}"


def _default_start(scene: Scene) -> Start:
    if isinstance(scene, HeavyTop):
        return Start(spin=5.0, attitude_noise=normal(1e-3))
    middle = int(np.argsort(scene.body.moments, kind="stable")[1]) + 1
    return Start(spin=1.0, axis=middle, noise=normal(1e-3))


def _job(spec: MapSpec) -> _core.MapJob:
    rows = pixels(spec.scene, spec.start, spec.axes)
    criterion, axis, limit = spec.stable.core()
    noise, attitude_noise = spec.start.noise, spec.start.attitude_noise
    return _core.MapJob(
        scene=spec.scene.kind,
        method=spec.method,
        moments=rows.moments,
        weight=rows.weight,
        omega=rows.omega,
        omega_noise="none" if noise is None else noise.kind,
        omega_size=rows.omega_size,
        attitude=rows.attitude,
        attitude_noise="none" if attitude_noise is None else attitude_noise.kind,
        attitude_size=rows.attitude_size,
        criterion=criterion,
        axis=axis,
        limit=limit,
        t_end=spec.t_end,
        step=spec.step,
        max_steps=spec.max_steps,
        samples=spec.samples,
        checked=spec.checked_samples,
        seed=spec.seed,
    )


def _empty(status: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
    counted: dict[str, NDArray[Any]] = {
        name: np.zeros(status.shape, dtype) for name, dtype in STORED.items()
    }
    counted["status"] = status
    counted["earliest"] = np.full(status.shape, np.inf)
    counted["nanoseconds"] = np.zeros(status.shape)
    return counted


def _merge(counted: dict[str, NDArray[Any]], part: Mapping[str, Any]) -> None:
    window = slice(part["first"], part["first"] + len(part["stable"]))
    for name in (*COUNTS, "steps", "nanoseconds"):
        counted[name][window] += part[name]
    for name in ("energy_drift", "momentum_drift"):
        np.maximum(counted[name][window], part[name], out=counted[name][window])
    np.minimum(counted["earliest"][window], part["earliest"], out=counted["earliest"][window])


def _costliest(part: Mapping[str, Any]) -> float:
    """Largest mean processor time of a body over the pixels of a chunk, s."""
    bodies = sum(part[name] for name in COUNTS[:4])
    seconds = 1e-9 * part["nanoseconds"][bodies > 0] / bodies[bodies > 0]
    return float(seconds.max(initial=0.0))


def _pixel_index(pixel: int | tuple[int, ...], shape: tuple[int, ...]) -> tuple[int, ...]:
    if isinstance(pixel, tuple):
        index = tuple(operator.index(part) for part in pixel)
        inside = len(index) == len(shape) and all(
            0 <= part < length for part, length in zip(index, shape, strict=True)
        )
    else:
        inside = 0 <= operator.index(pixel) < math.prod(shape)
        index = tuple(int(part) for part in np.unravel_index(pixel, shape)) if inside else ()
    if not inside:
        raise IndexError(f"pixel = {pixel}: lies outside the map of shape {shape}")
    return index
