"""States in arrays of the user, and in single precision."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rigid
from physics import METHODS, Floats, gamma_of, present
from refusals import refuses
from rigid.model.bodies import bodies_of
from rigid.model.scene import Scene
from rigid.solve.request import Request

FREE = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
SLOWED = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)), damping=(0.1, 0.2, 0.3))
RNG = np.random.default_rng(4)
OMEGA = RNG.normal(size=(40, 3))
TIMES = [0.0, 0.7, 2.0]
ULP = 2.0**-24
"""Relative rounding to single precision."""

CASES: list[tuple[Scene, dict[str, Any]]] = [
    (FREE, {}),
    (FREE, {"record": "rates"}),
    (TOP, {"method": "taylor12"}),
    (TOP, {"method": "rk4", "record": "axis", "check": False}),
    (TOP, {"accuracy": 1e-5}),
    (SLOWED, {"method": "taylor16", "tolerance": 1e-10}),
]

ENERGETIC = ("energy", "momentum")
MANY = rigid.Body(RNG.uniform(1.0, 1.9, (40, 3)))

NAMES = {"omega": 3, "gamma": 3, "attitude": 4, "work": 1}


def arrays(run: rigid.Run) -> dict[str, np.ndarray]:
    found = {name: getattr(run, name) for name in NAMES}
    return {name: array for name, array in found.items() if array is not None}


@pytest.mark.parametrize("single_body", [False, True])
@pytest.mark.parametrize(("scene", "options"), CASES)
def test_given_arrays_are_filled_with_the_bits_of_new_ones(
    scene: Scene, options: dict[str, Any], single_body: bool
) -> None:
    omega = OMEGA[0] if single_body else OMEGA
    run = rigid.simulate(scene, omega, t=TIMES, **options)
    out = {name: np.full_like(array, np.nan) for name, array in arrays(run).items()}
    again = rigid.simulate(scene, omega, t=TIMES, **options, out=out)
    for name, array in arrays(run).items():
        assert out[name].tobytes() == array.tobytes()
        assert np.may_share_memory(getattr(again, name), out[name])
        assert getattr(again, name).shape == array.shape
    assert (again.status == run.status).all()


@pytest.mark.parametrize("single_body", [False, True])
@pytest.mark.parametrize(("scene", "options"), CASES)
def test_single_precision_rounds_states_of_double_precision(
    scene: Scene, options: dict[str, Any], single_body: bool
) -> None:
    omega = OMEGA[0] if single_body else OMEGA
    run = rigid.simulate(scene, omega, t=TIMES, **options)
    half = rigid.simulate(scene, omega, t=TIMES, **options, dtype=np.float32)
    for name, array in arrays(run).items():
        rounded = getattr(half, name)
        if name == "work":
            assert rounded.tobytes() == array.tobytes()
        else:
            assert rounded.tobytes() == array.astype(np.float32).tobytes()
            assert (np.abs(rounded - array) <= ULP * np.abs(array)).all()
    known = ~np.isnan(run.error)
    assert np.array_equal(half.error[known], (run.error + 2.0**-23)[known])


def test_given_arrays_may_have_single_precision() -> None:
    out = {"attitude": np.empty((40, 3, 4), dtype=np.float32)}
    run = rigid.simulate(FREE, OMEGA, t=TIMES, out=out)
    plain: Any = rigid.simulate(FREE, OMEGA, t=TIMES)
    assert out["attitude"].tobytes() == plain.attitude.astype(np.float32).tobytes()
    assert run.omega.tobytes() == plain.omega.tobytes()


def test_the_same_arrays_are_filled_again_and_again() -> None:
    out = {"omega": np.empty((40, 3, 3)), "attitude": np.empty((40, 3, 4))}
    for factor in (1.0, 2.0):
        rigid.simulate(FREE, factor * OMEGA, t=TIMES, out=out)
        assert np.array_equal(out["omega"], rigid.simulate(FREE, factor * OMEGA, t=TIMES).omega)


READ_ONLY = np.empty((40, 3, 3))
READ_ONLY.flags.writeable = False


def asked(**options: Any) -> Callable[[], object]:
    return lambda: rigid.simulate(FREE, OMEGA, t=TIMES, **options)


def with_rate(rate: float) -> Callable[[], object]:
    omega = [[0.0, 1.0, 0.0], [0.0, rate, 0.0]]
    return lambda: rigid.simulate(FREE, omega, t=[0.0], dtype=np.float32)


HUGE = rigid.Body((1e38, 2e38, 2.5e38))
IN_PARTS = rigid.simulate_chunks

test_refused = refuses(
    [
        (
            asked(record=("axis", "rates")),
            "record = ('axis', 'rates'): must be one of 'rates', 'axis', 'attitude', and 'energy'",
        ),
        (asked(record=("energy", "energy")), "record = ('energy', 'energy'): must be"),
        (asked(record=("power",)), "record = 'power': must be one of 'rates', "),
        (asked(out={"energy": np.empty((40, 3))}), "out = 'energy': must be one of 'omega'"),
        (asked(dtype=np.float16), "dtype = float16: must be float64 or float32"),
        (asked(out={"omega": [0.0]}), TypeError, "out['omega'] = [0.0]: must be an array"),
        (asked(out={"gamma": np.empty((40, 3, 3))}), "out = 'gamma': must be one of 'omega'"),
        (
            asked(out={"omega": np.empty((40, 3))}),
            "out['omega']: must be writeable and C-contiguous, of shape (40, 3, 3) and float64",
        ),
        (asked(out={"omega": np.empty((40, 3, 3), dtype=int)}), "out['omega']: must be"),
        (asked(out={"omega": np.empty((40, 3, 6))[..., ::2]}), "out['omega']: must be"),
        (asked(out={"omega": READ_ONLY}), "out['omega']: must be writeable"),
        (asked(dtype=np.float32, accuracy=1e-7), "accuracy = 1e-07: must be at least 1.2e-07 in"),
        (with_rate(1e-31), "dtype = float32: the rates of body 1 reach 1.53e-31 rad"),
        (with_rate(1e31), "dtype = float32: the rates of body 1 reach 1.53e+31 rad"),
        (
            lambda: rigid.simulate(
                HUGE, [10.0, 0.0, 8.0], t=[0.0], record=("rates", "energy"), dtype=np.float32
            ),
            "dtype = float32: energy reaches 1.3e+40",
        ),
        (
            lambda: rigid.simulate(TOP, OMEGA, t=TIMES, record=("rates", "energy")),
            "the potential energy of a top needs its vertical",
        ),
        (
            lambda: run(SCENES["free"], "rk4", "rates", None).rotation(),
            "record = 'attitude' was not asked for",
        ),
        (lambda: IN_PARTS(FREE, OMEGA, t=TIMES, chunk=0), "chunk = 0: must be at least 1"),
        (lambda: IN_PARTS(FREE, [[0.0, np.nan, 0.0]], t=TIMES), "omega[0, 1] = nan: must be fini"),
        (
            lambda: next(IN_PARTS(FREE, OMEGA, t=[2.0, 1.0])),
            "t[0] = 2.0 > t[1] = 1.0: times must be ascending",
        ),
    ],
    literal=True,
)


@pytest.mark.parametrize("array", [np.empty((1, 2, 3)), np.empty((1, 1, 3), dtype=int)])
def test_the_core_refuses_arrays_that_it_cannot_fill(array: np.ndarray) -> None:
    with pytest.raises(
        ValueError, match=r"^omega: expected shape \[1, 1, 3\] of float64 or float32"
    ):
        Request(
            bodies=bodies_of(FREE, [1.0, 1.0, 1.0]),
            times=np.zeros(1),
            method="exact",
            record="rates",
            max_steps=1,
            threads=1,
        ).states(out={"omega": array})


# What is not asked for is not carried, and the rates do not notice: the same bits


SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
    "free symmetric about 1": rigid.FreeBody(rigid.Body((1.0, 1.5, 1.5))),
    "free symmetric about 3": rigid.FreeBody(rigid.Body((1.0, 1.0, 0.5))),
    "sphere": rigid.FreeBody(rigid.Body((1.0, 1.0, 1.0))),
    "top": rigid.HeavyTop(rigid.Body((2.0, 1.5, 1.0)), mgl=3.0, com=(0.48, -0.64, 0.6)),
    "symmetric top": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=3.0),
    "symmetric body off its axis": rigid.HeavyTop(
        rigid.Body((2.0, 2.0, 1.0)), mgl=3.0, com=(1.0, 0.0, 0.0)
    ),
}

EVERY = [
    pytest.param(method, scene, id=f"{method.name}-{name}")
    for method in METHODS
    for name, scene in SCENES.items()
]


def starts(n: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(7)
    return 2.0 * rng.standard_normal((n, 3)), rng.standard_normal((n, 4))


def run(scene: Scene, method: str, record: str, step: float | None) -> rigid.Run:
    omega, attitude = starts(11)
    t = [-3.0, -0.5, 0.0, 1.0, 4.0]
    return rigid.simulate(scene, omega, attitude, t=t, method=method, record=record, step=step)


def follows_from_attitude(method: rigid.Method, scene: Scene) -> bool:
    """Whether the vertical of a top follows from the quaternion: in Runge-Kutta steps."""
    return method.name in ("rk4", "dop853") and isinstance(scene, rigid.HeavyTop)


@pytest.mark.parametrize("step", [None, 0.03])
@pytest.mark.parametrize(("method", "scene"), EVERY)
def test_rates_are_the_same_bits_whatever_else_is_asked(
    method: rigid.Method, scene: Scene, step: float | None
) -> None:
    rates, axis, attitude = (
        run(scene, method.name, record, step) for record in ("rates", "axis", "attitude")
    )
    assert rates.omega.tobytes() == axis.omega.tobytes()
    if follows_from_attitude(method, scene):
        # Another error of the method: order 4, 0.1 rad a step, some turns.
        assert attitude.omega == pytest.approx(rates.omega, abs=1e-3)
    else:
        assert attitude.omega.tobytes() == rates.omega.tobytes()
    assert np.array_equal(rates.steps, axis.steps)
    assert np.array_equal(rates.steps, attitude.steps)
    if step is not None:
        return
    # What was not asked for is not there.
    assert rates.gamma is rates.attitude is axis.attitude is None
    assert axis.gamma is not None
    assert attitude.attitude is not None
    if follows_from_attitude(method, scene):
        assert gamma_of(attitude.attitude) == pytest.approx(present(attitude.gamma), abs=2e-15)
    elif isinstance(scene, rigid.HeavyTop):
        assert axis.gamma.tobytes() == present(attitude.gamma).tobytes()
    else:
        # A free body has it from the attitude; carried alone it has another error of the method.
        assert attitude.gamma is None
        assert gamma_of(attitude.attitude) == pytest.approx(axis.gamma, abs=1e-4)


# Many bodies in parts are the bodies of one run


OMEGA_PARTS = RNG.normal(size=(70, 3))
ATTITUDE = RNG.normal(size=(70, 4))


@pytest.mark.parametrize("chunk", [1, 32, 69, 70, 1000])
@pytest.mark.parametrize(("scene", "method"), [(FREE, "exact"), (TOP, "taylor12")])
def test_parts_have_the_bits_of_one_run(scene: rigid.FreeBody, method: str, chunk: int) -> None:
    options: dict[str, Any] = {"t": TIMES, "method": method, "check": False}
    whole = rigid.simulate(scene, OMEGA_PARTS, ATTITUDE, **options)
    parts = list(rigid.simulate_chunks(scene, OMEGA_PARTS, ATTITUDE, chunk=chunk, **options))
    assert [len(part.omega) for part in parts[:-1]] == [chunk] * (len(parts) - 1)
    for name in ("omega", "attitude", "energy_drift", "status"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert joined.tobytes() == getattr(whole, name).tobytes()


@pytest.mark.parametrize("attitude", [None, ATTITUDE[0], Rotation.from_quat(ATTITUDE[0])])
def test_one_attitude_serves_all_bodies(attitude: Any) -> None:
    whole = rigid.simulate(FREE, OMEGA_PARTS, attitude, t=TIMES)
    parts = rigid.simulate_chunks(FREE, OMEGA_PARTS, attitude, t=TIMES, chunk=40)
    joined = np.concatenate([part.attitude for part in parts if part.attitude is not None])
    assert joined.tobytes() == (b"" if whole.attitude is None else whole.attitude.tobytes())


def test_one_start_of_the_rates_serves_all_attitudes() -> None:
    parts = list(rigid.simulate_chunks(FREE, OMEGA_PARTS[0], ATTITUDE, t=TIMES, chunk=64))
    assert [part.omega.shape for part in parts] == [(64, 3, 3), (6, 3, 3)]


def test_no_bodies_have_no_parts() -> None:
    assert not list(rigid.simulate_chunks(FREE, np.empty((0, 3)), t=TIMES))


def test_a_part_is_computed_when_it_is_asked_for() -> None:
    """The states of all bodies together are beyond any memory."""
    omega = np.broadcast_to([0.1, 1.0, 0.2], (10**6, 3))
    times = np.linspace(0.0, 1.0, 10**5)
    assert next(rigid.simulate_chunks(FREE, omega, t=times, chunk=2)).omega.shape == (2, 10**5, 3)
    with pytest.raises(MemoryError, match="states of 1000000 bodies at 100000 times: "):
        rigid.simulate(FREE, omega, t=times)


@pytest.mark.parametrize(
    "scene",
    [
        rigid.FreeBody(MANY, rotor=(0.1, 0.2, 0.3), damping=0.1),
        rigid.HeavyTop(MANY, mgl=RNG.uniform(1.0, 2.0, 40), com=(0.6, 0.0, 0.8)),
    ],
)
def test_recorded_energy_and_momentum_follow_from_the_states(scene: Scene, tmp_path: Path) -> None:
    """Sums of at most six products of numbers that NumPy adds in another order."""
    options: dict[str, Any] = {"t": TIMES, "check": False}
    run = rigid.simulate(scene, OMEGA, record=("axis", *ENERGETIC), **options)
    momentum = np.array(MANY.moments)[:, np.newaxis] * run.omega
    kinetic = 0.5 * np.sum(run.omega * momentum, axis=-1)
    energy, size = kinetic, kinetic
    if isinstance(scene, rigid.HeavyTop):
        down = np.sum(present(run.gamma) * scene.weight[:, np.newaxis], axis=-1)
        energy, size = kinetic + down, kinetic + np.linalg.norm(scene.weight, axis=-1)[:, None]
    else:
        momentum = momentum + np.array([0.1, 0.2, 0.3])
    assert np.all(np.abs(run.energy() - energy) <= 8 * np.finfo(float).eps * size)
    assert np.allclose(run.momentum(), momentum, rtol=4 * np.finfo(float).eps, atol=0.0)
    # What was not recorded is computed alike, and no state has other bits.
    plain = rigid.simulate(scene, OMEGA, record="axis", **options)
    assert plain.omega.tobytes() == run.omega.tobytes()
    for name in ENERGETIC:
        assert getattr(plain, name)().tobytes() == getattr(run, name)().tobytes()
    # Files have it, tables have columns of it, and a frame turns it.
    kept = rigid.load_run(run.save(tmp_path / "run.npz"))
    assert kept.energy().tobytes() == run.energy().tobytes()
    header = run.to_csv(tmp_path / "run.csv").read_text().splitlines()[0].split(",")
    assert {"energy", "momentum1", "momentum3"} <= set(header)
    assert run.to_xarray().momentum.attrs["units"] == "kg m²/s"
    axes = Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix()
    assert np.allclose(run.in_frame(axes).momentum(), momentum @ axes.T, rtol=0.0, atol=1e-14)
    assert run.at(TIMES).energy().shape == (40, 3)


def test_energy_and_momentum_fill_arrays_in_their_type() -> None:
    shapes = {"energy": (40, 3), "momentum": (40, 3, 3)}
    out = {name: np.empty(shape, dtype=np.float32) for name, shape in shapes.items()}
    record = ("rates", *ENERGETIC)
    run = rigid.simulate(FREE, OMEGA, t=TIMES, record=record, out=out)
    half = rigid.simulate(FREE, OMEGA, t=TIMES, record=record, dtype=np.float32)
    for name in ENERGETIC:
        double = getattr(rigid.simulate(FREE, OMEGA, t=TIMES, record="rates"), name)()
        assert np.shares_memory(getattr(run, name)(), out[name])
        assert out[name].tobytes() == double.astype(np.float32).tobytes()
        # Of rounded rates: twice their rounding, and that of the sum.
        single = getattr(half, name)()
        assert single.dtype == np.float32
        assert np.all(np.abs(single - double) <= 4.0 * ULP * np.abs(double))


def test_energy_ends_with_the_record_of_a_body() -> None:
    run = rigid.simulate(
        FREE,
        [0.1, 1.0, 0.1],
        t=np.linspace(0.0, 20.0, 50),
        until=rigid.crosses("omega2", 0.0),
        record=("attitude", *ENERGETIC),
    )
    ended = np.isnan(run.omega[:, 0])
    assert ended.any()
    assert np.array_equal(np.isnan(run.energy()), ended)


def test_parts_fill_one_memory_map(tmp_path: Path) -> None:
    """Arrays for all bodies, also on the disk, get the states of each part in its rows."""
    whole = rigid.simulate(FREE, OMEGA_PARTS, ATTITUDE, t=TIMES)
    rates = np.memmap(tmp_path / "omega", dtype="f8", mode="w+", shape=whole.omega.shape)
    parts = list(
        rigid.simulate_chunks(FREE, OMEGA_PARTS, ATTITUDE, t=TIMES, chunk=32, out={"omega": rates})
    )
    assert all(np.shares_memory(part.omega, rates) for part in parts)
    assert rates.tobytes() == whole.omega.tobytes()


test_arrays_that_parts_cannot_fill = refuses(
    [
        (3, TypeError, "out = 3: must be a dict of arrays by their names"),
        (
            {"omega": np.zeros((32, 3, 3))},
            "out['omega']: expected a row for each of 70 bodies, got shape (32, 3, 3)",
        ),
    ],
    literal=True,
    by=lambda out: rigid.simulate_chunks(FREE, OMEGA_PARTS, t=TIMES, chunk=32, out=out),
)
