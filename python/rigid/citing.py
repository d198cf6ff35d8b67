"""References of the software and of the methods that produced a result."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from . import _core
from ._checks.arguments import brief
from .solve.methods import AUTO, EXACT, MAP_FALLBACK, Method, methods
from .solve.plan import Plan

if TYPE_CHECKING:
    from .reports.result import Report
    from .sections.crossings import Crossings
    from .solve.frequencies import FrequencyDrift, Lines
    from .solve.growth import Growth
    from .solve.run import Run
    from .store.result import StabilityMap


CLOSED_FORMS: Mapping[str, tuple[str, str]] = {
    "exact-jacobi": (
        "C. G. J. Jacobi, Sur la rotation d'un corps, J. reine angew. Math. 39 (1850) 293-350",
        "10.1515/crll.1850.39.293",
    ),
    "exact-klein": (
        "F. Klein, A. Sommerfeld, Über die Theorie des Kreisels, Teubner (1897-1910)",
        "",
    ),
    "exact-euler": (
        "L. Euler, Du mouvement de rotation des corps solides autour d'un axe variable, "
        "Mém. Acad. Sci. Berlin 14 (1765) 154-193",
        "",
    ),
}
"""Reference and DOI of the closed forms."""

INDICATORS: Mapping[str, tuple[str, str]] = {
    "lyapunov": (
        "G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Lyapunov characteristic exponents "
        "for smooth dynamical systems and for Hamiltonian systems; a method for computing all of "
        "them, Meccanica 15 (1980) 9-30",
        "10.1007/BF02128236",
    ),
    "megno": (
        "P. M. Cincotta, C. Simó, Simple tools to study global dynamics in non-axisymmetric "
        "galactic potentials I, Astron. Astrophys. Suppl. Ser. 147 (2000) 205-228",
        "10.1051/aas:2000108",
    ),
    "fli": (
        "C. Froeschlé, E. Lega, R. Gonczi, Fast Lyapunov indicators. Application to asteroidal "
        "motion, Celest. Mech. Dyn. Astron. 67 (1997) 41-62",
        "10.1023/A:1008276418601",
    ),
    "sali": (
        "C. Skokos, Alignment indices: a new, simple method for determining the ordered or chaotic "
        "nature of orbits, J. Phys. A 34 (2001) 10029-10043",
        "10.1088/0305-4470/34/47/309",
    ),
    "gali": (
        "C. Skokos, T. Bountis, C. Antonopoulos, Geometrical properties of local dynamics in "
        "Hamiltonian systems: the Generalized Alignment Index (GALI) method, Physica D 231 (2007) "
        "30-54",
        "10.1016/j.physd.2007.04.004",
    ),
}
"""Reference and DOI of the exponents and indicators of :func:`lyapunov`."""

SECTIONS: Mapping[str, tuple[str, str]] = {
    "poincare": (
        "H. Poincaré, Les méthodes nouvelles de la mécanique céleste III, Gauthier-Villars (1899)",
        "",
    ),
    "henon": (
        "M. Hénon, On the numerical computation of Poincaré maps, Physica D 5 (1982) 412-414",
        "10.1016/0167-2789(82)90034-3",
    ),
    "complete": (
        "S. Schmidt, H. R. Dullin, P. H. Richter, A Poincaré section for the general heavy rigid "
        "body, SIAM J. Appl. Dyn. Syst. 7 (2008) 371-389",
        "",
    ),
    "descartes": (
        "F. Rouillier, P. Zimmermann, Efficient isolation of polynomial's real roots, J. Comput. "
        "Appl. Math. 162 (2004) 33-50",
        "10.1016/j.cam.2003.08.015",
    ),
}
"""Reference and DOI of the methods of :func:`poincare`."""

LINES: Mapping[str, tuple[str, str]] = {
    "naff": (
        "J. Laskar, The chaotic motion of the solar system: a numerical estimate of the size of "
        "the chaotic zones, Icarus 88 (1990) 266-291",
        "",
    ),
    "frequency-map": (
        "J. Laskar, Frequency analysis for multi-dimensional systems. Global dynamics and "
        "diffusion, Physica D 67 (1993) 257-281",
        "10.1016/0167-2789(93)90210-R",
    ),
}
"""Reference and DOI of the method and the drift of :func:`frequencies`."""

_OF_FORM: Mapping[str, str] = {
    "axis spin": "exact-euler",
    "free symmetric": "exact-euler",
    "free asymmetric": "exact-jacobi",
    "lagrange": "exact-klein",
    "pendulum": "exact-klein",
}


Used: TypeAlias = (
    "Run | Growth | Crossings | Lines | FrequencyDrift"
    " | StabilityMap | Report | Plan | Method | str"
)


def cite(used: Used) -> str:
    """BibTeX entries of this software and of the methods that produced a result.

    Parameters
    ----------
    used : Run, Growth, Crossings, Lines, FrequencyDrift, StabilityMap, Report, Plan, Method or str
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
    found: dict[str, tuple[str, str]] = {}
    for name in names:
        if name not in known:
            raise ValueError(
                f"used = {brief(name)}: must be a result, a plan, 'exact' or one of "
                f"{', '.join(known)}"
            )
        found[name] = known[name].citation, known[name].doi
    closed = {_OF_FORM[form] for form in forms}
    found |= {key: of for key, of in CLOSED_FORMS.items() if key in closed}
    carried = getattr(getattr(used, "plan", used), "carried", ())
    if hasattr(used, "log_growth") or "deviation" in carried:
        found |= INDICATORS
    if hasattr(used, "grazing"):
        found |= SECTIONS
    if _is_of_lines(used):
        found |= LINES
    entries = [_entry(key, note, doi) for key, (note, doi) in found.items()]
    return "\n\n".join([_software(), *entries])


def _is_of_lines(used: object) -> bool:
    """Whether the result holds frequencies, which no method of motion produced."""
    return hasattr(used, "frequency") or hasattr(used, "drift")


def _used(used: Used) -> tuple[list[str], list[str]]:
    """The names of the methods, and the closed forms."""
    if _is_of_lines(used):
        return [], []
    if isinstance(used, Method):
        return [used.name], []
    if isinstance(used, str):
        return ([], list(_OF_FORM)) if used == EXACT else ([used], [])
    if hasattr(used, "rows"):
        names = list(dict.fromkeys(row.method for row in used.rows))
        return [name for name in names if name != EXACT], list(_OF_FORM) if EXACT in names else []
    result: Any = used
    plan: Plan = used if isinstance(used, Plan) else result.plan
    forms = plan.closed_form.split(", ") if plan.closed_form else []
    method = MAP_FALLBACK if plan.method == AUTO else plan.method
    return ([] if method == EXACT else [method]), forms


def _software() -> str:
    return (
        "@software{rigid,\n"
        "  title = {rigid: rotation of rigid bodies with stated errors},\n"
        "  author = {{The rigid developers}},\n"
        f"  version = {{{_core.__version__}}},\n"
        "}"
    )


def _entry(key: str, note: str, doi: str) -> str:
    lines = [f"@misc{{rigid-{key},", f"  note = {{{note}}},"]
    if doi:
        lines.append(f"  doi = {{{doi}}},")
    return "\n".join([*lines, "}"])
