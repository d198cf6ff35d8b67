"""States of more bodies than fit into memory, part by part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, numbers, positive_int, times_of_each
from .._checks.arrays import AttitudeLike
from ..model.bodies import bodies_of
from ..model.body import Body
from ..model.forces import FORCES
from ..model.scene import Scene, check_scene
from .plan import Lazy
from .run import Run
from .simulate import simulate


def simulate_chunks(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: AttitudeLike | None = None,
    *,
    t: ArrayLike,
    chunk: int = 65_536,
    **options: Any,
) -> Iterator[Run]:
    """Yield the runs of parts of many bodies, for states that do not fit into memory.

    Only one part is computed at a time, when it is requested. The states of a body have the same
    bits as in one call of :func:`simulate`. All parts have the same arrays: their Datasets can be
    appended, the first by ``part.to_xarray().to_zarr(path)``, the others by
    ``part.to_xarray().to_zarr(path, append_dim="body")``.

    Parameters
    ----------
    scene, omega, attitude, t
        As in :func:`simulate`.
    chunk : int
        Bodies of a part; the last part may have fewer.
    **options
        The other arguments of :func:`simulate`. Arrays of ``out`` have a row for each of all
        bodies, and each part fills its rows: memory maps keep the states on the disk.

    Yields
    ------
    Run
        The bodies of a part, with the leading axis also of a single body.

    Raises
    ------
    ValueError
        As :func:`simulate`. The starts are checked at once, all else with the first part.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> scene = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
    >>> omega = np.random.default_rng(1).normal(size=(1000, 3))
    >>> parts = rigid.simulate_chunks(scene, omega, t=[0.0, 1.0], chunk=400)
    >>> [part.omega.shape for part in parts]
    [(400, 2, 3), (400, 2, 3), (200, 2, 3)]
    """
    scene = check_scene(scene, many=True)
    states = options.pop("states", None)
    if states is not None:
        scene = scene.started(states)
    size = positive_int("chunk", chunk)
    times = times_of_each("t", t)
    bodies = bodies_of(scene, omega, attitude, times=times.shape[:-1], rod=True)
    shape = bodies.shape or (1,)
    if len(shape) > 1:
        raise ValueError(f"omega: expected one axis of bodies, got bodies of shape {shape}")
    count, rates = shape[0], bodies.omega
    if attitude is None:
        attitude = [1.0, 0.0, 0.0, 0.0]
    elif hasattr(attitude, "as_quat"):
        attitude = attitude.as_quat(scalar_first=True)
    turned = numbers("attitude", attitude)
    turned = np.broadcast_to(turned, (count, 4))
    out = options.pop("out", None)
    if out is not None:
        if not isinstance(out, Mapping):
            raise TypeError(f"out = {brief(out)}: must be a dict of arrays by their names")
        for name, array in out.items():
            if np.shape(array)[:1] != (count,):
                raise ValueError(
                    f"out[{name!r}]: expected a row for each of {count} bodies, got shape "
                    f"{np.shape(array)}"
                )
    parts = (slice(first, first + size) for first in range(0, count, size))
    return (
        _with_zeros(
            simulate(
                scene[part] if scene.shape == shape else scene,
                rates[part],
                turned[part],
                t=times[part] if times.shape[:-1] == shape else times,
                out=None if out is None else {name: array[part] for name, array in out.items()},
                **options,
            ),
            scene,
        )
        for part in parts
    )


def _with_zeros(run: Run, whole: Scene) -> Run:
    """A part with zeros for forces on other bodies only: all parts have the same arrays."""
    count, known = len(run.status), run.spec["scene"]
    zeros = {
        name: np.zeros((count, 3, 3) if name == "damping" else (count, 3)).tolist()
        for name in ("damping", *FORCES)
        if getattr(whole, name) is not None and known.get(name) is None
    }
    if not zeros:
        return run
    spec = {**run.spec, "scene": {**known, **zeros}}
    run = replace(run, _spec=Lazy.of(spec))
    if run.work is not None:
        return run
    return run.with_arrays(work=np.zeros(run.omega.shape[:-1], run.omega.dtype))
