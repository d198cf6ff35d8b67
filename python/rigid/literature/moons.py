"""Moons and satellites under a gravity gradient on a circular orbit."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from ..free import libration
from ..model.body import Body
from ..model.criteria import tilt_below
from ..model.orbit import Orbit
from ..model.scene import FreeBody
from ..model.start import Start, normal
from ..solve.frequencies import frequencies
from ..solve.simulate import simulate
from ..store.call import stability_map
from .entry import Entry

Floats = NDArray[np.float64]

YANG = (
    "Y.-Z. Yang, J.-L. Li, J.-S. Ping, H. Hanada, Determination of the free lunar libration modes "
    "from ephemeris DE430, Res. Astron. Astrophys. 17 (2017) 127, doi 10.1088/1674-4527/17/12/127"
)
YANG_SEEN = (
    "periods: the abstract; beta = 6.310e-4 and gamma = 2.277e-4 of the Moon: from memory of the "
    "constants of DE430, to four digits"
)
# The numbers of the model follow from n √(3 γ), and from the quartic of roll and yaw.
MOON_REASON = (
    "the model is a circular orbit in the plane of the equator: of the missing percent, the "
    "eccentricity 0.055 (factor 1 - 5 e²/2 of the torque) and the inclination 6.7 degrees make 0.7"
)
TETHER = (
    "V. V. Beletskii, Motion of an Artificial Satellite about its Center of Mass, Israel Program "
    "for Scientific Translations (1966)"
)
HUGHES = (
    "P. C. Hughes, Spacecraft Attitude Dynamics, Wiley (1986), section 9.2; D. B. DeBra, R. H. "
    "Delp, J. Astronaut. Sci. 8 (1961) 14-17"
)
TEXTBOOK = "formula of the textbook, from memory"
REGIONS = (
    "plots of the regions of the course AA 279C (Stanford) in public repositories, with the "
    "formula and references to J. R. Wertz, Spacecraft Attitude Determination and Control, pp. "
    "611-612"
)

AT_REST = (0.5, 0.5, -0.5, -0.5)
"""Roll along the motion, pitch along the normal, yaw to the centre, in ``on_orbit``."""

NEEDLE = (1.0, 1.0 + 0.5e-4, 1e-4)
"""Moments of a dumbbell: roll, pitch, and yaw along its length."""

K3 = -0.5
"""``(I2 - I1) / I3`` of the bodies near the border of DeBra and Delp."""

STEP_OF_K1 = 0.001
"""Distance of these bodies in ``k1 = (I2 - I3) / I1``."""


def on_orbit(moments: tuple[float, float, float] | Floats) -> FreeBody:
    """Satellites on a circular orbit of the rate 1 rad/s."""
    return FreeBody(Body(moments), orbit=Orbit(1.0))


def moon() -> tuple[float, float, float]:
    """Periods (d) of the free modes of the Moon: longitude, latitude and wobble.

    In the body the mode in latitude is nearly a month; the literature refers it to the node of the
    orbit, whose month is the draconic one.
    """
    beta, gamma = 6.310e-4, 2.277e-4  # (C - A)/B and (B - A)/C
    # With A = 1: B = 1 + gamma C and C = 1 + beta B.
    largest = (1.0 + beta) / (1.0 - beta * gamma)
    middle = 1.0 + gamma * largest
    found = libration((middle, largest, 1.0), 2.0 * pi / 27.321661)
    latitude = 2.0 * pi / 27.212221 - float(found.roll_yaw[0])
    longitude, wobble = float(found.pitch), float(found.roll_yaw[1])
    return 2.0 * pi / longitude, 2.0 * pi / latitude, 2.0 * pi / wobble


def frequency_of_dumbbell(axis: int, lines: int) -> float:
    """Highest frequency of a dumbbell that swings about a body axis, over the rate of the orbit.

    Pitch has one line, roll and yaw together have two.
    """
    rest = np.array([0.0, 1.0, 0.0])
    swing = 1e-5 * np.eye(3)[axis - 1]
    t = np.linspace(0.0, 100.0, 1001)
    run = simulate(on_orbit(NEEDLE), rest + swing, AT_REST, t=t, record="rates")
    found = frequencies(t, run.omega[:, axis - 1] - rest[axis - 1], count=lines)
    return float(found.frequency.max())


def border_by_formula() -> float:
    """``k1`` at the border of DeBra and Delp: the roots of roll and yaw meet.

    ``1 + 3 k1 + k1 k3 = 4 sqrt(k1 k3)``, a quadratic equation for the root of ``-k1``.
    """
    a, b = 3.0 + K3, 2.0 * sqrt(-K3)
    root = (sqrt(b * b + a) - b) / a
    return -root * root


def border_by_motion() -> float:
    """``k1`` of the first of a row of satellites that leaves its rest."""
    k1 = border_by_formula() + STEP_OF_K1 * (15.25 - np.arange(30.0))
    roll = (1.0 - K3) / (1.0 - k1 * K3)
    moments = np.stack([roll, np.ones(30), 1.0 - k1 * roll], axis=-1)
    run = simulate(
        on_orbit(moments),
        [1e-6, 1.0, 1e-6],
        AT_REST,
        t=np.linspace(0.0, 1500.0, 76),
        record="rates",
    )
    leaves = np.abs(run.omega[..., [0, 2]]).max(axis=(1, 2)) > 1e-2
    return float(k1[leaves].max()) + 0.5 * STEP_OF_K1


def wrong_pixels() -> float:
    """Pixels of a map of satellites whose motions the linear theory predicts wrongly."""
    ratios = np.linspace(0.1, 2.3, 23)
    result = stability_map(
        FreeBody(Body((1.0, 1.0, 1.0)), orbit=Orbit(1.0)),
        axes={"I1/I3": ratios, "I2/I3": ratios},
        start=Start(omega=(0.0, 0.0, 1.0), noise=normal(1e-4)),
        stable=tilt_below(0.5, axis=3, reference="vertical"),
        t_end=100.0,
        samples=4,
        rng=2026,
        progress=False,
    )
    return float(result.disagreement().sum())


ENTRIES = (
    Entry(
        name="moon-longitude",
        quantity="the Moon: period of the free libration in longitude, linear on a circular orbit",
        printed="1056.16",
        unit="d",
        source=YANG,
        seen=YANG_SEEN,
        compute=lambda: moon()[0],
        reason=MOON_REASON,
        model=1045.358,
    ),
    Entry(
        name="moon-latitude",
        quantity="the Moon: period of the free libration in latitude against the node, linear on a "
        "circular orbit",
        printed="8806.9",
        unit="d",
        source=YANG,
        seen=YANG_SEEN,
        compute=lambda: moon()[1],
        reason="the period is a beat of nearly a month with the draconic month; eccentricity and "
        "inclination of the orbit are missing, as in the libration in longitude",
        model=8882.06,
    ),
    Entry(
        name="moon-wobble",
        quantity="the Moon: period of the free wobble, linear on a circular orbit",
        printed="27262.99",
        unit="d",
        source=YANG,
        seen=YANG_SEEN,
        compute=lambda: moon()[2],
        reason="the model is a circular orbit in the plane of the equator; eccentricity and "
        "inclination of the orbit are missing, as in the libration in longitude",
        model=27105.585,
    ),
    Entry(
        name="dumbbell-in-plane",
        quantity="dumbbell on a circular orbit: frequency of the swing in the plane, over the rate "
        "of the orbit, measured from a motion",
        printed="√3",
        value=sqrt(3.0),
        within=2e-4,
        interval="ratio 1e-4 of the moments",
        source=TETHER,
        seen=TEXTBOOK,
        compute=lambda: frequency_of_dumbbell(2, lines=1),
    ),
    Entry(
        name="dumbbell-out-of-plane",
        quantity="dumbbell on a circular orbit: frequency of the swing out of the plane, over the "
        "rate of the orbit, measured from a motion",
        printed="2",
        within=2e-4,
        interval="ratio 1e-4 of the moments",
        source=TETHER,
        seen=TEXTBOOK,
        compute=lambda: frequency_of_dumbbell(1, lines=2),
    ),
    Entry(
        name="debra-delp-border",
        quantity="satellite on a circular orbit: (I_pitch - I_yaw)/I_roll at the border of DeBra "
        "and Delp, with (I_pitch - I_roll)/I_yaw = -1/2; measured from motions",
        printed="1 + 3 k1 + k1 k3 = 4 √(k1 k3)",
        value=border_by_formula(),
        within=0.5 * STEP_OF_K1,
        interval="half the distance of the bodies",
        source=HUGHES,
        seen=REGIONS,
        compute=border_by_motion,
    ),
    Entry(
        name="debra-delp-map",
        quantity="satellites on a circular orbit, 529 pairs of ratios of moments: pixels of the "
        "map that contradict the regions of Lagrange and of DeBra and Delp",
        printed="no exception",
        value=0.0,
        within=0.0,
        interval="whole number",
        source=HUGHES,
        seen=REGIONS,
        compute=wrong_pixels,
    ),
)
