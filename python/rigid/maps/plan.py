"""The plan of a map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._moments import possible
from ..solve.closed_form import NO_FORM, Codes, closed_forms, names, why_not
from ..solve.cost_model import calibration_class_of_any, closed_form_estimate, steps_estimate
from ..solve.methods import AUTO, EXACT
from ..solve.plan import Plan, carried, left_out
from .spec import MapSpec

__all__ = ["map_plan"]

Floats = NDArray[np.float64]


def map_plan(spec: MapSpec) -> Plan:
    """The plan of a map; its numbers are those of the costliest nominal start, run once."""
    real = possible(spec.grid.moments)
    moments, weight = spec.grid.moments[real], spec.grid.weight[real]
    forms = closed_forms(spec.stable, moments, weight)
    if spec.is_driven:
        forms = np.full_like(forms, NO_FORM)
    method, why = _choice(spec, moments, weight, forms)
    rates = _rates(spec, np.flatnonzero(real), spec.scheme)
    if method == AUTO:
        rates = rates[forms == NO_FORM]
    if method == EXACT:
        estimate = closed_form_estimate(spec.stable, forms, 0, rates, spec.t_end)
    else:
        kind = "driven" if spec.is_driven else calibration_class_of_any(spec.scene)
        steps: float | Floats | None = spec.step
        if steps is None:
            steps = _core.default_steps(spec.method, rates, spec.stable.displaced)
        estimate = steps_estimate(spec.stable, spec.scheme, kind, rates, spec.t_end, steps)
    return Plan(
        scene=spec.scene_words,
        question=spec.criterion,
        closed_form=", ".join(names(forms)) or None if method in (AUTO, EXACT) else None,
        method=method,
        carried=carried(spec.scene, spec.stable, method),
        why=(why,),
        left_out=left_out(spec.scene, spec.stable, method, spec.step, forms),
        step=estimate.step,
        steps=estimate.steps,
        work=estimate.work,
        error=estimate.error,
    )


def _choice(spec: MapSpec, moments: Floats, weight: Floats, forms: Codes) -> tuple[str, str]:
    """The method of the possible pixels and the reason; ``"auto"`` where two are needed."""
    if spec.method not in (AUTO, EXACT):
        return spec.method, f"method = {spec.method!r} was asked for"
    closed = forms != NO_FORM
    if not closed.size:
        return EXACT, "no pixel has a possible body: nothing is done"
    if closed.all():
        return EXACT, "every body has a closed form"
    if closed.any():
        return AUTO, f"{closed.sum():,} of {closed.size:,} pixels have a closed form"
    if spec.is_driven:
        return spec.scheme, "no closed form under torque and damping"
    return spec.scheme, why_not(spec.stable, moments[0], weight[0])


def _rates(spec: MapSpec, pixels: NDArray[np.intp], scheme: str) -> Floats:
    """The rates that the steps of these pixels follow."""
    rates = np.zeros(len(pixels))
    for start in spec.start.starts:
        grid = spec.starting(start)
        starts = grid.omega[pixels], grid.attitude[pixels]
        for mine, batch in grid.batches_by_forcing(pixels, *starts):
            fastest = batch.fastest_rates((0.0, spec.t_end), scheme)
            rates[mine] = np.maximum(rates[mine], fastest)
    return rates
