"""The result of a stability map: named arrays, pictures, files, and every body again alone."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._check import positive_int, resolve_threads
from .bodies import Body
from .grid import pixels
from .mapspec import MapSpec, core_job
from .methods import AUTO, EXACT, FALLBACK, SECOND
from .plan import Plan, map_plan
from .scenes import FreeBody, HeavyTop, scene_words
from .simulate import Run, replay_steps, simulate

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

    from .theory import Theory

__all__ = ["COUNTS", "FAILURES", "STATUS", "STORED", "Replay", "StabilityMap", "wilson"]

STATUS = ("possible", "not finite", "not positive", "triangle inequality broken")

COUNTS = ("stable", "unstable", "undecided", "failed", "checked")
FAILURES = ("step_limit", "not_finite", "drifted")
"""Why a body has failed: these sum up to the failed."""
STORED: Mapping[str, type[np.generic]] = {
    **dict.fromkeys((*COUNTS, *FAILURES), np.int64),
    "energy_drift": np.float64,
    "momentum_drift": np.float64,
    "earliest": np.float64,
    "steps": np.int64,
    "exact": np.int64,
    "status": np.uint8,
}
"""The arrays of a saved map that the others follow from, with their types."""

_Z95 = 1.959963984540054


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
    method : str
        ``"exact"`` if it was classified in closed form, else the scheme.
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
        NaN by closed form, which conserves both.
    step : float
        Time step in s; NaN by closed form.
    steps : int
    run : Run
        The trajectory until the horizon, with the same method and step.
    """

    pixel: tuple[int, ...]
    sample: int
    parameters: dict[str, float]
    omega: NDArray[np.float64]
    attitude: NDArray[np.float64]
    method: str
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
        Bodies of each class. Undecided: the second method disagrees; in closed form, the body
        leaves stability within rounding of the horizon.
    step_limit, not_finite, drifted : ndarray of int64
        Why bodies have failed: more than ``max_steps`` steps were needed; overflow; energy,
        momentum or unit lengths off by more than 0.1.
    checked : ndarray of int64
        Bodies judged again by the second method, ``taylor16``.
    samples : ndarray of int64
        Bodies done, the sum of the four classes.
    share : ndarray
        ``stable / (stable + unstable)``, NaN if there are none.
    lower, upper : ndarray
        95 % Wilson interval of the share, widened by the undecided: they count as unstable for
        ``lower`` and as stable for ``upper``.
    energy_drift, momentum_drift : ndarray
        Worst relative drift of the conserved quantities in each pixel, failed bodies included; NaN
        where nothing was integrated, because closed forms do not drift.
    earliest : ndarray
        First time at which a body left stability, s; inf if none did.
    steps : ndarray of int64
        Time steps taken.
    exact : ndarray of int64
        Bodies classified in closed form; they take no steps and are not repeated.
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
    step_limit: NDArray[np.int64]
    not_finite: NDArray[np.int64]
    drifted: NDArray[np.int64]
    checked: NDArray[np.int64]
    samples: NDArray[np.int64]
    share: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    energy_drift: NDArray[np.float64]
    momentum_drift: NDArray[np.float64]
    earliest: NDArray[np.float64]
    steps: NDArray[np.int64]
    exact: NDArray[np.int64]
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

    @property
    def plan(self) -> Plan:
        """What was done for this map, what was left out, and why."""
        return map_plan(self.spec)

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
            default about 500 ends of the very steps that were taken, until ``t_end``, or 501 times
            by closed form. Of a body that was not run, because of ``max_steps`` say, there is only
            the start.

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
        record = core_job(spec).sample(flat, number)
        i1, i2, i3 = rows.moments[flat].tolist()
        body = Body((i1, i2, i3))
        acting: dict[str, Any] = {"torque": spec.scene.torque}
        if rows.damping is not None:
            acting["damping"] = rows.damping[flat]
        scene = (
            HeavyTop(body, mgl=float(rows.mgl[flat]), com=spec.scene.com, **acting)
            if isinstance(spec.scene, HeavyTop)
            else FreeBody(body, **acting)
        )
        begin, step = (record["omega"], record["attitude"]), float(record["step"])
        method = record["method"]
        if method == EXACT:
            times = np.linspace(0.0, spec.t_end, 501) if t is None else t
            run = simulate(scene, *begin, t=times, method=method)
        elif not math.isfinite(step):  # it was not run: only its start is known
            run = simulate(scene, *begin, t=[0.0], method=method)
        elif t is None:
            total = round(min(spec.t_end / step, spec.max_steps))
            ends = np.linspace(0, total, min(total, 500) + 1).astype(np.int64)
            strides = np.diff(ends, prepend=0).tolist()
            run = replay_steps(scene, *begin, method=method, step=step, strides=strides)
        else:
            run = simulate(scene, *begin, t=t, method=method, step=step)
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

    def condition(self, samples: int = 1, *, threads: int | None = None) -> NDArray[np.float64]:
        """How much the motions of this map magnify a small change of their start, by pixel.

        It tells the sensitivity of the physics from errors of the solver; see :func:`condition`.

        Parameters
        ----------
        samples : int
            So many bodies of each pixel, the first, are followed to ``t_end``.
        threads : int, optional
            Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

        Returns
        -------
        ndarray
            Their median at ``t_end``; NaN where no body is possible.

        Raises
        ------
        ValueError
            If ``samples`` is not between 1 and those of the map.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"I2/I1": [1.2, 1.8]}, samples=4, t_end=50.0,
        ...     stable=rigid.no_flip(), rng=2026,
        ... )
        >>> result.condition().shape
        (2,)
        """
        from .conditioning import over_map

        count = positive_int("samples", samples)
        if count > self.spec.samples:
            raise ValueError(f"samples = {count}: the map has {self.spec.samples} in a pixel")
        return over_map(self.spec, count, resolve_threads(threads))

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
        names = [axis.name for axis in spec.axes]
        lines = [
            ("scene", scene_words(spec.scene, [name.partition("/")[0] for name in names])),
            ("start", spec.start.describe(names)),
            *((letter, str(axis)) for letter, axis in zip("xy", spec.axes, strict=False)),
            ("stable", spec.criterion),
            ("method", self._method(done)),
            ("samples", self._samples(done)),
            ("bodies", self._bodies(done, possible)),
            ("classes", self._classes(done)),
            ("worst drift", self._drift(done)),
            ("theory", self._theory_line()),
        ]
        if spec.title:
            lines.insert(0, ("map", spec.title))
        return "\n".join(f"{name:<12}{text}" for name, text in lines)

    def _method(self, done: int) -> str:
        spec, exact = self.spec, int(self.exact.sum())
        step = "step chosen for each body" if spec.step is None else f"step {spec.step:g} s"
        if spec.method not in (AUTO, EXACT):
            return f"{spec.method}, {step}"
        if exact == done:
            return f"{spec.method}: closed form"
        share = f"closed form for {exact:,} bodies, else " if exact else ""
        return f"{spec.method}: {share}{FALLBACK}, {step}"

    def _samples(self, done: int) -> str:
        text = f"{self.spec.samples} per pixel"
        integrated, repeated = done - int(self.exact.sum()), int(self.checked.sum())
        if integrated:
            checked = {0: "none", integrated: "all"}.get(repeated, f"{repeated:,}")
            which = "" if integrated == done else " of those integrated"
            text += f", {checked}{which} judged again by {SECOND}"
        return f"{text}; seed {self.spec.seed}"

    def _drift(self, done: int) -> str:
        if 0 < done == self.exact.sum():
            return "none: closed form"
        worst = f"energy {_worst(self.energy_drift)}, momentum {_worst(self.momentum_drift)}"
        return f"{worst} (relative)"

    def _bodies(self, done: int, possible: int) -> str:
        text = f"{done:,}"
        if not self.complete:
            text += f" of {possible * self.spec.samples:,} (stopped early)"
        impossible = self.status.size - possible
        return f"{text}; {impossible:,} impossible pixels" if impossible else text

    def _classes(self, done: int) -> str:
        counts = {name: int(getattr(self, name).sum()) for name in (*COUNTS[:4], *FAILURES)}
        text = ", ".join(
            f"{counts[name]:,} {name}" + (f" ({counts[name] / done:.2%})" if done else "")
            for name in COUNTS[:4]
        )
        why = ", ".join(
            f"{counts[name]:,} {name.replace('_', ' ')}" for name in FAILURES if counts[name]
        )
        return f"{text}: {why}" if why else text

    def _theory_line(self) -> str:
        theory = self.theory()
        if theory is None:
            return "none is known for this map"
        compared = int((~np.isnan(theory.share) & ~np.isnan(self.lower)).sum())
        disagree = int(self.disagreement(theory).sum())
        text = f"{theory.label}: {disagree:,} of {compared:,} pixels outside their 95 % interval"
        return text + (f" ({disagree / compared:.1%}; up to 5 % by chance)" if compared else "")


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


def _worst(drifts: NDArray[np.float64]) -> str:
    known = drifts[~np.isnan(drifts)]
    return f"{known.max():.1e}" if known.size else "unknown"


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
