"""Requests of maps with every kind of scene, start, criterion, measure and option.

Whatever a map has of its own besides, `test_every_kind.py` asks all of them what holds for any.
"""

import math
from typing import Any

import numpy as np

import rigid
from planar_moons import MOMENTS

BODY = rigid.Body((1.0, 1.3, 0.7))
TOP = rigid.HeavyTop(BODY, mgl=1.0)
LEANING = rigid.HeavyTop(BODY, mgl=1.0, com=(0.6, 0.0, 0.8))
ORBIT = rigid.Orbit(0.7, 0.2, 1.1, normal=(0.0, 0.6, 0.8))
CLOUD = rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.3))
UPRIGHT = rigid.tilt_below(0.6)
COV = np.diag([0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
COV[0, 1] = COV[1, 0] = 0.005
EVERY_MEASURE = (
    rigid.time_to_leave(),
    rigid.flips(2),
    rigid.largest_tilt(reference="vertical"),
    rigid.mean_rate(1),
    rigid.mean_rate(-3),
    rigid.drift(),
)

_random = np.random.default_rng(3)
GIVEN = rigid.samples(_random.normal(size=(7, 3)), _random.normal(size=(7, 4)), np.arange(7))
MIXTURE = rigid.mixture(
    [
        rigid.Start(spin=3.0, attitude_noise=rigid.normal(0.1)),
        rigid.Start(
            spin=1.0, tilt=0.4, noise=rigid.uniform(2.0), attitude_noise=rigid.von_mises_fisher(2)
        ),
        rigid.Start(omega=(0.0, 0.0, 2.0), noise=rigid.samples(np.diag([0.1, 0.2, 0.3]))),
        rigid.Start(spin=2.0, noise=rigid.normal(cov=COV)),
    ],
    weights=[4.0, 3.0, 2.0, 1.0],
)


def stays_low(states: rigid.States) -> Any:
    """As ``tilt_below(0.6)``."""
    assert states.gamma is not None
    return np.all(states.gamma[..., 2] > math.cos(0.6), axis=1)


def wheel(wheel: Any) -> rigid.FreeBody:
    """The satellite with a rotor in each pixel, in some of no momentum."""
    rotor = np.stack([0.0 * wheel, wheel, 0.0 * wheel], axis=-1)
    return rigid.FreeBody(rigid.Body(MOMENTS), orbit=ORBIT, rotor=rotor)


PATH_TIMES = np.linspace(0.0, 9.0, 19)
PATH = np.stack([PATH_TIMES - 4.0, np.ones(19), 0.1 * PATH_TIMES], axis=1)

POINTING: dict[str, Any] = {
    "start": rigid.Start(omega=(0.1, 0.2, 0.7), attitude_noise=rigid.uniform_attitude()),
    "stable": rigid.pointing_within(1.4, 1, "along", either=True),
    "measure": [rigid.libration_amplitude(), rigid.obliquity(), rigid.spin_orbit_ratio()],
    "method": "auto",
    "samples": 12,
    "t_end": 3.0,
}
JUDGED: dict[str, Any] = {
    "scene": TOP,
    "start": CLOUD,
    "t_end": None,
    "stable": rigid.judged(stays_low, np.linspace(0.0, 20.0, 101)),
}

KINDS: dict[str, tuple[dict[str, Any], str]] = {
    "free, impossible bodies": (
        {
            "axes": {"I1": np.linspace(0.3, 3.6, 8), "noise": np.geomspace(1e-3, 0.3, 5)},
            "start": rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.0)),
            "samples": 23,
            "title": "A title, with Ümläüts",
        },
        "A title, with Ümläüts",
    ),
    "closed forms": ({"method": "exact"}, "closed form"),
    "box, splitting": (
        {
            "scene": rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)),
            "axes": {"b": [0.1, 0.05]},
            "start": rigid.Start(omega=(0.1, 1.0, 0.1), noise=rigid.normal([0.1, 0.2, 0.0])),
            "stable": rigid.no_flip(2),
            "method": "splitting",
            "step": 0.1,
            "t_end": 8.0,
            "rng": 2**128 - 1,
        },
        "seed 340282366920938463463374607431768211455",
    ),
    "free, tilt, splitting": (
        {
            "axes": {"tilt": np.linspace(0.0, 0.6, 9)},
            "start": rigid.Start(spin=1.0, axis=3, noise=rigid.direction(0.2)),
            "stable": rigid.tilt_below(0.4),
            "method": "splitting",
            "samples": 41,
            "check": 0.3,
        },
        "direction(0.2)",
    ),
    "free, attitude given": (
        {
            "scene": rigid.FreeBody(BODY, torque=rigid.Torque.space((1.0, 0.0, 0.0))),
            "axes": {"spin": [0.05, 5.0]},
            "start": rigid.Start(
                spin=1.0, attitude=(1.0, -1.0, 1.0, -1.0), noise=rigid.normal(0.3)
            ),
            "stable": rigid.no_flip(3),
        },
        "attitude (0.5, -0.5, 0.5, -0.5)",
    ),
    "top, tilt from the vertical": (
        {
            "scene": rigid.HeavyTop,
            "axes": {"spin": np.linspace(2.0, 6.0, 7), "attitude_noise": [1e-3, 0.1, 0.3]},
            "start": rigid.Start(spin=1.0, attitude_noise=rigid.normal(0.0)),
            "stable": rigid.tilt_below(0.5),
        },
        "attitude + normal(varied)",
    ),
    "top, flips, splitting": (
        {
            "scene": LEANING,
            "axes": {"spin": np.linspace(1.0, 4.0, 6)},
            "start": rigid.Start(
                spin=1.0, noise=rigid.uniform(0.1), attitude_noise=rigid.uniform_attitude()
            ),
            "stable": rigid.no_flip(3),
            "method": "splitting",
            "samples": 50,
        },
        "uniform_attitude()",
    ),
    "top, tilt from the start": (
        {
            "scene": TOP,
            "axes": {"spin": np.linspace(2.0, 10.0, 6)},
            "start": rigid.Start(spin=1.0, tilt=0.3, attitude_noise=rigid.normal(0.05)),
            "stable": rigid.tilt_below(0.8, axis=-3, reference="start"),
            "samples": 30,
            "max_steps": 12345,
        },
        "tilt of axis -3 from its start below 0.8 rad",
    ),
    "audits, limits and horizons": (
        {
            # Dividing this direction by its length again would change its last digit.
            "scene": rigid.HeavyTop(
                BODY, mgl=1 / 3, com=(-0.4392637023877839, 0.22738247619184124, -0.8691056375869641)
            ),
            "axes": {"limit": [0.3, 0.6], "mgl": [0.5, 1.0], "t_end": [2.0, 5.0, 11.0]},
            "start": CLOUD,
            "stable": UPRIGHT,
            "method": "auto",
            "samples": 70,
        },
        "limit and t_end varied",
    ),
    "joined criteria": (
        {
            "scene": TOP,
            "axes": {"spin": [2.0, 3.5]},
            "start": CLOUD,
            "stable": (rigid.tilt_between(0.0, 2.0) | rigid.near_start(1.0))
            & ~rigid.returns(0.8, after=2),
            "t_end": 5.0,
        },
        "(tilt of axis 3 from the vertical between 0 and 2 rad or attitude within 1 rad of the "
        "start) and (not (attitude back within 0.8 rad of the start after 2 s))",
    ),
    "measures": (
        {
            "scene": TOP,
            "axes": {"spin": [2.0, 3.0, 4.5]},
            "start": rigid.Start(spin=3.0, tilt=0.2, attitude_noise=rigid.normal(0.2)),
            "stable": UPRIGHT,
            "measure": EVERY_MEASURE,
            "method": None,
            "samples": 90,
            "t_end": 8.0,
        },
        "mean_rate(-3): mean",
    ),
    "regular": (
        {
            "scene": rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8)),
            "axes": {"spin": [1.0, 2.9, 7.0]},
            "start": rigid.Start(spin=0.0, tilt=0.6, attitude_noise=rigid.normal(0.2)),
            "stable": rigid.regular("attitude", 2.0, 2.5, 6.0, 1.4),
            "method": None,
            "samples": 24,
            "t_end": 100.0,
        },
        "regular with its attitude",
    ),
    "judged": ({**JUDGED, "axes": {"spin": [2.0, 3.5, 4.0]}}, "judged by stays_low"),
    "judged, measures and horizons": (
        {
            **JUDGED,
            "axes": {"spin": [3.5, 4.0], "t_end": [5.0, 20.0]},
            "measure": [rigid.flips(1), rigid.drift()],
        },
        "judged by stays_low",
    ),
    "mixture": (
        {
            "scene": TOP,
            "axes": {"mgl": [0.5, 1.0, 2.0]},
            "start": MIXTURE,
            "stable": rigid.tilt_below(0.8),
            "measure": rigid.flips(3),
            "samples": 130,
            "t_end": 5.0,
        },
        "0.4 of the bodies: spin 3 rad/s about axis 3",
    ),
    "directions": (
        {
            "scene": TOP,
            "axes": {"attitude_kappa": [0.5, 5.0]},
            "start": rigid.Start(spin=2.0, axis=1, attitude_noise=rigid.von_mises_fisher(1.0)),
            "stable": rigid.tilt_below(2.0, axis=1),
            "samples": 150,
            "t_end": 5.0,
        },
        "attitude + von_mises_fisher(varied)",
    ),
    "covariance": (
        {
            "scene": TOP,
            "axes": {"spin": [1.0, 3.0]},
            "start": rigid.Start(spin=3.0, noise=rigid.normal(cov=COV)),
            "stable": UPRIGHT,
        },
        "rates + normal(cov 6 x 6)",
    ),
    "given samples": (
        {
            "scene": TOP,
            "axes": {"mgl": [1.0, 1.5]},
            "start": rigid.Start(omega=(0.0, 0.0, 0.0), noise=GIVEN),
            "stable": rigid.tilt_below(2.5),
            "samples": 50,
            "t_end": 2.0,
        },
        "rates + 7 given samples",
    ),
    "given rates": (
        {
            "axes": {"I2/I1": [1.2, 1.5]},
            "start": rigid.Start(
                spin=1.0, axis=2, noise=rigid.samples(_random.normal(size=(7, 3)) * 1e-2)
            ),
        },
        "rates + 7 given samples",
    ),
    "driven and damped": (
        {
            "scene": rigid.HeavyTop(BODY, mgl=1.0, torque=rigid.Torque.space((0.0, 0.02, 0.0))),
            "axes": {"spin": [4.5, 6.0], "damping3": [1e-2, 0.1]},
            "start": CLOUD,
            "stable": UPRIGHT,
            "method": None,
            "t_end": 12.0,
        },
        "torque",
    ),
    "varied bodies": (
        {
            "scene": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.7)), mgl=1.2, damping=0.03),
            "axes": {"spin": [3.0, 3.6], "t_end": [5.0, 10.0]},
            "stable": rigid.tilt_below(0.5),
            "vary": {
                "I1": rigid.normal(0.1),
                "damping2": rigid.uniform(0.02),
                "mgl": rigid.uniform(0.5, relative=True),
            },
            "method": None,
            "samples": 40,
            "t_end": None,
        },
        "mgl by uniform(0.5, relative)",
    ),
    "satellites": (
        {
            "scene": rigid.FreeBody(
                rigid.Body((1.0, 1.6, 2.0)),
                orbit=rigid.Orbit(0.3, 0.2),
                rotor=(0.1, 0.0, 0.2),
                dissipation=rigid.EnergySink(0.05),
            ),
            "axes": {"spin": [0.5, 1.0], "I1": [0.8, 1.2]},
            "start": rigid.Start(
                spin=1.0, axis=2, noise=rigid.normal(1e-2), attitude_noise=rigid.normal(1e-2)
            ),
            "stable": rigid.no_flip(2),
            "method": None,
            "check": 0.5,
            "t_end": 8.0,
        },
        "orbit",
    ),
    "under tables": (
        {
            "scene": rigid.FreeBody(
                rigid.Body((1.0, 1.6, 2.0)),
                orbit=rigid.Orbit.table(PATH_TIMES, PATH, gm=0.4),
                rotor=rigid.RotorTable([0.0, 3.3, 9.0], [(0, 0, 0), (0.3, 0, 0.2), (0, 0.4, 0)]),
                torque=rigid.Torque.body([(0, 0, 0.02), (0, 0, 0)], times=[0.0, 9.0]),
            ),
            "axes": {"spin": [0.5, 1.0], "I1": [0.8, 1.2]},
            "start": rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)),
            "stable": rigid.no_flip(2),
            "measure": [rigid.mean_rate(1), rigid.drift()],
            "method": None,
            "check": 0.5,
            "t_end": 8.0,
        },
        "orbit by a table of 19 times",
    ),
    "pointing": (
        {
            **POINTING,
            "scene": rigid.FreeBody(rigid.Body(MOMENTS), orbit=ORBIT),
            "axes": {"eccentricity": [0.0, 0.1, 0.4], "rotor2": [0.0, 0.1]},
        },
        "axis 1 within 1.4 rad",
    ),
    "roll, pitch and yaw": (
        {
            **POINTING,
            "scene": rigid.FreeBody(rigid.Body(MOMENTS), orbit=ORBIT),
            "axes": {"eccentricity": [0.0, 0.4], "rotor2": [0.0, 0.1]},
            "stable": rigid.yaw_within(2.0)
            & rigid.pitch_within(1.4)
            & rigid.roll_within(2.5, axes=(3, -2)),
            "measure": [
                rigid.largest_pitch(),
                rigid.time_to_settle(0.6),
                rigid.time_to_settle(1.5, "roll"),
            ],
        },
        "(yaw within 2 rad and pitch within 1.4 rad) and roll within 2.5 rad",
    ),
    "rates": (
        {
            "axes": {"spin": [0.3, 1.0, 3.0]},
            "start": rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.1)),
            "stable": rigid.rate_within(1.5) & rigid.spin_above(0.2, axis=2),
            "samples": 12,
        },
        "and rate about axis 2 above 0.2 rad/s",
    ),
    "pointing, rotors by a function": (
        {**POINTING, "scene": wheel, "axes": {"eccentricity": [0.0, 0.4], "wheel": [0.0, 0.1]}},
        "free body by wheel(wheel)",
    ),
    "as many as needed": (
        {"samples": None, "half_width": 0.1, "axes": {"noise": [1e-3, 3e-3, 0.1]}, "check": 0.3},
        "per pixel",
    ),
}
"""By name: what :func:`small_maps.small_map` is given, and words of the summary."""
