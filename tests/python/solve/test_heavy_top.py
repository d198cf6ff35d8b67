"""Bodies with a fixed point under their weight, above all the symmetric (Lagrange) top."""

import numpy as np
import pytest

import rigid
from physics import (
    METHODS,
    ROUNDOFF,
    Floats,
    Golden,
    angular_momentum,
    energy,
    gamma_of,
    golden,
    present,
    rotation_angle,
    rotation_matrix,
)

LAGRANGE = golden("lagrange")
OTHERS = golden("pendulum") + golden("kovalevskaya") + golden("heavy_asymmetric")


@pytest.mark.parametrize("case", LAGRANGE, ids=lambda case: case.id)
def test_constants_of_the_symmetric_top(case: Golden) -> None:
    """Energy, L·gamma and omega_3: exact for the splitting but for the energy, which is bounded."""
    scene = case.scene
    assert isinstance(scene, rigid.HeavyTop)
    run = case.run("splitting", step=case.step_turning(0.025))
    gamma = present(run.gamma)
    steps = float(run.steps)
    # L3 turns with the rotor about L and back: a roundoff or two of |L| a step.
    start = angular_momentum(scene, case.omega0)
    reach = np.linalg.norm(angular_momentum(scene, run.omega), axis=-1).max()
    bound = 4.0 * ROUNDOFF * steps * reach
    assert angular_momentum(scene, run.omega)[:, 2] == pytest.approx(start[2], abs=bound)
    along = (angular_momentum(scene, run.omega) * gamma).sum(axis=-1)
    assert along == pytest.approx(start @ gamma_of(case.attitude0), abs=bound)
    # Energy: order 2 in a step of 1/40 rad.
    scale = energy(scene, case.omega0) + scene.mgl
    assert np.abs(energy(scene, run.omega, gamma) - case.energy).max() < 0.025**2 * scale


@pytest.mark.parametrize("case", LAGRANGE + OTHERS, ids=lambda case: case.id)
def test_the_vertical_is_that_of_the_attitude(case: Golden) -> None:
    """It is carried beside the attitude; each method turns both alike."""
    until = case.t[case.kappa_att < 1e6].max()
    run = case.run("splitting", until=until, step=case.step_turning(0.025))
    apart = np.abs(present(run.gamma) - gamma_of(present(run.attitude))).max()
    assert apart < 4.0 * ROUNDOFF * float(run.steps) + 8 * ROUNDOFF


# --- worked cases ---------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_hanging_top_hangs(method: rigid.Method) -> None:
    hanging = rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=3.0, com=(0.0, 0.0, -1.0))
    still = rigid.simulate(hanging, [0.0, 0.0, 0.0], t=[1.0, 50.0], method=method.name, step=0.01)
    assert np.array_equal(still.omega, np.zeros((2, 3)))
    assert np.array_equal(present(still.attitude), [[1.0, 0.0, 0.0, 0.0]] * 2)
    # Pushed, it swings about axis 1 with sqrt(mgl / I1), and the push returns after a period.
    period = 2.0 * np.pi / np.sqrt(3.0)
    swing = rigid.simulate(
        hanging, [1e-4, 0.0, 0.0], t=[period / 4, period / 2, period], method=method.name, step=1e-3
    )
    # The amplitude lengthens the period by (theta/4)^2 = 2e-10; order 2 misses 1e-7 of it.
    assert 1e4 * swing.omega[:, 0] == pytest.approx([0.0, -1.0, 1.0], abs=1e-6)


# --- the smallest motions -------------------------------------------------------------------------


@pytest.mark.parametrize("t", [1e-60, 1e-161, 1e-200])
@pytest.mark.parametrize("mgl", [1.0, 1e-100])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_top_that_is_let_go_begins_to_turn_by_its_torque(
    method: rigid.Method, mgl: float, t: float
) -> None:
    """The rates are the torque over the moments times the time, however short."""
    moments, com = np.array([1.0, 1.6, 0.7]), np.array([0.6, 0.0, 0.8])
    top = rigid.HeavyTop(rigid.Body(tuple(moments)), mgl=mgl, com=tuple(com))
    run = rigid.simulate(top, [0.0, 0.0, 0.0], [1.0, 0.3, 0.2, 0.1], t=[t], method=method.name)
    gamma = present(run.gamma)[-1]
    begin = np.cross(gamma, com) / moments
    assert np.abs(run.omega[-1] / (mgl * t) - begin).max() < 1e-14


# --- weight and axes ------------------------------------------------------------------------------


@pytest.mark.parametrize("record", ["rates", "axis", "attitude"])
@pytest.mark.parametrize(
    "moments", [(1.0, 2.0, 2.5), (1.0, 1.0, 1.5), (1.5, 1.0, 1.0), (1.0, 1.5, 1.0)]
)
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_without_weight_it_is_the_free_body(
    method: rigid.Method, moments: tuple[float, float, float], record: str
) -> None:
    """Bit for bit, but for Runge-Kutta, which multiplies the constants of both in another order.

    Also at the default step: the same bound of the rates holds.
    """
    body = rigid.Body(moments)
    runs = [
        rigid.simulate(
            scene, [0.3, 1.0, 0.2], [0.5, 0.1, 0.3, 0.2], t=[-2.0, 0.0, 1.0, 7.0],
            method=method.name, record=record,
        )
        for scene in (rigid.FreeBody(body), rigid.HeavyTop(body, mgl=0.0, com=(0.6, 0.0, 0.8)))
    ]  # fmt: skip
    free, top = runs
    assert free.steps == top.steps
    # By Runge-Kutta a random walk of some operations a step.
    is_runge_kutta = method.name in ("rk4", "dop853")
    rounding = 10.0 * ROUNDOFF * np.sqrt(float(free.steps))
    for name in ("omega", "energy_drift", *(("gamma",) if record == "axis" else ())):
        one, other = (np.asarray(getattr(run, name)) for run in runs)
        if is_runge_kutta:
            assert np.abs(one - other).max() < rounding * max(np.abs(one).max(), 1.0)
        else:
            assert one.tobytes() == other.tobytes()
    if record == "attitude":
        attitudes = present(free.attitude), present(top.attitude)
        if method.name == "splitting":
            assert attitudes[0].tobytes() == attitudes[1].tobytes()
        else:
            # Most carry the attitude of a top as rows of its matrix, of a free body as quaternion.
            most = 10.0 * rounding if method.name == "rk4" else 1e-9
            assert rotation_angle(*attitudes).max() < most


def renamed(v: tuple[float, ...], turns: int) -> tuple[float, ...]:
    return tuple(np.roll(v, turns).tolist())


@pytest.mark.parametrize("moments", [(1.0, 1.5, 2.0), (1.5, 1.2, 1.0), (1.0, 1.0, 0.5)])
@pytest.mark.parametrize("com", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.48, -0.64, 0.6)])
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_the_names_of_the_body_axes_do_not_matter(
    method: rigid.Method, com: tuple[float, ...], moments: tuple[float, ...]
) -> None:
    """Axes 1, 2, 3 called 2, 3, 1 or 3, 1, 2: the same motion; starts differ by rounding."""
    start, rates = (0.5, 0.1, 0.3, 0.2), (0.3, 1.0, 0.2)

    def motion(turns: int) -> tuple[Floats, Floats]:
        body = rigid.Body(renamed(moments, turns))
        top = rigid.HeavyTop(body, mgl=1.0, com=renamed(com, turns))
        # The turn by 120 degrees about (1, 1, 1) takes the new body axes to the old ones.
        half = -turns * np.pi / 3
        s = np.sin(half) / np.sqrt(3.0)
        w, x, y, z = start
        c = np.cos(half)
        attitude = [
            w * c - s * (x + y + z),
            x * c + s * (w + y - z),
            y * c + s * (w + z - x),
            z * c + s * (w + x - y),
        ]
        run = rigid.simulate(
            top, renamed(rates, turns), attitude, t=[0.0, 1.0, 7.0], method=method.name, step=0.01
        )
        matrix = rotation_matrix(present(run.attitude))
        return np.roll(run.omega, -turns, axis=-1), np.roll(matrix, -turns, axis=-1)

    omega, matrix = motion(0)
    for turns in (1, 2):
        other_omega, other_matrix = motion(turns)
        # 700 steps of regular motion: rounding grows to some 1e-14.
        assert other_omega == pytest.approx(omega, abs=2e-13)
        assert other_matrix == pytest.approx(matrix, abs=2e-13)
