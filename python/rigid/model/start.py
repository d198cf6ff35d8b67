"""The start of a body: nominal rates and attitude, and the distributions of perturbations."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from math import pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, finite_float, one_of, vector

__all__ = ["Noise", "Start", "direction", "normal", "uniform", "uniform_attitude"]

NOISE_KINDS = ("normal", "uniform", "direction", "uniform_attitude")

_EVEN_PERMUTATION = {1: (0.5, -0.5, -0.5, -0.5), 2: (0.5, 0.5, 0.5, 0.5), 3: (1.0, 0.0, 0.0, 0.0)}


@dataclass(frozen=True, slots=True)
class Noise:
    """The law of a random perturbation, made by :func:`normal` and its siblings.

    Attributes
    ----------
    kind : str
        One of ``"normal"``, ``"uniform"``, ``"direction"``, ``"uniform_attitude"``.
    size : float or tuple of 3 floats
        Factor of the law, one number or one for each body axis: rad/s for rates, rad for an
        attitude.
    """

    kind: str
    size: float | tuple[float, float, float] = 1.0

    def __post_init__(self) -> None:
        one_of("kind", self.kind, NOISE_KINDS)
        object.__setattr__(self, "size", _size(self.size))

    def to_dict(self) -> dict[str, Any]:
        """The noise as a JSON-able dictionary."""
        size = list(self.size) if isinstance(self.size, tuple) else self.size
        return {"kind": self.kind, "size": size}

    def describe(self, *, varied: bool = False) -> str:
        """The noise in words; ``varied`` if an axis of a map sets its size."""
        if self.kind == "uniform_attitude":
            return "uniform_attitude()"
        if varied:
            return f"{self.kind}(varied)"
        sizes = self.size if isinstance(self.size, tuple) else (self.size,)
        return f"{self.kind}({', '.join(f'{size:g}' for size in sizes)})"


def _size(value: Any) -> float | tuple[float, float, float]:
    if np.ndim(value) == 0:
        return finite_float("size", value, nonnegative=True)
    first, second, third = (
        finite_float("size", component, nonnegative=True)
        for component in vector("size", value, 3).tolist()
    )
    return first, second, third


def normal(size: float | ArrayLike) -> Noise:
    """Independent normal deviates: ``size * N(0, 1)`` for each body component.

    Parameters
    ----------
    size : float or array_like, shape (3,)
        Standard deviation: rad/s for rates; rad for an attitude, where the deviates are the
        components of a rotation vector applied on the body side.

    Returns
    -------
    Noise

    Raises
    ------
    ValueError
        If a size is negative or not finite.

    Examples
    --------
    >>> import rigid
    >>> rigid.normal(1e-3)
    Noise(kind='normal', size=0.001)
    >>> rigid.normal([1e-3, 0.0, 1e-3]).size
    (0.001, 0.0, 0.001)
    """
    return Noise("normal", size)  # type: ignore[arg-type]  # normalised in __post_init__


def uniform(size: float | ArrayLike) -> Noise:
    """Independent uniform deviates: ``size * U(-1, 1)`` for each body component.

    Parameters and errors are those of :func:`normal`.
    """
    return Noise("uniform", size)  # type: ignore[arg-type]


def direction(size: float | ArrayLike) -> Noise:
    """A fixed length in a random direction: ``size`` times an isotropic unit vector.

    Parameters and errors are those of :func:`normal`.
    """
    return Noise("direction", size)  # type: ignore[arg-type]


def uniform_attitude() -> Noise:
    """Any attitude, uniformly over all rotations (for ``attitude_noise`` only)."""
    return Noise("uniform_attitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """The start of a body: nominal rates and attitude, and their perturbation.

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
        The body axis that the start is about.
    tilt : float
        Angle between ``axis`` and the rates (free body) or the vertical (top), rad, in [-pi, pi].
    noise : Noise, optional
        Perturbation of the rates.
    attitude_noise : Noise, optional
        Perturbation of the attitude: a rotation vector applied on the body side.

    Raises
    ------
    ValueError
        If neither or both of ``omega`` and ``spin`` are given, or a value is out of range.

    Examples
    --------
    >>> import rigid
    >>> rigid.Start(spin=10.0, axis=2, noise=rigid.normal(1e-3)).describe()
    'spin 10 rad/s about axis 2, rates + normal(0.001)'
    >>> rigid.Start(omega=[1e-10, 1.0, 1e-10]).omega
    (1e-10, 1.0, 1e-10)
    """

    omega: tuple[float, float, float] | None = None
    spin: float | None = None
    axis: int = 3
    tilt: float = 0.0
    noise: Noise | None = None
    attitude_noise: Noise | None = None

    def __post_init__(self) -> None:
        if (self.omega is None) == (self.spin is None):
            raise ValueError("a start needs either omega or spin, and not both")
        if self.omega is not None:
            object.__setattr__(self, "omega", tuple(vector("omega", self.omega, 3).tolist()))
        if self.spin is not None:
            object.__setattr__(self, "spin", finite_float("spin", self.spin))
        object.__setattr__(self, "axis", body_axis(self.axis))
        object.__setattr__(self, "tilt", finite_float("tilt", self.tilt))
        if abs(self.tilt) > pi:
            raise ValueError(f"tilt = {self.tilt}: must lie in [-pi, pi] (rad)")
        for name in ("noise", "attitude_noise"):
            noise = getattr(self, name)
            if noise is not None and not isinstance(noise, Noise):
                raise TypeError(
                    f"{name} = {brief(noise)}: must be a Noise such as rigid.normal(1e-3)"
                )
        if self.noise is not None and self.noise.kind == "uniform_attitude":
            raise ValueError(
                "noise = uniform_attitude(): rates have no attitude; use attitude_noise"
            )

    def to_dict(self) -> dict[str, Any]:
        """The start as a JSON-able dictionary; :meth:`from_dict` is its inverse."""
        return {
            "omega": None if self.omega is None else list(self.omega),
            "spin": self.spin,
            "axis": self.axis,
            "tilt": self.tilt,
            "noise": None if self.noise is None else self.noise.to_dict(),
            "attitude_noise": (
                None if self.attitude_noise is None else self.attitude_noise.to_dict()
            ),
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Start:
        """The start that :meth:`to_dict` described."""
        values = dict(data)
        for name in ("noise", "attitude_noise"):
            if values.get(name) is not None:
                values[name] = Noise(**values[name])
        return cls(**values)

    def describe(self, varied: Container[str] = ()) -> str:
        """The start in words; ``varied`` names what the axes of a map set."""

        def number(name: str, value: float | None) -> str:
            return "varied" if name in varied else f"{value:g}"

        if self.omega is not None:
            rates = (number(f"omega{i}", rate) for i, rate in enumerate(self.omega, 1))
            parts = [f"omega ({', '.join(rates)}) rad/s"]
        else:
            parts = [f"spin {number('spin', self.spin)} rad/s about axis {self.axis}"]
        if self.tilt != 0.0 or "tilt" in varied:
            parts.append(f"tilt {number('tilt', self.tilt)} rad")
        for label, name, noise in (
            ("rates", "noise", self.noise),
            ("attitude", "attitude_noise", self.attitude_noise),
        ):
            if noise is not None:
                parts.append(f"{label} + {noise.describe(varied=name in varied)}")
        return ", ".join(parts)


def body_axis(value: object, *, signed: bool = False) -> int:
    """The number of a body axis: 1, 2 or 3, with ``signed`` also -1, -2 or -3."""
    known = (1, 2, 3, -1, -2, -3) if signed else (1, 2, 3)
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"axis = {brief(value)}: must be a whole number")
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
