"""Questions about satellites in the frame of their orbit: pointing, libration, ratios, axes."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from planar_moons import MOMENTS, Floats, beginning_so, planar
from refusals import refuses
from rigid.model.criterion import Criterion
from rigid.model.measures import Measure
from rigid.rotations import quaternion_to_matrix
from small_maps import small_map


def in_plane(
    starts: list[tuple[float, float]], e: float, *, anomaly: float = 0.0, **options: Any
) -> rigid.StabilityMap:
    """One pixel with these angles and rates of axis 1 in the plane of the orbit."""
    scene = rigid.FreeBody(rigid.Body(MOMENTS), orbit=rigid.Orbit(1.0, e, anomaly))
    chosen: dict[str, Any] = {
        "axes": {"t_end": [40.0]},
        "start": beginning_so(starts),
        "stable": rigid.librates(),
        "samples": len(starts),
        "method": "auto",
    }
    return small_map(scene, **{**chosen, **options})


PLANAR = [
    (0.0, 1.1),
    (0.3, 1.3),
    (0.0, 1.6),
    (math.pi, 1.55),
    (-0.4, 0.7),
    (0.0, 2.2),
    (1.2, 0.9),
    (1.0, 1.4),
    (1.3, 1.3),
    (1.4, 1.8),
]


@pytest.mark.parametrize("e", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("method", ["auto", "rk4", "dop853"])
def test_librations_in_the_plane_are_those_of_their_equation(e: float, method: str) -> None:
    amplitudes = rigid.libration_amplitude()
    result = in_plane(PLANAR, e, anomaly=0.7, method=method, measure=[amplitudes])
    found = result.outcomes(range(len(PLANAR)))
    classes = []
    for k, (theta, rate) in enumerate(PLANAR):
        t, _, libration = planar(theta, rate, e, 40.0, anomaly=0.7)
        # The end that faces the planet, or away from it, at the start.
        facing = np.cos(libration) * np.sign(np.cos(libration[0]))
        swing = np.unwrap(libration)
        swing -= math.pi * round(swing[0] / math.pi)
        largest = min(float(np.abs(swing).max()), math.pi)
        stays = bool((facing > 0.0).all())
        classes.append(stays)
        assert found.outcome[0, k] == ("stable" if stays else "unstable")
        value = found.measures["libration_amplitude(1)"][0, k]
        # Times 1e-3 s apart miss 1e-7 of an extremum. Near pi an angle has half of its digits. The
        # default steps and those of "rk4" err by 1e-8 and 1e-7 for each of the 40 rad, which the
        # separatrix magnifies.
        exact = {"dop853": 1e-7, "auto": 4e-6, "rk4": 4e-5}[method]
        assert value == pytest.approx(largest, abs=exact if largest < 3.0 else 1e-3)
        if not stays:
            first = int(np.argmax(facing <= 0.0))
            share = facing[first - 1] / (facing[first - 1] - facing[first])
            left = t[first - 1] + share * (t[first] - t[first - 1])
            # A straight line between these times is off by 1e-7 s.
            assert found.left[0, k] == pytest.approx(left, abs=1e-6)
    assert not all(classes)
    assert any(classes) or e == 0.3


INCLINED = rigid.FreeBody(
    rigid.Body((1.0, 1.25, 1.5)),
    orbit=rigid.Orbit(0.7, 0.3, 1.1, normal=(0.0, 0.6, 0.8), periapsis=(0.0, -0.8, 0.6)),
)
OPTIONS: dict[str, Any] = {
    "axes": {"t_end": [8.0]},
    "start": rigid.Start(
        omega=(0.1, -0.2, 0.5), attitude_noise=rigid.uniform_attitude(), noise=rigid.normal(0.2)
    ),
    "method": "auto",
}
FINE = np.linspace(0.0, 8.0, 4001)


@cache
def fine_motion() -> tuple[Floats, Floats]:
    """Matrices of 24 bodies at these times, and the frames of the orbit."""
    starts = small_map(INCLINED, stable=rigid.no_flip(3), samples=24, **OPTIONS).starts(range(24))
    run: Any = rigid.simulate(
        INCLINED, starts.omega[0], starts.attitude[0], t=FINE, method="taylor20", check=False
    )
    orbit: Any = INCLINED.orbit
    return quaternion_to_matrix(run.attitude), orbit.frame(FINE)


@pytest.mark.parametrize("of", ["radial", "along", "normal"])
@pytest.mark.parametrize("axis", [1, -2, 3])
@pytest.mark.parametrize("either", [False, True])
def test_pointing_is_that_of_a_fine_motion(of: str, axis: int, either: bool) -> None:
    """Angles from the frame of the orbit at 4001 times, on an orbit inclined in space.

    The limit lies between the largest angles of two bodies, so that half of the bodies leave it.
    """
    matrices, frames = fine_motion()
    column = ("radial", "along", "normal").index(of)
    cosine = np.sign(axis) * np.sum(matrices[..., abs(axis) - 1] * frames[..., column], axis=-1)
    if either:
        cosine *= np.sign(cosine[:, :1])
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    low, high = np.sort(angle.max(axis=1))[11:13]
    limit = float(0.5 * (low + high))
    assert high - low > 1e-5  # the sampling of the fine motion misses less of its largest angle
    stable = rigid.pointing_within(limit, axis, of, either=either)
    result = small_map(INCLINED, stable=stable, samples=24, **OPTIONS)
    outcomes = result.outcomes(range(24))
    for k in range(24):
        left = np.flatnonzero(angle[k] > limit)
        assert outcomes.outcome[0, k] == ("unstable" if len(left) else "stable")
        if len(left):
            begin, end = FINE[max(left[0] - 1, 0)], FINE[left[0]]
            assert begin - 1e-9 <= outcomes.left[0, k] <= end + 1e-9
    assert result.stable[0] == 12


ORBIT = rigid.Orbit(0.7, 0.2, 1.1, normal=(0.0, 0.6, 0.8))


@pytest.mark.parametrize("method", ["auto", "rk4", "dop853"])
def test_the_vertical_of_a_satellite_is_the_normal_of_its_orbit(method: str) -> None:
    """The same satellite with another normal: one motion, seen from other axes."""
    shares = []
    for turn in (Rotation.identity(), Rotation.from_rotvec([0.3, -1.2, 0.8])):
        normal, periapsis = turn.apply([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
        orbit = rigid.Orbit(1.0, 0.2, normal=normal, periapsis=periapsis)
        result = small_map(
            rigid.FreeBody(rigid.Body(MOMENTS), orbit=orbit),
            axes={"t_end": [15.0]},
            start=rigid.Start(omega=(0.0, 0.0, 1.0), attitude=turn, noise=rigid.normal(0.1)),
            stable=rigid.tilt_below(0.2, axis=3, reference="vertical"),
            measure=[rigid.largest_tilt(axis=3, reference="vertical"), rigid.obliquity()],
            samples=40,
            method=method,
        )
        values = result.outcomes(range(40)).measures
        # Both tell the same angle; 4 sin²(a/2) and sin² of it are exact to some roundings.
        np.testing.assert_allclose(values["obliquity(3)"], values["largest_tilt(3)"], atol=1e-7)
        shares.append(result.share[0])
    assert 0.0 < shares[0] < 1.0
    assert shares[0] == shares[1]


def test_a_rotation_locked_to_the_orbit_turns_once_in_it() -> None:
    """Of librations the mean rate is that of the orbit, of fast rotations their rate.

    The angle turned until t is ``n t`` and a libration of at most pi/2 more.
    """
    period = 2.0 * math.pi
    result = in_plane(
        [(0.0, 1.05), (0.0, 8.0)],
        0.05,
        axes={"t_end": [30.0 * period]},
        measure=rigid.spin_orbit_ratio(),
    )
    locked, fast = result.outcomes(range(2)).measures["spin_orbit_ratio(3)"][0]
    assert locked == pytest.approx(1.0, abs=0.5 * math.pi / (30.0 * period))
    # The mean over the libration of a fast rotation: the energy changes by 1.5 (I2 - I1) at most.
    assert fast == pytest.approx(8.0, abs=0.05)
    scene = rigid.FreeBody(rigid.Body(MOMENTS), orbit=rigid.Orbit(0.5, 0.05))
    slow = small_map(
        scene,
        axes={"t_end": [60.0]},
        start=rigid.Start(omega=(0.0, 0.0, 2.0)),
        stable=rigid.no_flip(3),
        measure=[rigid.spin_orbit_ratio(), rigid.mean_rate(3)],
        samples=1,
        method="auto",
    )
    values = slow.outcomes(0).measures
    assert values["spin_orbit_ratio(3)"][0] == values["mean_rate(3)"][0] / 0.5


def test_eccentricity_and_anomaly_are_axes_of_a_map() -> None:
    axes = {"eccentricity": [0.0, 0.1, 0.3], "anomaly": [0.0, 1.5, 3.0]}
    orbit = rigid.Orbit(1.0, 0.2, normal=(0.0, 0.6, 0.8), periapsis=(1.0, 0.0, 0.0))
    scene = rigid.FreeBody(rigid.Body(MOMENTS), orbit=orbit)
    options: dict[str, Any] = {
        "start": rigid.Start(omega=(0.1, 0.6, 0.9), noise=rigid.normal(0.1)),
        "stable": rigid.pointing_within(1.2, of="normal", axis=3),
        "samples": 20,
        "t_end": 15.0,
        "method": "auto",
    }
    result = small_map(scene, axes=axes, **options)
    seen = set()
    for y, x in np.ndindex(3, 3):
        e, anomaly = axes["eccentricity"][x], axes["anomaly"][y]
        found: Any = result.spec.grid.scene[3 * y + x].orbit
        expected = rigid.Orbit(1.0, e, anomaly, orbit.normal, orbit.periapsis)
        np.testing.assert_allclose(found.numbers, expected.numbers, atol=4e-16)
        alone = small_map(
            rigid.FreeBody(scene.body, orbit=expected),
            axes={"omega1": 0.1 + np.arange(9.0) - (3 * y + x)},
            **options,
        )
        assert alone.stable[3 * y + x] == result.stable[y, x]
        seen.add(int(result.stable[y, x]))
        body = result.replay((y, x), 3)
        assert body.outcome == result.outcomes(3).outcome[y, x]
        assert body.run.spec["scene"]["orbit"] == found.to_dict()
    assert len(seen) > 3
    with pytest.raises(ValueError, match="'eccentricity' does not apply: the scene has no orbit"):
        small_map(axes={"eccentricity": [0.1]})
    with pytest.raises(ValueError, match=r"\[1\] = 1: must lie in \[0, 0\.95\] or \[1\.05, "):
        small_map(scene, axes={"eccentricity": [0.1, 1.0]})


test_questions_that_have_no_frame = refuses(
    [
        (lambda: rigid.pointing_within(0.0), r"angle = 0\.0: must be positive"),
        (lambda: rigid.pointing_within(1.0, of="up"), "of = 'up': must be one of"),
        (lambda: rigid.pointing_within(1.0, axis=4), "axis = 4: must be one of"),
        (lambda: rigid.pointing_within(1.0, either=1), TypeError, "either = 1: must be True or"),  # type: ignore[arg-type]
        (lambda: small_map(stable=rigid.librates()), r"pointing_within\(\) measures in the frame"),
        (
            lambda: small_map(measure=rigid.obliquity()),
            r"obliquity\(\) measures in the frame of an",
        ),
    ],
)


def test_a_default_axis_is_that_of_the_bodies_of_all_pixels() -> None:
    # The scene alone has its least moment about axis 3; every pixel has it about axis 1.
    scene = rigid.FreeBody(rigid.Body((2.0, 1.4, 1.0)), orbit=rigid.Orbit(1.0, 0.1))
    asked: dict[str, Any] = {
        "start": rigid.Start(omega=(0.01, 0.02, 1.0)), "samples": 1, "t_end": 3.0, "rng": 1,
        "progress": False, "stable": rigid.librates(), "measure": rigid.obliquity(),
    }  # fmt: skip
    shapes = rigid.stability_map(scene, axes={"a/b": [1.2, 1.3], "b/c": [1.1]}, **asked)
    assert "axis 1 within" in str(shapes.spec.stable)
    assert shapes.spec.measure[0].axis == 3
    with pytest.raises(ValueError, match="axis: is needed, because the long axis of the bodies"):
        rigid.stability_map(scene, axes={"I3": [1.0, 1.9]}, **asked)

    def long_or_short(k: Floats) -> rigid.FreeBody:
        moments = np.stack([1.4 * k, np.full_like(k, 1.4), np.full_like(k, 2.0)], axis=-1)
        return rigid.FreeBody(rigid.Body(moments), orbit=rigid.Orbit(1.0))

    # However little the moments differ, one axis is long and the other is not.
    for order in ([0.8, 1.2], [1.2, 0.8], [1.0 - 1e-9, 1.0 + 1e-9]):
        with pytest.raises(ValueError, match="axis: is needed"):
            rigid.stability_map(long_or_short, axes={"k": order}, **asked)


# Maps on an orbit alone, in steps of its eccentric anomaly, against short steps in the time.


SOLID = (0.9, 1.2, 1.4)
COUNT = 32

#: Limits that some bodies pass.
LEFT: dict[str, Criterion] = {
    "no flip": rigid.no_flip(3),
    "tilt": rigid.tilt_below(0.6, axis=3, reference="vertical"),
    "pointing": rigid.pointing_within(1.0, 1, "radial", either=True),
    "along": rigid.pointing_within(1.3, 2, "along", either=True),
    "libration": rigid.librates(1),
    "spin": rigid.spin_above(0.4, axis=3),
    "speed": rigid.spin_above(0.5),
    "rates in the body": rigid.rate_within(0.8, frame="body"),
    "rates in space": rigid.rate_within(0.9),
    "momentum": rigid.rate_within(0.6, of="L"),
    "start": rigid.near_start(1.5),
    "return": rigid.returns(1.0, 10.0),
}


#: A damping that is lost in every sum needs all variables, and steps in the time.
IN_TIME: dict[str, Any] = {"damping": 1e-300, "method": "dop853", "step": 0.02}


def mapped(
    e: float, stable: Criterion, method: str, damping: Any = None, **options: Any
) -> rigid.StabilityMap:
    scene = rigid.FreeBody(
        rigid.Body(SOLID), orbit=rigid.Orbit(0.7, e, 1.1, normal=(0.0, 0.6, 0.8)), damping=damping
    )
    chosen: dict[str, Any] = {
        "axes": {"t_end": [30.0]},
        "start": rigid.Start(
            omega=(0.1, 0.2, 0.8), noise=rigid.normal(0.3), attitude_noise=rigid.uniform_attitude()
        ),
        "samples": COUNT,
        "check": 0.0,
    }
    return small_map(scene, stable=stable, method=method, **{**chosen, **options})


@pytest.mark.parametrize("e", [0.0, 0.3])
@pytest.mark.parametrize("name", LEFT)
def test_bodies_leave_when_they_do_in_the_time(name: str, e: float) -> None:
    exact = mapped(e, LEFT[name], **IN_TIME).outcomes(range(COUNT))
    assert (exact.outcome[0] == "unstable").sum() > COUNT / 6
    for method in ("auto", "dop853"):
        found = mapped(e, LEFT[name], method).outcomes(range(COUNT))
        np.testing.assert_array_equal(found.outcome, exact.outcome)
        # Default steps err by 1e-8 rad for each rad, by default; tumbling magnifies that.
        allowed = 1e-4 if method == "auto" else 1e-8
        np.testing.assert_allclose(found.left, exact.left, rtol=0.0, atol=allowed)


def test_a_chosen_dop853_is_checked_by_half_its_steps() -> None:
    """Each run of a body takes whole blocks of 16 steps."""
    first, both = (
        int(mapped(0.3, LEFT["libration"], "dop853", check=check).columns["steps"].sum())
        for check in (0.0, 1.0)
    )
    assert 2 * first - COUNT * 2 * 16 < both - first <= 2 * first


@pytest.mark.parametrize("e", [0.0, 0.3])
@pytest.mark.parametrize(
    "measure",
    [
        rigid.mean_rate(axis=2),
        rigid.spin_orbit_ratio(axis=3),
        rigid.obliquity(axis=3),
        rigid.libration_amplitude(axis=1),
        rigid.largest_tilt(axis=3, reference="vertical"),
        rigid.flips(axis=3),
    ],
    ids=str,
)
def test_measures_are_those_in_the_time(measure: Measure, e: float) -> None:
    options: dict[str, Any] = {"measure": [measure], "axes": {"t_end": [12.0]}}
    exact = mapped(e, rigid.no_flip(3), **IN_TIME, **options).outcomes(range(COUNT))
    found = mapped(e, rigid.no_flip(3), "dop853", **options).outcomes(range(COUNT))
    (one,), (same,) = exact.measures.values(), found.measures.values()
    # An angle near pi has half of its digits.
    far = np.abs(np.asarray(one) - np.pi) > 1e-3
    np.testing.assert_allclose(np.asarray(same)[far], np.asarray(one)[far], rtol=1e-7, atol=1e-7)


def test_a_body_that_becomes_faster_than_its_bound_begins_again() -> None:
    """Slow bodies at the apoapsis of a flat orbit: the periapsis spins some of them up."""
    scene = rigid.FreeBody(rigid.Body((0.4, 0.9, 1.0)), orbit=rigid.Orbit(1.0, 0.9, 3.0))
    result = small_map(
        scene,
        axes={"t_end": [60.0]},
        start=rigid.Start(omega=(0.0, 0.0, 0.0), attitude_noise=rigid.uniform_attitude()),
        stable=rigid.no_flip(1),
        measure=[rigid.mean_rate(axis=3)],
        samples=64,
        check=0.0,
        method="auto",
    )
    assert not result.failed.any()
    # The length of the quaternion of a body whose steps are too long shrinks.
    assert (result.unit_drift < 1e-5).all()


def test_drifts_are_those_of_the_jacobi_integral() -> None:
    circle, ellipse = (mapped(e, rigid.no_flip(3), "auto") for e in (0.0, 0.3))
    assert (circle.energy_drift < 1e-5).all()
    assert (circle.energy_drift > 0.0).all()
    assert np.isnan(ellipse.energy_drift).all()
    assert np.isnan(circle.momentum_drift).all()
