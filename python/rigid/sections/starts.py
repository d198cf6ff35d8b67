"""Random starts of tops with one energy and one angular momentum about the vertical."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import finite_float, positive_int
from .._checks.arrays import Floats
from .._checks.moments import refuse_rods
from .._checks.overflow import refuses_overflow
from ..model.scene import HeavyTop, check_heavy_top, require_unforced
from ..model.seed import seed_from
from .surface import Section, checked_section

DRAWS = 4096
"""Verticals drawn at once."""

ROUNDS = 500
"""Draws after which a surface counts as out of reach."""

FAINT = 1e-30
"""A component of the weight, as a share of the largest, that changes no digit of an energy."""

HALVINGS = 60
"""Halvings of an interval of logarithms, at most 1000 long, to the spacing of doubles."""


@refuses_overflow
def on_surface(
    top: HeavyTop,
    energy: float,
    l_gamma: float,
    count: int,
    section: Section | str | None = None,
    rng: int | np.random.Generator | np.random.SeedSequence | None = None,
) -> tuple[Floats, Floats]:
    """Draw random starts of one energy and one ``L·gamma`` on a surface of section.

    Both are constants of the motion, so a picture of a section shows motions that share them. The
    vertical is drawn evenly over the directions that the energy allows (on the circle of a section
    by ``gamma`` alone); the rates then follow, up to a choice among those that cross the surface in
    its direction, which is drawn too.

    Parameters
    ----------
    top : HeavyTop
        One top, without applied torque and damping.
    energy : float
        Kinetic and potential energy (J), as in :func:`heavy_constants`.
    l_gamma : float
        Angular momentum about the upward vertical (kg m²/s).
    count : int
        Number of starts.
    section : Section or str, optional
        The surface, made by :func:`rigid.section`, or its name. Default: ``"height"``.
    rng : int, Generator or SeedSequence, optional
        Key of the random numbers; a whole number gives the same starts every time.

    Returns
    -------
    omega : ndarray, shape (count, 3)
        Angular velocities in the body (rad/s).
    attitude : ndarray, shape (count, 4)
        Unit quaternions.

    Raises
    ------
    ValueError
        Naming the argument, its value and the rule: an energy below the least with this
        ``l_gamma``, a section that no motion of this energy crosses, torque or damping.

    Examples
    --------
    >>> import rigid
    >>> top = rigid.HeavyTop(rigid.Body((2.0, 2.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
    >>> omega, attitude = rigid.top.on_surface(top, energy=1.5, l_gamma=0.5, count=10, rng=1)
    >>> constants = rigid.top.heavy_constants(top, omega, attitude)
    >>> constants.energy.round(12).tolist() == [1.5] * 10
    True
    >>> constants.p_phi.round(12).tolist() == [0.5] * 10
    True
    """
    require_unforced(check_heavy_top(top), "a surface of one energy")
    level = finite_float("energy", energy)
    momentum = finite_float("l_gamma", l_gamma)
    count = positive_int("count", count)
    surface = checked_section(section)
    body = _Top(top, momentum)
    least = least_energy(top, momentum)
    if level < least:
        raise ValueError(
            f"energy = {level!r}: must be at least {least:.9g} J with l_gamma = {momentum!r}"
        )
    generator = np.random.Generator(np.random.PCG64(seed_from(rng)))
    normals = surface.normals(top, body.weight[np.newaxis])
    omegas, gammas = np.empty((0, 3)), np.empty((0, 3))
    for _ in range(ROUNDS):
        omega, gamma = body.drawn(generator, level, surface, normals[0])
        omegas, gammas = np.concatenate([omegas, omega]), np.concatenate([gammas, gamma])
        if len(omegas) >= count:
            return omegas[:count], _attitudes(gammas[:count])
    raise ValueError(
        f"section: {len(omegas)} of {ROUNDS * DRAWS} random verticals have a crossing "
        f"({surface.words()}) with energy = {level!r} and l_gamma = {momentum!r}; the least "
        f"energy is {least:.9g} J"
    )


def least_energy(top: HeavyTop, l_gamma: float) -> float:
    """The least energy (J) of a top with this angular momentum L about the vertical.

    The top turns about the vertical, and each component of the vertical has the opposite sign of
    the weight w. The energy ``L²/(2 Σ I_k y_k) - Σ |w_k| sqrt(y_k)`` is a convex function of the
    squares y of the components, so it has one minimum, a rotation about an axis of Staude's cone:
    ``sqrt(y_k)`` is proportional to ``|w_k| / (x + 1 - I_k / max(I))``, where a monotonic equation
    determines x > 0.
    """
    moments, weight = np.array(top.body.moments), np.abs(np.reshape(top.weight, 3))
    largest, heaviest = moments.max(), weight.max()
    kinetic = 0.5 * l_gamma * (l_gamma / largest)
    turning = 2.0 * kinetic / heaviest if heaviest else 0.0
    if not turning:
        return float(kinetic - np.linalg.norm(weight))
    inertia, pull = moments / largest, weight / heaviest
    apart = (largest - moments) / largest
    # Without a component along the axis of the largest moment x may be zero.
    pull[moments.argmax()] = max(pull[moments.argmax()], FAINT)
    low = np.log(np.linalg.norm(pull[apart == 0.0])) + 2.0 * np.log(inertia.min())
    low, high = np.array([low, np.log(np.linalg.norm(pull))]) - np.log(turning)
    for _ in range(HALVINGS):
        half = 0.5 * (low + high)
        parts = pull / (np.exp(half) + apart)
        size = parts.max() * np.linalg.norm(parts / parts.max())
        vertical = parts / size
        about = inertia @ vertical**2
        low, high = (half, high) if size * about**2 > turning else (low, half)
    return float(heaviest * (0.5 * turning / about - pull @ vertical))


class _Top:
    """A top with an angular momentum about the vertical."""

    def __init__(self, top: HeavyTop, momentum: float) -> None:
        self.moments = np.array(top.body.moments)
        refuse_rods(self.moments)
        self.weight = np.reshape(top.weight, 3)
        self.momentum = momentum

    def effective(self, gamma: Floats) -> Floats:
        """The least energy at verticals (n, 3): the body turns about the vertical."""
        about = np.sum(self.moments * gamma**2, axis=-1)
        least: Floats = gamma @ self.weight + 0.5 * self.momentum**2 / about
        return least

    def drawn(
        self, generator: np.random.Generator, energy: float, surface: Section, normal: Floats
    ) -> tuple[Floats, Floats]:
        """Rates and verticals of some random starts, at most one for each vertical drawn."""
        gamma = generator.normal(size=(DRAWS, 3))
        if not surface.is_height and not any(surface.omega):
            gamma = _on_circle(gamma, normal[3:], surface.value)
        else:
            gamma /= np.linalg.norm(gamma, axis=1, keepdims=True)
        # Which of the rates that fit, and their angle where all fit.
        second, angle = generator.random(DRAWS) < 0.5, 2.0 * np.pi * generator.random(DRAWS)
        rest = energy - self.effective(gamma)
        allowed = rest >= 0.0
        gamma, second, angle = gamma[allowed], second[allowed], angle[allowed]
        omega, fits = self._rates(gamma, rest[allowed], surface, normal, second, angle)
        slope = self._slope(omega, gamma, surface, normal)
        fits &= (slope * surface.direction > 0.0) | (surface.direction == 0)
        return omega[fits], gamma[fits]

    def _rates(
        self,
        gamma: Floats,
        rest: Floats,
        surface: Section,
        normal: Floats,
        second: NDArray[np.bool_],
        angle: Floats,
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Rates on the surface, and whether there are any; ``rest`` is the remaining energy.

        The rates are the turning about the vertical and a part without angular momentum about it,
        whose kinetic energy is ``rest``: an ellipse, which the surface cuts in two points.
        """
        heavy = self.moments * gamma
        turning = (self.momentum / np.sum(heavy * gamma, axis=1))[:, np.newaxis] * gamma
        # An orthonormal frame of the plane, in the metric of the kinetic energy.
        root = np.sqrt(self.moments)
        frame = _frame(heavy / root / np.linalg.norm(heavy / root, axis=1, keepdims=True))
        across, along = (direction / root for direction in frame)
        radius = np.sqrt(2.0 * rest)
        if surface.is_height:
            # gamma × omega has no part of the turning.
            cut = np.cross(normal[3:], gamma)
            aim = np.zeros(len(gamma))
        else:
            cut = np.broadcast_to(normal[:3], gamma.shape)
            aim = surface.value - gamma @ normal[3:] - turning @ normal[:3]
        a, b = np.sum(cut * across, axis=1), np.sum(cut * along, axis=1)
        size = np.hypot(a, b) * radius
        if not surface.is_height and not any(surface.omega):
            fits, phase = np.ones(len(gamma), dtype=bool), angle
        else:
            fits = (size > 0.0) & (np.abs(aim) <= size)
            share = np.divide(aim, size, out=np.zeros(len(gamma)), where=fits)
            opening = np.arccos(share)
            phase = np.arctan2(b, a) + np.where(second, opening, -opening)
        rates = across * np.cos(phase)[:, np.newaxis] + along * np.sin(phase)[:, np.newaxis]
        return turning + radius[:, np.newaxis] * rates, fits

    def _slope(self, omega: Floats, gamma: Floats, surface: Section, normal: Floats) -> Floats:
        """The rate of change of the function that is zero on the surface."""
        torque = np.cross(self.moments * omega, omega) + np.cross(gamma, self.weight)
        change, turn = torque / self.moments, np.cross(gamma, omega)
        if surface.is_height:
            slope: Floats = (np.cross(turn, omega) + np.cross(gamma, change)) @ normal[3:]
        else:
            slope = change @ normal[:3] + turn @ normal[3:]
        return slope


def _frame(normal: Floats) -> tuple[Floats, Floats]:
    """Two orthonormal directions across unit vectors (n, 3)."""
    least = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    across = np.cross(normal, least)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(normal, across)


def _on_circle(directions: Floats, normal: Floats, value: float) -> Floats:
    """Unit vectors with this component along a normal, evenly on their circle."""
    length = float(np.linalg.norm(normal))
    unit, height = normal / length, value / length
    flat = directions - (directions @ unit)[:, np.newaxis] * unit
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    circle: Floats = height * unit + np.sqrt(max(0.0, 1.0 - height * height)) * flat
    return circle


def _attitudes(gamma: Floats) -> Floats:
    """Attitudes with these upward verticals in the body, by the shortest turn."""
    x, y, z = gamma.T
    zero = np.zeros_like(x)
    q = np.stack([1.0 + z, y, -x, zero], axis=1)
    # Near the downward vertical a turn by half a turn about axis 1 first keeps the digits.
    q = np.where((z < 0.0)[:, np.newaxis], np.stack([y, 1.0 - z, zero, x], axis=1), q)
    attitude: Floats = q / np.linalg.norm(q, axis=1, keepdims=True)
    return attitude
