"""The cases of ``result_hashes.py`` that belong to the textbook modules.

All of them go through functions of NumPy that may differ between machines.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import rigid
from rigid import (
    earth,
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

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
BOX = rigid.Body.box(0.01, 0.08, 0.25, mass=0.3)
BODY = rigid.Body((1.0, 2.0, 2.5))
OMEGA = np.array([[1.1, 0.3, 0.4], [0.02, 1.0, 0.02], [0.0, 0.0, 3.0], [-1.0, 2.0, -0.5]])
QUATERNIONS = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.9, 0.3, -0.2, 0.1], [-3.0, 1.0, 4.0, 2.0], [0.3, -0.1, 0.7, 0.2]]
)
"""Not of length one, but for the first: functions that take attitudes normalise them."""

TILTED = [np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0, 0.0]
CONSTANTS = {"a": 1.25, "b": 2.5, "alpha": 1.0, "beta": 2.0}
ANGLES = np.array([[0.3, 1.1, -0.4], [2.0, 0.2, 5.0], [0.3, 0.0, 0.5]])
VECTORS = np.array([[1.0, 2.0, 3.0], [-0.3, 0.2, 0.1], [3e-12, 0.0, -4e-12]])
CORNER = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
UNEVEN = [[2.0, 0.3, -0.5], [0.3, 2.5, 0.1], [-0.5, 0.1, 1.5]]
TIMES = np.linspace(0.0, 9.0, 31)


def textbook_cases() -> Iterator[tuple[str, Callable[[], Any]]]:
    """Name and function of each case."""
    for group in (_rotations, _free, _top, _bodies, _figures):
        for name, compute in group().items():
            kind = "attitude" if name.endswith("attitude") else "machine"
            yield f"{kind}/{name}", compute


def _run(scene: Any = None, **options: Any) -> rigid.Run:
    scene = rigid.FreeBody(BODY) if scene is None else scene
    return rigid.simulate(scene, [1.1, 0.3, 0.4], t=TIMES, **options)


def _rotations() -> dict[str, Callable[[], Any]]:
    r = rotations
    matrices = r.euler_to_matrix(ANGLES)
    return {
        "rotations/elementary": lambda: [
            turn(VECTORS[0], passive=passive)
            for turn in (r.rotation_x, r.rotation_y, r.rotation_z)
            for passive in (False, True)
        ],
        "rotations/axis_angle": lambda: [
            r.axis_angle_matrix([1, 1, 1], 0.7),
            r.rotate(VECTORS, [0.0, 0.6, 0.8], 0.7),
        ],
        "rotations/so3": lambda: [
            r.hat(VECTORS),
            r.vee(r.hat(VECTORS)),
            r.exp_so3(VECTORS),
            r.log_so3(r.exp_so3(VECTORS)),
            r.exp_quaternion(VECTORS),
            r.orthogonality_error(1.001 * matrices),
            r.nearest_rotation(1.001 * matrices + 1e-3),
        ],
        "rotations/euler": lambda: [
            matrices,
            r.matrix_to_euler(matrices),
            r.euler_to_quaternion(ANGLES),
            r.euler_axes(ANGLES),
            r.omega_from_euler_rates(ANGLES, VECTORS),
            r.euler_rates_from_omega(ANGLES, VECTORS, least_norm=True),
        ],
        "rotations/matrix_to_quaternion": lambda: r.matrix_to_quaternion(matrices),
        "rotations/quaternion_product": lambda: r.quaternion_product(
            QUATERNIONS, QUATERNIONS[::-1]
        ),
        "rotations/quaternion_to_matrix/attitude": lambda: r.quaternion_to_matrix(QUATERNIONS),
        "rotations/canonical_quaternion/attitude": lambda: r.canonical_quaternion(QUATERNIONS),
        "rotations/log_quaternion/attitude": lambda: r.log_quaternion(QUATERNIONS),
        "rotations/quaternion_to_euler/attitude": lambda: r.quaternion_to_euler(QUATERNIONS),
        "rotations/omega_from_attitudes/attitude": lambda: r.omega_from_attitudes(
            _run().attitude, TIMES
        ),
        "rotations/attitude_from_omega/attitude": lambda: r.attitude_from_omega(
            lambda t: np.stack([np.cos(3 * t), np.sin(3 * t), 0 * t + 2.0], axis=-1),
            [0.0, 1.0, 2.0],
            QUATERNIONS[1],
        ),
    }


def _free() -> dict[str, Callable[[], Any]]:
    symmetric = (1.0, 1.0, 1.6)
    return {
        "free/euler_rhs": lambda: free.euler_rhs(BODY, OMEGA, torque=[0.1, 0.2, 0.3]),
        "free/euler_rhs/attitude": lambda: free.euler_rhs(
            BODY, OMEGA, torque=[0.1, 0.2, 0.3], attitude=QUATERNIONS, frame="space"
        ),
        "free/invariants/attitude": lambda: [free.invariants(_run()), free.invariants(_run(TOP))],
        "free/power_balance/attitude": lambda: [
            free.power_balance(_run()),
            free.power_balance(_run(TOP)),
        ],
        "free/cones": lambda: free.cones(symmetric, OMEGA[0]),
        "free/cones/attitude": lambda: free.cones(symmetric, OMEGA[0], QUATERNIONS[2]),
        "free/poinsot/attitude": lambda: free.poinsot(BODY, _run().omega, _run().attitude),
        "free/permanent_rotation": lambda: [
            free.permanent_rotation(BOX, axis, 2.0) for axis in (1, 2, 3)
        ],
        "free/gammas": lambda: [free.gammas(BOX), free.gamma_residual([0.8, -1.0, 0.9])],
        "free/local_stability": lambda: [
            free.jacobian(free.gammas(BOX), OMEGA),
            free.local_stability(free.gammas(BOX), OMEGA),
        ],
        "free/circulation": lambda: free.circulation(BOX, OMEGA),
        "free/crossings": lambda: free.crossings(BODY, OMEGA[:2], count=4),
        "free/throw_experiment": lambda: free.throw_experiment(BOX, [0.05, 0.05, 0.05]),
        "free/symmetric_free_top": lambda: _evaluated(free.symmetric_free_top(symmetric, OMEGA[0])),
        "free/symmetric_free_top/attitude": lambda: _evaluated(
            free.symmetric_free_top(symmetric, OMEGA[0], QUATERNIONS[3], t=TIMES)
        ),
        "free/asymmetric_free_top": lambda: _evaluated(free.asymmetric_free_top(BODY, OMEGA[0])),
        "free/asymmetric_free_top/attitude": lambda: _evaluated(
            free.asymmetric_free_top(BODY, OMEGA[0], QUATERNIONS[3], t=TIMES)
        ),
        "free/steady_axis": lambda: [
            free.steady_axis_frame((1.0, 1.0, 1.5), [-1.0, 2.0], 0.4),
            free.steady_axis_spin((1.0, 1.0, 1.5), [0.2, 0.0, 3.0]),
        ],
    }


def _evaluated(motion: Any) -> Any:
    """A motion with its states at some times, however it gives them."""
    names = [name for name in dir(motion) if not name.startswith("_")]
    values = {name: getattr(motion, name) for name in names}
    plain = {name: value for name, value in values.items() if not callable(value)}
    called = {name: value(TIMES) for name, value in values.items() if callable(value)}
    return [{n: v for n, v in plain.items() if not isinstance(v, rigid.Body)}, called]


def _top() -> dict[str, Callable[[], Any]]:
    spun = [0.0, -0.26, 5.0]
    return {
        "top/heavy_constants/attitude": lambda: [
            top.heavy_constants(TOP, spun, TILTED),
            top.heavy_constants(TOP, OMEGA, QUATERNIONS),
        ],
        "top/gravity_torque/attitude": lambda: [
            top.gravity_torque(TOP, QUATERNIONS, frame=frame) for frame in ("space", "body")
        ],
        "top/precession_spin_rates": lambda: top.precession_spin_rates(TOP, 0.4, a=2.5, b=2.0),
        "top/cubic": lambda: [
            top.f_u([-0.5, 0.5, 0.9], **CONSTANTS),
            top.f_roots(**CONSTANTS),
            top.nutation_period(**CONSTANTS),
            top.time_of([0.2, 0.5], **CONSTANTS),
            top.u_of(TIMES, **CONSTANTS),
        ],
        "top/classify_locus/attitude": lambda: top.classify_locus(TOP, [spun, OMEGA[0]], TILTED),
        "top/advance/attitude": lambda: top.advance(TOP, spun, TILTED),
        "top/locus/attitude": lambda: top.locus(TOP, spun, TILTED, t=TIMES),
        "top/fast_top_approx": lambda: top.fast_top_approx(TOP, 1.0, 5.0),
        "top/potential": lambda: [
            top.effective_potential(TOP, [0.2, 1.0], a=2.5, b=2.0),
            top.effective_minimum(TOP, a=1.25, b=2.5),
            top.turning_angles(TOP, a=1.25, b=2.5, E_prime=0.5),
        ],
        "top/steady": lambda: [
            top.steady_precession(TOP, [0.2, 1.0], 5.0),
            top.sleeping_top(TOP, [3.9, 4.0, -4.1]),
            top.upright_f(TOP, 4.0, [0.5, 0.9]),
            top.spin_down(TOP, 8.0, damping=0.05),
        ],
    }


def _bodies() -> dict[str, Callable[[], Any]]:
    masses = [1.0, 2.0, 3.0, 0.5]
    solid = [
        lambda: solids.box(0.1, 0.2, 0.3, mass=2.0),
        lambda: solids.cone(0.1, 0.3, mass=2.0),
        lambda: solids.cylinder(0.1, 0.3, mass=2.0),
        lambda: solids.ellipsoid(0.1, 0.2, 0.3, mass=2.0),
        lambda: solids.sphere(0.1, mass=2.0),
        lambda: solids.rod(2.0, mass=3.0),
    ]
    return {
        "bodies/solids": lambda: [make() for make in solid],
        "bodies/inertia": lambda: [
            inertia.inertia_tensor(masses, CORNER),
            inertia.point_masses(masses, CORNER),
            inertia.compose(
                [solids.sphere(0.1, mass=1.0).placed([0, 0, 1]), solids.rod(1.0, mass=1.0)]
            ),
            inertia.steiner(UNEVEN, 2.0, [0.0, 0.1, 3.0]),
            inertia.rotate_tensor(rotations.rotation_z(0.4), UNEVEN),
            inertia.principal_axes(UNEVEN),
            inertia.classify_body([1.0, 2.0, 1.0]),
            inertia.symmetry_check(CORNER),
        ],
        "bodies/momentum": lambda: [
            inertia.rotational_energy(OMEGA, BODY.moments),
            inertia.kinetic_energy(OMEGA, BODY.moments, 3.0, VECTORS[0]),
            inertia.angular_momentum(OMEGA, BODY.moments),
            inertia.omega_from_momentum(OMEGA, BODY.moments),
            inertia.energy_from_momentum(OMEGA, BODY.moments),
        ],
        "bodies/particles": lambda: [
            particles.particle_totals(masses, CORNER, CORNER[::-1]),
            particles.split_com(masses, CORNER, CORNER[::-1]),
            particles.velocity_field(VECTORS[0], CORNER, velocity=VECTORS[1]),
            particles.fit_omega(CORNER, np.cross(VECTORS[0], CORNER)),
            particles.rigid_motion(CORNER, CORNER[:, [2, 0, 1]] + [5, 0, 0]),
            particles.screw(rotations.rotation_z(0.4), [1, 1, 3]),
            particles.degrees_of_freedom(CORNER),
            particles.rigidity_residual([CORNER, 1.1 * CORNER]),
        ],
        "bodies/propagate_body": lambda: _path(
            particles.propagate_body(
                BOX, [0, 0, 1], [2, 0, 5], [0, 10, 0.01], force=[0.0, 0.0, -2.9], t=[0.0, 0.5, 1.0]
            )
        ),
        "bodies/springs": lambda: [
            springs.pair_system([1.0, 3.0], [[0, 0, 0], [2, 0, 0]], stiffness=12.0).modes(),
            springs.spring_body(np.ones(4), CORNER, [0, 1, 0.3], stiffness=1e3, t=[0.0, 1.0]),
        ],
        "bodies/statics": lambda: [
            statics.equilibrium(VECTORS, CORNER[1:]),
            statics.equilibrant(VECTORS, CORNER[1:]),
            statics.wrench(VECTORS, CORNER[1:]),
        ],
        "bodies/fixed_axis": lambda: [
            fixed_axis.bearing_torques(UNEVEN, omega=10.0, omega_dot=2.0),
            fixed_axis.bearing_forces(2.0, [0.1, 0.0, 5.0], omega=10.0),
            fixed_axis.balance_test(UNEVEN, mass=10.0, com=[0.1, 0, 0]),
        ],
        "bodies/frames": lambda: [
            frames.rotating_frame([2, 0, 0], [0, 6, 0], [-18, 0, 0], omega=[0, 0, 3]),
            frames.transport([1, 0, 0], [0, 0, 0], omega=[0, 0, 2]),
            frames.fictitious_forces(70.0, [2, 0, 0], [0, -1, 0], omega=[0, 0, 3]),
            frames.earth_frame(0.8),
        ],
        "bodies/earth": lambda: [
            earth.rotation_rate(),
            earth.ellipsoid_moments(1.0, 2.0, mass=5.0),
            earth.ellipticity(6356752.3, 6378137.0),
            earth.wobble(0.00329, 7.29e-5, 1e-6),
        ],
    }


def _path(path: particles.BodyPath) -> Any:
    run = path.rotation  # without its measured time
    return [path.t, path.position, path.velocity, run.omega, run.attitude, run.error]


def _figures() -> dict[str, Callable[[], Any]]:
    f = figures
    symmetric = (1.0, 1.0, 1.6)
    cubic = (TOP, [0.0, 0.0, 5.0], TILTED)
    return {
        "figures/bodies/attitude": lambda: [f.box(BOX), f.heavy_top(TOP, ANGLES[0])],
        "figures/cones/attitude": lambda: f.cones(symmetric, OMEGA[0], t=1.0),
        "figures/cubic/attitude": lambda: f.cubic(*cubic),
        "figures/upright_cubic": lambda: f.upright_cubic(TOP),
        "figures/euler_steps": lambda: f.euler_steps(ANGLES[0]),
        "figures/polhodes": lambda: f.polhodes(BODY),
        "figures/bearing_torque": lambda: f.bearing_torque(UNEVEN, 10.0),
        "figures/frames": lambda: [f.frames(ANGLES[0]), f.node_frame(ANGLES[0])],
        "figures/locus/attitude": lambda: f.locus(*cubic),
        "figures/effective_potential/attitude": lambda: f.effective_potential(*cubic),
        "figures/poinsot/attitude": lambda: f.poinsot(_run(), frame=10),
        "figures/rotating_body": lambda: f.rotating_body(CORNER, VECTORS[0]),
        "figures/free_top_omega": lambda: f.free_top_omega(symmetric, OMEGA[0], t=1.0),
        "figures/coplanar_vectors": lambda: f.coplanar_vectors([symmetric], OMEGA[0]).tops,
        "figures/invariants/attitude": lambda: f.invariants(_run(method="rk4")),
        "figures/active_passive": lambda: f.active_passive(0.3),
        "figures/unit_vector_change": lambda: f.unit_vector_change(0.3),
        "figures/cycloids/attitude": lambda: f.cycloids(TOP, 1.0, 40.0),
    }
