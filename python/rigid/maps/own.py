"""Scenes and starts that a function of the user makes from its own parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief
from .._checks.arrays import Floats, attitudes, vectors
from ..model.parameters import OF_RUN, PARAMETERS
from ..model.scene import SCENES, Scene
from ..model.sourced import Sourced
from ..model.start import Start
from .axes import Axis, make_axes


@dataclass(frozen=True, slots=True)
class OwnScene:
    """A function of named numbers that gives a scene of many bodies, and perhaps their starts.

    Attributes
    ----------
    names : tuple of str
        The axes that are its arguments.
    source : Sourced
        The function.
    gives : tuple of str
        What it gives of the starts: ``"omega"``, or ``"omega"`` and ``"attitude"``.
    """

    names: tuple[str, ...]
    source: Sourced
    gives: tuple[str, ...] = ()

    @classmethod
    def of(cls, function: Callable[..., Any], axes: Iterable[str]) -> OwnScene:
        """The scene of a function whose arguments are among the axes of a map."""
        source = Sourced.of("scene", function)
        parameters = inspect.signature(function).parameters
        every = any(one.kind is one.VAR_KEYWORD for one in parameters.values())
        if every:
            raise ValueError(f"scene = {source.name}: must name its arguments, without **")
        names = tuple(name for name in axes if name in parameters)
        for name, one in parameters.items():
            if one.kind in (one.POSITIONAL_ONLY, one.VAR_POSITIONAL):
                raise ValueError(f"scene = {source.name}: {name} must be an argument by name")
            if one.default is one.empty and name not in names:
                raise ValueError(f"axes: the function {source.name!r} needs an axis {name!r}")
        if not names:
            raise ValueError(f"axes: none is an argument of the function {source.name!r}")
        for name in names:
            if name in PARAMETERS and PARAMETERS[name].place == OF_RUN:
                raise ValueError(
                    f"axes: {name!r} belongs to the map; call the argument of the function "
                    f"{source.name!r} otherwise"
                )
        return cls(names, source)

    def made(self, values: Mapping[str, Floats]) -> tuple[Scene, dict[str, Floats]]:
        """The scene of all pixels, from the values of the axes there, and what it gives of starts.

        The scene has one body, or one for each pixel; rates and attitudes have a row for each.
        """
        found = self.source.call("scene")(**{name: values[name] for name in self.names})
        count = len(next(iter(values.values())))
        scene, *starts = found if isinstance(found, tuple) and found else (found,)
        if not isinstance(scene, Scene) or len(starts) > 2:
            known = " or ".join(f"rigid.{one.__name__}" for one in SCENES.values())
            raise TypeError(
                f"scene = {self.source.name}: must return a {known}, not {brief(found)}; omega "
                "and attitude may follow the scene"
            )
        if scene.shape not in ((), (count,)):
            raise ValueError(
                f"scene = {self.source.name}: must return bodies of shape ({count},), one for each "
                f"number it is given, got {scene.shape}"
            )
        checks: Mapping[str, Callable[[Any], Floats]] = {"omega": _rates, "attitude": attitudes}
        given = {
            name: check(part) for (name, check), part in zip(checks.items(), starts, strict=False)
        }
        for name, part in given.items():
            if part.shape[:-1] not in ((), (count,)):
                raise ValueError(
                    f"scene = {self.source.name}: must return {name} of shape "
                    f"({count}, {part.shape[-1]}), a row for each number it is given, got "
                    f"{part.shape}"
                )
        rows = {name: np.broadcast_to(one, (count, one.shape[-1])) for name, one in given.items()}
        return scene, rows

    def check_start(self, start: Start, axes: Iterable[str]) -> None:
        """Raise ValueError if a start or an axis sets a part that the function returns.

        The noise of the start still perturbs the values that the function gives.
        """
        if "omega" in self.gives and start.omega != (0.0, 0.0, 0.0):
            raise ValueError(
                f"start: {self.source.name} gives the rates; the start must have none, as in "
                "Start(omega=(0, 0, 0), noise=...)"
            )
        is_given = start.tilt != 0.0 or start.attitude is not None or "tilt" in axes
        if "attitude" in self.gives and is_given:
            raise ValueError(
                f"start: {self.source.name} gives the attitude; omit tilt and attitude"
            )

    def default_start(self, scene: Scene) -> Start:
        """The default start of a map."""
        return Start(omega=(0.0, 0.0, 0.0)) if self.gives else scene.default_start()

    def words(self, title: str) -> str:
        """The scene in words."""
        starts = f" with {' and '.join(self.gives)}" if self.gives else ""
        return f"{title}{starts} by {self.source.name}({', '.join(self.names)})"

    def to_dict(self) -> dict[str, Any]:
        """The names of the arguments, and name and digests of the function."""
        given = {"gives": list(self.gives)} if self.gives else {}
        return {"names": list(self.names), "function": self.source.to_dict(), **given}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> OwnScene:
        """The scene of :meth:`to_dict`, whose function must be given again."""
        gives = tuple(map(str, data.get("gives", ())))
        return cls(tuple(map(str, data["names"])), Sourced.from_dict(data["function"]), gives)


def _rates(omega: ArrayLike) -> Floats:
    return vectors("omega", omega)


def own_scene(
    function: Callable[..., Any], given: Mapping[str, ArrayLike]
) -> tuple[Scene, OwnScene, tuple[Axis, ...]]:
    """The scene of the first pixel, the function for the scenes of all pixels, and the axes."""
    if not isinstance(given, Mapping):
        make_axes(given)
    own = OwnScene.of(function, given)
    axes = make_axes(given, own.names)
    scene, given_starts = own.made({axis.name: np.array(axis.values[:1]) for axis in axes})
    own = replace(own, gives=tuple(given_starts))
    return (scene[0] if scene.shape else scene), own, axes
