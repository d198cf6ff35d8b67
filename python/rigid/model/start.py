"""The start of a body: its nominal rates and attitude, and what perturbs them."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief, finite_float, vector
from .._checks.arrays import attitudes
from .noise import Noise, Samples, plain_fields

_EVEN_PERMUTATION = {1: (0.5, -0.5, -0.5, -0.5), 2: (0.5, 0.5, 0.5, 0.5), 3: (1.0, 0.0, 0.0, 0.0)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """The start of a body: nominal rates and attitude, and the distribution of perturbations.

    Give either ``omega`` or ``spin``. With ``e`` the body axis ``axis`` and ``e_before`` the one
    before it in cyclic order (for axis 3: axis 2):

    * a free body given by ``spin`` starts with ``omega = spin (cos(tilt) e + sin(tilt) e_before)``;
    * a heavy top starts with ``omega = spin e``, its axis leaning so that the upward vertical in
      the body is ``gamma = cos(tilt) e + sin(tilt) e_before`` (for axis 3: ``R = Rx(tilt)``).

    Parameters
    ----------
    omega : array_like, shape (3,), optional
        Angular velocity in body components, rad/s.
    spin : float, optional
        Rate about ``axis``, rad/s.
    axis : {1, 2, 3}
        The body axis to which ``spin`` and ``tilt`` refer.
    tilt : float
        Angle between ``axis`` and the rates (free body) or the vertical (top), rad, in [-pi, pi].
    attitude : array_like, shape (4,), or scipy Rotation, optional
        The nominal attitude, instead of ``tilt``: a quaternion (w, x, y, z) that takes components
        in the body to components in space. It is divided by its length. A start with ``spin`` then
        has ``omega = spin e``.
    noise : Noise or Samples, optional
        Perturbation of the rates; samples, and a covariance of shape (6, 6), perturb the attitude
        too.
    attitude_noise : Noise, optional
        Perturbation of the attitude: a rotation vector applied on the body side.
    states : array_like, shape (k,), optional
        States of :meth:`Torque.call` with ``states=k``, which begin at zero by default.

    Raises
    ------
    ValueError
        If neither or both of ``omega`` and ``spin`` are given, ``tilt`` and ``attitude`` are both
        given, or a value is out of range.

    Examples
    --------
    >>> import rigid
    >>> rigid.Start(spin=10.0, axis=2, noise=rigid.normal(1e-3)).describe()
    'spin 10 rad/s about axis 2, rates + normal(0.001)'
    >>> rigid.Start(omega=[1e-10, 1.0, 1e-10]).omega
    (1e-10, 1.0, 1e-10)
    >>> rigid.Start(spin=2.0, attitude=[0.8, 0.6, 0.0, 0.0]).describe()
    'spin 2 rad/s about axis 3, attitude (0.8, 0.6, 0, 0)'
    """

    omega: tuple[float, float, float] | None = None
    spin: float | None = None
    axis: int = 3
    tilt: float = 0.0
    attitude: tuple[float, float, float, float] | None = None
    noise: Noise | Samples | None = None
    attitude_noise: Noise | None = None
    states: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if self.states is not None:
            states = vector("states", self.states, np.size(self.states))
            object.__setattr__(self, "states", tuple(states.tolist()))
        if (self.omega is None) == (self.spin is None):
            raise ValueError("omega, spin: give one of the two to a start")
        if self.omega is not None:
            object.__setattr__(self, "omega", tuple(vector("omega", self.omega, 3).tolist()))
        if self.spin is not None:
            object.__setattr__(self, "spin", finite_float("spin", self.spin))
        object.__setattr__(self, "axis", body_axis(self.axis))
        object.__setattr__(self, "tilt", finite_float("tilt", self.tilt))
        if abs(self.tilt) > pi:
            raise ValueError(f"tilt = {self.tilt}: must lie in [-pi, pi] (rad)")
        if self.attitude is not None:
            object.__setattr__(self, "attitude", _attitude(self.attitude))
            if self.tilt != 0.0:
                raise ValueError(f"tilt = {self.tilt:g}: the attitude is given; leave out the tilt")
        for name in ("noise", "attitude_noise"):
            noise = getattr(self, name)
            given = name == "noise" and isinstance(noise, Samples)
            if noise is not None and not isinstance(noise, Noise) and not given:
                raise TypeError(
                    f"{name} = {brief(noise)}: must be a Noise such as rigid.normal(1e-3)"
                )
            if isinstance(noise, Noise) and (noise.relative or noise.high is not None):
                what = "a relative size" if noise.relative else "a range of values"
                raise ValueError(
                    f"{name} = {noise.describe()}: a start has absolute noise; {what} is for vary="
                )
        if isinstance(self.noise, Noise) and self.noise.kind == "uniform_attitude":
            raise ValueError(
                "noise = uniform_attitude(): rates have no attitude; use attitude_noise"
            )
        if self.attitude_noise is not None:
            if self.attitude_noise.cov is not None and len(self.attitude_noise.cov) == 6:
                raise ValueError("attitude_noise: a covariance of rates and attitude is a noise")
            if self.joint:
                raise ValueError("attitude_noise: the noise perturbs the attitude already")

    @property
    def starts(self) -> tuple[Start, ...]:
        """The start as a tuple of one; a :class:`Mixture` has several."""
        return (self,)

    @property
    def joint(self) -> bool:
        """Whether the noise perturbs rates and attitude together."""
        if isinstance(self.noise, Samples):
            return self.noise.turns
        return self.noise is not None and self.noise.cov is not None and len(self.noise.cov) == 6

    def to_dict(self) -> dict[str, Any]:
        """The start as a JSON-able dictionary; :meth:`from_dict` reads it.

        Returns
        -------
        dict
        """
        # Starts without one have the bytes that they had before there was any.
        late = ("attitude", "states")
        every = plain_fields(self).items()
        return {name: value for name, value in every if value is not None or name not in late}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Start:
        """The start that :meth:`to_dict` described.

        Parameters
        ----------
        data : dict
            The dictionary.

        Returns
        -------
        Start

        Examples
        --------
        >>> import rigid
        >>> start = rigid.Start(spin=5.0, tilt=0.1, noise=rigid.normal(1e-3))
        >>> rigid.Start.from_dict(start.to_dict()) == start
        True
        """
        values = dict(data)
        for name in ("noise", "attitude_noise"):
            if values.get(name) is not None:
                noise = dict(values[name])
                given = noise.get("kind") == "samples"
                if given:
                    del noise["kind"]
                values[name] = Samples(**noise) if given else Noise(**noise)
        return cls(**values)

    def describe(self, varied: Container[str] = ()) -> str:
        """The start in words; ``varied`` names the parts that the axes of a map set.

        Parameters
        ----------
        varied : container of str
            Names of parameters that vary.

        Returns
        -------
        str

        Examples
        --------
        >>> import rigid
        >>> rigid.Start(spin=5.0, axis=3, noise=rigid.normal(1e-3)).describe()
        'spin 5 rad/s about axis 3, rates + normal(0.001)'
        """

        def number(name: str, value: float | None) -> str:
            return "varied" if name in varied else f"{value:g}"

        if self.omega is not None:
            rates = (number(f"omega{i}", rate) for i, rate in enumerate(self.omega, 1))
            parts = [f"omega ({', '.join(rates)}) rad/s"]
        else:
            parts = [f"spin {number('spin', self.spin)} rad/s about axis {self.axis}"]
        if self.tilt != 0.0 or "tilt" in varied:
            parts.append(f"tilt {number('tilt', self.tilt)} rad")
        if self.attitude is not None:
            parts.append(f"attitude ({', '.join(f'{part:g}' for part in self.attitude)})")
        for label, name, noise in (
            ("rates", "noise", self.noise),
            ("attitude", "attitude_noise", self.attitude_noise),
        ):
            if noise is not None:
                of_size = name
                if isinstance(noise, Noise) and noise.is_direction:
                    of_size = name.replace("noise", "kappa")
                parts.append(f"{label} + {noise.describe(varied=of_size in varied)}")
        if self.states is not None:
            parts.append(f"states ({', '.join(f'{state:g}' for state in self.states)})")
        return ", ".join(parts)


def _attitude(value: Any) -> tuple[float, float, float, float]:
    """A unit quaternion from any form that attitude arguments may have."""
    unit = attitudes(value)
    if unit.shape != (4,):
        raise ValueError(f"attitude: expected shape (4,), got {unit.shape}")
    given = np.asarray(value, dtype=np.float64) if not hasattr(value, "as_quat") else unit
    # A unit quaternion to rounding stays: a file gives back the same start.
    if abs(float(given @ given) - 1.0) <= 8.0 * np.finfo(np.float64).eps:
        unit = given
    w, x, y, z = unit.tolist()
    return w, x, y, z


def body_axis(value: object, *, signed: bool = False) -> int:
    """The number of a body axis: 1, 2 or 3, with ``signed`` also -1, -2 or -3."""
    known = (1, 2, 3, -1, -2, -3) if signed else (1, 2, 3)
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(
            f"axis = {brief(value)}: must be a whole number, one of {', '.join(map(str, known))}"
        )
    if value not in known:
        raise ValueError(f"axis = {brief(value)}: must be one of {', '.join(map(str, known))}")
    return int(value)


def tilted_rates(
    spin: NDArray[np.float64], axis: int, tilt: NDArray[np.float64]
) -> NDArray[np.float64]:
    """``spin (cos(tilt) e + sin(tilt) e_before)``, shape (n, 3)."""
    cosine, sine = cos_sin(tilt)
    omega = np.zeros((spin.size, 3))
    omega[:, axis - 1] = spin * cosine
    omega[:, axis - 2] = spin * sine
    return omega


def tilted_attitude(axis: int, tilt: NDArray[np.float64]) -> NDArray[np.float64]:
    """Quaternions (w, x, y, z), shape (n, 4), with ``gamma = cos(tilt) e + sin(tilt) e_before``.

    The body is first laid with ``axis`` along the vertical by a cyclic permutation of its axes,
    then turned by ``tilt`` about the first axis of space. Exactly the identity for axis 3 without
    tilt.
    """
    cosine, sine = cos_sin(0.5 * tilt)
    w, x, y, z = _EVEN_PERMUTATION[axis]
    return np.stack(
        [
            cosine * w - sine * x,
            cosine * x + sine * w,
            cosine * y - sine * z,
            cosine * z + sine * y,
        ],
        axis=-1,
    )


def cos_sin(angles: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cosine and sine of some angles up to 2 pi, correctly rounded."""
    # The sine and cosine of NumPy and of the C library differ between machines in the last bit, and
    # a map must not. A grid has few distinct tilts, so each can be evaluated exactly.
    distinct, inverse = np.unique(angles, return_inverse=True)
    table = np.array([_cos_sin_rounded(angle) for angle in distinct.tolist()])
    return table[inverse, 0], table[inverse, 1]


def _cos_sin_rounded(angle: float) -> tuple[float, float]:
    """Correctly rounded cosine and sine by their Taylor series, for angles up to 2 pi."""
    with localcontext() as context:
        context.prec = 60
        x = Decimal(angle)
        sums = [Decimal(0), Decimal(0)]
        term = Decimal(1)
        for n in range(70):
            sums[n % 2] += -term if n & 2 else term
            term *= x / (n + 1)
        return float(sums[0]), float(sums[1])
