"""What a package has for users: each name stands once, where the package imports it as itself."""

from __future__ import annotations

from collections.abc import Mapping


def exported(names: Mapping[str, object]) -> list[str]:
    """The functions and classes of rigid among the names of a package, in order.

    Type checkers read the same from imports such as ``from .body import Body as Body``.

    Examples
    --------
    >>> import rigid
    >>> from rigid._checks.exported import exported
    >>> exported({"Body": rigid.Body, "_unit": rigid.Body.box, "pi": 3.14})
    ['Body']
    """
    modules = {name: str(getattr(one, "__module__", None)) for name, one in names.items()}
    return sorted(
        name for name, module in modules.items() if module.startswith("rigid.") and name[0] != "_"
    )
