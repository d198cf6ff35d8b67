"""Particles joined by springs: small oscillations, and the limit of the rigid body."""

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from physics import ROUNDOFF, Floats
from refusals import refuses
from rigid import particles, springs

#: Five particles in no special place, with unequal masses.
_RNG = np.random.default_rng(8)
FIVE = _RNG.normal(size=(5, 3))
MASSES = _RNG.uniform(0.5, 3.0, 5)

#: The four particles of the table of stiff springs.
FOUR = np.array([[1.0, 0, 0], [-0.6, 0.9, 0], [-0.5, -0.8, 0.1], [0.1, 0.1, 1.1]])
FOUR_MASSES = np.array([1.0, 1.4, 0.8, 1.2])
SPIN = np.array([0.4, 1.0, -0.3])


def morse(distance: Floats) -> tuple[Floats, Floats, Floats]:
    """A molecule's potential, of depth 2 and range 1/1.3 about the distance 1.5."""
    decay = np.exp(-1.3 * (distance - 1.5))
    energy = 2.0 * (1.0 - decay) ** 2
    return energy, 5.2 * (1.0 - decay) * decay, 6.76 * (2.0 * decay - 1.0) * decay


LAWS = {
    "springs at rest": springs.pair_system(MASSES, FIVE, stiffness=2.5),
    "stretched springs": springs.pair_system(MASSES, FIVE, stiffness=2.5, rest=0.4),
    "morse": springs.pair_system(MASSES, FIVE, law=morse),
    "a chain": springs.pair_system(
        MASSES, FIVE, pairs=[[0, 1], [1, 2], [3, 2], [3, 4]], stiffness=[1, 2, 3, 4], rest=1.0
    ),
}
LAW = pytest.mark.parametrize("system", LAWS.values(), ids=LAWS.keys())


def central_difference(function: Callable[[Floats], Any], at: Floats, step: float) -> Floats:
    """Fourth order in each coordinate, the coordinate along the last axis."""

    def along(k: int) -> Floats:
        e = np.zeros(at.size)
        e[k] = step
        shift = e.reshape(at.shape)
        near = np.asarray(function(at + shift)) - function(at - shift)
        far = np.asarray(function(at + 2 * shift)) - function(at - 2 * shift)
        return np.asarray((8.0 * near - far) / (12.0 * step))

    return np.stack([along(k) for k in range(at.size)], axis=-1)


def test_particles_keep_their_places_when_the_arrays_of_the_caller_change() -> None:
    masses, places = MASSES.copy(), FIVE.copy()
    system = springs.pair_system(masses, places, stiffness=1.0)
    masses[:], places[:] = 9.0, 0.0
    assert np.array_equal(system.masses, MASSES)
    assert np.array_equal(system.positions, FIVE)


@LAW
def test_energy_is_the_sum_over_pairs(system: springs.PairSystem) -> None:
    x = FIVE + 0.05 * np.sin(np.arange(15.0)).reshape(5, 3)
    total = 0.0
    for pair, (i, j) in enumerate(system.pairs):
        distances = np.full(len(system.pairs), np.linalg.norm(x[i] - x[j]))
        total += system.law(distances)[0][pair]
    assert system.energy(x) == pytest.approx(total, rel=1e-14)


@LAW
def test_forces_and_stiffness_are_derivatives(system: springs.PairSystem) -> None:
    x = FIVE + 0.05 * np.sin(np.arange(15.0)).reshape(5, 3)
    # Step 1e-3: truncation about step⁴ = 1e-12, rounding 1e-16/1e-3, times the size of the terms.
    forces = -central_difference(system.energy, x, 1e-3)
    np.testing.assert_allclose(system.forces(x).ravel(), forces, atol=1e-9 * np.abs(forces).max())
    hessian = -central_difference(lambda at: system.forces(at).ravel(), x, 1e-3)
    np.testing.assert_allclose(system.hessian(x), hessian, atol=1e-8 * np.abs(hessian).max())
    # Internal forces: no sum, no torque about any point.
    totals = particles.particle_totals(MASSES, x, np.zeros((5, 3)), system.forces(x))
    assert np.abs(totals.force).max() < 1e-13 * np.abs(forces).max()
    assert np.abs(totals.torque).max() < 1e-13 * np.abs(forces).max() * 3.0


def test_many_configurations_at_once() -> None:
    system = LAWS["morse"]
    x = FIVE + 0.1 * np.random.default_rng(1).normal(size=(2, 3, 5, 3))
    assert system.energy(x).shape == (2, 3)
    assert system.hessian(x).shape == (2, 3, 15, 15)
    np.testing.assert_allclose(system.forces(x)[1, 2], system.forces(x[1, 2]), rtol=1e-12)
    np.testing.assert_allclose(
        system.hessian(x)[1, 2],
        system.hessian(x[1, 2]),
        atol=1e-12 * np.abs(system.hessian()).max(),
    )
    assert system.forces(x[:0]).shape == (0, 3, 5, 3)
    assert springs.pair_system([1, 1], np.eye(3)[:2], stiffness=1.0).modes(
        np.zeros((0, 2, 3))
    ).zero.shape == (0,)


# Modes


def test_six_squared_frequencies_vanish_and_nine_are_positive() -> None:
    """Not all of them are positive, as printed: a body of springs can be shifted and turned."""
    modes = springs.pair_system(MASSES, FIVE, stiffness=1.0).modes()
    assert modes.zero == 6
    assert (np.abs(modes.omega_squared[:6]) < 1e-12).all()
    assert (modes.omega_squared[6:] > 1e-3).all()
    # The six are the shifts and the turns: they lie in the space of the modes without frequency.
    zero = modes.shapes[:6].reshape(6, 15)
    for velocity, omega in zip(np.eye(6)[:, :3], np.eye(6)[:, 3:], strict=True):
        field = particles.velocity_field(omega, FIVE, velocity=velocity).ravel()
        weighted = np.repeat(MASSES, 3) * field
        np.testing.assert_allclose(zero.T @ (zero @ weighted), field, atol=1e-10)


def test_modes_are_normal_and_diagonal() -> None:
    system = springs.pair_system(MASSES, FIVE, stiffness=1.7)
    modes = system.modes()
    flat = modes.shapes.reshape(15, 15)
    gram = np.einsum("an,bn,n->ab", flat, flat, np.repeat(MASSES, 3))
    np.testing.assert_allclose(gram, np.eye(15), atol=1e-13)
    values = flat @ system.hessian() @ flat.T
    np.testing.assert_allclose(values, np.diag(modes.omega_squared), atol=1e-12)


def test_frequencies_are_those_of_the_mass_weighted_matrix() -> None:
    """The eigenvalues of the second derivatives alone, as printed, are not the frequencies."""
    system = springs.pair_system(MASSES, FIVE, stiffness=1.0)
    printed = np.linalg.eigvalsh(system.hessian())[-1]
    assert system.modes().omega_squared[-1] == pytest.approx(3.255, abs=5e-4)
    assert printed == pytest.approx(5.0, abs=5e-4)
    # Equal masses: only then does one follow from the other.
    equal = springs.pair_system(np.full(5, 2.0), FIVE, stiffness=1.0).modes()
    assert equal.omega_squared[-1] == pytest.approx(printed / 2.0, rel=1e-13)


def test_two_particles_swing_with_their_reduced_mass() -> None:
    modes = springs.pair_system([1.0, 3.0], FIVE[:2], stiffness=12.0).modes()
    assert modes.zero == 5
    assert modes.omega_squared[-1] == pytest.approx(12.0 / 0.75, rel=8 * ROUNDOFF)
    assert modes.stiff_step == pytest.approx(np.sqrt(0.75 / 12.0), rel=8 * ROUNDOFF)


def test_a_line_held_straight_has_five_modes_without_frequency() -> None:
    # Tension between neighbours against pressure between the ends: an equilibrium that resists
    # bending. 1 and 2, 2 and 3 pull with 0.5; 1 and 3 push with 0.5.
    line = np.array([[-1.0, 0, 0], [0, 0, 0], [1, 0, 0]])
    held = springs.pair_system([1.0, 2.0, 1.0], line, stiffness=1.0, rest=[0.5, 2.5, 0.5])
    assert np.abs(held.forces()).max() < 4 * ROUNDOFF
    modes = held.modes()
    assert modes.zero == 5
    assert (modes.omega_squared[5:] > 0.1).all()
    # Across, the middle moves against the ends, each pull T giving T/d of the distance between:
    # w² = 2 (T/d) (1/m_middle + 1/(2 m_end)).
    assert modes.omega_squared[5] == pytest.approx(2.0 * 0.5 * (1.0 / 2.0 + 1.0 / 2.0), rel=1e-12)
    # A single particle has its three shifts, and springs without stiffness resist nothing.
    assert springs.pair_system([2.0], [[1.0, 2, 3]], stiffness=1.0).modes().zero == 3
    nothing = springs.pair_system(MASSES, FIVE, stiffness=0.0).modes()
    assert nothing.zero == 15
    assert springs.pair_system(MASSES, FIVE, stiffness=1.0, pairs=[]).modes().zero == 15
    assert nothing.stiff_step == np.inf
    # Springs at rest do not resist bending at all, and under pressure the line buckles.
    slack = springs.pair_system(np.ones(5), np.arange(5.0)[:, None] * [1, 0, 0], stiffness=1.0)
    assert slack.modes().zero == 11
    pressed = springs.pair_system([1.0, 2.0, 1.0], line, stiffness=1.0, rest=[1.5, 1.5, 1.5])
    np.testing.assert_allclose(pressed.modes().omega_squared[:2], -1.0, rtol=1e-12)


def test_a_plane_of_springs_folds_to_first_order() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    system = springs.pair_system(np.ones(4), square, stiffness=1.0)
    modes = system.modes()
    free = particles.degrees_of_freedom(square)
    assert modes.zero == free.first_order == 7


def test_modes_of_a_molecule_at_its_minimum() -> None:
    system = springs.pair_system(np.ones(4), FOUR, law=morse)
    best = minimize(
        lambda x: float(system.energy(x.reshape(4, 3))),
        FOUR.ravel(),
        jac=lambda x: -system.forces(x.reshape(4, 3)).ravel(),
        method="BFGS",
        options={"gtol": 1e-11},
    )
    modes = system.modes(best.x.reshape(4, 3))
    # A regular tetrahedron of edge 1.5: w²/k = 4 (breathing), 2 (three times), 1 (twice).
    assert modes.zero == 6
    np.testing.assert_allclose(modes.omega_squared[6:] / 6.76, [1, 1, 2, 2, 2, 4], rtol=1e-8)


# The rigid limit

#: Stiffness: largest coordinate of the distance from the rigid body after 3 s, to the digits given.
TABLE = {1e2: 4.0e-2, 1e3: 3.9e-3, 1e4: 3.8e-4}


def test_springs_approach_the_rigid_body_as_one_over_their_stiffness() -> None:
    paths = {
        k: springs.spring_body(FOUR_MASSES, FOUR, SPIN, stiffness=k, t=[0.0, 1.5, 3.0], rtol=1e-8)
        for k in TABLE
    }
    for k, printed in TABLE.items():
        apart = np.abs(paths[k].positions - paths[k].rigid)[-1].max()
        # Half a unit of the last digit printed.
        assert apart == pytest.approx(printed, abs=0.5 * 10 ** (np.floor(np.log10(printed)) - 1))
        assert paths[k].distance[0] < 1e-14
        # The springs stretch by about m w² r / k: what makes them no rigid body.
        residual = particles.rigidity_residual(paths[k].positions)
        assert 0.1 / k < residual.max() < 10.0 / k
        assert particles.rigidity_residual(paths[k].rigid).max() < 1e-14
    ends = np.array([paths[k].distance[-1] for k in TABLE])
    np.testing.assert_allclose(ends[:-1] / ends[1:], 10.0, atol=0.5)


def test_a_stiff_step_is_the_root_of_mass_over_stiffness() -> None:
    steps, calls = [], []
    for k in (1e2, 1e3, 1e4, 1e5):
        # With so coarse a tolerance the stability of the method decides, not its error.
        path = springs.spring_body(FOUR_MASSES, FOUR, SPIN, stiffness=k, t=[3.0], rtol=1e-3)
        steps.append(path.stiff_step)
        calls.append(path.evaluations)
        # A step of DOP853 takes 12 evaluations: some stiff steps each, whatever the stiffness.
        assert 1.0 < 3.0 / (path.evaluations / 12) / path.stiff_step < 8.0
    np.testing.assert_allclose(np.array(steps) * np.sqrt([1e2, 1e3, 1e4, 1e5]), 10 * steps[0])
    # sqrt(m / k) to a factor of order one: 3 to 4 springs pull at each particle.
    assert 0.3 < 10.0 * steps[0] / np.sqrt(FOUR_MASSES.min()) < 1.0
    assert calls[-1] > 10 * calls[0]
    heavy = springs.spring_body(4 * FOUR_MASSES, FOUR, SPIN, stiffness=1e2, t=[0.1])
    assert heavy.stiff_step == pytest.approx(2 * steps[0], rel=1e-13)


def test_a_drifting_body_of_springs_is_the_same_in_its_own_frame() -> None:
    options: dict[str, Any] = {"stiffness": 1e3, "t": [0.5, 1.0]}
    at_rest = springs.spring_body(FOUR_MASSES, FOUR, SPIN, **options)
    moving = springs.spring_body(FOUR_MASSES, FOUR, SPIN, velocity=[3.0, 0.0, -1.0], **options)
    drift = np.array([0.5, 1.0])[:, None, None] * [3.0, 0.0, -1.0]
    np.testing.assert_allclose(moving.rigid, at_rest.rigid + drift, atol=1e-14)
    np.testing.assert_allclose(moving.positions, at_rest.positions + drift, atol=1e-14)


# Refusals


LINE = np.arange(3.0)[:, None] * [1.0, 0.0, 0.0]
EITHER = "stiffness, rest, law:"


def lennard_jones(d: Floats) -> tuple[Floats, Floats, Floats]:
    """Depth one at the distance one."""
    near, far = d**-12.0, 2.0 * d**-6.0
    return near - far, (6.0 * far - 12.0 * near) / d, (156.0 * near - 42.0 * far) / d**2


def coulomb(d: Floats) -> tuple[Floats, Floats, Floats]:
    return 1.0 / d, -1.0 / d**2, 2.0 / d**3


def attraction(d: Floats) -> tuple[Floats, Floats, Floats]:
    return -1.0 / d, 1.0 / d**2, -2.0 / d**3


@pytest.mark.parametrize(
    ("count", "least"), [(2, -1.0), (3, -3.0), (4, -6.0), (5, -9.103852), (7, -16.505384)]
)
def test_clusters_of_atoms_come_to_rest(count: int, least: float) -> None:
    """Least energies of the Cambridge Cluster Database (D. J. Wales and J. P. K. Doye 1997)."""
    rng = np.random.default_rng(count)
    energies = []
    for _ in range(8):
        start = 0.8 * count ** (1.0 / 3.0) * rng.normal(size=(count, 3))
        cluster = springs.pair_system(np.ones(count), start, law=lennard_jones)
        found = cluster.equilibrium()
        modes = cluster.modes(found)  # refuses positions where a force acts
        assert int(modes.zero) == (5 if count == 2 else 6)
        assert (modes.omega_squared[int(modes.zero) :] > 0.0).all()
        # Forces of pairs have no sum.
        assert np.abs(found.mean(axis=0) - start.mean(axis=0)).max() < 1e-12
        energies.append(float(cluster.energy(found)))
    assert min(energies) == pytest.approx(least, abs=5e-7)
    # An independent search from the last start ends no lower than the least.
    other = minimize(lambda r: cluster.energy(r.reshape(-1, 3)), found.ravel(), method="BFGS")
    assert other.fun == pytest.approx(energies[-1], abs=1e-9)


def test_a_saddle_is_left_for_the_minimum() -> None:
    """Three atoms on a line feel no force across the line, but a triangle has less energy."""
    start = np.array([0.0, 1.1, 2.3])[:, np.newaxis] * [1.0, 0.0, 0.0]
    row = springs.pair_system([1.0] * 3, start, law=lennard_jones)
    assert float(row.energy(row.equilibrium())) == pytest.approx(-3.0, abs=1e-12)


def test_a_law_divides_by_zero_as_its_user_says() -> None:
    def touching(d: Floats) -> tuple[Floats, Floats, Floats]:
        """Zero from a distance of 1 on, by the limit of 1 / (1 + 1 / 0)."""
        energy = 1.0 / (1.0 + 1.0 / np.maximum(1.0 - d, 0.0))
        return energy, 0.0 * d, 0.0 * d

    def fails(d: Floats) -> tuple[Floats, Floats, Floats]:
        raise OverflowError("own")

    with np.errstate(divide="ignore"):
        pair = springs.pair_system([1.0, 1.0], [[0.0] * 3, [2.0, 0.0, 0.0]], law=touching)
        assert pair.energy() == 0.0
    assert pair.law is touching
    with pytest.raises(OverflowError, match="own"):
        springs.pair_system([1.0, 1.0], [[0.0] * 3, [2.0, 0.0, 0.0]], law=fails)


def test_springs_that_break_are_not_torn_on_the_way_to_rest() -> None:
    """The energy -d - ln(1 - d) / 100 ends at d = 1, and is least at 0.99: a step goes beyond."""

    def brittle(d: Floats) -> tuple[Floats, Floats, Floats]:
        with np.errstate(invalid="ignore"):
            energy = -d - 0.01 * np.log(1.0 - d)
        return energy, 0.01 / (1.0 - d) - 1.0, 0.01 / (1.0 - d) ** 2

    pair = springs.pair_system([1.0, 2.0], [[0.0] * 3, [0.95, 0.0, 0.0]], law=brittle)
    assert np.ptp(pair.equilibrium(), axis=0)[0] == pytest.approx(0.99, rel=1e-12)


def test_a_triangle_that_springs_cannot_close_lies_on_a_line() -> None:
    """Rest lengths 1, 1, 3: each spring is off by 1/3, so the energy is 3 k/2 (1/3)²."""
    start = np.array([[0.0, 0.0, 0.0], [1.1, 0.0, 0.0], [2.3, 0.4, 0.0]])
    system = springs.pair_system([1.0, 3.0, 2.0], start, stiffness=10.0, rest=[1.0, 1.0, 3.0])
    found = system.equilibrium()
    assert float(system.energy(found)) == pytest.approx(10.0 / 6.0, abs=1e-13)
    assert np.linalg.svd(found - found.mean(axis=0), compute_uv=False)[1] < 1e-8
    alone = springs.pair_system([1.0], [[1.0, 2.0, 3.0]], stiffness=1.0)
    assert alone.equilibrium().tolist() == [[1.0, 2.0, 3.0]]


def test_springs_return_to_their_rest_lengths_to_rounding() -> None:
    """From seed 25 rounding of the forces on four particles did not end the steps."""
    rng = np.random.default_rng(25)
    rest = rng.normal(size=(4, 3))
    system = springs.pair_system(np.ones(4), rest, stiffness=1.0)
    found = system.equilibrium(rest + 0.05 * rng.normal(size=(4, 3)))
    now, before = (np.linalg.norm(r[:, None] - r, axis=-1) for r in (found, rest))
    # What rounding leaves of each of six forces, over the softest spring of a mode.
    left = 6.0 * 8.0 * np.finfo(float).eps * before.max() / system.modes(found).omega_squared[6]
    np.testing.assert_allclose(now, before, rtol=0.0, atol=left)


test_what_is_no_system_of_springs_is_refused = refuses(
    [
        ({"masses": [1.0, 0.0], "positions": FOUR[:2]}, "masses[1] = 0.0: must be positive"),
        ({"masses": [1.0], "positions": FOUR[:2]}, "masses: expected shape (2,), got (1,)"),
        (
            {"masses": [], "positions": np.zeros((0, 3))},
            "positions: expected shape (N, 3) of one or more, got (0, 3)",
        ),
        ({"stiffness": None}, "stiffness, law: give the stiffness of springs or a law"),
        ({"law": morse}, f"{EITHER} give stiffness and rest, or a law, not both"),
        ({"stiffness": None, "rest": 1.0, "law": morse}, f"{EITHER} give stiffness and rest, or"),
        ({"stiffness": -1.0}, "stiffness = -1.0: must not be negative"),
        ({"stiffness": [0, 1, -2, 0, 0, 0]}, "stiffness[2] = -2.0: must not be negative"),
        ({"stiffness": [1.0, 2.0]}, "stiffness: expected shape (6,), got (2,)"),
        ({"rest": float("inf")}, "rest = inf: must be finite"),
        ({"positions": 0.0 * FOUR}, "positions: points 0 and 1 coincide"),
        (
            {"stiffness": None, "law": lambda d: (np.nan * d, d, d)},
            "law: must return energy, first and second derivative of each distance, all finite",
        ),
    ],
    by=lambda given: springs.pair_system(
        **{"masses": np.ones(4), "positions": FOUR, "stiffness": 1.0, **given}
    ),
    literal=True,
)

SLACK = springs.pair_system(np.ones(3), LINE, stiffness=1.0)


test_a_call_of_such_a_system_is_refused = refuses(
    [
        (lambda: LAWS["morse"].forces(FOUR), "positions: expected 5 particles, got (4, 3)"),
        (
            lambda: LAWS["morse"].modes(),
            "positions: must be an equilibrium, where no force acts (equilibrium() finds one); th",
        ),
        (
            lambda: springs.pair_system([1.0] * 3, LINE, law=coulomb).equilibrium(),
            "positions: no equilibrium was found; the particles fly apart, to ",
        ),
        (
            lambda: springs.pair_system([1.0] * 3, LINE, law=attraction).equilibrium(),
            "positions: no equilibrium was found in 500 steps; the largest force is ",
        ),
        (
            lambda: SLACK.equilibrium([LINE, LINE]),
            "positions: expected shape (N, 3), got (2, 3, 3)",
        ),
    ],
    literal=True,
)


LOOSE = "positions, pairs: the springs leave 7 coordinates to first order"

test_what_does_not_become_a_rigid_body_is_refused = refuses(
    [
        ({"masses": np.ones(3), "positions": LINE}, f"{LOOSE}, a rigid body has 6"),
        ({"pairs": list(combinations(range(4), 2))[1:]}, LOOSE),
        ({"t": [-1.0, 1.0]}, "t, shape (2,): the springs start at t = 0"),
    ],
    by=lambda given: springs.spring_body(
        **{
            **{"masses": FOUR_MASSES, "positions": FOUR, "omega": SPIN},
            **{"stiffness": 1.0, "t": [1.0], **given},
        }
    ),
    literal=True,
)
