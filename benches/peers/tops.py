"""The two scenes, the ways to write their equations, and the error of a state.

A form is a set of variables with the right-hand side as a plain function of them: heyoka calls it
with its expressions, numba compiles it. The numbers of the body are constants in both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
State = tuple[Floats, Floats]
"""Rates in the body, (n, 3), and rotation matrices, body to space, (n, 3, 3)."""


@dataclass(frozen=True)
class Scene:
    name: str
    moments: tuple[float, float, float]
    mgl: float
    com: tuple[float, float, float]
    omega: tuple[float, float, float]
    tilt: float
    t: float
    targets: tuple[float, ...]
    goals: dict[float, float]
    """Time of the better peer over that of rigid."""

    @property
    def weight(self) -> tuple[float, float, float]:
        x, y, z = (self.mgl * c for c in self.com)
        return x, y, z

    @property
    def symmetric(self) -> bool:
        return self.moments[0] == self.moments[1] and self.com[:2] == (0.0, 0.0)

    def cloud(self, count: int) -> Floats:
        """Rates at the start: a nominal one and 1e-3 of noise."""
        noise = np.random.default_rng(2026).standard_normal((count, 3))
        return np.array(self.omega) + 1e-3 * noise

    def attitude(self) -> Floats:
        """Quaternion at the start, scalar first."""
        return np.array([np.cos(0.5 * self.tilt), np.sin(0.5 * self.tilt), 0.0, 0.0])


_C = np.array([0.3, 0.2, 0.93]) / np.linalg.norm([0.3, 0.2, 0.93])
SCENES = (
    Scene(
        name="asymmetric top",
        moments=(1.0, 1.6, 0.7),
        mgl=1.2,
        com=(float(_C[0]), float(_C[1]), float(_C[2])),
        omega=(0.3, 0.1, 2.0),
        tilt=0.0,
        t=50.0,
        targets=(1e-4, 1e-6, 1e-8),
        goals={1e-4: 1.0, 1e-6: 1.3, 1e-8: 2.5},
    ),
    Scene(
        name="Lagrange top",
        moments=(1.0, 1.0, 0.4),
        mgl=1.0,
        com=(0.0, 0.0, 1.0),
        omega=(0.0, 0.0, 6.0),
        tilt=0.6,
        t=100.0,
        targets=(1e-8,),
        goals={1e-8: 4.0},
    ),
)


@dataclass(frozen=True)
class Form:
    name: str
    moving: int
    """Variables with an equation; the others are constants of a body."""
    rates: Callable[..., tuple[Any, ...]]
    """Their derivatives: a function of the variables, then of the constants."""
    start: Callable[[Floats, Floats], Floats]
    """Variables and constants, (m, n), from rates and the rotation matrix at the start."""
    end: Callable[[Floats, float], State]
    """The state from variables, constants and the time."""


def matrices(q: Floats) -> Floats:
    """Of quaternions (n, 4), which are not normalised."""
    w, x, y, z = q.T
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def forms(scene: Scene, number: Callable[[Any], Any] = float) -> list[Form]:
    """All forms of a scene; ``number`` makes the constants."""
    i1, i2, i3 = (np.longdouble(i) for i in scene.moments)
    c1, c2, c3 = (np.longdouble(c) for c in scene.weight)
    d1, d2, d3 = number((i2 - i3) / i1), number((i3 - i1) / i2), number((i1 - i2) / i3)
    c31, c21, c12, c32 = number(c3 / i1), number(c2 / i1), number(c1 / i2), number(c3 / i2)
    c23, c13 = number(c2 / i3), number(c1 / i3)
    half, one, two = number(0.5), number(1.0), number(2.0)

    def rows(u, v, w, x, y, z, a, b, c):  # type: ignore[no-untyped-def]
        return (
            d1 * (v * w) + c31 * y - c21 * z,
            d2 * (w * u) + c12 * z - c32 * x,
            d3 * (u * v) + c23 * x - c13 * y,
            y * w - z * v,
            z * u - x * w,
            x * v - y * u,
            b * w - c * v,
            c * u - a * w,
            a * v - b * u,
        )

    def quaternion(u, v, w, p, q, r, s):  # type: ignore[no-untyped-def]
        x = two * (q * s - p * r)
        y = two * (r * s + p * q)
        z = one - two * (q * q + r * r)
        e, f, g = half * u, half * v, half * w
        return (
            d1 * (v * w) + c31 * y - c21 * z,
            d2 * (w * u) + c12 * z - c32 * x,
            d3 * (u * v) + c23 * x - c13 * y,
            -(q * e + r * f + s * g),
            p * e + r * g - s * f,
            p * f + s * e - q * g,
            p * g + q * f - r * e,
        )

    def rows_start(omega: Floats, rotation: Floats) -> Floats:
        fixed = np.concatenate([rotation[2], rotation[0]])
        return np.concatenate([omega.T, np.tile(fixed[:, None], len(omega))])

    def of_rows(omega: Floats, vertical: Floats, first: Floats) -> State:
        return omega.T, np.stack([first.T, np.cross(vertical.T, first.T), vertical.T], axis=1)

    def quaternion_start(omega: Floats, _: Floats) -> Floats:
        return np.concatenate([omega.T, np.tile(scene.attitude()[:, None], len(omega))])

    made = [
        Form("two rows", 9, rows, rows_start, lambda y, _: of_rows(y[:3], y[3:6], y[6:])),
        Form(
            "quaternion", 7, quaternion, quaternion_start, lambda y, _: (y[:3].T, matrices(y[3:].T))
        ),
    ]
    if not scene.symmetric:
        return made

    # The spin about the axis of a symmetric top does not change.
    def spinning(u, v, x, y, z, a, b, c, w):  # type: ignore[no-untyped-def]
        return (
            d1 * (v * w) + c31 * y,
            d2 * (w * u) - c32 * x,
            y * w - z * v,
            z * u - x * w,
            x * v - y * u,
            b * w - c * v,
            c * u - a * w,
            a * v - b * u,
        )

    def spinning_start(omega: Floats, rotation: Floats) -> Floats:
        return np.roll(rows_start(omega, rotation), -3, axis=0)[[6, 7, 0, 1, 2, 3, 4, 5, 8]]

    made.append(
        Form(
            "two rows, spin constant",
            8,
            spinning,
            spinning_start,
            lambda y, _: of_rows(y[[0, 1, 8]], y[2:5], y[5:8]),
        )
    )

    # In space, as a ball with the moment I1, whose turns are slower; the rest of the spin is known.
    # Angular momentum (k, l, m), axis (x, y, z) and a direction across it, carried with the ball.
    mgl, inverse = number(np.longdouble(scene.mgl)), number(1 / i1)

    def ball(k, l, x, y, z, a, b, c, m):  # type: ignore[no-untyped-def]  # noqa: E741
        e, f, g = inverse * k, inverse * l, inverse * m
        return (
            -mgl * y,
            mgl * x,
            f * z - g * y,
            g * x - e * z,
            e * y - f * x,
            f * c - g * b,
            g * a - e * c,
            e * b - f * a,
        )

    moments = np.array(scene.moments)

    def ball_start(omega: Floats, rotation: Floats) -> Floats:
        momentum = (omega * moments) @ rotation.T
        fixed = np.concatenate([rotation[:, 2], rotation[:, 0]])
        known = np.tile(fixed[:, None], len(omega))
        return np.concatenate([momentum.T[:2], known, momentum.T[2:]])

    def ball_end(y: Floats, t: float) -> State:
        axis, across, momentum = y[2:5].T, y[5:8].T, y[[0, 1, 8]].T
        spin = np.einsum("ni,ni->n", momentum, axis) / scene.moments[2]
        turned = (spin * (1.0 - scene.moments[2] / scene.moments[0]) * t)[:, None]
        third = np.cross(axis, across)
        first = np.cos(turned) * across + np.sin(turned) * third
        rotation = np.stack([first, np.cross(axis, first), axis], axis=2)
        return np.einsum("nij,ni->nj", rotation, momentum) / moments, rotation

    made.append(Form(BALL, 8, ball, ball_start, ball_end))
    return made


BALL = "ball in space, by hand"
"""The form that uses the symmetry; rigid has a closed form instead."""


def errors(state: State, truth: State) -> Floats:
    """Of each body: its attitude (rad) or its rates relative to their size, what is larger."""
    with np.errstate(all="ignore"):
        size = np.linalg.norm(truth[0], axis=1)
        rates = np.linalg.norm(state[0] - truth[0], axis=1) / size
        angles = np.linalg.norm(state[1] - truth[1], axis=(1, 2)) / np.sqrt(2.0)
        larger = np.maximum(rates, angles).astype(np.float64)
    return np.where(np.isfinite(larger), larger, np.inf)
