"""Quantities with units become numbers in SI units at the door, or are refused in words."""

import warnings
from contextlib import nullcontext
from functools import partial
from typing import Any

import numpy as np
import pint
import pytest

import rigid
from refusals import refuses
from rigid import solids, units
from rigid._checks.quantities import UNITS
from rigid.model.parameters import PARAMETERS

REGISTRY: Any = pint.UnitRegistry()
Q: Any = REGISTRY.Quantity


def test_constants_are_those_of_pint() -> None:
    assert np.isclose(units.rpm, Q(1.0, "rpm").to("rad/s").magnitude, rtol=1e-15)
    assert np.isclose(units.degree, Q(1.0, "degree").to("rad").magnitude, rtol=1e-15)


def test_pint_knows_every_unit_of_the_tables() -> None:
    known = [unit for some in UNITS.values() for unit in some]
    known += [row.unit for row in PARAMETERS.values() if row.unit != "1"]
    base = {str(REGISTRY.parse_units(unit).dimensionality) for unit in known}
    assert len(base) > 8
    for unit in known:
        one = Q(1.0, unit)
        assert np.isclose(one.to_base_units().magnitude, 1.0, rtol=1e-12), unit


def test_a_body_of_millimetres_and_grams() -> None:
    sides = [Q(250.0, "mm"), Q(8.0, "cm"), Q(0.01, "m")]
    book = rigid.Body.box(*sides, mass=Q(300.0, "g"))
    assert np.allclose(book.moments, rigid.Body.box(0.25, 0.08, 0.01, mass=0.3).moments, rtol=1e-15)
    tensor = np.array([[2.0, 0.1, 0.0], [0.1, 3.0, 0.0], [0.0, 0.0, 4.0]])
    body, _ = rigid.Body.from_tensor(Q(tensor, "g cm²"))
    assert np.allclose(body.moments, rigid.Body.from_tensor(1e-7 * tensor)[0].moments, rtol=1e-14)
    bodies = rigid.Body(Q([[1.0, 2.0, 2.5], [1.0, 1.0, 1.5]], "kg m²"), mass=Q([1.0, 2.0], "kg"))
    assert bodies[1].mass == 2.0
    slab = solids.box(*sides, mass=Q(300.0, "g"))
    assert np.allclose(np.diagonal(slab.tensor), book.moments, rtol=1e-15)
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    corner, _ = rigid.Body.from_mesh(
        Q(60.0 * np.eye(4, 3, -1), "mm"), faces, density=Q(7.8, "g/cm³")
    )
    assert isinstance(corner.mass, float)
    assert np.isclose(corner.mass, 7800.0 * 0.06**3 / 6.0, rtol=1e-14)


def test_a_top_of_millimetres() -> None:
    cone = rigid.Body.cone(Q(3.0, "cm"), Q(5.0, "cm"), mass=Q(100.0, "g"))
    centre = [Q(0.0, "mm"), Q(0.0, "mm"), Q(37.5, "mm")]
    top, _ = rigid.HeavyTop.from_mass(cone, com=centre, g=Q(9.81, "m/s**2"))
    same, _ = rigid.HeavyTop.from_mass(rigid.Body.cone(0.03, 0.05, mass=0.1), com=[0, 0, 0.0375])
    assert np.isclose(top.mgl, same.mgl, rtol=1e-14)
    assert np.allclose(top.body.moments, same.body.moments, rtol=1e-14)
    assert rigid.HeavyTop(same.body, mgl=Q(1000.0, "mJ")).mgl == 1.0


def test_a_run_in_turns_a_minute_and_minutes() -> None:
    wheel = rigid.Body((1.0, 1.0, 1.8))
    scene = rigid.FreeBody(
        wheel,
        torque=rigid.Torque.body(Q([0.0, 0.0, 300.0], "N mm")),
        damping=Q(0.1, "N m / (rad/s)"),
        rotor=Q([0.0, 0.0, 1.0], "kg m²/s"),
    )
    other = rigid.FreeBody(
        wheel, torque=rigid.Torque.body([0.0, 0.0, 0.3]), damping=0.1, rotor=[0.0, 0.0, 1.0]
    )
    assert scene == other
    start = Q([0.0, 0.0, 30.0], "rpm")
    run = rigid.simulate(scene, start, t=Q([0.0, 0.1], "minute"), step=Q(5.0, "ms"), method="rk4")
    same = rigid.simulate(
        other, np.array([0.0, 0.0, 30.0]) * units.rpm, t=[0.0, 6.0], step=0.005, method="rk4"
    )
    assert np.allclose(run.omega, same.omega, rtol=1e-14)
    assert np.array_equal(run.t, same.t)


def test_a_start_and_a_map_in_degrees() -> None:
    start = rigid.Start(
        spin=Q(60.0, "rpm"),
        tilt=Q(5.0, "degree"),
        noise=rigid.normal(Q(0.1, "degree/s")),
    )
    assert start.spin is not None
    assert np.isclose(start.spin, 2.0 * np.pi, rtol=1e-15)
    assert np.isclose(start.tilt, np.radians(5.0), rtol=1e-15)
    assert np.isclose(start.noise.size, np.radians(0.1), rtol=1e-15)  # type: ignore[union-attr]
    assert np.isclose(rigid.normal(Q(1.0, "degree")).size, units.degree, rtol=1e-15)
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        axes={"spin": Q([30.0, 60.0], "rpm"), "I2/I1": [1.2, 1.4]},
        samples=2,
        t_end=Q(0.5, "minute"),
        stable=rigid.no_flip(),
        rng=1,
    )
    assert np.allclose(result.spec.axes[0].values, [np.pi, 2.0 * np.pi], rtol=1e-15)
    assert result.spec.t_end == 30.0
    assert np.isclose(rigid.tilt_below(Q(30.0, "degree")).angle, np.pi / 6.0, rtol=1e-15)


def test_steps_of_milliseconds_by_torques_of_millimetres() -> None:
    states = []
    for dt, torque in (
        (Q(5.0, "ms"), (0.1, Q(200.0, "N mm"), 0.3)),
        (0.005, (0.1, 0.2, 0.3)),
    ):
        motion = rigid.Motion(BODY, [1.0, 0.1, 0.0])
        motion.step(dt, torque)
        states.append([motion.t, *motion.omega])
    np.testing.assert_allclose(states[0], states[1], rtol=1e-14)


BODY = rigid.Body((1.0, 1.5, 2.0))
RATES = [1.0, 0.0, 0.0]


def moved(omega: Any = RATES, **options: Any) -> rigid.Run:
    return rigid.simulate(BODY, omega, **{"t": [1.0], **options})


def stepped(*how: Any) -> None:
    rigid.Motion(BODY, RATES).step(*how)


def axes(**given: Any) -> None:
    rigid.maps.axes.make_axes(given)


test_a_quantity_of_another_kind_is_refused = refuses(
    [
        (moved, Q(RATES, "m"), r"omega in meter: must be in rad/s or a unit of its kind"),
        (
            moved,
            Q(RATES, "kHz"),
            r"omega in kilohertz: a rate is in rad/s, rpm or degrees per second",
        ),
        (moved, [0.0, 0.0, Q(1.0, "kg")], r"omega in kilogram: must be in rad/s"),
        (partial(moved, t=Q([1.0], "rad")), r"t in radian: must be in s or"),
        (partial(moved, accuracy=Q(1.0, "m")), r"accuracy in meter: takes numbers without units"),
        (partial(rigid.Body.box, mass=Q(1.0, "m")), 1.0, 2.0, 3.0, r"mass in meter: must be in kg"),
        (rigid.Body.box, Q(1.0, "kg"), 2.0, 3.0, r"a in kilogram: must be in m or"),
        (
            rigid.normal,
            Q(1.0, "s"),
            r"size in second: must be in rad/s or rad or a unit of its kind",
        ),
        (stepped, Q(5.0, "percent"), r"dt in percent: must be in s or a unit of its kind"),
        (
            stepped,
            0.1,
            (0.1, Q(5.0, "percent"), 0.2),
            r"torque in percent: must be in N m or a unit of its kind",
        ),
        (partial(axes, spin=Q([1.0], "N")), r"axes\['spin'\] in newton: must be in rad/s"),
        (
            partial(axes, **{"I2/I1": Q([1.0], "kg")}),
            r"axes\['I2/I1'\] in kilogram: takes numbers without units",
        ),
    ],
    by=lambda call, *given: call(*given),
)


def test_no_unit_is_lost_in_silence() -> None:
    # Arguments that the table does not know refuse a unit instead of dropping it.
    with pytest.raises(ValueError, match="takes numbers without units"):
        rigid.exact.agm(Q(1.0, "m"), 2.0)
    nutation = {"a": 1.25, "b": 2.5}
    percent = {"alpha": Q(100.0, "percent"), "beta": Q(200.0, "percent")}
    one = rigid.top.u_of(1.0, **nutation, alpha=1.0, beta=2.0)
    assert rigid.top.u_of(1.0, **nutation, **percent) == one
    share = Q(1e-4, "percent")
    assert rigid.simulate(BODY, [1.0, 0.1, 0.0], t=[1.0], accuracy=share).spec["accuracy"] < 2e-6


def test_periods_of_an_asteroid_in_hours_and_a_damping_time_in_years() -> None:
    moments = (0.61, 0.965, 1.0)
    found = rigid.free.spin_state(
        moments, precession=Q(27.38, "hour"), rotation=Q(263.0, "hour"), mode="SAM"
    )
    same = rigid.free.spin_state(
        moments, precession=27.38 * 3600.0, rotation=263.0 * 3600.0, mode="SAM"
    )
    assert np.allclose(found.omega, same.omega, rtol=1e-13)
    of_quantities = rigid.free.damping_time(
        Q(0.5, "km"),
        Q(1.0, "turn/day"),
        density=Q(2.0, "g/cm³"),
        rigidity=Q(5.0, "GPa"),
        quality=100.0,
    )
    of_numbers = rigid.free.damping_time(
        500.0, 2.0 * np.pi / 86400.0, density=2000.0, rigidity=5e9, quality=100.0
    )
    assert np.isclose(of_quantities, of_numbers, rtol=1e-12)
    sink = rigid.free.sink_of_damping(moments, Q(1.0, "rpm"), Q(2.0, "hour"))
    same_sink = rigid.free.sink_of_damping(moments, units.rpm, 7200.0)
    assert np.allclose(sink.coefficient, same_sink.coefficient, rtol=1e-13)


WITHOUT = "must be a real number in {}, written without the unit"

test_a_text_with_a_unit_is_refused_with_the_number = refuses(
    [
        (
            lambda: rigid.Start(spin=1.0, tilt="35 deg"),  # type: ignore[arg-type]
            f"tilt = '35 deg': {WITHOUT.format('rad')}; 35 . rigid.units.degree is 0.610865238198",
        ),
        (
            lambda: rigid.Start(spin="5 rpm"),  # type: ignore[arg-type]
            f"spin = '5 rpm': {WITHOUT.format('rad/s')}; 5 . rigid.units.rpm is 0.523598775598",
        ),
        (lambda: rigid.Start(spin="5 deg"), f"spin = '5 deg': {WITHOUT.format('rad/s')}$"),  # type: ignore[arg-type]
        (
            lambda: rigid.Start(omega=("5 rpm", 0, 0)),  # type: ignore[arg-type]
            r"omega = \('5 rpm', 0, 0\): must be real numbers in rad/s, written without the unit; "
            r"5 \* rigid.units.rpm is",
        ),
        (lambda: rigid.Body.box("25 cm", 1.0, 1.0), f"a = '25 cm': {WITHOUT.format('m')}$"),
        (
            lambda: rigid.Body.box(1.0, 1.0, 1.0, mass="3"),
            "mass = '3': must be a real number in kg, not a text; leave out the quotation marks$",
        ),
        *(
            (
                lambda text=text: rigid.Body.box(1.0, 1.0, 1.0, mass=text),
                f"mass = '{text}': must be a real number in kg, {words}$",
            )
            for text, words in (
                ("heavy", "not a text"),
                ("1.2.3 kg", "not a text"),
                ("-.5e1", "not a text; leave out the quotation marks"),
                ("1. kg", "written without the unit"),
                ("3 rpm", "written without the unit"),
            )
        ),
        (
            lambda: rigid.section("omega1", value="3 rpm"),  # type: ignore[arg-type]
            r"written without the unit; 3 \* rigid.units.rpm is 0.314159265359",
        ),
    ],
    kind=TypeError,
)


def test_the_number_that_is_told_is_taken() -> None:
    """35 degrees and 5 revolutions a minute, as the two messages above write them."""
    start = rigid.Start(spin=5 * rigid.units.rpm, tilt=35 * rigid.units.degree)
    assert start.spin == pytest.approx(np.pi / 6.0, rel=1e-15)
    assert start.tilt == pytest.approx(np.pi * 35.0 / 180.0, rel=1e-15)


def test_a_large_box_of_nothing_has_other_units() -> None:
    """0.3 kg in 250 m x 80 m x 10 m have 1.5e-6 kg/m³; an asteroid and a unit mass are no fault."""
    with pytest.warns(UserWarning, match=r"a box of 1.5e-06 kg/m³ is lighter than any solid; leng"):
        rigid.Body.box(250.0, 80.0, 10.0, mass=0.3)
    with pytest.warns(UserWarning, match="lengths are in m"):
        rigid.Body.box(25.0, 8.0, 1.0, mass=0.3)  # in cm
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
        rigid.Body.box(505.0, 492.0, 457.0, mass=7.3e10)  # about Bennu
        rigid.Body.box(250.0, 80.0, 10.0)


LARGE = (10.0, 10.0, 10.0)


@pytest.mark.parametrize(
    ("sides", "mass", "light"),
    [
        ((5.0, 5.0, 5.0), 1.5, False),
        ((5.1, 1.0, 1.0), 0.5, True),
        (LARGE, 100.0, False),
        (LARGE, 99.0, True),
        (LARGE, 1.0, False),
    ],
)
def test_a_large_box_lighter_than_any_solid_has_other_units(
    sides: tuple[float, float, float], mass: float, light: bool
) -> None:
    """Above 5 m and below 0.1 kg/m³; a mass of 1 stands for any."""
    warns = pytest.warns(UserWarning, match="is lighter than any solid") if light else nullcontext()
    with warns:
        rigid.Body.box(*sides, mass=mass)
