"""The request of a map: its specification from the arguments of a call."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from .._checks.arguments import brief
from ..model.body import Body
from ..model.criterion import Criterion
from ..model.judged import Custom
from ..model.mixture import Mixture
from ..model.scene import Scene, check_scene
from ..model.seed import seed_from
from ..model.start import Start
from ..solve.timing import LEAST_STEPS
from .axes import Axis, check_axis_name, make_axes
from .own import own_scene
from .sequential import checked_half_width, stop_table
from .spec import MapSpec


def as_it_is(spec: MapSpec, given: Mapping[str, Any]) -> MapSpec:
    """A specification that this version of rigid runs again."""
    if given:
        name, value = next(iter(given.items()))
        field = "seed" if name == "rng" else name
        raise TypeError(
            f"{name} = {brief(value)}: the specification has its own; change it by "
            f"spec.replace({field}=...)"
        )
    return spec.replace()


def spec_of(
    scene: Scene | Body | type[Scene] | Callable[..., Scene], given: dict[str, Any]
) -> MapSpec:
    """The specification of a new map, from the arguments that were given."""
    if isinstance(given.get("axes"), Mapping) and "t_end" in given["axes"]:
        given.setdefault("t_end", 1.0)  # the longest one is taken from the values
    if isinstance(scene, type | Scene | Body) and isinstance(given.get("axes"), Mapping):
        for name in given["axes"]:
            check_axis_name(name)  # before what is missing, which would hide a wrong name
    _require("stability_map", given, "axes", "t_end", "stable")
    if ("samples" in given) == ("half_width" in given):
        raise TypeError("samples, half_width: give one of the two")
    if "samples" not in given:
        given["samples"] = stop_table(checked_half_width(given["half_width"])).last
    if not isinstance(scene, type | Scene | Body) and callable(scene):
        known, given["own"], given["axes"] = own_scene(scene, given["axes"])
    else:
        known = _scene(scene)
        given["axes"] = make_axes(given["axes"])
    return _started(known, seed_from(given.pop("rng", None)), given)


def of_one_pixel(
    scene: Scene | Body,
    stable: Criterion,
    *,
    start: Start | Mixture | None,
    t_end: float | None,
    method: str | None,
    step: float | None,
) -> MapSpec:
    """The specification of a map without axes: of one pixel, in which one body starts."""
    asked = {"stable": stable, "start": start, "t_end": t_end, "method": method, "step": step}
    given = {name: value for name, value in asked.items() if value is not None}
    _require("plan", given, "t_end")
    return _started(check_scene(scene), 0, {**given, "axes": (), "samples": 1})


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


def _require(function: str, given: dict[str, Any], *names: str) -> None:
    """Raise TypeError if arguments are missing; the horizon of ``judged`` is its last time."""
    if isinstance(given.get("stable"), Custom):
        given.setdefault("t_end", given["stable"].times[-1])
    missing = [name for name in names if name not in given]
    if missing:
        raise TypeError(f"{function}() needs {' and '.join(missing)}")


def _started(scene: Scene, seed: int, given: dict[str, Any]) -> MapSpec:
    """The specification, with the start of the scene if none is given."""
    own = given.get("own")
    given.setdefault("start", scene.default_start() if own is None else own.default_start(scene))
    return MapSpec(scene=scene, seed=seed, **given)


def _scene(scene: Scene | Body | type[Scene]) -> Scene:
    if isinstance(scene, type) and issubclass(scene, Scene):
        return scene.example()
    return check_scene(scene)
