"""The plan of a map, and the smaller maps by which a plan is timed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arrays import Floats
from .._timing import LEAST_STEPS
from ..model.bodies import Bodies
from ..model.body import Body
from ..model.criterion import Criterion
from ..model.forces import forces_in_words
from ..model.judged import Custom
from ..model.mixture import Mixture
from ..model.scene import Scene, check_scene
from ..model.start import Start
from ..solve.closed_form import NO_FORM, Codes, closed_forms, names, why_not
from ..solve.methods import AUTO, EXACT
from ..solve.plan import (
    UNKNOWN,
    Plan,
    carried,
    closed_form_error,
    left_out,
    not_left_out,
    shortest_and_most,
    why_unforeseen,
)
from .axes import Axis
from .judge import TOLERANCE, is_adaptive
from .spec import MapSpec


def map_plan(spec: MapSpec) -> Plan:
    """The plan of a map, for its nominal starts."""
    real = spec.grid.possible
    moments, weight = spec.grid.moving[real], spec.grid.weight[real]
    forms = closed_forms(spec.stable, moments, weight)
    if spec.forces:
        forms = np.full_like(forms, NO_FORM)
    method, why = _choice(spec, moments, weight, forms)
    of_pixels = np.flatnonzero(real)
    reasons, error, tolerance = [why], None, None
    step: float | None = None
    steps: int | None = 0
    if method == EXACT:
        batches = list(_batches(spec, of_pixels))
        span = (0.0, spec.t_end)
        error = closed_form_error(_joined(batch.fastest_rates(span) for batch in batches), span[1])
        looks = (why_unforeseen(batch, spec.t_end) for batch in batches)
        unknown = next((words for words in looks if words is not None), None)
        if error is not None and unknown is not None:
            error = None
            reasons.append(UNKNOWN.format(unknown))
    elif is_adaptive(spec, spec.scheme):
        steps, tolerance = None, TOLERANCE
    else:
        moved = of_pixels[forms == NO_FORM] if method == AUTO else of_pixels
        planned = [_steps(spec, batch) for batch in _batches(spec, moved)]
        longest, times = (_joined(rows) for rows in zip(*planned, strict=True))
        step, steps = shortest_and_most(longest, times)
    torque = spec.whole.torque
    if torque is not None and torque.function is not None:
        reasons.extend(torque.function.reasons)
    done = carried(spec.scene, spec.stable, method, spec.forces)
    return Plan(
        scene=spec.scene_words,
        question=spec.criterion,
        closed_form=", ".join(names(forms)) or None if method in (AUTO, EXACT) else None,
        method=method,
        carried=done,
        why=(*reasons, *not_left_out(done, spec.forces)),
        left_out=left_out(spec.scene, spec.stable, method, spec.step, forms, spec.forces),
        step=step,
        steps=steps,
        tolerance=tolerance,
        error=error,
    )


def _joined(rows: Iterable[Floats]) -> Floats:
    return np.concatenate([np.zeros(0), *rows])


def _steps(spec: MapSpec, batch: Bodies) -> tuple[Floats, Floats]:
    """The longest step of each body (s), and the time in which so long ones are as many."""
    of = "growth" if spec.stable.has_deviation else "samples"
    return batch.planned_steps(spec.method, (0.0, spec.t_end), of, spec.step)


def _choice(spec: MapSpec, moments: Floats, weight: Floats, forms: Codes) -> tuple[str, str]:
    """The method of the possible pixels and the reason; ``"auto"`` if two methods are needed."""
    if spec.method not in (AUTO, EXACT):
        return spec.method, f"method = {spec.method!r} was asked for"
    if spec.vary and not spec.forces:
        return AUTO, "parameters vary: in closed form each body that has one"
    closed = forms != NO_FORM
    if not closed.size:
        return EXACT, "no pixel has a possible body: nothing is done"
    if closed.all():
        return EXACT, "every body has a closed form"
    if closed.any():
        return AUTO, f"{closed.sum():,} of {closed.size:,} pixels have a closed form"
    if spec.forces:
        return spec.scheme, f"no closed form under {forces_in_words(spec.forces)}"
    return spec.scheme, why_not(spec.stable, moments[0], weight[0])


def _batches(spec: MapSpec, pixels: NDArray[np.intp]) -> Iterator[Bodies]:
    """The nominal starts of these pixels, for each start of a mixture."""
    for start in spec.start.starts:
        grid = spec.bodies(start)
        yield grid.bodies(pixels, grid.omega[pixels], grid.attitude[pixels])


def of_one_pixel(
    scene: Scene | Body,
    stable: Criterion,
    *,
    start: Start | Mixture | None,
    t_end: float | None,
    **asked: Any,
) -> MapSpec:
    """The specification of a map without axes: of one pixel, in which one body starts."""
    scene = check_scene(scene)
    if t_end is None and isinstance(stable, Custom):
        t_end = stable.times[-1]
    if t_end is None:
        raise TypeError("plan() needs t_end")
    return MapSpec(
        scene=scene,
        start=start or scene.default_start(),
        axes=(),
        stable=stable,
        t_end=t_end,
        samples=1,
        seed=0,
        **{name: value for name, value in asked.items() if value is not None},
    )


def shortened(spec: MapSpec, share: float) -> MapSpec:
    """The same map until this share of its horizon and of its most steps."""
    if share == 1.0:
        return spec
    changes: dict[str, Any] = {
        "t_end": share * spec.t_end,
        "max_steps": min(spec.max_steps, max(LEAST_STEPS, int(share * spec.max_steps))),
        "axes": tuple(_shortened(axis, share) for axis in spec.axes),
    }
    if isinstance(spec.stable, Custom):
        times = tuple(share * time for time in spec.stable.times)
        changes |= {"stable": replace(spec.stable, times=times), "t_end": times[-1]}
    return spec.replace(**changes)


def _shortened(axis: Axis, share: float) -> Axis:
    """The axis, with shares of its values if these are horizons."""
    if axis.name != "t_end":
        return axis
    return replace(axis, values=tuple(share * value for value in axis.values))
