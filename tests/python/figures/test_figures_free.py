"""The numbers under the figures of free motions and of drift, and that the figures show them."""

import re
from typing import Any

import numpy as np
import pytest

import rigid
from figure_cases import (
    ASYMMETRIC,
    BODY,
    DAMPED,
    TILTED,
    TOP,
    artist,
    artists,
    data_of,
    drawn,
    joined,
    omega_of,
    poinsot_run,
    texts,
)
from physics import golden_number
from refusals import refuses
from rigid import figures, free
from rigid.drawing import colours


@pytest.mark.parametrize("frame", [0, 333, -1])
def test_the_ellipsoid_touches_the_plane_in_the_contact(frame: int) -> None:
    run = poinsot_run()
    data = figures.poinsot(run, frame=frame)
    assert data.t == run.t[frame]
    with pytest.raises(AttributeError, match="t: the data of a figure do not change"):
        data.t = 0.0
    assert re.fullmatch(r"Picture\((\w+, )*contact(, \w+)*\)", repr(data))
    assert data.contact[2] == pytest.approx(data.distance, rel=1e-14)
    np.testing.assert_allclose(data.herpolhode[:, 2], data.distance, rtol=1e-13)
    # The highest point of the ellipsoid is in the plane and is the contact: it is tangent there.
    reach = data.semi_axes * data.axes[:, 2]
    assert np.linalg.norm(reach) == pytest.approx(data.distance, rel=1e-13)
    highest = (data.semi_axes * reach / np.linalg.norm(reach)) @ data.axes
    np.testing.assert_allclose(highest, data.contact, atol=1e-13)
    np.testing.assert_allclose(data.axes @ data.axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(data.axes) == pytest.approx(1.0)
    # The polhode lies on the inertia ellipsoid and on that of L².
    own = data.polhode @ data.axes.T
    moments = np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(own, run.omega, atol=1e-13)
    np.testing.assert_allclose(((own / data.semi_axes) ** 2).sum(axis=1), 1.0, rtol=1e-13)
    square = ((moments * own) ** 2).sum(axis=1)
    np.testing.assert_allclose(square, square[0], rtol=1e-13)
    np.testing.assert_allclose(data.polhode[frame], data.contact, atol=1e-15)
    np.testing.assert_allclose(data.herpolhode[frame], data.contact, atol=1e-15)


def test_the_picture_of_poinsot_carries_its_curves() -> None:
    data = figures.poinsot(poinsot_run(401), frame=100)
    ax = drawn(data)
    np.testing.assert_array_equal(joined(ax, "polhode"), [data.polhode])
    np.testing.assert_array_equal(data_of(artist(ax, "herpolhode")), data.herpolhode[:101])
    np.testing.assert_array_equal(data_of(artist(ax, "contact")), data.contact[np.newaxis])
    np.testing.assert_array_equal(artist(ax, "omega").vector, data.contact)
    # L is solid from where it leaves the ellipsoid.
    np.testing.assert_allclose(artist(ax, "momentum").vector[:2], 0.0)
    leaves = data.axes @ artist(ax, "momentum").start
    assert np.sum((leaves / data.semi_axes) ** 2) == pytest.approx(1.0, rel=1e-14)
    assert "invariable plane" in [text.strip() for text in texts(ax)]
    assert colours.L.label in texts(ax)
    assert colours.OMEGA.label in texts(ax)


ORDERS = [(1.0, 2.0, 3.0), (3.0, 1.2, 2.5), (2.0, 2.5, 0.9), (0.0109, 0.1044, 0.1148)]


@pytest.mark.parametrize("moments", ORDERS)
def test_polhodes_have_one_energy_and_each_its_momentum(moments: Any) -> None:
    data = figures.polhodes(moments, count=4, samples=181)
    own = np.array(moments)
    energy = (own * data.curves**2).sum(axis=-1)
    np.testing.assert_allclose(energy, own.min(), rtol=1e-13)
    momentum = ((own * data.curves) ** 2).sum(axis=-1)
    np.testing.assert_allclose(momentum, momentum[:, :1] + 0.0 * momentum, rtol=1e-12)
    np.testing.assert_allclose(data.curves[:, 0], data.curves[:, -1], atol=1e-14)
    # On each side of the separatrix L² = 2 E I2, about the axis it says, which keeps its sign.
    middle = np.sort(own)[1]
    about_least = np.abs(data.axis) == own.argmin() + 1
    np.testing.assert_array_equal(momentum[:, 0] < energy[:, 0] * middle, about_least)
    for curve, axis in zip(data.curves, data.axis, strict=True):
        assert (np.sign(curve[:, abs(axis) - 1]) == np.sign(axis)).all()
    counts = np.unique(data.axis, return_counts=True)[1]
    np.testing.assert_array_equal(counts, 4)
    on_border = ((own * data.separatrix) ** 2).sum(axis=-1)
    np.testing.assert_allclose(on_border, own.min() * middle, rtol=1e-13)
    np.testing.assert_allclose((own * data.separatrix**2).sum(axis=-1), own.min(), rtol=1e-13)


def test_the_polhode_of_a_run_lies_on_the_ellipsoid_of_the_family() -> None:
    body = rigid.Body((1.0, 2.0, 3.0))
    run = rigid.simulate(body, [0.1, 5.0, 0.2], t=np.linspace(0.0, 9.0, 91), record="rates")
    data: Any = figures.polhodes(run)
    moments = np.array(body.moments)
    assert np.allclose((data.path**2 * moments).sum(axis=1), 1.0, rtol=1e-13)
    assert np.allclose(data.path / run.omega, data.path[0, 0] / run.omega[0, 0], rtol=1e-12)
    assert artist(drawn(data), "path").get_color() == colours.OMEGA.colour
    assert figures.polhodes(body).path is None


test_runs_without_a_polhode_are_refused = refuses(
    [
        (rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)), damping=0.1), [0, 1, 0], "without damping"),
        (rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))), [0, 0, 0], "at rest has no polhode"),
        (rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0))), np.eye(3), "the run has 3 bodies"),
    ],
    by=lambda scene, omega: figures.polhodes(rigid.simulate(scene, omega, t=[0.0, 1.0])),
)


def test_the_picture_of_polhodes_carries_the_family() -> None:
    data = figures.polhodes((1.0, 2.0, 3.0), count=3)
    ax = drawn(data)
    np.testing.assert_array_equal(joined(ax, "curves"), data.curves)
    for line, axis in zip(artists(ax, "curves"), data.axis, strict=True):
        assert line.get_color() == colours.AXES[abs(axis) - 1].colour
    np.testing.assert_array_equal(joined(ax, "separatrix"), data.separatrix)
    words = texts(ax)
    assert words == ["1: least moment", "2: middle moment", "3: largest moment"]
    figures.polhodes(rigid.Body((3.0, 1.2, 2.5)))


def test_the_picture_of_the_throw_carries_the_experiment() -> None:
    thrown = free.throw_experiment(rigid.Body.box(0.01, 0.08, 0.25), [0.05, 0.05, 0.05])
    axes = drawn(figures.throw(thrown))
    for k in range(6):
        for axis, line in enumerate(artists(axes[k], "omega")):
            np.testing.assert_array_equal(data_of(line)[:, 0], thrown.t)
            np.testing.assert_array_equal(data_of(line)[:, 1], thrown.omega[k, :, axis])
            assert line.get_color() == colours.AXES[axis].colour
        dots = np.stack([np.arange(31.0), thrown.dots[k]], axis=1)
        np.testing.assert_array_equal(data_of(artist(axes[k], "dots")), dots)
        assert dots[:, 1].min() >= 0.0  # never below zero (erratum S-14)
    # Clean runs stand still, and their dots are 0, the growth rate about the middle axis, 0.
    np.testing.assert_array_equal(np.ptp(thrown.omega[:3], axis=1), 0.0)
    np.testing.assert_allclose(thrown.dots[:3].T, [[0.0, 0.888352678, 0.0]] * 31, atol=1e-9)
    # On the lasting motions with noise most dots are positive too (erratum S-15).
    assert (thrown.dots[[3, 5]] > 1e-3).mean() > 0.5
    seen = data_of(artists(axes[4], "omega")[1])[-1]
    np.testing.assert_allclose(seen, [30.0, golden_number("box.run_y.w(30)")[1]], rtol=1e-12)
    titles = [ax.get_title(loc="left") for ax in axes]
    assert titles[0] == "exactly about axis 1"
    assert titles[5] == "with noise about axis 3"
    assert axes[3].get_xlabel() == "$t$ (s)"
    assert axes[0].get_ylabel() == r"$\omega$ (rad/s), growth rate (1/s)"
    (key,) = axes[0].figure.legends
    names = [text.get_text() for text in key.get_texts()]
    assert names[:3] == [r"$\omega_1$", r"$\omega_2$", r"$\omega_3$"]
    assert names[3].startswith("growth rate")
    # Colour is not needed to tell the components apart.
    assert len({str(line.get_linestyle()) for line in artists(axes[4], "omega")}) == 3


def test_the_largest_drift_is_that_of_the_run() -> None:
    free_run = rigid.simulate(
        BODY, [1.0, 1.0, 1.0], t=np.linspace(0.0, 50.0, 101), method="rk4", step=0.05
    )
    data = figures.invariants(free_run)
    assert data.names == ("energy", "L", "L_space")
    assert data.drift[0].max() == pytest.approx(float(free_run.energy_drift), rel=1e-6)
    assert data.drift[1].max() == pytest.approx(float(free_run.momentum_drift), rel=1e-6)
    assert (data.drift[2] >= data.drift[1] * (1.0 - 1e-6)).all()  # a vector and its size
    # Without the attitude, the vertical of which has an error of its own.
    top_run = rigid.simulate(
        TOP,
        omega_of("cusp"),
        TILTED,
        t=np.linspace(0.0, 50.0, 101),
        method="rk4",
        step=0.02,
        record="axis",
    )
    data = figures.invariants(top_run)
    assert data.names == ("energy", "p_phi", "p_psi")
    assert data.drift[0].max() == pytest.approx(float(top_run.energy_drift), rel=1e-6)
    assert data.drift[1].max() == pytest.approx(float(top_run.momentum_drift), rel=1e-6)
    assert data.drift[2].max() == 0.0  # I3 omega3 of equal moments is no sum
    np.testing.assert_array_equal(data.drift[:, 0], 0.0)


def test_what_is_kept_depends_on_the_scene() -> None:
    t = np.linspace(0.0, 10.0, 51)
    general = rigid.simulate(ASYMMETRIC, [0.2, 0.1, 5.0], TILTED, t=t)
    assert figures.invariants(general).names == ("energy", "p_phi")
    rates = rigid.simulate(BODY, [1.0, 1.0, 1.0], t=t, record="rates")
    assert figures.invariants(rates).names == ("energy", "L")
    driven = rigid.simulate(DAMPED, [0.1, 0.1, 5.0], TILTED, t=t, method="dop853", step=0.01)
    data = figures.invariants(driven)
    assert data.names == ("energy less work",)
    assert data.drift.max() < 1e-10  # the energy itself falls by more than a tenth
    kept = free.invariants(driven).energy
    assert np.ptp(kept) > 0.1 * kept[0]


def test_the_picture_of_drift_carries_it() -> None:
    run = rigid.simulate(
        BODY, [1.0, 1.0, 1.0], t=np.linspace(0.0, 50.0, 101), method="splitting4", step=0.05
    )
    data = figures.invariants(run)
    ax = drawn(data)
    floor = 0.02 * np.finfo(float).eps
    for line, values in zip(artists(ax, "drift"), data.drift, strict=True):
        np.testing.assert_array_equal(data_of(line)[:, 0], run.t)
        np.testing.assert_array_equal(data_of(line)[:, 1], np.maximum(values, floor))
    assert ax.get_yscale() == "log"
    assert ax.get_xlabel() == "$t$ (s)"
    assert ax.get_ylabel() == "relative drift"
    assert data.drift[1:].max() < 1e-13  # the method keeps L, in space too
    assert data.drift[0].max() > 1e-10
