"""Maps under torque and damping: a sleeping top loses its spin and falls."""

from typing import Any

import numpy as np
import pytest

import rigid
from map_texts import TABLES, map_text
from physics import present
from refusals import refuses
from rigid.cli.toml_map import parse_spec
from rigid.maps.data import STORED
from rigid.maps.spec import MapSpec
from rigid.maps.theory import falling_lag, predict

MGL, I1, I3 = 1.0, 1.0, 0.5


BOUND = 2.0 * np.sqrt(MGL * I1) / I3


TOP = rigid.HeavyTop(rigid.Body((I1, I1, I3)), mgl=MGL)


CLOUD = rigid.Start(spin=6.0, attitude_noise=rigid.normal(1e-2))


def small(scene: Any = TOP, **options: Any) -> rigid.StabilityMap:
    given: dict[str, Any] = {
        "axes": {"spin": [4.5, 6.0, 9.0], "damping3": [1e-3, 4e-3, 1.6e-2]},
        "start": CLOUD,
        "samples": 8,
        "t_end": 60.0,
        "stable": rigid.tilt_below(0.5, reference="vertical"),
        "rng": 7,
    }
    return rigid.stability_map(scene, **{**given, **options})


def test_the_falling_time_is_the_quasi_static_one_in_the_slow_limit() -> None:
    """It falls after the bound, by the lag in which its tilt grows: `c^(2/3)` of the time."""
    tilt, limit, spin = 1e-3, 0.5, 5.0
    attitude = [np.cos(tilt / 2), np.sin(tilt / 2), 0.0, 0.0]
    relative = []
    for c in (1.6e-2, 4e-3, 1e-3):
        scene = rigid.HeavyTop(TOP.body, mgl=MGL, damping=(0.0, 0.0, c))
        bound = I3 / c * np.log(spin / BOUND)
        lag = float(falling_lag(*map(np.asarray, (MGL, I1, I3, c, limit / tilt))))
        t = np.linspace(bound, bound + 2.0 * lag, 400)
        run = rigid.simulate(scene, [0.0, 0.0, spin], attitude, t=t, method="taylor16", check=False)
        fallen = np.flatnonzero(present(run.gamma)[:, 2] < np.cos(limit))
        assert fallen.size
        # The tilt grows from what the slow change left of it: a factor of a few, in the logarithm.
        late = t[fallen[0]] - bound
        assert 0.5 * lag < late < 1.5 * lag
        relative.append(late / bound)
    # A quarter of the damping: the lag, in units of the time, falls by 4^(2/3) = 2.5.
    assert relative[0] / relative[1] == pytest.approx(4.0 ** (2.0 / 3.0), rel=0.15)
    assert relative[1] / relative[2] == pytest.approx(4.0 ** (2.0 / 3.0), rel=0.1)


def test_the_lines_of_the_falling_top_are_its_onset_and_its_border() -> None:
    """Before the onset all stand; half have fallen where the second line says, within a pixel.

    The rows are those of three dampings of the built-in map, its spins about the lines.
    """
    pixel = 9.0 / 89.0
    for damping, spins in ((2e-3, (5.3, 6.2)), (3e-3, (6.3, 7.6)), (5e-3, (9.2, 11.1))):
        spin = np.arange(spins[0], spins[1], 0.5 * pixel)
        result = small(
            axes={"spin": spin, "damping3": [0.999 * damping, damping]},
            samples=32,
            t_end=100.0,
            check=0.0,
        )
        theory = present_theory(result.spec)
        onset, border = (curve.field[1] for curve in theory.curves)
        assert onset.min() < border.min() < 0.0 < onset.max() < border.max()
        share = result.share[1]
        assert share[onset > 0.0].min() == 1.0
        # Falling begins after the onset: there is no prediction between the onset and two lags.
        fallen = share < 1.0
        assert fallen.any()
        np.testing.assert_array_equal(np.isnan(theory.share[1]), onset <= 0.0)
        assert not result.disagreement().any()
        half = np.interp(0.5, share, spin)
        assert abs(half - np.interp(0.0, border, spin)) < pixel


@pytest.mark.parametrize("spin", [6.0, 3.0])
def test_a_fall_is_predicted_until_its_onset_and_after_twice_the_lag(spin: float) -> None:
    """The lag of a tilt of a thousandth of the noise; below the bound it counts from the start."""
    c, size, limit = 0.02, 1e-2, 0.5
    onset = I3 / c * np.log(spin / BOUND)
    growth = np.log(limit / (1e-3 * size))
    lag = (1.5 * growth / np.sqrt(2.0 * c * MGL / (I1 * I3))) ** (2.0 / 3.0)
    # To swing out so far from upright a top spins more slowly than at the bound.
    late = max(onset, 0.0) + 2.0 * lag + 0.5 * I3 / c * np.log(2.0 / (1.0 + np.cos(limit)))

    def share(t_end: float, noise: float = size) -> float:
        start = rigid.Start(spin=spin, attitude_noise=rigid.normal(noise))
        axes = {"spin": [spin], "damping3": [c]}
        theory = predict(small(axes=axes, start=start, samples=1, t_end=t_end).spec)
        return np.nan if theory is None else float(theory.share[0, 0])

    assert share(1.01 * late) == 0.0
    assert np.isnan(share(0.99 * late))
    if onset > 0.0:
        assert share(0.99 * onset) == 1.0
        assert np.isnan(share(1.01 * onset))
        # The nutation of four standard deviations must stay below the limit. Its square times its
        # rate is constant while the spin falls.
        end = spin * np.exp(-0.99 * c * onset / I3)
        first, last = np.sqrt(np.square([I3 * spin, I3 * end]) - 4.0 * MGL * I1) / (2.0 * I1)
        swing = I3 * spin / (2.0 * I1) / np.sqrt(first * last)
        assert share(0.99 * onset, 0.99 * limit / (4.0 * swing)) == 1.0
        assert np.isnan(share(0.99 * onset, 1.01 * limit / (4.0 * swing)))


def test_a_fall_before_the_onset_disagrees_and_one_after_it_does_not() -> None:
    result = small(axes={"spin": [4.5, 5.0, 5.5, 6.0], "damping3": [1e-3, 2e-3]}, samples=1)
    (onset, _) = present_theory(result.spec).curves
    zero = np.zeros(result.spec.shape, dtype=np.int64)
    fell = dict.fromkeys(STORED, zero) | {"unstable": zero + 64}
    everywhere = rigid.StabilityMap.from_arrays(result.spec, fell)
    np.testing.assert_array_equal(everywhere.disagreement(), onset.field > 0.0)
    assert 0 < everywhere.disagreement().sum() < zero.size
    unknown = int((onset.field <= 0.0).sum())
    assert f"; no prediction for {unknown} pixels" in everywhere.summary()


def present_theory(spec: MapSpec) -> Any:
    theory = predict(spec)
    assert theory is not None
    return theory


@pytest.mark.parametrize("method", ["rk4", "dop853", "etd4", "splitting", "midpoint"])
def test_a_map_under_damping_and_its_samples(method: str) -> None:
    """A sample alone is the sample of the map; so it is on any number of threads."""
    result = small(method=method)
    again = small(method=method, threads=1)
    for name in ("stable", "unstable", "failed"):
        assert getattr(result, name).tolist() == getattr(again, name).tolist()
    # Weak damping keeps the fast one up, strong damping lets the slow one fall.
    assert result.stable[0, 2] == 8
    assert result.unstable[2, 0] == 8
    body = result.replay(pixel=(2, 0), sample=3)
    assert body.outcome == "unstable"
    run = body.run
    tilt = np.arccos(np.clip(present(run.gamma)[:, 2], -1.0, 1.0))
    first = run.t[np.flatnonzero(tilt > 0.5)[0]]
    assert abs(first - body.left) < 60.0 / 400.0
    assert np.array(result.spec.scene.damping or np.zeros((3, 3))).sum() == 0.0


def test_a_file_says_torque_and_damping() -> None:
    torques = "torque = [0.0, 0.0, 0.001]\ntorque_in_space = [0.001, 0.0, 0.0]"
    text = map_text(scene=f"{TABLES['scene']}\ndamping = [0.0, 0.0, 0.01]\n{torques}")
    spec = parse_spec(text, "own.toml")
    expected = rigid.Torque.body((0, 0, 1e-3)) + rigid.Torque.space((1e-3, 0, 0))
    assert spec.scene.torque == expected
    assert np.array(spec.scene.damping)[2, 2] == 0.01
    assert MapSpec.from_json(spec.to_json()) == spec
    assert spec.forces


test_what_a_map_under_damping_refuses = refuses(
    [
        ({"method": "exact"}, "method = 'exact': under forces a closed form is known only of"),
        ({"method": "chin4a"}, "method = 'chin4a': does not integrate "),
        (
            {"stable": rigid.tilt_below(0.5, reference="start")},
            "reference = 'start': under damping",
        ),
        ({"axes": {"damping3": [1e3, 1e4]}, "step": 0.1}, "unstable under damping"),
        ({"axes": {"damping3": [-1.0, 1.0]}}, "must not be negative"),
    ],
    literal=True,
    by=lambda options: small(**options),
)
