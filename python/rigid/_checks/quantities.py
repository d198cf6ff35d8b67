"""Numbers of other libraries: quantities of Pint become SI numbers, masked ones are refused."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

__all__ = ["UNITS", "plain", "without_unit"]

_LENGTHS = ("about", "com", "height", "inner", "pivot", "points", "positions", "radius", "vertices")
_RATES = ("omega", "rates", "spin", "spins")
_TIMES = ("step", "t", "t_end", "torque times")
_ANGLES = ("angle", "angles", "tilt")

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


def plain(name: str, value: Any, unit: str | None = None) -> Any:
    """``value`` :func:`without_unit`; ValueError if elements of an array are masked."""
    if "pint" in sys.modules:
        value = without_unit(name, value, unit)
    masked = sys.modules.get("numpy.ma")  # there is no masked array before it is imported
    if masked is None or not isinstance(value, masked.MaskedArray) or not masked.is_masked(value):
        return value
    raise ValueError(
        f"{name}: {masked.count_masked(value)} elements are masked; fill them or leave them out"
    )


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
