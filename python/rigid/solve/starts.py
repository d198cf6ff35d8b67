"""The bodies of a call: rates and attitudes are checked here, once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arrays import IDENTITY, attitudes, unit_quaternions, vectors
from .._moments import hold_rods
from ..model.body import rates_of_rods, refuse_rods
from ..model.frame import attitudes_in_principal_axes, turned
from ..model.leading import Shape, leading_shape
from ..model.scene import Scene
from .bodies import Bodies

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


Floats = NDArray[np.float64]


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
        moments = np.asarray(scene.body.moments)
        if not rod:
            refuse_rods(moments)
        rates = rates_of_rods("omega", rates, moments, scene.weight, scene.forces)
    bodies = Bodies.of_scene(scene, rates, attitude, shape)
    bodies.check_ranges(scene)
    return bodies


def holds_rods(scene: Scene) -> bool:
    """Whether a body of the scene is a rod, without a moment about its axis."""
    return hold_rods(np.asarray(scene.body.moments))
