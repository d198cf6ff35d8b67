"""The summary of a stability map in words."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from .._checks.shown import labelled
from ..model.start import Start
from ..solve.methods import AUTO, EXACT
from .axes import axis_letter
from .data import CLASSES, FAILURES, MapData
from .measured import Measured
from .refine import LEFT_OUT, refined
from .spec import MapSpec
from .theory import agreement, predict
from .words import own_unit


def summary(data: MapData) -> str:
    """Summary of computation, largest drift, undecided samples and comparison with theory."""
    spec = data.spec
    start = spec.start.describe([axis.name for axis in spec.axes])
    lines = [
        ("scene", spec.scene_words.replace("rad/s", own_unit(spec, "rad/s"))),
        ("start", start.replace("rad/s", own_unit(spec, "rad/s"))),
        *(
            (axis_letter(place), axis.words(own_unit(spec, axis.unit)))
            for place, axis in enumerate(spec.axes)
        ),
        *([("varied", ", ".join(map(str, spec.vary)))] if spec.vary else []),
        ("stable", spec.criterion),
        ("method", _method(data)),
        ("samples", _samples(data)),
        ("bodies", _bodies(data)),
        ("classes", _classes(data)),
        *([("exponents", _exponents(data))] if spec.stable.has_deviation else []),
        *(("measured", _measured(data, one)) for one in data.measures.values()),
        ("worst drift", _drift(data)),
        ("theory", _theory(data)),
    ]
    if spec.clock.by_motion:
        lines.insert(0, ("units", "n is the mean motion, an orbit lasts 2 pi/n"))
    if spec.title:
        lines.insert(0, ("map", spec.title))
    return labelled(lines)


def _method(data: MapData) -> str:
    spec, done, exact = data.spec, int(data.samples.sum()), int(data.exact.sum())
    step = "step chosen for each body" if spec.step is None else f"step {spec.step:g} s"
    if spec.method not in (AUTO, EXACT):
        return f"{spec.method}, {step}"
    if exact == done:
        return f"{spec.method}: closed form"
    share = f"closed form for {exact:,} bodies, else " if exact else ""
    return f"{spec.method}: {share}{spec.scheme}, {step}"


def _samples(data: MapData) -> str:
    text = f"{data.spec.samples} per pixel"
    if data.spec.half_width is not None:
        text = (
            f"64 to {data.spec.samples} per pixel, until the share is known to within "
            f"{data.spec.half_width:g}: {_narrow(data)}"
        )
    done = int(data.samples.sum())
    integrated, repeated = done - int(data.exact.sum()), int(data.checked.sum())
    if integrated:
        checked = {0: "none", integrated: "all"}.get(repeated, f"{repeated:,}")
        which = "" if integrated == done else " of those integrated"
        text += f", {checked}{which} cross-checked by {data.spec.second}"
        text += " in half the steps" if data.spec.is_called else ""
        audited, differ = data.audited.sum(), data.audited_undecided.sum()
        if 0 < audited < repeated:
            text += f", {audited:,} of these as an audit: {differ:,} differ"
    return f"{text}; seed {data.spec.seed}"


def _narrow(data: MapData) -> str:
    """How many pixels met the half width, and how many did not."""
    asked = data.status == 0
    if data.spec.refine is not None:
        asked &= data.stage != LEFT_OUT
    missed = int((asked & ~data.narrow).sum())
    text = f"so in {int((asked & data.narrow).sum()):,} pixels"
    return f"{text}, not in {missed:,}" if missed else text


def _bodies(data: MapData) -> str:
    done, possible = int(data.samples.sum()), int((data.status == 0).sum())
    text = f"{done:,}"
    if refined(data.spec):
        computed = int((data.samples > 0).sum())
        text += f" in {computed:,} of {possible:,} pixels"
        if not data.ended:
            text += " (stopped early)"
        elif data.cut:
            stage = "" if data.spec.refine is None else "of the next stage "
            text += f"; the budget of {data.spec.budget:,} omits {data.cut:,} {stage}".rstrip()
    elif data.spec.half_width is not None:
        text += "" if data.complete else " (stopped early)"
    elif not data.complete:
        text += f" of {possible * data.spec.samples:,} (stopped early)"
    impossible = data.status.size - possible
    return f"{text}; {impossible:,} impossible pixels" if impossible else text


def _classes(data: MapData) -> str:
    done = int(data.samples.sum())
    counts = {name: int(data.columns[name].sum()) for name in (*CLASSES, *FAILURES)}
    text = ", ".join(
        f"{counts[name]:,} {name}" + (f" ({counts[name] / done:.2%})" if done else "")
        for name in CLASSES
    )
    why = ", ".join(
        f"{counts[name]:,} {name.replace('_', ' ')}" for name in FAILURES if counts[name]
    )
    return f"{text}: {why}" if why else text


def _exponents(data: MapData) -> str:
    known = data.largest_exponent[~np.isnan(data.largest_exponent)]
    if not known.size:
        return "none measured"
    rate = data.spec.clock.rate
    return f"largest {rate(known.max())}; none below {rate(data.resolution)} can be seen"


def _measured(data: MapData, measured: Measured) -> str:
    shown, factor = data.spec.clock.shown(measured.measure.unit)
    bodies, *totals = measured.totals()
    mean, least, largest = (factor * number for number in totals)
    unit = "" if shown == "1" else f" {shown}"
    rest = f", {without:,} undecided" if (without := _undecided(data, measured)) else ""
    if not bodies:
        return f"{measured.measure}: of no body{rest}"
    text = f"mean {mean:.4g}{unit}, from {least:.4g} to {largest:.4g}{unit}"
    known = measured.error[~np.isnan(measured.error)]
    error = f", error at most {factor * known.max():.1e}{unit}" if known.size else ""
    return f"{measured.measure}: {text}{error}, of {bodies:,} bodies{rest}"


def _undecided(data: MapData, measured: Measured) -> int:
    """Bodies without a value whose verdict says that they have one."""
    name, spec = measured.measure.name, data.spec
    is_joined = len(spec.stable.leaves) > 1
    # No verdict tells how many bodies settle.
    if name in ("drift", "time_to_settle") or spec.check == 0.0:
        return 0
    if name == "time_to_leave" and is_joined:
        return 0
    asked = data.unstable if name == "time_to_leave" else data.samples - data.failed
    return max(int((asked - measured.count).sum()), 0)


def _drift(data: MapData) -> str:
    if 0 < int(data.samples.sum()) == data.exact.sum():
        return "none: closed form"
    drifts = {
        "energy": data.energy_drift,
        "momentum": data.momentum_drift,
        "unit lengths": data.unit_drift,
    }
    if "orbit" in data.spec.forces:  # neither is constant
        del drifts["energy"], drifts["momentum"]
    return ", ".join(f"{name} {_worst(values)}" for name, values in drifts.items()) + " (relative)"


def _worst(drifts: NDArray[np.float64]) -> str:
    known = drifts[~np.isnan(drifts)]
    return f"{known.max():.1e}" if known.size else "unknown"


def _why_none(spec: MapSpec) -> str:
    """That theory knows the map without the noise of its attitude, if so."""
    start = spec.start
    if not isinstance(start, Start) or start.attitude_noise is None:
        return ""
    if any(axis.name.startswith("attitude_") for axis in spec.axes):
        return ""
    without = spec.replace(start=dataclasses.replace(start, attitude_noise=None))
    return "" if predict(without) is None else ": one is without attitude_noise"


def _theory(data: MapData) -> str:
    found = agreement(data)
    if found is None:
        return f"none is known for this map{_why_none(data.spec)}"
    compared, disagree = found.compared, found.disagree
    if not compared:
        return f"{found.label}: lines, no shares"
    text = (
        f"{found.label}: {disagree:,} of {compared:,} pixels outside their 95 % interval "
        f"({disagree / compared:.1%}; up to 5 % by chance)"
    )
    return f"{text}; no prediction for {found.unknown:,} pixels" if found.unknown else text
