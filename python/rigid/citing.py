"""References of the software and of the methods behind a result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from . import _core
from ._checks.arguments import brief
from .solve.methods import AUTO, EXACT, MAP_FALLBACK, Method, methods
from .solve.plan import Plan

if TYPE_CHECKING:
    from .maps.result import StabilityMap
    from .reports.result import Report
    from .solve.run import Run

__all__ = ["cite"]

CLOSED_FORMS: Mapping[str, tuple[str, str, str]] = {
    "free": (
        "jacobi",
        "C. G. J. Jacobi, Sur la rotation d'un corps, J. reine angew. Math. 39 (1850) 293-350",
        "10.1515/crll.1850.39.293",
    ),
    "spin": (
        "euler",
        "L. Euler, Du mouvement de rotation des corps solides autour d'un axe variable, "
        "Mém. Acad. Sci. Berlin 14 (1765) 154-193",
        "",
    ),
    "lagrange": (
        "klein",
        "F. Klein, A. Sommerfeld, Über die Theorie des Kreisels, Teubner (1897-1910)",
        "",
    ),
}
"""Key, reference and DOI of the closed forms."""

_OF_FORM: Mapping[str, str] = {
    "axis spin": "spin",
    "free symmetric": "spin",
    "free asymmetric": "free",
    "lagrange": "lagrange",
    "pendulum": "lagrange",
}


def cite(used: Run | StabilityMap | Report | Plan | Method | str) -> str:
    """BibTeX entries of this software and of the methods behind a result.

    Parameters
    ----------
    used : Run, StabilityMap, Report, Plan, Method or str
        A result, a plan, the name of a method, or ``"exact"`` for the closed forms.

    Returns
    -------
    str
        BibTeX entries; the key of a method is ``rigid-`` and its name.

    Raises
    ------
    ValueError
        If there is no method of that name.

    Examples
    --------
    >>> import rigid
    >>> rigid.cite("rk4").splitlines()[-3]
    '@misc{rigid-rk4,'
    """
    names, forms = _used(used)
    known = {method.name: method for method in methods()}
    entries = [_software()]
    for name in names:
        if name not in known:
            raise ValueError(
                f"used = {brief(name)}: must be a result, a plan, 'exact' or one of "
                f"{', '.join(known)}"
            )
        entries.append(_entry(f"rigid-{name}", known[name].citation, known[name].doi))
    for form in sorted({_OF_FORM[form] for form in forms}):
        key, note, doi = CLOSED_FORMS[form]
        entries.append(_entry(f"rigid-exact-{key}", note, doi))
    return "\n\n".join(entries)


def _used(used: Run | StabilityMap | Report | Plan | Method | str) -> tuple[list[str], list[str]]:
    """The names of the schemes, and the closed forms."""
    if isinstance(used, Method):
        return [used.name], []
    if isinstance(used, str):
        return ([], list(_OF_FORM)) if used == EXACT else ([used], [])
    if hasattr(used, "rows"):
        names = list(dict.fromkeys(row.method for row in used.rows))
        return [name for name in names if name != EXACT], list(_OF_FORM) if EXACT in names else []
    plan = used if isinstance(used, Plan) else used.plan
    forms = plan.closed_form.split(", ") if plan.closed_form else []
    scheme = MAP_FALLBACK if plan.method == AUTO else plan.method
    return ([] if scheme == EXACT else [scheme]), forms


def _software() -> str:
    return (
        "@software{rigid,\n"
        "  title = {rigid: rotation of rigid bodies with stated errors},\n"
        "  author = {{The rigid developers}},\n"
        f"  version = {{{_core.__version__}}},\n"
        "}"
    )


def _entry(key: str, note: str, doi: str) -> str:
    lines = [f"@misc{{{key},", f"  note = {{{note}}},"]
    if doi:
        lines.append(f"  doi = {{{doi}}},")
    return "\n".join([*lines, "}"])
