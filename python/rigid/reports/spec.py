"""The request of a report as one frozen, JSON-able record."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import brief, finite_float, numbers, one_of, positive_int, vector
from ..model.bodies import bodies_of
from ..model.body import Body
from ..model.scene import Scene, check_scene, scene_from_dict
from ..model.seed import checked_seed
from ..solve.methods import EXACT, run_methods
from .scheme import Scheme

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


REVOLUTIONS = (1e3, 1e4, 1e5, 1e6)
"""Revolutions of ``rigid report --long``."""

BODIES = 32
"""Bodies over revolutions: they fill one group of lanes, which takes no longer than one body."""

MOST_REVOLUTIONS = 1e9
"""Most revolutions of a report; after more, a phase in float64 has no digits left to compare."""

MOST_BODIES = 4096
"""Most bodies; with more, the memory would be measured and not the method."""


@dataclass(frozen=True, kw_only=True)
class ReportSpec:
    """Everything that the errors of a report depend on; made by :func:`rigid.report`.

    Attributes
    ----------
    scene : FreeBody, HeavyTop or Body
        The body with its weight, applied torque and damping.
    omega, attitude : tuple of float
        Nominal start of the ensemble: rates in the body (rad/s), unit quaternion (w, x, y, z).
    t_end : float
        Horizon, in units of time of the scene; the longest of several.
    methods : tuple of str
        The compared methods.
    bodies : int
        Bodies in the ensemble.
    errors : tuple of float
        Errors for each of which the cheapest method is determined, the largest first.
    seed : int
        Key of the random perturbations of the ensemble.
    unit : str
        Name of the unit of time.
    title : str or None
        For tables and plots.
    revolutions : tuple of float
        Horizons in revolutions, from short to long; empty if ``t_end`` was given.
    version : str
        The version of rigid that made it.
    schemes : dict of str to Scheme
        The own schemes among the methods, by their names; a file has their names only.
    """

    scene: Scene
    omega: tuple[float, float, float]
    attitude: tuple[float, float, float, float]
    t_end: float
    methods: tuple[str, ...]
    bodies: int = 64
    errors: tuple[float, ...] = (1e-3, 1e-6, 1e-9, 1e-12)
    seed: int = 0
    unit: str = "s"
    title: str | None = None
    revolutions: tuple[float, ...] = ()
    version: str = _core.__version__
    schemes: Mapping[str, Scheme] = field(default_factory=dict, compare=False, repr=False)

    @property
    def horizons(self) -> tuple[float, ...]:
        """The lengths of the runs in revolutions; one if ``t_end`` was given."""
        return self.revolutions or (self.t_end / self.time_of(1.0),)

    def time_of(self, revolutions: float) -> float:
        """Time of some revolutions at the rate of the start, ``2 pi / |omega|`` each."""
        rate = math.hypot(*self.omega)
        return math.tau * revolutions / rate if rate > 0.0 else math.inf

    def to_dict(self) -> dict[str, Any]:
        """The specification as a JSON-able dictionary; :meth:`from_dict` reads it."""
        values = {one.name: getattr(self, one.name) for one in fields(self) if one.compare}
        lists = {name: list(one) for name, one in values.items() if isinstance(one, tuple)}
        return {**values, **lists, "scene": self.scene.to_dict()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> ReportSpec:
        """The specification that :meth:`to_dict` described; its methods need not exist here."""
        scene = scene_from_dict(data["scene"])
        tuples = {name: tuple(one) for name, one in data.items() if isinstance(one, list)}
        return cls(**{**data, **tuples, "scene": scene})

    def to_json(self) -> str:
        """The specification as JSON text; floats keep all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False)


def make_spec(
    scene: Scene | Body,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    t_end: float | None = None,
    revolutions: ArrayLike | None = None,
    methods: Iterable[str | Scheme] | None = None,
    bodies: int | None = None,
    errors: ArrayLike = ReportSpec.errors,
    seed: int = ReportSpec.seed,
    unit: str = ReportSpec.unit,
    title: str | None = None,
) -> ReportSpec:
    """The checked specification of a report, from the arguments of :func:`rigid.report`."""
    scene = check_scene(scene)
    w1, w2, w3 = vector("omega", omega, 3).tolist()
    first = bodies_of(scene, [w1, w2, w3], attitude)
    if first.shape:
        raise ValueError(
            f"attitude: expected shape (4,), got {len(first.attitude)} attitudes; "
            "a report starts from one body"
        )
    a, b, c, d = first.attitude[0].tolist()
    lengths = () if revolutions is None else _revolutions(revolutions)
    if (t_end is None) != bool(lengths):
        raise TypeError("t_end, revolutions: give one of the two")
    if lengths:
        rate = math.hypot(w1, w2, w3)
        if rate == 0.0:
            raise ValueError(
                f"omega = {[w1, w2, w3]}: must not be zero; a long run counts revolutions"
            )
        t_end = math.tau * lengths[-1] / rate
    end = finite_float("t_end", t_end, positive=True)
    rate, most = float(first.fastest_rates((0.0, end))[0]), math.tau * MOST_REVOLUTIONS
    if not lengths and end * rate > most:
        raise ValueError(
            f"t_end = {end:g}: must be at most {most / rate:.6g}, in which the body may turn by "
            f"{MOST_REVOLUTIONS:g} revolutions"
        )
    if bodies is None:
        bodies = BODIES if lengths else ReportSpec.bodies
    names, schemes = _methods(methods, closed_form=not lengths)
    if positive_int("bodies", bodies) > MOST_BODIES:
        raise ValueError(f"bodies = {brief(bodies)}: must be at most {MOST_BODIES}")
    if not isinstance(unit, str) or not unit:
        raise TypeError(f"unit = {brief(unit)}: must be the name of a unit of time")
    return ReportSpec(
        scene=scene,
        omega=(w1, w2, w3),
        attitude=(a, b, c, d),
        t_end=end,
        methods=names,
        bodies=int(bodies),
        errors=_errors(errors),
        seed=checked_seed("seed", seed),
        unit=unit,
        title=title,
        revolutions=lengths,
        schemes=schemes,
    )


def _methods(
    methods: Iterable[str | Scheme] | None, *, closed_form: bool
) -> tuple[tuple[str, ...], dict[str, Scheme]]:
    """The names of the methods, and the own schemes among them."""
    known = run_methods()
    if methods is None:
        return tuple(name for name in known if closed_form or name != EXACT), {}
    if isinstance(methods, str):
        raise TypeError(
            f"methods = {brief(methods)}: must be a list of names, such as [{brief(methods)}]"
        )
    asked = list(methods)
    if not asked:
        raise ValueError("methods = []: must name at least one method")
    names: list[str] = []
    for k, one in enumerate(asked):
        if isinstance(one, Scheme):
            name = one.name
            if name in known:
                raise ValueError(f"methods[{k}] = {brief(name)}: is a method of the library")
        else:
            name = one
            one_of(f"methods[{k}]", name, known)
        if name in names:
            raise ValueError(f"methods[{k}] = {brief(name)}: is there already")
        names.append(name)
    return tuple(names), {one.name: one for one in asked if isinstance(one, Scheme)}


def _revolutions(revolutions: ArrayLike) -> tuple[float, ...]:
    values = _some("revolutions", "number", revolutions)
    for k, value in enumerate(values):
        before = values[k - 1] if k else 0.0
        if not before < value <= MOST_REVOLUTIONS:
            raise ValueError(
                f"revolutions[{k}] = {value}: must be above {before:g} and at most "
                f"{MOST_REVOLUTIONS:g}"
            )
    return tuple(values)


def _errors(errors: ArrayLike) -> tuple[float, ...]:
    values = _some("errors", "error", errors)
    for k, error in enumerate(values):
        if not 1e-15 <= error < 1.0:
            raise ValueError(
                f"errors[{k}] = {error}: must lie in [1e-15, 1), "
                "below which float64 cannot go and above which nothing is known"
            )
    return tuple(sorted(set(values), reverse=True))


def _some(name: str, what: str, values: ArrayLike) -> list[float]:
    array = numbers(name, values)
    if array.ndim != 1 or not array.size:
        raise ValueError(f"{name}: expected shape (m,) with at least one {what}, got {array.shape}")
    some: list[float] = array.tolist()
    return some
