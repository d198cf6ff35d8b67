"""The numbers under the figures of heavy tops, and that the figures show them."""

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import rigid
from figure_cases import (
    ASYMMETRIC,
    BODY,
    DAMPED,
    SIN60,
    STARTS,
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
from processes import python_process
from refusals import refuses
from rigid import figures, top


def wrong(value: Any) -> Any:
    """What no type checker would let through."""
    return value


# The effective potential


@pytest.mark.parametrize("name", STARTS)
def test_the_well_is_as_high_as_the_energy_at_the_circles(name: str) -> None:
    data = figures.effective_potential(TOP, omega_of(name), TILTED)
    _, _, u1, u2, _ = STARTS[name]
    assert np.cos(data.theta_lower) == pytest.approx(u1, abs=2e-11)
    assert np.cos(data.theta_upper) == pytest.approx(u2, abs=2e-11)
    circles = np.interp([data.theta_upper, data.theta_lower], data.tilt, data.potential)
    np.testing.assert_allclose(circles, data.E_prime, rtol=2e-2)  # of the polygon
    # E', not E, is the level (erratum D-40): the energy of the spin is no part of it.
    constants = top.heavy_constants(TOP, omega_of(name), TILTED)
    assert data.E_prime == pytest.approx(float(constants.energy) - 0.25 * STARTS[name][1] ** 2)
    assert data.lowest <= data.potential.min()
    assert data.theta_upper < data.theta_steady < data.theta_lower


def test_the_path_moves_in_the_well() -> None:
    # E' - V'(theta) = ½ I1 theta'² along the motion; theta' from the rates across the axis.
    omega = omega_of("loop")
    data = figures.effective_potential(TOP, omega, TILTED, samples=20001)
    run: Any = rigid.simulate(TOP, omega, TILTED, t=np.linspace(0.0, 6.0, 400), record="axis")
    u_rate = np.cross(run.gamma, run.omega)[:, 2]
    sine = np.hypot(run.gamma[:, 0], run.gamma[:, 1])
    tilt = np.arctan2(sine, run.gamma[:, 2])
    well = np.interp(tilt, data.tilt, data.potential)
    np.testing.assert_allclose(data.E_prime - well, 0.5 * (u_rate / sine) ** 2, atol=1e-6)


def keys(legend: Any) -> list[str]:
    """The words of a legend."""
    return [text.get_text() for text in legend.get_texts()]


def test_the_picture_of_the_well_carries_its_numbers() -> None:
    data = figures.effective_potential(TOP, omega_of("cusp"), TILTED)
    ax = drawn(data)
    well = np.stack([np.degrees(data.tilt), data.potential], axis=1)
    np.testing.assert_array_equal(data_of(artist(ax, "potential")), well)
    ends = np.degrees([data.theta_upper, data.theta_lower])
    # Let go at 60 degrees: sin² x = a (cos 60° - cos x) with a = (I3 w3)²/(2 I1 mgl).
    a = 0.5 * (0.5 * omega_of("cusp")[2]) ** 2
    lowest = 0.5 * (a - np.sqrt(a * a - 2.0 * a + 4.0))
    np.testing.assert_allclose(ends, [60.0, np.degrees(np.arccos(lowest))], rtol=1e-12)
    for line in (artist(ax, "E_prime"), artist(ax, "turning")):
        np.testing.assert_array_equal(data_of(line), np.stack([ends, [data.E_prime] * 2], axis=1))
    assert ax.get_xlabel() == r"tilt $\theta$ (°)"
    assert ax.get_ylabel() == "energy (J)"
    assert {"$E'$", r"$V'(\theta)$", r"$\theta_\mathrm{m}$"} < set(texts(ax))
    low, high = ax.get_ylim()
    assert low < data.lowest < data.E_prime < high
    # The well fills the half of the width, and a key says which circle is high.
    well = np.degrees(data.tilt[data.potential <= high])
    left, right = ax.get_xlim()
    assert np.ptp(well) == pytest.approx(0.5 * (right - left), rel=1e-9)
    assert keys(ax.get_legend())[0].startswith(r"highest ($\theta_\mathrm{upper}$)")


def test_a_steady_top_lies_at_the_bottom_of_the_well() -> None:
    slow = float(top.steady_precession(TOP, np.pi / 3, 5.0).slow)
    data = figures.effective_potential(TOP, [0.0, slow * SIN60, 5.0], TILTED)
    ax = drawn(data)
    assert data.E_prime == pytest.approx(data.lowest, rel=1e-14)
    assert data.theta_steady == pytest.approx(np.pi / 3, rel=1e-9)
    assert r"$\theta_\mathrm{upper}$" not in texts(ax)


# The cubic


@pytest.mark.parametrize("name", STARTS)
def test_roots_of_the_cubic(name: str) -> None:
    data = figures.cubic(TOP, omega_of(name), TILTED)
    np.testing.assert_allclose(data.roots, STARTS[name][2:], rtol=1e-11, atol=1e-12)
    assert (data.f_allowed >= -1e-13).all()
    outside = (data.near < data.roots[0]) | (data.near > data.roots[1])
    assert (data.f_near[outside] < 0.0).all()
    known: Any = top.heavy_constants(TOP, omega_of(name), TILTED)
    assert data.still == pytest.approx(float(known.a / known.b))
    # f is lowest where it has to be: f(±1) = -(a ∓ b)².
    ends = np.interp([1.0, -1.0], data.u, data.f)
    expected = [-((known.a - known.b) ** 2), -((known.a + known.b) ** 2)]
    np.testing.assert_allclose(ends, expected, atol=2e-3 * np.abs(data.f).max())


def test_the_picture_of_the_cubic_carries_its_numbers() -> None:
    data = figures.cubic(TOP, omega_of("loop"), TILTED)
    ax = drawn(data)
    np.testing.assert_array_equal(data_of(artist(ax, "f")), np.stack([data.u, data.f], axis=1))
    allowed = np.stack([data.allowed, data.f_allowed], axis=1)
    np.testing.assert_array_equal(data_of(artist(ax, "allowed")), allowed)
    np.testing.assert_array_equal(data_of(artists(ax, "roots")[0])[:, 0], data.roots)
    (close,) = ax.child_axes
    assert artist(close, "still").get_xdata()[0] == data.still
    assert ax.get_xlabel() == r"height $u = \cos\theta$"
    assert ax.get_ylabel() == r"$f(u) = \dot u^2$ (1/s²)"
    assert "$u_3$" in texts(ax)
    assert {"$u_1$", "$u_2$", "$a/b$"} <= set(texts(close))
    defined = " ".join(keys(ax.get_legend()))
    assert all(name in defined for name in ("$u_3$", r"$a = p_\phi/I_1$", r"$b = p_\psi/I_1$"))
    # The wide interval of the fourth kind needs no closer look, and its u3 is out of sight.
    wide = figures.cubic(TOP, omega_of("monotone retrograde"), TILTED).plot()
    assert not wide.child_axes
    assert len(data_of(artist(wide, "roots"))) == 2
    assert {"$u_1$", "$u_2$"} <= set(texts(wide))
    # A steady top has a double root (erratum G-21).
    slow = float(top.steady_precession(TOP, np.pi / 3, 5.0).slow)
    (close,) = figures.cubic(TOP, [0.0, slow * SIN60, 5.0], TILTED).plot().child_axes
    assert "$u_1 = u_2$" in texts(close)


def test_a_top_without_weight_has_no_third_root() -> None:
    light = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=0.0)
    data = figures.cubic(light, [0.3, 0.2, 1.0], TILTED)
    ax = drawn(data)
    assert data.roots[2] == np.inf
    assert len(data_of(artists(ax, "roots")[0])) == 2


# The upright top


def test_an_upright_top_sleeps_where_f_is_negative() -> None:
    data = figures.upright_cubic(TOP)
    axes = drawn(data)
    assert data.spin_min == 4.0
    np.testing.assert_allclose(data.spin, [3.6, 4.0, 4.4], rtol=1e-15)
    beside = data.u < 1.0
    near = beside & (data.u > 0.9)
    below, at, above = data.exact
    assert (below[near] > 0.0).all()
    assert (at[beside] < 0.0).all()
    assert (above[beside] < 0.0).all()
    np.testing.assert_array_equal(data.stable, [False, True, True])
    # At the bound the printed approximation vanishes and says nothing (erratum G-19), f decides.
    np.testing.assert_array_equal(data.approximate[1], 0.0)
    np.testing.assert_allclose(at, -2.0 * (1.0 - data.u) ** 3, atol=1e-15)
    np.testing.assert_array_equal(np.sign(data.approximate[[0, 2]][:, beside]).T[0], [1.0, -1.0])
    for name in ("exact", "approximate"):
        curves = np.array([data_of(line)[:, 1] for line in artists(axes, name)])
        np.testing.assert_array_equal(curves, getattr(data, name))
    titles = [ax.get_title() for ax in axes]
    assert [title.split(": ")[1] for title in titles] == ["falls", "sleeps", "sleeps"]
    assert axes[0].get_ylabel() == "$f(u)$ (1/s²)"
    (key,) = axes[0].figure.legends
    assert r"$\beta = 2mgl/I_1$, $b = I_3\omega_3/I_1$" in keys(key)[1]


# The locus


@pytest.mark.parametrize("name", STARTS)
def test_the_axis_stays_between_its_circles_and_touches_them(name: str) -> None:
    data: Any = figures.locus(TOP, omega_of(name), TILTED)
    assert data.kind == name.split()[0]
    assert np.cos(data.theta_lower) == pytest.approx(STARTS[name][2], abs=2e-11)
    assert data.theta.min() > data.theta_upper - 1e-12
    assert data.theta.max() < data.theta_lower + 1e-12
    np.testing.assert_allclose(data.theta.min(), data.theta_upper, atol=1e-3)
    np.testing.assert_allclose(data.theta.max(), data.theta_lower, atol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(data.point, axis=1), 1.0, rtol=1e-14)
    assert abs(np.ptp(data.phi)) > 0.95 * 2.0 * np.pi
    rate = np.diff(data.phi)
    # Erratum G-18: the axis may go against the spin all the time.
    assert data.retrograde == (name == "monotone retrograde")
    if data.kind != "cusp":
        forward, backward = bool((rate > 0.0).any()), bool((rate < 0.0).any())
        assert (forward, backward) == (not data.retrograde, data.retrograde or data.kind == "loop")


def test_the_picture_of_the_locus_carries_its_path() -> None:
    data = figures.locus(TOP, omega_of("cusp"), TILTED)
    ax = drawn(data)
    np.testing.assert_array_equal(joined(ax, "point"), [data.point])
    np.testing.assert_array_equal(data_of(artist(ax, "start")), data.point[:1])
    for name in ("theta_upper", "theta_lower"):
        heights = joined(ax, name)[..., 2]
        np.testing.assert_allclose(heights, np.cos(getattr(data, name)), rtol=1e-14)
    # What is seen is in front.
    elev, azim = np.radians([ax.elev, ax.azim])
    eye = np.array([np.cos(elev) * np.cos(azim), np.cos(elev) * np.sin(azim), np.sin(elev)])
    assert np.nanmin(data_of(artist(ax, "point")) @ eye) >= -1e-12
    assert np.nanmax(data_of(artist(ax, "point_hidden")) @ eye) <= 1e-12
    assert {r"$\theta_\mathrm{upper}$", r"$\theta_\mathrm{lower}$"} <= {
        text.strip() for text in texts(ax)
    }


def test_from_above_the_lower_circle_no_path_is_hidden() -> None:
    omega = omega_of("cusp")
    lower = figures.locus(TOP, omega, TILTED).theta_lower
    assert lower is not None
    for above, hidden in ((1.0, False), (-1.0, True)):
        ax = figures.locus(TOP, omega, TILTED, elev=np.degrees(lower) + above).plot()
        assert np.isfinite(data_of(artist(ax, "point_hidden"))).any() == hidden


def test_panels_of_loci_are_named() -> None:
    names = ["loop", "cusp", "monotone", "monotone retrograde"]
    found = figures.loci(TOP, [omega_of(name) for name in names], TILTED)
    assert [one.kind for one in found.paths] == [name.split()[0] for name in names]
    titles = [ax.get_title() for ax in drawn(found)]
    assert titles == ["loop", "cusp", "monotone", "monotone, retrograde"]


def test_tops_without_circles_are_drawn_for_given_times() -> None:
    t = np.linspace(0.0, 5.0, 51)
    for scene in (ASYMMETRIC, DAMPED):
        data = figures.locus(scene, [0.2, 0.1, 5.0], TILTED, t=t)
        assert data.kind == "general"
        assert not artists(drawn(data), "theta_upper")
        path = top.locus(scene, [0.2, 0.1, 5.0], TILTED, t=t)
        np.testing.assert_array_equal(data.point, path.point)


# Cycloids


def test_any_axis_may_be_that_of_a_cycloid() -> None:
    plain = figures.cycloids(TOP, 1.0, 20.0)
    turned = rigid.HeavyTop(rigid.Body((0.5, 1.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
    against = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0, com=(0.0, 0.0, -1.0))
    for scene, spin in ((turned, 20.0), (against, -20.0)):
        data = figures.cycloids(scene, 1.0, spin)
        np.testing.assert_allclose(data.theta, plain.theta, rtol=1e-12)
        np.testing.assert_allclose(data.phi, plain.phi, atol=1e-12)
        np.testing.assert_allclose(data.theta_approx, plain.theta_approx, rtol=1e-14)


def test_the_picture_of_cycloids_carries_both_curves() -> None:
    data = figures.cycloids(TOP, 1.0, 20.0)
    axes = drawn(data)
    for k in range(3):
        for line, phi, theta in (
            (artist(axes[k], "theta"), data.phi[k], data.theta[k]),
            (artist(axes[k], "theta_approx"), data.phi_approx[k], data.theta_approx[k]),
        ):
            expected = np.degrees(np.stack([np.sin(1.0) * phi, theta], axis=1))
            np.testing.assert_array_equal(data_of(line), expected)
        assert axes[k].get_ylim()[0] > axes[k].get_ylim()[1]  # upward is up
        assert axes[k].get_ylabel() == r"tilt $\theta$ (°)"
    assert axes[2].get_xlabel() == r"azimuth $\phi\,\sin\theta_0$ (°)"
    assert figures.cycloids(TOP, 1.0, 20.0, pushes=[]).plot() == ()


# Refusals


test_what_cannot_be_drawn_is_refused = refuses(
    [
        (lambda: figures.cubic(ASYMMETRIC, [0, 0, 1]), "moments = .* two exactly equal moments"),
        (
            lambda: figures.effective_potential(DAMPED, [0, 0, 1]),
            "a picture with constants of motion needs a scene without damping",
        ),
        (lambda: figures.cubic(wrong(BODY), [0, 0, 1]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: figures.cubic(TOP, [0, 0]), r"omega: expected shape \(3,\)"),
        (lambda: figures.cubic(TOP, [0, 0, np.nan]), "nan: must be finite"),
        (
            lambda: figures.cubic(TOP, [0, 0, 1], [TILTED, TILTED]),
            "attitude: expected a single one",
        ),
        (lambda: figures.upright_cubic(TOP, [1, 2]), r"spins: expected shape \(3,\)"),
        (lambda: figures.upright_cubic(DAMPED), "a closed form needs a scene without damping"),
        (
            lambda: figures.locus(ASYMMETRIC, [0, 0, 1]),
            r"t = None: the axis of this top has no period \(general\)",
        ),
        (lambda: figures.locus(TOP, [0, 0, 5]), r"no period \(sleeping\)"),
        (lambda: figures.locus(TOP, [0, 0, 5], elev=np.nan), "elev = nan: must be fin"),
        (lambda: figures.locus(wrong(BODY), [0, 0, 5]), TypeError, "must be a rigid.HeavyTop"),
        (lambda: figures.locus(TOP, [0, 0, 5], [TILTED]), r"attitude: expected shape \(4,\)"),
        (
            lambda: figures.loci(TOP, [[0, 0, 5]], [TILTED, TILTED]),
            r"attitude: expected shape \(4,\) or \(1, 4\)",
        ),
        (lambda: figures.cycloids(TOP, 1.0, 0.0), "a fast top needs a spin"),
        (lambda: figures.cycloids(TOP, 4.0, 9.0), "tilt = 4.0: must lie in"),
        (lambda: figures.cycloids(DAMPED, 1.0, 9.0), "a picture of cycloids needs a scene"),
        (lambda: figures.cycloids(TOP, 1.0, 9.0, periods=0), "periods = 0.0"),
        (lambda: figures.cycloids(TOP, 1.0, 9.0, pushes=[[1.0]]), r"pushes: expected shape \(k,\)"),
        (lambda: figures.poinsot(poinsot_run(3), frame=3), "frame = 3: the run has 3"),
        (
            lambda: figures.poinsot(poinsot_run(3), frame=wrong(0.5)),
            TypeError,
            "must be a whole number",
        ),
        (
            lambda: figures.poinsot(rigid.simulate(TOP, [0, 0, 1], t=[0, 1])),
            TypeError,
            "must be a rigid.FreeBody, which Poinsot",
        ),
        (
            lambda: figures.poinsot(rigid.simulate(BODY, [0, 0, 1], t=[0, 1], record="rates")),
            "record = 'rates': record = 'attitude' is needed",
        ),
        (lambda: figures.poinsot(rigid.simulate(BODY, [0, 0, 0], t=[0, 1])), "no invariable plane"),
        (
            lambda: figures.poinsot(
                rigid.simulate(rigid.FreeBody(BODY.body, damping=0.1), [0, 0, 1], t=[0, 1])
            ),
            "Poinsot's picture needs a scene without",
        ),
        (lambda: figures.polhodes((1, 1, 1.5)), "three different moments"),
        (lambda: figures.polhodes((1, 2, 4)), "triangle inequality"),
        (lambda: figures.polhodes((1, 2, 2.5), count=0), "count = 0: must be at least"),
        (lambda: figures.throw(wrong(None)), TypeError, "experiment = None: must be a"),
        (lambda: figures.invariants(wrong(None)), TypeError, "run = None: must be a rigid.Run"),
        (
            lambda: figures.invariants(rigid.simulate(BODY, [[0, 0, 1]], t=[0, 1])),
            r"omega of shape \(1, 2, 3\): needs one body",
        ),
        (
            lambda: figures.invariants(rigid.simulate(BODY, [0, 0, 0], t=[0, 1])),
            "at rest has nothing to drift",
        ),
        (
            lambda: figures.invariants(rigid.simulate(TOP, [0, 0, 1], t=[0, 1], record="rates")),
            "the energy of a heavy top needs it",
        ),
        (lambda: figures.poinsot(poinsot_run(3)).plot(Figure().add_subplot()), "needs 3-D axes"),
        (
            lambda: figures.cubic(TOP, [0, 0, 1]).plot(Figure().add_subplot(projection="3d")),
            "needs 2-D axes",
        ),
        (
            lambda: figures.upright_cubic(TOP).plot([Figure().add_subplot()]),
            "has 3 panels, got 1 axes",
        ),
    ]
)


def test_without_matplotlib_it_is_said_what_is_missing() -> None:
    code = (
        "import sys; sys.modules['matplotlib'] = sys.modules['matplotlib.figure'] = None\n"
        "from rigid import figures\n"
        "found = figures.polhodes((1.0, 2.0, 3.0))\n"
        "try:\n"
        "    found.plot()\n"
        "except ImportError as error:\n"
        "    print(error)\n"
    )
    said = python_process(code).stdout.strip()
    assert said == "plotting needs matplotlib: pip install 'rigid-rotation[maps]'"
