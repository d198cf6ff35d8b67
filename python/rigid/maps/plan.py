"""The plan of a map."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..model.forces import forces_in_words
from ..solve.bodies import Bodies
from ..solve.closed_form import NO_FORM, Codes, closed_forms, names, why_not
from ..solve.cost_model import (
    Estimate,
    Motions,
    calibration_class_of_any,
    calibration_class_of_forces,
    closed_form_estimate,
    joined,
    steps_estimate,
)
from ..solve.foresight import motions_of, why_unforeseen
from ..solve.methods import AUTO, EXACT
from ..solve.plan import Plan, carried, left_out, not_left_out
from ..solve.planned import UNKNOWN
from .spec import MapSpec

__all__ = ["map_plan"]

Floats = NDArray[np.float64]


def map_plan(spec: MapSpec) -> Plan:
    """The plan of a map, with the cost of its costliest nominal start."""
    real = spec.grid.possible
    moments, weight = spec.grid.moving[real], spec.grid.weight[real]
    forms = closed_forms(spec.stable, moments, weight)
    if spec.forces:
        forms = np.full_like(forms, NO_FORM)
    method, why = _choice(spec, moments, weight, forms)
    of_pixels = np.flatnonzero(real)
    batches = list(_batches(spec, of_pixels[forms == NO_FORM] if method == AUTO else of_pixels))
    estimate = _estimate(spec, method, forms, batches)
    reasons, error = [why], estimate.error
    unknown = estimate.unknown
    if error is not None:
        span = (0.0, spec.t_end)
        looks = (why_unforeseen(batch, span, by_steps=method != EXACT) for batch in batches)
        unknown = next((words for words in looks if words is not None), None)
    if spec.is_called and error is not None:
        unknown = "a function gives the torque"
    if unknown is not None:
        error = None
        reasons.append(UNKNOWN.format(unknown))
    torque = (spec.scene if spec.made is None else spec.made).torque
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
        step=estimate.step,
        steps=estimate.steps,
        work=estimate.work,
        error=error,
    )


def _estimate(spec: MapSpec, method: str, forms: Codes, batches: list[Bodies]) -> Estimate:
    """Work and error of the nominal starts."""
    span = (0.0, spec.t_end)
    if method == EXACT:
        rates = [batch.fastest_rates(span) for batch in batches]
        every = np.concatenate([np.zeros(0), *rates])
        return closed_form_estimate(spec.stable, forms, 0, every, spec.t_end)
    scene = spec.scene
    kind = calibration_class_of_forces(scene) if spec.forces else calibration_class_of_any(scene)
    motions = [_motions(spec, batch) for batch in batches]
    return steps_estimate(spec.stable, spec.scheme, kind, joined(motions))


def _motions(spec: MapSpec, batch: Bodies) -> Motions:
    span = (0.0, spec.t_end)
    rates = batch.fastest_rates(span, spec.scheme)
    if spec.step is None:
        steps = _core.default_steps(spec.method, rates, spec.stable.has_deviation)
    else:
        steps = np.full(len(rates), spec.step)
    return motions_of(batch, spec.scheme, span, spec.t_end, steps, states=1)


def _choice(spec: MapSpec, moments: Floats, weight: Floats, forms: Codes) -> tuple[str, str]:
    """The method of the possible pixels and the reason; ``"auto"`` if two methods are needed."""
    if spec.method not in (AUTO, EXACT):
        return spec.method, f"method = {spec.method!r} was asked for"
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
    """The nominal starts of these pixels, in batches under the same forces."""
    for start in spec.start.starts:
        grid = spec.starting(start)
        starts = grid.omega[pixels], grid.attitude[pixels]
        for _, batch in grid.batches_by_forces(pixels, *starts):
            yield batch
