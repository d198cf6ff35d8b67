"""The bodies of a call: rates and attitudes are checked here, once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import brief
from .._checks.arrays import IDENTITY, attitudes, unit_quaternions, vectors
from .._moments import rods
from ..model.body import refuse_rods
from ..model.forces import forces_in_words
from ..model.frame import attitudes_in_principal_axes, turned
from ..model.leading import Shape, leading_shape
from ..model.scene import Scene
from .bodies import Bodies

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["bodies_of", "holds_rods"]

Floats = NDArray[np.float64]

ROUNDING = 8.0 * 2.0**-53
"""Share of the largest rate that rounding leaves about the axis of a rod in another frame."""


def bodies_of(
    scene: Scene,
    omega: ArrayLike,
    attitude: ArrayLike | Rotation | None = None,
    *,
    frame: NDArray[np.float64] | None = None,
    times: Shape = (),
    rod: bool = False,
) -> Bodies:
    """The bodies that the arguments of a call describe.

    Parameters
    ----------
    scene : Scene
        A checked scene.
    omega, attitude : array_like
        What a user gives; without an attitude the axes of body and space coincide.
    frame : ndarray, shape (3, 3), optional
        The checked axes of rates and attitude, if they are not the principal axes.
    times : tuple of int
        The leading axes of the times.
    rod : bool
        Whether a rod may be among the bodies: what is asked does not vary its spin.

    Raises
    ------
    ValueError
        If an array is not finite, has the wrong shape, or holds a zero quaternion, if the axes of
        bodies, rates and attitudes do not broadcast, if the rates are so slow that their squares
        underflow, or the weight, torque or damping so large that they overflow in the unit of the
        moments.
    """
    rates = _core.plain_numbers(omega, 3, kept=True)
    if rates is None:
        rates = vectors("omega", omega)
        if not isinstance(omega, (list, tuple)):
            rates = rates.copy()  # a run keeps it: the caller may write to this memory
        rates.setflags(write=False)
    attitude = attitudes(attitude)
    if frame is not None:
        with np.errstate(over="ignore", invalid="ignore"):
            rates = turned(frame.T, rates)
        if not np.isfinite(rates).all():
            raise ValueError("omega: must be finite along the principal axes of the frame too")
        rates.setflags(write=False)
        attitude = unit_quaternions("attitude", attitudes_in_principal_axes(frame, attitude))
    if attitude is not IDENTITY:
        attitude.setflags(write=False)
    shape = scene.shape
    if shape or times or rates.ndim > 1 or attitude.ndim > 1:
        own = rates.shape[:-1], attitude.shape[:-1]
        shape = leading_shape({"scene": shape, "omega": own[0], "attitude": own[1], "t": times})
    if scene.once(holds_rods):
        rates = _of_rods(scene, rates, rod)
    bodies = Bodies.of_scene(scene, rates, attitude, shape)
    bodies.check_ranges(scene)
    return bodies


def holds_rods(scene: Scene) -> bool:
    """Whether a body of the scene is a rod, without a moment about its axis."""
    return bool(rods(np.asarray(scene.body.moments)).any())


def _of_rods(scene: Scene, rates: Floats, rod: bool) -> Floats:
    """The rates; the rounding of the rates of rods about their axes becomes zero.

    Raises
    ------
    ValueError
        Where a rod would spin, or where its spin counts.
    """
    moments = np.asarray(scene.body.moments)
    if not rod:
        refuse_rods(moments)
    along = (moments == 0.0) & rods(moments)[..., np.newaxis]
    axis = int(np.argmax(along.reshape(-1, 3).any(axis=0))) + 1
    size = np.abs(rates).max(axis=-1, keepdims=True)
    if np.any(along & (np.abs(rates) > ROUNDING * size)):
        raise ValueError(
            f"omega = {brief(rates.tolist())}: a rod has no moment about its axis and cannot spin "
            f"about it; the rate about axis {axis} must be 0"
        )
    if np.any(~along & along.any(axis=-1, keepdims=True) & (scene.weight != 0.0)):
        raise ValueError("com: the mass of a rod is on its axis, and so must be com")
    if scene.forces:
        raise ValueError(
            f"scene = {scene.words()}: no rod moves under {forces_in_words(scene.forces)}, which "
            "could spin it about its axis, where it has no moment; give a small moment"
        )
    kept: Floats = np.where(along, 0.0, rates)
    kept.setflags(write=False)
    return kept
