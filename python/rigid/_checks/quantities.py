"""Numbers of other libraries: quantities of Pint become SI numbers, masked ones are refused."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from math import pi
from typing import Any

LARGE_SIDE, LEAST_DENSITY = 5.0, 0.1
"""Above this side (m) a body below this density (kg/m³) has other units: aerogels have 0.16."""

_LENGTHS = ("about", "com", "height", "inner", "pivot", "points", "positions", "radius", "vertices")
_RATES = ("omega", "rates", "spin", "spins")
_TIMES = ("dt", "every", "step", "t", "t0", "t_end", "torque times")
_ANGLES = ("angle", "angles", "limit", "tilt")

UNITS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(_LENGTHS, ("m",)),
    **dict.fromkeys(_RATES, ("rad/s",)),
    **dict.fromkeys(_TIMES, ("s",)),
    **dict.fromkeys(_ANGLES, ("rad",)),
    "coefficient": ("kg m² s",),
    "damping": ("N m s",),
    "density": ("kg/m³",),
    "energy": ("J",),
    "g": ("m/s²",),
    "mass": ("kg",),
    "masses": ("kg",),
    "mgl": ("J",),
    "moments": ("kg m²",),
    "momentum": ("kg m²/s",),
    "size": ("rad/s", "rad"),  # of the rates, or of an attitude
    "tensor": ("kg m²",),
    "torque": ("N m",),
}
"""SI units of arguments by name, for names that mean the same everywhere; some names have two
units."""


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_MEASURE = re.compile(rf"\s*({_NUMBER})(?![\d.])\s*(\S.*?)?\s*")
"""A number and its unit in a text, such as ``35 deg``."""

_TURNING = {
    **dict.fromkeys(("deg", "degree", "degrees", "°"), ("rad", "degree", pi / 180.0)),
    **dict.fromkeys(("deg/s", "°/s"), ("rad/s", "degree", pi / 180.0)),
    "rpm": ("rad/s", "rpm", pi / 30.0),
}
"""The SI unit, the constant of :mod:`rigid.units` and its size for the names of a unit."""


def instead_of_a_text(name: str, value: Any, unit: str | None = None) -> str:
    """What to write instead of a text such as ``"35 deg"``; nothing if there is no text."""
    texts = [value] if isinstance(value, str) else _texts(value)
    if not texts:
        return ""
    units = [one for one in (UNITS.get(name, ()) if unit is None else (unit,)) if one != "1"]
    rule = f" in {' or '.join(units)}" if units else ""
    measure = _MEASURE.fullmatch(texts[0])
    if measure is None:
        return f"{rule}, not a text"
    if measure[2] is None:
        return f"{rule}, not a text; leave out the quotation marks"
    rule += ", written without the unit"
    if measure[2] in _TURNING:
        unit, constant, size = _TURNING[measure[2]]
        if not units or unit in units:
            number = float(measure[1]) * size
            return f"{rule}; {measure[1]} * rigid.units.{constant} is {number:.12g}"
    return rule


def _texts(value: Any) -> list[str]:
    """The texts in a list or an array."""
    if isinstance(value, str):
        return [value]
    if hasattr(value, "tolist"):
        value = value.tolist()
    if not isinstance(value, (list, tuple)):
        return []
    return [text for part in value for text in _texts(part)]


def plain(name: str, value: Any, unit: str | None = None) -> Any:
    """``value`` :func:`without_unit`; ValueError if elements of an array are masked."""
    if "pint" in sys.modules:
        value = without_unit(name, value, unit)
    masked = sys.modules.get("numpy.ma")  # there is no masked array before it is imported
    if masked is not None and (count := _masked(value, masked)):
        raise ValueError(f"{name}: {count} elements are masked; fill them or leave them out")
    return value


def _masked(value: Any, masked: Any) -> int:
    """The number of masked elements of an array, or of the arrays in a list."""
    if isinstance(value, (list, tuple)):
        holds = _holds(value, masked.MaskedArray)
        return sum(_masked(part, masked) for part in value) if holds else 0
    return int(masked.count_masked(value)) if isinstance(value, masked.MaskedArray) else 0


def without_unit(name: str, value: Any, unit: str | None = None) -> Any:
    """``value`` as a number or an array in SI units, if it is a quantity of Pint.

    Lists and tuples may hold quantities; plain numbers among them are in SI units. ``unit`` is the
    unit of the argument; None takes the units of :data:`UNITS`.

    Raises
    ------
    ValueError
        Naming the argument and both units, if the quantity is of another kind, is a frequency in
        hertz where a rate in rad/s is expected, or if the argument takes no unit.
    """
    pint = sys.modules.get("pint")  # there is no quantity before it is imported
    if pint is None:
        return value
    if isinstance(value, (list, tuple)):
        if not _holds(value, pint.Quantity):
            return value
        return [without_unit(name, part, unit) for part in value]
    if not isinstance(value, pint.Quantity):
        return value
    units = UNITS.get(name, ("1",)) if unit is None else (unit,)
    given = f"{value.units}" or "dimensionless"
    if "hertz" in given and "rad/s" in units:
        # Pint takes a hertz for one radian in a second, and not for a turn.
        raise ValueError(f"{name} in {given}: a rate is in rad/s, rpm or degrees per second")
    for known in units:
        if value.is_compatible_with("dimensionless" if known == "1" else known):
            return value.to("dimensionless" if known == "1" else known).magnitude
    rule = f"must be in {' or '.join(units)} or a unit of its kind"
    if units == ("1",):
        rule = "takes numbers without units"
    raise ValueError(f"{name} in {given}: {rule}")


def _holds(value: list[Any] | tuple[Any, ...], kind: type) -> bool:
    """Whether there is an element of this type in a nested list."""
    return any(
        _holds(part, kind) if isinstance(part, (list, tuple)) else isinstance(part, kind)
        for part in value
    )
