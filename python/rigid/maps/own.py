"""Scenes that a function of the user makes from its own parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief
from ..model.scene import SCENES, Scene
from ..model.sourced import Sourced
from .parameters import Axis, make_axes

__all__ = ["OwnScene", "own_scene"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class OwnScene:
    """A function of named numbers that gives a scene of many bodies.

    Attributes
    ----------
    names : tuple of str
        The axes that are its arguments.
    source : Sourced
        The function.
    """

    names: tuple[str, ...]
    source: Sourced

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
        return cls(names, source)

    def made(self, values: Mapping[str, Floats]) -> Scene:
        """The scene of all pixels, from the numbers of its axes there."""
        scene = self.source.call("scene")(**{name: values[name] for name in self.names})
        count = len(next(iter(values.values())))
        if not isinstance(scene, Scene):
            known = " or ".join(f"rigid.{one.__name__}" for one in SCENES.values())
            raise TypeError(
                f"scene = {self.source.name}: must return a {known}, not {brief(scene)}"
            )
        if scene.shape not in ((), (count,)):
            raise ValueError(
                f"scene = {self.source.name}: must return bodies of shape ({count},), one for each "
                f"number it is given, got {scene.shape}"
            )
        if scene.torque is not None and scene.torque.times:
            raise ValueError("torque: maps accept constant torques only, not a table")
        return scene

    def words(self, title: str) -> str:
        """The scene in words."""
        return f"{title} by {self.source.name}({', '.join(self.names)})"

    def to_dict(self) -> dict[str, Any]:
        """Names, and name and digests of the function."""
        return {"names": list(self.names), "function": self.source.to_dict()}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> OwnScene:
        """The scene of :meth:`to_dict`, whose function must be given again."""
        return cls(tuple(map(str, data["names"])), Sourced.from_dict(data["function"]))


def own_scene(
    function: Callable[..., Any], given: Mapping[str, ArrayLike]
) -> tuple[Scene, OwnScene, tuple[Axis, ...]]:
    """The scene of the first pixel, the function that makes those of all, and the axes."""
    if not isinstance(given, Mapping):
        make_axes(given)
    own = OwnScene.of(function, given)
    axes = make_axes(given, own.names)
    first = own.made({axis.name: np.array(axis.values[:1]) for axis in axes})
    return (first[0] if first.shape else first), own, axes
