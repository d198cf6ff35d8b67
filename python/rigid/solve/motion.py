"""One body or many in motion, step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .. import _core
from .._checks.arguments import finite_float, one_of, resolve_threads, rows
from .._checks.arrays import AttitudeLike, Floats
from .._checks.warned import warn_caller
from ..model.batch import rows_of_each
from ..model.bodies import bodies_of, holds_rods, starts_of
from ..model.body import Body
from ..model.frame import attitudes_in_frame, checked_frame, turned
from ..model.scene import Scene, check_scene
from .methods import check_method, method_named, methods

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

DEFAULT = "dop853"
"""Its steps keep energy and attitude as steps of ``rk4`` do that are a ninth as long."""


class Motion:
    """One body or many in motion, for a torque that is chosen from step to step.

    A controller reads the state, chooses a torque and makes a step; a step of one body takes some
    microseconds. The steps are the steps of :func:`simulate` with the same method: the states have
    the bits of a run with the end of each step as output time, if the times of both are the same
    numbers, as with steps of ``2**-k`` s. The error of a motion is not estimated: compare it with a
    motion of half the step. Between steps :attr:`omega` and :attr:`attitude` may be set.

    Parameters
    ----------
    scene : FreeBody, HeavyTop or Body
        One body, with weight, applied torque and damping; many starts are many such bodies. Or n
        bodies, which may differ in moments, weight and forces.
    omega : array_like, shape (3,) or (n, 3)
        Angular velocity at ``t0`` in the body (rad/s).
    attitude : array_like, shape (4,) or (n, 4), or scipy Rotation, optional
        Attitude at ``t0``: quaternion, scalar first, body to space; normalised here. Default:
        body and space axes coincide.
    t0 : float
        Time at which the motion begins (s). A table of a torque is read, and an orbit has turned,
        from ``t = 0``.
    method : str
        One of :func:`rigid.methods`. Under forces one that integrates them: ``Method.forces``. A
        step that turns the body by more than the ``longest_angle`` of the method warns once.
    threads : int, optional
        Most threads of a step of many bodies. Default: ``RIGID_NUM_THREADS``, else the cores that
        this process may use. A thousand bodies and fewer are moved by the calling thread.
    frame : array_like, shape (3, 3), optional
        The body axes of rates, attitude and the torque of a step, if they are not the principal
        axes: ``axes`` as :meth:`Body.from_tensor` returns them. The scene has its own ``frame=``.

    Raises
    ------
    ValueError
        If a number is not finite, a shape or the method is wrong, a quaternion is zero, or the
        frame is no rotation matrix.

    Examples
    --------
    A wheel that a motor brings to 2 rad/s:

    >>> import rigid
    >>> motion = rigid.Motion(rigid.FreeBody(rigid.Body((1.0, 1.0, 1.8))), [0.0, 0.0, 0.0])
    >>> for _ in range(100):
    ...     motion.step(0.1, torque=(0.0, 0.0, 2.0 - motion.omega[2]))
    >>> round(motion.t, 9), round(float(motion.omega[2]), 2)
    (10.0, 1.99)

    A copy tries the next step and leaves the motion unchanged:

    >>> tried = motion.copy()
    >>> tried.step(0.1, torque=(0.0, 0.0, 1.0))
    >>> round(tried.t, 9), round(motion.t, 9)
    (10.1, 10.0)
    """

    __slots__ = ("_bodies", "_core", "_frame", "_method", "_scene", "_threads")

    def __init__(
        self,
        scene: Scene | Body,
        omega: ArrayLike,
        attitude: AttitudeLike | None = None,
        *,
        t0: float = 0.0,
        method: str = DEFAULT,
        threads: int | None = None,
        frame: ArrayLike | None = None,
    ) -> None:
        scene = self._scene = check_scene(scene, many=True)
        self._method = one_of("method", method, [method.name for method in methods()])
        check_method(method, scene.kind, watched=False, forces=scene.forces)
        self._frame = None if frame is None else checked_frame(frame)
        bodies = bodies_of(scene, omega, attitude, frame=self._frame, rod=True)
        if len(bodies.shape) > 1:
            raise ValueError(
                f"{'scene' if len(scene.shape) > 1 else 'omega'}: expected one body or n in a row, "
                f"got bodies of shape {bodies.shape}"
            )
        self._bodies, self._threads = bodies, threads
        self._core = _core.Motion(
            bodies,
            method=method,
            time=finite_float("t0", t0, unit="s"),
            units=np.ldexp(1.0, bodies.scale_exponent),
            threads=resolve_threads(threads),
        )

    @property
    def scene(self) -> Scene:
        """The body and what acts on it; another scene needs another motion."""
        return self._scene

    @property
    def method(self) -> str:
        """The name of the method."""
        return self._method

    @property
    def t(self) -> float:
        """The present time (s): the sum of all steps, each rounded.

        A million steps of 0.1 s end at 100000.0000013 s, steps of ``2**-k`` s at no wrong time.
        """
        return self._core.time

    @property
    def omega(self) -> Floats:
        """Angular velocity in the body now (rad/s), shape (3,) or (n, 3); may be set.

        The array is a copy: change it, then set it. Bodies whose rates stay go on with all their
        bits. The attitude of the others is normalised. A collision that stops one of two bodies:

        >>> import rigid
        >>> motion = rigid.Motion(rigid.Body((1.0, 2.0, 3.0)), [[0.1, 1.0, 0.1], [0.0, 0.0, 2.0]])
        >>> motion.step(0.5)
        >>> omega = motion.omega
        >>> omega[1] = 0.0
        >>> motion.omega = omega
        >>> motion.omega[1].tolist()
        [0.0, 0.0, 0.0]
        """
        every = self._core.omega()
        if self._frame is not None:
            every = turned(self._frame, every)
        omega: Floats = self._bodies.in_axes(every)
        return omega

    @omega.setter
    def omega(self, omega: ArrayLike) -> None:
        now = self.omega, self.attitude
        self._begin("omega", now, (omega, now[1]))

    @property
    def attitude(self) -> Floats:
        """Quaternion now, scalar first, body to space, (4,) or (n, 4); may be set.

        It is not normalised again after steps; one that is set is, and may be a SciPy ``Rotation``.
        Bodies whose quaternion stays go on with all their bits.

        >>> import rigid
        >>> motion = rigid.Motion(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.1])
        >>> motion.attitude = (2.0, 0.0, 0.0, 0.0)
        >>> motion.attitude.tolist()
        [1.0, 0.0, 0.0, 0.0]
        """
        every = self._core.attitude()
        if self._frame is not None:
            every = attitudes_in_frame(self._frame, every)
        attitude: Floats = self._bodies.in_axes(every)
        return attitude

    @attitude.setter
    def attitude(self, attitude: AttitudeLike) -> None:
        now = self.omega, self.attitude
        self._begin("attitude", now, (now[0], attitude))

    def _begin(
        self, name: str, now: tuple[Floats, Floats], given: tuple[ArrayLike, AttitudeLike]
    ) -> None:
        """Begin again from here with given rates and attitudes, where these are others than now."""
        starts = partial(starts_of, self.scene, frame=self._frame, rod=True)
        rates, quaternions, shape = starts(*given)
        if shape != self._bodies.shape:
            raise ValueError(f"{name}: expected bodies of shape {self._bodies.shape}, got {shape}")
        begun = replace(
            self._bodies,
            omega=rows_of_each(rates, shape),
            attitude=rows_of_each(quaternions, shape),
        )
        begun.check_ranges(self.scene)
        before = [rows_of_each(array, shape) for array in starts(*now)[:2]]
        self._core.begin(begun.omega, begun.attitude, *before)
        self._bodies = begun

    def rotation(self) -> Rotation:
        """The attitude as a SciPy ``Rotation`` (active, body to space), of one body or of n.

        Its ``as_quat()`` has the scalar last, ``(x, y, z, w)``.

        Returns
        -------
        scipy.spatial.transform.Rotation

        Examples
        --------
        >>> import rigid
        >>> motion = rigid.Motion(rigid.Body((1.0, 2.0, 3.0)), [0.0, 0.0, 1.0])
        >>> motion.step(0.25)
        >>> motion.rotation().as_rotvec().round(9).tolist()
        [0.0, 0.0, 0.25]
        """
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.attitude, scalar_first=True)

    def step(self, dt: float, torque: ArrayLike | None = None) -> None:
        """Make one step of the method; two steps if a knot of the table of a torque lies inside.

        Parameters
        ----------
        dt : float
            Length of the step (s); negative backward in time.
        torque : array_like, shape (3,) or (n, 3), optional
            Torque in body axes during the step (N m), in addition to the torque of the scene. The
            first torque changes a scene without torque and damping to the variables of forced
            bodies; from there on its bits agree with a run that begins at this state.

        Warns
        -----
        UserWarning
            The first time that a step turns a body by more than the method bears.

        Raises
        ------
        TypeError
            If an argument is not a number.
        ValueError
            If a number is not finite or has another unit, or the torque has another shape. Under
            torque and damping: if the method does not integrate them, if it is unstable with the
            step, or if the table of the scene's torque does not reach the end. The motion is then
            as before, as it is after Ctrl-C in a step over many knots. If the steps are so long
            that the quaternion is off by more than a tenth: the motion is then lost.

        Examples
        --------
        >>> import rigid
        >>> motion = rigid.Motion(rigid.Body((1.0, 2.0, 3.0)), [0.0, 0.0, 0.0])
        >>> motion.step(0.5, torque=(0.0, 0.0, 6.0))
        >>> motion.omega.round(9).tolist()
        [0.0, 0.0, 1.0]
        """
        if not isinstance(dt, float):
            dt = finite_float("dt", dt, unit="s")
        if torque is not None and self.scene.once(holds_rods):
            raise ValueError("torque: could spin a rod about its axis, where it has no moment")
        if torque is not None and (self._frame is not None or not _is_plain(torque)):
            torque = rows("torque", torque, 3)
            count = len(self._bodies)
            if count and not len(torque):  # to the core no torques are no torque
                raise ValueError(f"torque: expected shape (3,) or ({count}, 3), got (0, 3)")
            if self._frame is not None:
                torque = turned(self._frame.T, torque)
        angle = self._core.step(dt, torque)
        if angle is not None:
            longest = method_named(self.method).longest_angle
            warn_caller(
                f"dt = {dt:g}: the step turns the body by {angle:.2g} rad; {self.method!r} keeps "
                f"energy and attitude to 1e-3 over 1000 rad up to {longest:g} "
                "rad a step"
            )

    def __repr__(self) -> str:
        """Number of bodies, present time and method."""
        count = f"{len(self._bodies)} bodies" if self._bodies.shape else "one body"
        return f"Motion({count} at t = {self.t:g} s; {self.method})"

    def copy(self) -> Motion:
        """A second motion of the same bodies from here on, with the same bits.

        ``copy.copy``, ``copy.deepcopy`` and ``pickle`` make one too.

        Returns
        -------
        Motion

        Examples
        --------
        >>> import rigid
        >>> motion = rigid.Motion(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.1])
        >>> other = motion.copy()
        >>> other.step(0.5)
        >>> other.t, motion.t
        (0.5, 0.0)
        """
        rebuild, state = self.__reduce__()
        return rebuild(*state)

    __copy__ = copy

    def __deepcopy__(self, _memo: object) -> Motion:
        # A scene does not change, and the torque of a function cannot be copied.
        return self.copy()

    def __reduce__(self) -> tuple[Callable[..., Motion], tuple[Any, ...]]:
        options = {"t0": self.t, "method": self.method, "threads": self._threads}
        states = map(self._bodies.in_axes, (self._core.omega(), self._core.attitude()))
        return _rebuilt, (self.scene, *states, self._frame, options, *self._core.numbers())


def _rebuilt(
    scene: Scene,
    omega: Floats,
    attitude: Floats,
    frame: Floats | None,
    options: dict[str, Any],
    numbers: Floats,
    forced: bool,
) -> Motion:
    """A motion whose bodies have the numbers of another; rates and attitude in principal axes."""
    motion = Motion(scene, omega, attitude, **options)
    motion._frame = frame
    motion._core.restore(numbers, forced)
    return motion


def _is_plain(torque: ArrayLike) -> bool:
    """Whether the core can read the torque without a check, which would take as long as a step."""
    return (
        isinstance(torque, tuple)
        and len(torque) == 3
        and all(isinstance(part, float) for part in torque)
    )
