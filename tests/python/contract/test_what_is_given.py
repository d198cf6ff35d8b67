"""What a function does not know, it refuses: forces in a formula, pairs, tensors for moments."""

import inspect
import re
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import rigid
from physics import tilted
from rigid import (
    earth,
    exact,
    figures,
    fixed_axis,
    frames,
    free,
    inertia,
    particles,
    rotations,
    solids,
    springs,
    statics,
    top,
)

BODY = rigid.Body((1.0, 1.0, 1.6))
RATES = [0.3, 0.2, 3.0]
PAIR = rigid.HeavyTop.from_mass(rigid.Body.cone(0.05, 0.1, mass=0.2), com=(0, 0, 0.075))
SPIN = rigid.Torque.body((0.0, 0.0, 0.1))
FORCES: list[dict[str, Any]] = [{"damping": 0.1}, {"torque": SPIN}, {"drag": 0.1}]
FREE_FORCES = [
    *FORCES,
    {"rotor": (0.0, 0.0, 1.0)},
    {"dissipation": rigid.EnergySink(0.1)},
    {"orbit": rigid.Orbit(0.1)},
]

#: Formulas that hold without forces, by their module.
OF_TOPS: dict[str, Callable[[Any], Any]] = {
    "advance": lambda scene: top.advance(scene, RATES, tilted(1.0)),
    "classify_locus": lambda scene: top.classify_locus(scene, RATES, tilted(1.0)),
    "effective_minimum": lambda scene: top.effective_minimum(scene, a=1.0, b=2.0),
    "effective_potential": lambda scene: top.effective_potential(scene, 1.0, a=1.0, b=2.0),
    "fast_top_approx": lambda scene: top.fast_top_approx(scene, 1.0, 8.0),
    "lagrange_top": lambda scene: exact.lagrange_top(scene, RATES, tilted(1.0)),
    "on_surface": lambda scene: top.on_surface(scene, 9.0, 0.1, 5),
    "pendulum_period": lambda scene: exact.pendulum_period(scene, 1.0, axis=1),
    "precession_spin_rates": lambda scene: top.precession_spin_rates(scene, 1.0, a=1.0, b=2.0),
    "sleeping_spin": exact.sleeping_spin,
    "sleeping_top": lambda scene: top.sleeping_top(scene, 5.0),
    "spin_down": lambda scene: top.spin_down(scene, 5.0, damping=0.1),
    "spin_from_precession": lambda scene: top.spin_from_precession(scene, 1.0, 0.5),
    "steady_precession": lambda scene: exact.steady_precession(scene, 1.0, 5.0),
    "tilt_time": lambda scene: exact.tilt_time(scene, RATES, tilted(1.0), limit=1.1),
    "turning_angles": lambda scene: top.turning_angles(scene, a=1.0, b=2.0, E_prime=2.0),
    "upright_f": lambda scene: top.upright_f(scene, 5.0, 0.5),
}
OF_BODIES: dict[str, Callable[[Any], Any]] = {
    "asymmetric_free_top": lambda body: free.asymmetric_free_top(body, RATES),
    "circulation": lambda body: free.circulation(body, RATES),
    "cones": lambda body: free.cones(body, RATES),
    "crossings": lambda body: free.crossings(body, RATES),
    "euler_rhs": lambda body: free.euler_rhs(body, RATES),
    "flip_times": lambda body: exact.flip_times(body, RATES, axis=1),
    "free_body": lambda body: exact.free_body(body, RATES),
    "gammas": free.gammas,
    "libration": lambda body: free.libration(body, 1.0),
    "permanent_rotation": lambda body: free.permanent_rotation(body, 3),
    "poinsot": lambda body: free.poinsot(body, [RATES]),
    "relaxation": lambda body: free.relaxation(body, RATES, [0.0, 1.0], rigid.EnergySink(0.1)),
    "sink_of_damping": lambda body: free.sink_of_damping(body, 1.0, 100.0),
    "spin_periods": lambda body: free.spin_periods(body, RATES),
    "spin_state": lambda body: free.spin_state(body, precession=20.0, rotation=40.0, mode="SAM"),
    "steady_axis_frame": lambda body: free.steady_axis_frame(body, 1.0),
    "steady_axis_spin": lambda body: free.steady_axis_spin(body, RATES),
    "symmetric_free_top": lambda body: free.symmetric_free_top(body, RATES),
}
#: Of states at given times, with whatever acts; and with numbers of their own.
OF_STATES = {
    "gravity_torque",
    "heavy_constants",
    "jacobi_integral",
    "locus",
    "roll_pitch_yaw",
    "throw_experiment",
}


def functions(*modules: ModuleType) -> set[str]:
    """Public functions that take a scene or a body first."""
    found = set()
    for module in modules:
        for name in module.__all__:
            value = getattr(module, name)
            if inspect.isfunction(value):
                first = next(iter(inspect.signature(value).parameters), "")
                if first in ("scene", "body", "top"):
                    found.add(name)
    return found


def test_every_function_of_the_textbook_is_in_a_table() -> None:
    assert functions(exact, free, top) == OF_TOPS.keys() | OF_BODIES.keys() | OF_STATES


@pytest.mark.parametrize("name", OF_TOPS)
@pytest.mark.parametrize("forces", FORCES, ids=lambda forces: next(iter(forces)))
def test_formulas_of_tops_refuse_further_forces(name: str, forces: dict[str, Any]) -> None:
    OF_TOPS[name](rigid.HeavyTop(BODY, mgl=1.0))
    with pytest.raises(ValueError, match=f"needs a scene without {next(iter(forces))}"):
        OF_TOPS[name](rigid.HeavyTop(BODY, mgl=1.0, **forces))


@pytest.mark.parametrize("name", OF_BODIES)
@pytest.mark.parametrize("forces", FREE_FORCES, ids=lambda forces: next(iter(forces)))
def test_formulas_of_free_bodies_refuse_forces(name: str, forces: dict[str, Any]) -> None:
    OF_BODIES[name](rigid.FreeBody(BODY))
    with pytest.raises(ValueError, match="needs a scene without "):
        OF_BODIES[name](rigid.FreeBody(BODY, **forces))


@pytest.mark.parametrize("name", sorted(OF_BODIES.keys() - {"flip_times"}))
def test_formulas_of_free_bodies_refuse_weight(name: str) -> None:
    with pytest.raises(TypeError, match=r"must be a rigid\.Body"):
        OF_BODIES[name](rigid.HeavyTop(BODY, mgl=1.0))


# Pairs of a body or a top and its axes

MADE = rigid.Body.from_tensor([[2.0, 0.1, 0.0], [0.1, 3.0, 0.0], [0.0, 0.0, 4.0]])
TAKES_A_TOP: dict[str, Callable[[Any], Any]] = {
    "simulate": lambda scene: rigid.simulate(scene, RATES, t=[1.0]),
    "plan": lambda scene: rigid.plan(scene),
    "report": lambda scene: rigid.report(scene, omega=RATES, t_end=1.0),
    "Motion": lambda scene: rigid.Motion(scene, RATES),
    "lyapunov": lambda scene: rigid.lyapunov(scene, RATES, t=[1.0]),
    "stability_map": lambda scene: rigid.stability_map(
        scene, axes={"spin": [1.0, 2.0]}, samples=1, t_end=1.0, stable=rigid.no_flip()
    ),
    "heavy_top": lambda scene: figures.heavy_top(scene, (0.1, 0.2, 0.3)),
    **{name: call for name, call in OF_TOPS.items() if name != "on_surface"},
}


@pytest.mark.parametrize("name", TAKES_A_TOP)
def test_a_pair_of_a_top_and_its_axes_is_recognised(name: str) -> None:
    with pytest.raises(TypeError, match=re.escape("this is a pair, the top and its axes: write")):
        TAKES_A_TOP[name](PAIR)


@pytest.mark.parametrize(
    "call",
    [
        rigid.FreeBody,
        lambda body: rigid.HeavyTop(body, mgl=1.0),
        lambda body: rigid.HeavyTop.from_mass(body, com=(0, 0, 1.0), mass=1.0),
        lambda body: rigid.simulate(body, RATES, t=[1.0]),
        lambda body: particles.propagate_body(body, [0, 0, 0], [0, 0, 0], RATES, t=[1.0]),
        figures.box,
        *OF_BODIES.values(),
    ],
)
def test_a_pair_of_a_body_and_its_axes_is_recognised(call: Callable[[Any], Any]) -> None:
    message = "this is a pair, the body and its axes: write body, axes = ..., and pass body "
    with pytest.raises(TypeError, match=re.escape(message)):
        call(MADE)


def test_a_pair_of_numbers_is_no_body_with_axes() -> None:
    with pytest.raises(TypeError, match=r"rigid\.Body without weight$"):
        rigid.simulate((1, 2), RATES, t=[1.0])  # type: ignore[arg-type]


# What is no axes of Matplotlib


@pytest.mark.parametrize(
    "draw",
    [
        lambda ax: rigid.simulate(BODY, RATES, t=[0.0, 1.0]).plot(ax),
        lambda ax: rigid.lyapunov(BODY, RATES, t=[1.0, 2.0], check=False).plot(ax=ax),
        lambda ax: figures.polhodes((1.0, 2.0, 2.5)).plot(ax),
    ],
)
def test_axes_are_those_of_matplotlib(draw: Callable[[Any], Any]) -> None:
    with pytest.raises(TypeError, match="ax = 'attitude': must be axes of Matplotlib, or left out"):
        draw("attitude")


# Tensors where moments are asked

TENSOR = [[2.0, 1.0, 1.2], [1.0, 2.0, 1.3], [1.2, 1.3, 2.0]]


OF_MOMENTS = [
    call for name, call in OF_BODIES.items() if name not in ("crossings", "flip_times", "free_body")
]


@pytest.mark.parametrize("call", [rigid.Body, *OF_MOMENTS])
@pytest.mark.parametrize(
    "tensor",
    [
        TENSOR,
        [TENSOR, TENSOR],
        [[2.0, 0.1, 0.0], [0.1 + 1e-8, 3.0, 0.0], [0.0, 0.0, 4.0]],
        np.diag([2.0, 3.0, 4.0]),
    ],
    ids=["rows of bodies", "stack", "five digits", "diagonal"],
)
def test_a_tensor_is_not_three_bodies(call: Callable[[Any], Any], tensor: Any) -> None:
    with pytest.raises(ValueError, match=r"is a tensor of inertia.* take rigid\.Body\.from_tensor"):
        call(tensor)


def test_no_tensor_of_a_body_has_rows_of_bodies() -> None:
    """So the refusal of tensors hides no three bodies: orders of one body are never definite."""
    rng = np.random.default_rng(3)
    rows = np.abs(rng.normal(size=(200_000, 3, 3)))
    rows = rows + np.swapaxes(rows, 1, 2)
    are_bodies = (2.0 * rows.max(axis=2) <= rows.sum(axis=2)).all(axis=1)
    assert are_bodies.sum() > 1000
    least, middle, largest = np.linalg.eigvalsh(rows[are_bodies]).T
    assert not ((least > 0.0) & (largest <= least + middle)).any()
    for three in ([[1, 2, 2.5], [2, 2.5, 1], [2.5, 1, 2]], np.full((3, 3), 0.4)):
        assert rigid.Body(three).shape == (3,)


# Numbers that leave the range of doubles are refused, and other objects than those meant.


SOLID = rigid.Body((1.0, 2.0, 2.5))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
SPECK = rigid.HeavyTop(rigid.Body((1e-200, 1e-200, 1e-200)), mgl=1e-200)
HUGE = 1e300
FAST = [1.0, HUGE, 2.0]
CUBIC = {"a": 1.25, "b": 2.5, "alpha": 1.0, "beta": 2.0}

OVERFLOWS: dict[str, tuple[str, Callable[[], Any]]] = {
    "steady precession": ("spin", lambda: exact.steady_precession(TOP, 1.0, HUGE)),
    "weight of a speck": ("spin", lambda: exact.steady_precession(SPECK, 1.0, 5.0)),
    "elliptic integral": ("y", lambda: exact.carlson_rj(1e-210, 1e-211, 1e-210, 1e-210)),
    "fit": ("omega", lambda: rigid.fit(SOLID, [0.0], omega=[FAST], sigma=0.1, free="omega")),
    "disk": ("radius", lambda: solids.disk(HUGE)),
    "sphere": ("radius", lambda: solids.sphere(HUGE)),
    "cylinder": ("height", lambda: solids.cylinder(1.0, HUGE)),
    "box": ("a", lambda: solids.box(HUGE, 1.0, 1.0)),
    "cone": ("radius", lambda: solids.cone(HUGE, 1.0)),
    "wrench": ("forces", lambda: statics.wrench([FAST], [[1e200, 0.0, 0.0]])),
    "cubic": ("beta", lambda: top.f_u(2.0, **{**CUBIC, "beta": 1e308})),
    "roots": ("a", lambda: top.f_roots(**{**CUBIC, "a": HUGE})),
    "period of nutation": ("b", lambda: top.nutation_period(**{**CUBIC, "b": HUGE})),
    "effective potential": ("b", lambda: top.effective_potential(TOP, 1.0, a=1.0, b=HUGE)),
    "ellipticity": ("polar_radius", lambda: earth.ellipticity(HUGE, 1.0)),
    "rotation vector": ("vector", lambda: rotations.exp_so3(FAST)),
    "Euler's equations": ("omega", lambda: free.euler_rhs(SOLID, [HUGE, HUGE, 2.0])),
    "permanent rotation": ("rate", lambda: free.permanent_rotation(SOLID, 3, HUGE)),
    "local stability": ("factors", lambda: free.local_stability([HUGE] * 3, [HUGE, HUGE, 2.0])),
    "constants of a top": ("omega", lambda: top.heavy_constants(TOP, FAST, [1.0, 0.0, 0.0, 0.0])),
    "spin down": ("damping", lambda: top.spin_down(TOP, 9.0, damping=1e-320)),
    "points": ("points", lambda: inertia.point_masses([1.0] * 2, [FAST, [0.0] * 3])),
    "tensor": ("points", lambda: inertia.inertia_tensor([1.0], [FAST])),
    "parallel axes": ("shift", lambda: inertia.steiner(np.eye(3), 1.0, FAST)),
    "transport": ("vector", lambda: frames.transport(FAST, FAST, [1e200] * 3)),
    "rotating frame": (
        "omega",
        lambda: frames.rotating_frame(FAST[:1] * 3, FAST[:1] * 3, omega=FAST),
    ),
    "totals": ("velocities", lambda: particles.particle_totals([1.0], [[1.0] * 3], [FAST])),
    "König": ("velocities", lambda: particles.split_com([1.0], [[1.0] * 3], [FAST])),
    "velocity field": ("omega", lambda: particles.velocity_field([FAST], [HUGE] * 3)),
    "screw": ("translation", lambda: particles.screw(rotations.rotation_z(1e-9), FAST)),
    "displacement": ("after", lambda: particles.rigid_motion(np.eye(3), HUGE * np.eye(3))),
    "freedom": ("positions", lambda: particles.degrees_of_freedom(HUGE * np.eye(3))),
    "distances": ("positions", lambda: particles.rigidity_residual([HUGE * np.eye(3)])),
    "energy": ("omega", lambda: inertia.rotational_energy(FAST, SOLID)),
    "momentum": ("inertia", lambda: inertia.angular_momentum([1e200] * 3, HUGE * np.eye(3))),
    "rates": ("momentum", lambda: inertia.omega_from_momentum(FAST, 1e-200 * np.eye(3))),
    "bearings": ("omega", lambda: fixed_axis.bearing_torques(np.eye(3), HUGE)),
    "balance": ("com", lambda: fixed_axis.balance_test(np.eye(3), mass=1.0, com=FAST)),
    "frame of the axis": ("spin", lambda: free.steady_axis_frame((1.0, 1.0, 1.0001), 1e307)),
    "mean": ("a", lambda: exact.agm(HUGE, 1e-300)),
    "Jacobian": ("factors", lambda: free.jacobian([HUGE] * 3, FAST)),
    "springs": (
        "positions",
        lambda: springs.pair_system([1.0] * 2, [[0.0] * 3, FAST], stiffness=1.0),
    ),
    "stiff springs": (
        "stiffness",
        lambda: springs.spring_body([1.0] * 3, np.eye(3), [0.0, 0.0, 1.0], stiffness=HUGE, t=[1.0]),
    ),
    "orthogonality": ("matrix", lambda: rotations.orthogonality_error(HUGE * np.eye(3))),
    "starts of an energy": (
        "energy",
        lambda: top.on_surface(TOP, energy=1e308, l_gamma=0.4, count=1),
    ),
    "starts of a momentum": (
        "l_gamma",
        lambda: top.on_surface(TOP, energy=2.0, l_gamma=HUGE, count=1),
    ),
    "sampled rates": (
        "omega",
        lambda: rotations.attitude_from_samples([[1e-308] * 3] * 8, np.arange(8) * 1e160),
    ),
}


@pytest.mark.parametrize("name", OVERFLOWS)
def test_an_overflow_is_refused_by_the_argument_that_is_out_of_range(name: str) -> None:
    argument, call = OVERFLOWS[name]
    with pytest.raises(ValueError, match=f"^{argument} = .*range of doubles; count in other"):
        call()


OTHERS: list[Any] = [rigid.FreeBody(SOLID), 0.2, [1.0], np.ones(3)]


@pytest.mark.parametrize(
    ("words", "call"),
    [
        ("scene = ", lambda: top.effective_minimum(OTHERS[0], a=1.0, b=2.0)),
        ("region = 0.2: must be a rigid.solids.", lambda: solids.density_integral(1.0, OTHERS[1])),
        (r"parts\[0\] = 1.0: must be rigid.inertia.", lambda: inertia.compose(OTHERS[2])),
        ("run = array.*: must be a rigid.Run", lambda: figures.poinsot(OTHERS[3])),
    ],
)
def test_other_objects_are_refused_as_what_they_are(words: str, call: Callable[[], Any]) -> None:
    with pytest.raises(TypeError, match=f"^{words}"):
        call()
