"""Trajectories known to 25 digits: free bodies, tops and pendulums of all kinds."""

from __future__ import annotations

import numpy as np
import pytest

import rigid
from physics import (
    METHODS,
    ROUNDOFF,
    Golden,
    angular_momentum,
    golden,
    present,
    rotation_angle,
    rotation_matrix,
)

FAMILIES = [
    "free_asymmetric",
    "free_symmetric",
    "lab_box",
    "lagrange",
    "pendulum",
    "kovalevskaya",
    "heavy_asymmetric",
]

#: Starts off an unstable turn by little or nothing, and exact relative to that little. A step
#: rounds relative to the whole, and 1e-16 of the whole grows to everything within these runs,
#: or (1e-3, 1e-1) to a thousand times what the condition numbers of the inputs say.
UNSTABLE = {
    "free_asymmetric/sep_w1_1e-3",
    "free_asymmetric/sep_w1_1e-6",
    "free_asymmetric/sep_w1_1e-10",
    "free_asymmetric/sep_w1_1e-12",
    "free_asymmetric/sep_w3_1e-6",
    "free_asymmetric/sep_exact",
    "lab_box/axis2_1rad_1e-10",
    "lab_box/axis2_10rad_1e-10",
    "lab_box/axis2_10rad_1e-1",
    "lagrange/waking_1e-8",
    "pendulum/planar_near_sep",
}

CASES = [case for family in FAMILIES for case in golden(family) if case.id not in UNSTABLE]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_the_error_is_the_one_that_halving_the_step_reveals(
    method: rigid.Method, case: Golden
) -> None:
    """And rounding.

    With an error c h^p, runs of steps h and h/2 differ by (2^p - 1) times the error of the finer
    one. Twice that is granted: c is not the same at every time. Inputs rounded by one part in 2^53
    cost the condition number kappa; some operations a step, in a random walk, cost more; the rotor
    of a symmetric body rounds alike in every step. Chaotic motion is followed as long as an error
    grows less than ten thousand times.
    """
    until = case.t[np.maximum(case.kappa_omega, case.kappa_att) < 1e4].max()
    # From order 16 on, steps of 0.025 rad leave rounding alone; four times longer ones nearly so.
    step = case.step_turning(0.1 if method.order >= 16 else 0.025)
    # The errors that runs state themselves are tested over the same trajectories elsewhere.
    options = {"until": until, "check": False}
    coarse, fine = (case.run(method.name, step=h, **options) for h in (step, step / 2))
    m = len(fine.t)
    # Next to a separatrix a state may be right and yet flagged.
    assert {int(coarse.status), int(fine.status)} <= {rigid.Status.UNCHECKED, rigid.Status.FLAGGED}
    rotor = method.name == "splitting" and case.scene.body.symmetry_axis is not None
    steps = float(fine.steps)
    rounding = ROUNDOFF * (10.0 * np.sqrt(steps) + (0.1 * steps if rotor else 0.0))
    share = 2.0 / (2.0**method.order - 1.0)

    scale = np.linalg.norm(case.omega[:m], axis=-1).max()
    error = np.linalg.norm(fine.omega - case.omega[:m], axis=-1).max()
    revealed = np.linalg.norm(coarse.omega - fine.omega, axis=-1).max()
    allowed = share * revealed + rounding * scale * (1.0 + case.kappa_omega[:m].max())
    assert error <= allowed

    angle = rotation_angle(present(fine.attitude), case.attitude[:m]).max()
    revealed = rotation_angle(present(coarse.attitude), present(fine.attitude)).max()
    turned = share * revealed + rounding * (1.0 + case.kappa_att[:m].max())
    assert angle <= turned

    # Momentum in space: of the same attitude and rates, so off by no more than both.
    momentum = (
        rotation_matrix(present(fine.attitude))
        @ angular_momentum(case.scene, fine.omega)[..., None]
    )
    off = np.linalg.norm(momentum[..., 0] - case.L_space[:m], axis=-1).max()
    length = np.linalg.norm(case.L_space[:m], axis=-1).max()
    assert off <= length * turned + max(case.scene.body.moments) * allowed
