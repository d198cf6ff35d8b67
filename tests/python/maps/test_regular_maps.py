"""Maps of regular motions: theorems, the rule, the numbers of a pixel, and their bits."""

from typing import Any

import numpy as np
import pytest

import rigid
from refusals import refuses
from rigid import _core
from rigid.drawing.figure import html_text

COM = np.array([0.3, 0.2, 0.93]) / np.linalg.norm([0.3, 0.2, 0.93])
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=COM)
KOVALEVSKAYA = rigid.HeavyTop(rigid.Body((2.0, 2.0, 1.0)), mgl=1.0, com=(1.0, 0.0, 0.0))
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
SPIN = rigid.Start(spin=0.0)
SPINS = {"spin": [1.0, 3.0]}


def regular_map(scene: Any = TOP, **options: Any) -> rigid.StabilityMap:
    """Tilt and spin of a top, from hanging to upright and from rest to fast."""
    chosen: dict[str, Any] = {
        "axes": {"tilt": np.linspace(0.05, 3.09, 8), "spin": np.linspace(0.0, 8.0, 8)},
        "start": SPIN,
        "samples": 1,
        "t_end": 200.0,
        "stable": rigid.regular(),
        "rng": 1,
    }
    return rigid.stability_map(scene, **{**chosen, **options})


@pytest.fixture(scope="module")
def plain() -> rigid.StabilityMap:
    return regular_map()


CLOUD: dict[str, Any] = {
    "axes": {"spin": [1.0, 2.9, 7.0]},
    "start": rigid.Start(spin=0.0, tilt=0.6, attitude_noise=rigid.normal(0.2)),
    "samples": 24,
}
"""Regular, chaotic and undecided bodies in a pixel."""


# --- Theorems ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scene", "undecided"),
    [(LAGRANGE, 0.002), (BOX, 0.002), (KOVALEVSKAYA, 0.01)],
    ids=["lagrange", "euler", "kovalevskaya"],
)
def test_no_integrable_body_is_called_chaotic(scene: Any, undecided: float) -> None:
    """All are integrated; the whole of 4096 bodies of each is a long test."""
    found = regular_map(
        scene,
        axes={"spin": [0.5, 1.0, 2.0, 4.0]},
        start=rigid.Start(spin=0.0, tilt=0.7, noise=rigid.normal(0.3)),
        samples=64,
        t_end=100.0,
        method="dop853",
    )
    assert found.unstable.sum() == found.failed.sum() == found.exact.sum() == 0
    # Three standard deviations above the share of many.
    allowed = 256 * undecided
    assert found.undecided.sum() <= allowed + 3.0 * np.sqrt(allowed) + 1.0


@pytest.mark.parametrize("scene", [LAGRANGE, BOX, rigid.HeavyTop(BOX.body, mgl=0.0)])
def test_bodies_with_a_closed_form_are_regular_by_theorem(scene: Any) -> None:
    start = rigid.Start(spin=0.0, tilt=0.7, noise=rigid.normal(0.3))
    found = regular_map(scene, axes={"spin": [1.0, 4.0]}, start=start, samples=50, t_end=1e4)
    assert found.stable.tolist() == found.exact.tolist() == [50, 50]
    assert found.steps.sum() == 0
    for values in (found.exponent, found.mean_megno, found.largest_exponent):
        assert np.isnan(values).all()
    assert "closed form" in found.summary()
    assert found.plan.method == "exact"


@pytest.mark.parametrize(
    ("scene", "start", "share"),
    [
        # About the middle axis, and on the separatrix: 16 w1² = 9 w3² of moments 4, 8, 9.
        (BOX, rigid.Start(omega=(0.0, 1.0, 0.0)), np.nan),
        (BOX, rigid.Start(omega=(1.0, 0.0, 0.0)), 1.0),
        (BOX, rigid.Start(omega=(0.0, 0.0, 0.0)), 1.0),
        (
            rigid.FreeBody(rigid.Body((4.0, 8.0, 9.0))),
            rigid.Start(omega=(0.375, 0.7, 0.5)),
            np.nan,
        ),
        (
            rigid.FreeBody(rigid.Body((4.0, 8.0, 9.0))),
            rigid.Start(omega=(0.375, 0.7, np.nextafter(0.5, 1.0))),
            1.0,
        ),
        # Upright below and above the bound of the sleeping top, 4 rad/s, and hanging.
        (LAGRANGE, rigid.Start(spin=3.9), np.nan),
        (LAGRANGE, rigid.Start(spin=4.0), 1.0),
        (rigid.HeavyTop(LAGRANGE.body, mgl=1.0, com=(0.0, 0.0, -1.0)), rigid.Start(spin=1.0), 1.0),
    ],
)
def test_a_body_on_a_separatrix_is_undecided(scene: Any, start: rigid.Start, share: float) -> None:
    axis: Any = {"I1": [scene.body.moments[0]]}
    found = regular_map(scene, axes=axis, start=start, t_end=100.0)
    assert found.exact.tolist() == [1]
    np.testing.assert_array_equal(found.share, [share])


# --- Chaos ---------------------------------------------------------------------------------------


def test_fast_tops_are_regular_and_slow_ones_mostly_chaotic(plain: rigid.StabilityMap) -> None:
    found = plain
    assert found.failed.sum() == 0
    assert (found.stable[-3:] == 1).all()
    # 30 % of this top is chaotic: half of what is slower than 3 rad/s.
    assert 0.2 < np.nanmean(found.chaotic_share) < 0.45
    assert found.undecided.mean() < 0.1
    chaotic = found.unstable == 1
    assert found.resolution == 0.05
    assert (found.exponent[chaotic] > 0.05).all()
    assert (found.exponent[found.stable == 1] < 0.05).all()
    assert (found.mean_megno[found.stable == 1] < 3.0).all()
    # Clear chaos ends a run at a quarter or at half of the horizon.
    assert set(found.earliest[chaotic]) <= {50.0, 100.0, 200.0}
    assert set(found.earliest[~chaotic]) == {np.inf}
    assert found.earliest[chaotic].min() < 200.0


def test_it_is_the_growth_that_lyapunov_measures() -> None:
    """Bit for bit, by the same steps; and the verdict on it."""
    found = regular_map(axes={"tilt": [0.3, 2.8], "spin": [0.9, 3.3, 7.1]})
    verdicts = {"stable": "regular", "unstable": "chaotic", "undecided": "undecided"}
    for pixel in range(6):
        body = found.replay(pixel, 0)
        growth = body.run
        assert isinstance(growth, rigid.Growth)
        assert growth.t.shape == (64,)
        at = np.searchsorted(growth.t, body.left) if np.isfinite(body.left) else -1
        assert growth.t[at] == (200.0 if at == -1 else body.left)
        assert growth.exponent[at] == body.exponent
        assert growth.mean_megno[at] == body.mean_megno
        assert growth.verdict == verdicts[body.outcome]
        assert body._repr_html_() == html_text(repr(body))  # a picture is of rates alone
        assert body.exponent == found.largest_exponent.flat[pixel]
        assert body.exponent == pytest.approx(found.exponent.flat[pixel], abs=1e-8)


def test_both_norms_agree_on_what_is_chaotic() -> None:
    rates, attitude = (regular_map(stable=rigid.regular(of)) for of in ("rates", "attitude"))
    decided = rates.undecided + attitude.undecided == 0
    assert (rates.stable[decided] == attitude.stable[decided]).all()
    assert decided.mean() > 0.85


def test_damping_makes_every_motion_regular() -> None:
    """A top comes to rest, hanging: no deviation vector grows for ever."""
    damped = rigid.HeavyTop(TOP.body, mgl=1.2, com=COM, damping=0.1)
    found = regular_map(damped, axes=SPINS, start=rigid.Start(spin=0.0, tilt=2.0))
    assert found.unstable.sum() == 0
    assert found.exact.sum() == 0
    body = found.replay(0, 0)
    # Its turn about the vertical is removed at other times.
    assert body.run.exponent[-1] == pytest.approx(body.exponent, rel=1e-12)
    assert body.exponent < 0.0


def test_the_rule_can_be_moved(plain: rigid.StabilityMap) -> None:
    """Nothing is chaotic above an unattainable bound, and below a tiny one only what stays."""
    never = regular_map(stable=rigid.regular(high=1e6))
    assert never.unstable.sum() == 0
    assert never.resolution == 1e4
    strict = regular_map(stable=rigid.regular(sure=1e-9, low=1e-6))
    # Beside a stable steady rotation deviation vectors are bounded, and the limit of MEGNO is 0.
    assert (strict.mean_megno[strict.stable == 1] < 1e-6).all()
    assert strict.stable.sum() < 0.1 * plain.stable.sum()
    assert (strict.unstable == plain.unstable).all()


@pytest.mark.parametrize(("method", "step"), [("dop853", 1.6), ("rk4", 0.4), ("splitting", 0.4)])
def test_chaos_of_steps_that_are_too_long_is_seen(method: str, step: float) -> None:
    """No Kovalevskaya top is chaotic; a second run in half of these steps would agree to some."""
    start = rigid.Start(
        omega=(0, 0, 0), noise=rigid.normal(1.0), attitude_noise=rigid.uniform_attitude()
    )
    asked: dict[str, Any] = {
        "axes": {"mgl": [1.0]}, "start": start, "samples": 1024, "t_end": 800.0, "method": method
    }  # fmt: skip
    alone = regular_map(KOVALEVSKAYA, **asked, step=step, check=0.0)
    checked = regular_map(KOVALEVSKAYA, **asked, step=step)
    assert alone.unstable.sum() >= 5, "the steps are not long enough to show anything"
    assert checked.unstable.sum() == 0
    np.testing.assert_array_equal(checked.failed, alone.failed)


def test_the_check_has_steps_of_its_own() -> None:
    """Of 1 rad, at most half of those asked for, and others than the first run if both are few."""
    asked: dict[str, Any] = {"axes": {"spin": [7.0]}, "start": rigid.Start(spin=0.0, tilt=0.6)}

    def steps(t_end: float, **options: Any) -> list[int]:
        alone, both = (
            regular_map(**asked, t_end=t_end, **options, check=check).steps for check in (0.0, 1.0)
        )
        return [int(alone[0]), int(both[0] - alone[0])]

    assert steps(10.0) == [512, 576]
    first, second = steps(200.0)
    # Both are whole blocks of 64 steps.
    assert second == pytest.approx(1.25 * first, abs=128)
    assert steps(200.0, method="rk4")[1] == steps(200.0, method="rk4", step=0.5)[1] == second
    assert steps(200.0, step=0.02) == [10048, 20032]
    # Over 16 times the time, 16 times the root of the root of 16.
    assert steps(3200.0)[1] > 1.9 * 16 * second - 64


def test_the_check_has_another_deviation() -> None:
    alone, checked = (regular_map(**CLOUD, check=check) for check in (0.0, None))
    assert alone.checked.sum() == 0
    assert (checked.checked == checked.samples).all()
    some = regular_map(**CLOUD, check=0.5)
    assert (some.checked == 12).all()
    for name in ("growth", "megno", "largest_exponent"):
        # Those of the first run, whatever the check says.
        assert (getattr(alone, name) == getattr(checked, name)).all()
    assert checked.undecided.sum() > 0
    assert alone.undecided.sum() > 0


# --- Bits and files ------------------------------------------------------------------------------


def test_means_are_those_of_the_bodies() -> None:
    """The sums are in units of 2^-20, rounded once for each body."""
    found = regular_map(**CLOUD, check=0.0)
    for pixel in range(3):
        bodies = [found.replay(pixel, sample) for sample in range(24)]
        exponents = np.array([body.exponent for body in bodies])
        megno = np.array([body.mean_megno for body in bodies])
        assert found.exponent[pixel] == pytest.approx(exponents.mean(), abs=2.0**-21 / 200.0)
        assert found.mean_megno[pixel] == pytest.approx(megno.mean(), abs=2.0**-21)
        assert found.largest_exponent[pixel] == exponents.max()
        whole = np.round(exponents * 200.0 * _core.FIXED_POINT).sum()
        assert found.growth[pixel] == whole


def test_other_criteria_measure_no_exponent() -> None:
    found = regular_map(stable=rigid.tilt_below(1.0), t_end=10.0)
    assert np.isnan(found.exponent).all()
    assert np.isnan(found.mean_megno).all()
    assert np.isnan(found.largest_exponent).all()
    assert np.isnan(found.resolution)
    assert not found.growth.any()


def test_the_picture_says_what_it_can_see(plain: rigid.StabilityMap) -> None:
    from matplotlib.colors import to_hex

    ax = plain.plot()
    assert "regular: no exponent above 0.05/s until t = 200 s" in ax.get_title(loc="left")
    assert len(ax.figure.axes) == 1  # no bar of shares: each pixel has one body
    legend: Any = ax.get_legend()
    texts = [text.get_text() for text in legend.get_texts()]
    assert texts == ["regular", "chaotic", "undecided"]
    colours = [to_hex(patch.get_facecolor()) for patch in legend.get_patches()[:2]]
    (mesh,) = ax.collections
    ends = mesh.get_cmap()([1.0, 0.0])
    assert colours == [to_hex(end) for end in ends]
    assert to_hex(mesh.get_cmap().get_bad()) not in colours


def test_the_picture_of_many_bodies_has_a_bar() -> None:
    ax = regular_map(samples=2).plot()
    assert "share regular" in [axis.get_ylabel() for axis in ax.figure.axes]
    legend: Any = ax.get_legend()
    assert "regular" not in [text.get_text() for text in legend.get_texts()]


def test_the_summary_and_the_plan(plain: rigid.StabilityMap) -> None:
    found = plain
    words = found.summary()
    assert "regular: no exponent above 0.05/s until t = 200 s" in words
    assert f"auto: {found.plan.method}, step chosen for each body" in words
    assert "none below 0.05/s can be seen" in words
    assert found.plan.method != "exact"
    assert found.plan.carried == ("omega", "gamma", "deviation")
    assert "Cincotta" in rigid.cite(found)
    assert "Cincotta" not in rigid.cite(regular_map(stable=rigid.tilt_below(1.0), t_end=1.0))


# --- Bad input -----------------------------------------------------------------------------------


test_a_rule_that_means_nothing_is_refused = refuses(
    [
        ({"of": "speed"}, "of = 'speed': must be one of 'rates', 'attitude'"),
        ({"low": 5.0}, "low = 5: must be below high = 5"),
        ({"sure": 3.5}, "sure = 3.5: must be at most low = 3"),
        ({"ratio": 1.0}, "ratio = 1: must be above 1"),
        ({"high": np.nan}, "high = nan: must be finite"),
        ({"sure": 0.0}, "sure = 0.0: must be positive"),
    ],
    by=lambda arguments: rigid.regular(**arguments),
)


test_what_no_map_of_growth_has = refuses(
    [
        (lambda: regular_map(method="midpoint"), "method = 'midpoint': has no tangent"),
        (
            lambda: regular_map(axes=SPINS, t_end=10.0).replay(0, 0, t=[0.0]),
            "t: must be positive times",
        ),
        (lambda: regular_map(method="exact"), "no closed form of regular for the body of pixel"),
        (lambda: regular_map(BOX, axes={"com_tilt": [0.1]}), "a free body feels no weight"),
        (lambda: regular_map(BOX, axes={"com_turn": [0.1]}), "a free body feels no weight"),
    ]
)
