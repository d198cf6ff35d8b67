"""Tumbling asteroids: periods, energies and a time of damping."""

from __future__ import annotations

from math import pi

import numpy as np

from ..free import SpinState, damping_time, spin_periods, spin_state
from ..model.body import Body
from ..solve.simulate import simulate
from .entry import Entry

HUDSON = (
    "R. S. Hudson, S. J. Ostro, Shape and non-principal axis spin state of asteroid 4179 Toutatis, "
    "Science 270 (1995) 84-86, doi 10.1126/science.270.5233.84"
)
HUDSON_STATE = (
    "periods: the abstract; ratios of moments 3.22 ± 0.01 and 3.09 ± 0.01 and rates 20.7, 31.3 and "
    "98.0 degrees a day: not looked up, from memory of the paper"
)
ZHAO = (
    "Y. Zhao, S. Hu, J. Ji, Revisit of rotational dynamics of asteroid 4179 Toutatis from "
    "Chang'e-2's flyby, Proc. IAU Symposium 318 (2016) 156-159, doi 10.1017/S1743921315008741"
)
TAKAHASHI_STATE = (
    "periods: the abstract (arXiv:1511.04357); state of 9 November 1992: Y. Takahashi, M. W. "
    "Busch, D. J. Scheeres, Astron. J. 146 (2013) 95, as the test of Toutatis of "
    "mockingbirdnest/Principia has it"
)
TAKAHASHI = (
    "Y. Takahashi, M. W. Busch, D. J. Scheeres, Spin state and moment of inertia characterization "
    "of 4179 Toutatis, Astron. J. 146 (2013) 95, doi 10.1088/0004-6256/146/4/95; the angle by "
    "another program: the test of Toutatis of mockingbirdnest/Principia"
)
RATES = "state, rates by radar and angle: the test of Principia, physics/euler_solver_test.cpp"
BROZOVIC = (
    "M. Brozović et al., Goldstone and Arecibo radar observations of (99942) Apophis in 2012-2013, "
    "Icarus 300 (2018) 115-128, doi 10.1016/j.icarus.2017.08.032"
)
PRAVEC = (
    "P. Pravec et al., The tumbling spin state of (99942) Apophis, Icarus 233 (2014) 48-60, "
    "doi 10.1016/j.icarus.2014.01.026"
)


def toutatis_of_1995() -> SpinState:
    """The state of Hudson and Ostro; axes short, intermediate and long, time in days."""
    return spin_periods((3.22, 3.09, 1.0), np.radians([31.3, 20.7, 98.0]))


def toutatis_of_2013() -> SpinState:
    """The state of Takahashi, Busch and Scheeres; time in days."""
    return spin_periods((3.0836, 3.235, 1.0), np.radians([14.5, 33.7, -98.5]))


def from_radar(days: float, turns: tuple[float, float, float]) -> float:
    """Angle (degrees) of the rates of Toutatis by radar from the motion since 9 November 1992.

    ``turns`` are the rates (degrees a day) so many days later; no torque acts until then.
    """
    body = Body((3.0836, 3.235, 1.0))
    run = simulate(body, np.radians([14.51, 33.529, -98.709]), t=[days])
    here, there = run.omega[0], np.radians(turns)
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(here, there)), here @ there)))


def radar_energy() -> float:
    """Energy of Apophis over the least with its momentum, by moments and rates of radar."""
    moments, rates = np.array([0.729, 0.947, 1.0]), np.array([96.506, 50.799, 264.953])
    return float(np.sum(moments * rates**2) / np.sum((moments * rates) ** 2))


def apophis() -> SpinState:
    """The state of the moments and periods of Pravec et al.; time in hours."""
    return spin_state((0.61, 0.965, 1.0), precession=27.38, rotation=263.0, mode="SAM")


def period_of_damping() -> float:
    """Period (h) of a body of 1 km that is damped in 1e9 years; the time goes as its cube."""
    hour, age = 3600.0, 1e9 * 365.25 * 86400.0
    of_an_hour = damping_time(500.0, 2.0 * pi / hour, density=2000.0, rigidity=5e9, quality=100.0)
    return float((age / of_an_hour) ** (1.0 / 3.0))


ENTRIES = (
    Entry(
        name="toutatis-rotation",
        quantity="(4179) Toutatis: period of the rotation about the long axis, from its state in "
        "1992",
        printed="5.38 ± 0.03",
        unit="d",
        source=ZHAO,
        seen=TAKAHASHI_STATE,
        compute=lambda: float(toutatis_of_2013().rotation),
    ),
    Entry(
        name="toutatis-precession",
        quantity="(4179) Toutatis: period of the precession of the long axis, from its state in "
        "1992",
        printed="7.40 ± 0.03",
        unit="d",
        source=ZHAO,
        seen=TAKAHASHI_STATE,
        compute=lambda: float(toutatis_of_2013().precession),
    ),
    Entry(
        name="toutatis-1995-rotation",
        quantity="(4179) Toutatis: period of the rotation about the long axis, from the first "
        "published state",
        printed="5.41",
        within=0.02,
        interval="error 0.01 of the ratios of moments, rounding of the rates",
        unit="d",
        source=HUDSON,
        seen=HUDSON_STATE,
        compute=lambda: float(toutatis_of_1995().rotation),
    ),
    Entry(
        name="toutatis-1995-precession",
        quantity="(4179) Toutatis: period of the precession of the long axis, from the first "
        "published state",
        printed="7.35",
        within=0.02,
        interval="error 0.01 of the ratios of moments, rounding of the rates",
        unit="d",
        source=HUDSON,
        seen=HUDSON_STATE,
        compute=lambda: float(toutatis_of_1995().precession),
    ),
    Entry(
        name="toutatis-2-december",
        quantity="(4179) Toutatis: angle between its rates by radar on 2 December 1992 and the "
        "motion without torque since 9 November",
        printed="4.5",
        unit="degrees",
        source=TAKAHASHI,
        seen=RATES,
        compute=lambda: from_radar(23.159872685, (-35.6, 7.2, -97.0)),
    ),
    Entry(
        name="toutatis-10-december",
        quantity="(4179) Toutatis: angle between its rates by radar on 10 December 1992 and the "
        "motion without torque since 9 November",
        printed="0.8",
        unit="degrees",
        source=TAKAHASHI,
        seen=RATES,
        compute=lambda: from_radar(30.979317130, (35.8, -8.9, -97.9)),
    ),
    Entry(
        name="apophis-radar-energy",
        quantity="(99942) Apophis: energy over the least energy with its angular momentum, from "
        "its rates and moments by radar",
        printed="1.0254",
        source=BROZOVIC,
        seen="supplement, as the notebook spin_general of aquillen/Apophis has it",
        compute=radar_energy,
    ),
    Entry(
        name="apophis-period",
        quantity="(99942) Apophis: period of the main peak of its light curve, from the rotation "
        "of 263 h in the frame of the precession of 27.38 h",
        printed="30.56 ± 0.01",
        unit="h",
        source=PRAVEC,
        seen="J. V. DeMartini et al., Icarus 328 (2019) 93, section 1.3",
        compute=lambda: 1.0 / (1.0 / float(apophis().precession) - 1.0 / float(apophis().rotation)),
    ),
    Entry(
        name="apophis-energy",
        quantity="(99942) Apophis: energy over the least energy with its angular momentum, from "
        "its periods 27.38 h and 263 h",
        printed="1.024 ± 0.013",
        interval="stated error (3 sigma)",
        source=PRAVEC,
        seen="energy: the abstract; ratios of moments 0.61 and 0.965 and the periods: from memory "
        "of the abstract, the found text ends before them",
        compute=lambda: float(apophis().energy),
    ),
    Entry(
        name="damping-of-tumbling",
        quantity="asteroid of 1 km, of 2000 kg/m³, mu Q = 5e11 Pa and K3² = 0.03: period of "
        "rotation whose nutation is damped in 1e9 years",
        printed="17",
        unit="h",
        source="A. W. Harris, Tumbling asteroids, Icarus 107 (1994) 209-211, from the formula of "
        "J. A. Burns, V. S. Safronov, Mon. Not. R. Astron. Soc. 165 (1973) 403-411",
        seen="the abstract of the manuscript; the number and its parameters: from memory",
        compute=period_of_damping,
    ),
)
