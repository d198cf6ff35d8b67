"""Closed forms against Runge-Kutta steps, a small part of what tests/long does with a million."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from physics import Floats, gamma_of
from random_scenes import Scenes, batches, compared, free, tops
from rigid import _core


@pytest.mark.parametrize("seed", [1, 2])
def test_random_scenes_move_as_rk4_steps_them(seed: int) -> None:
    """All within the rounding of RK4 added up, nine in ten within that of random roundings."""
    expected = []
    for scenes, times in batches(np.random.default_rng(seed), 1000, 200):
        result = compared(scenes, times)
        worst = int(result.allowed.argmax())
        assert result.allowed[worst] <= 1.0, scenes.written(worst)
        expected.append(result.expected)
    assert np.quantile(np.concatenate(expected), 0.9) <= 1.0


def test_a_motion_that_is_off_by_a_part_in_a_billion_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The bars are narrow: closed forms of slightly faster starts lie beyond them."""
    states = Scenes.states

    def faster(
        self: Scenes, times: Floats, method: str, step: float, threads: int
    ) -> tuple[Floats, Floats]:
        off = 1.0 + 1e-9 * (method == "exact")
        return states(replace(self, omega=off * self.omega), times, method, step, threads)

    monkeypatch.setattr(Scenes, "states", faster)
    scenes, times = next(batches(np.random.default_rng(1), 1000, 400))
    assert (compared(scenes, times).allowed > 1.0).mean() > 0.99


def test_random_scenes_are_of_all_classes() -> None:
    rng = np.random.default_rng(1)
    found: set[str] = set()
    for scenes, _ in batches(rng, 2000, 2000):
        forms = _core.closed_forms(scenes.bodies)
        found.update(_core.closed_form_names()[code] for code in np.unique(forms))
    assert found == {"axis spin", "free symmetric", "free asymmetric", "lagrange", "pendulum"}


def test_random_moments_span_what_bodies_can_be() -> None:
    """Ratios over six decades, needles, flat bodies, and differences down to the last digits."""
    moments = np.sort(free(np.random.default_rng(1), 4000, equal=False).moments, axis=1)
    least, middle, largest = moments.T
    ratio, excess = least / largest, (least + middle - largest) / largest
    assert (excess >= -1e-15).all()
    assert ratio.min() < 1e-5
    assert ratio.max() > 0.99
    for small in (excess, (largest - middle) / largest, (middle - least) / largest):
        assert (abs(small) < 1e-12).sum() > 40


def test_random_tops_stand_hang_and_lie_on_every_axis() -> None:
    scenes = tops(np.random.default_rng(1), 4000)
    axis = np.abs(scenes.weight).argmax(axis=1)
    one = np.arange(len(axis))
    upward = np.sign(scenes.weight[one, axis]) * gamma_of(scenes.attitude)[one, axis]
    for k in range(3):
        for sign in (-1.0, 1.0):
            here = (axis == k) & (np.sign(scenes.weight[one, k]) == sign)
            assert here.sum() > 400
            for low, high in ((-1.1, -0.999), (-0.5, 0.5), (0.999, 1.1)):
                assert ((upward > low) & (upward < high) & here).sum() > 40
