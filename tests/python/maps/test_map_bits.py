"""The same request gives the same bits: any threads, blocks, process, processor, and alone."""

import multiprocessing
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import rigid
from map_kinds import KINDS
from physics import angular_momentum, energy, gamma_of
from processes import PATIENCE, python_process
from rigid import _core
from rigid.maps.data import COLUMNS
from rigid.maps.grid import nominal_starts
from rigid.maps.job import to_core
from rigid.model.bounds import NoFlip, TiltBelow
from rigid.model.scene import scene_from_dict
from rigid.solve.simulate import replayed
from small_maps import Floats, assert_same_map, saved_bytes, small_map, spec_of

# Each has bodies of every class that ends early and late, and the first an impossible body.
CASES = {
    name: KINDS[name][0]
    for name in (
        "free, impossible bodies",
        "free, tilt, splitting",
        "top, tilt from the vertical",
        "top, flips, splitting",
        "top, tilt from the start",
    )
}
EVERY = pytest.mark.parametrize("case", CASES)


def compute(case: str, **options: Any) -> rigid.StabilityMap:
    """One of the maps above."""
    return small_map(**{**CASES[case], **options})


def compute_bytes(case: str, folder: Path, **options: Any) -> bytes:
    """The file of one of the maps above; workers of executors are told to call this."""
    folder.mkdir(exist_ok=True)
    return saved_bytes(compute(case, **options), folder)


def _write(case: str, target: Path) -> None:
    target.write_bytes(compute_bytes(case, target.parent / "scratch", threads=2))


@pytest.mark.filterwarnings("ignore:This process.*multi-threaded:DeprecationWarning")
def test_a_forked_child_computes_the_same(tmp_path: Path) -> None:
    # After a run in the parent: a pool of threads built there would leave the child waiting.
    case = next(iter(CASES))
    expected = compute_bytes(case, tmp_path, threads=2)
    child = multiprocessing.get_context("fork").Process(
        target=_write, args=(case, tmp_path / "child.npz")
    )
    child.start()
    child.join(PATIENCE)
    if child.exitcode is None:
        child.kill()
    assert child.exitcode == 0
    assert (tmp_path / "child.npz").read_bytes() == expected


def test_executors_compute_the_same(tmp_path: Path) -> None:
    expected = [compute_bytes(case, tmp_path) for case in CASES]
    folders = [tmp_path / str(k) for k in range(len(CASES))]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(compute_bytes, CASES, folders)) == expected
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        assert list(pool.map(compute_bytes, CASES, folders, timeout=PATIENCE)) == expected


def few() -> Iterator[rigid.StabilityMap]:
    """A map of each kind; without SIMD up to fifty times slower, so of eight bodies a pixel.

    Under damping by each kind of method, and of more bodies than a group has lanes: when some
    have fallen, others take their lanes.
    """
    for options, _ in KINDS.values():
        few = {} if options.get("half_width") else {"samples": 8}
        yield small_map(**{**options, **few})
    for method in ("rk4", "dop853", "etd4", "splitting", "midpoint"):
        yield small_map(**{**KINDS["driven and damped"][0], "samples": 10, "method": method})


def test_instruction_sets_write_the_same_file(tmp_path: Path) -> None:
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        "import rigid, small_maps, test_map_bits as t\n"
        "print(rigid.build_info()['isa'])\n"
        "with small_maps.in_blocks(3):\n"
        "    for k, result in enumerate(t.few()):\n"
        "        result.save(Path(sys.argv[1]) / f'{k}.npz')\n"
    )
    files = {}
    available = rigid.build_info()["isa_available"]
    for isa in available:
        (tmp_path / isa).mkdir()
        assert python_process(code, str(tmp_path / isa), RIGID_ISA=isa).stdout.strip() == isa
    here = [saved_bytes(result, tmp_path) for result in few()]
    for isa in available:
        files[isa] = [(tmp_path / isa / f"{k}.npz").read_bytes() for k in range(len(here))]
        assert files[isa] == here, isa


def test_a_seed_of_numpy_integers_is_the_same_seed() -> None:
    assert_same_map(small_map(rng=7), small_map(rng=np.uint64(7)))
    different = small_map(rng=8)
    assert (different.stable != small_map(rng=7).stable).any()


def every_step(body: rigid.Replay) -> rigid.Run:
    """The trajectory of a replayed body at the end of every step until it was decided."""
    return replayed(
        scene_from_dict(body.run.spec["scene"]),
        body.omega,
        body.attitude,
        t=body.step * np.arange(body.steps + 1.0),
        method=body.run.spec["method"],
        step=body.step,
        strides=[0] + [1] * body.steps,
    )


def watched(result: rigid.StabilityMap, run: rigid.Run) -> Floats:
    """The tilt that the criterion watches (rad), at the end of every step."""
    criterion = result.spec.stable
    assert isinstance(criterion, TiltBelow)
    assert run.attitude is not None
    axis = np.sign(criterion.axis) * np.eye(3)[abs(criterion.axis) - 1]
    if criterion.reference == "vertical":
        seen = gamma_of(run.attitude) @ axis
    else:
        rotations = run.rotation()
        seen = rotations.apply(axis) @ rotations[0].apply(axis)
    angle: Floats = np.arccos(np.clip(seen, -1.0, 1.0))
    return angle


@EVERY
def test_a_replay_is_the_motion_that_was_judged(case: str) -> None:
    result = compute(case)
    shape = result.spec.shape
    flips = isinstance(result.spec.stable, NoFlip)
    seen = Counter[str]()
    for pixel in range(int(np.prod(shape))):
        if result.status[np.unravel_index(pixel, shape)]:
            continue
        body = result.replay(pixel, pixel % result.spec.samples)
        seen[body.status] += 1
        run = every_step(body)
        assert run.omega[0].tobytes() == body.omega.tobytes()

        # The states of the trajectory that the user sees are those at the ends of the same steps.
        numbers = np.rint(body.run.t / body.step).astype(np.int64)
        early = numbers <= body.steps
        assert body.run.omega[early].tobytes() == run.omega[numbers[early]].tobytes()
        assert numbers[-1] * body.step == pytest.approx(result.spec.t_end, rel=1e-13)

        if flips:
            assert isinstance(result.spec.stable, NoFlip)
            axis = abs(result.spec.stable.axis or 0) - 1
            side = np.signbit(run.omega[:, axis])
            changed = np.flatnonzero(side[1:] != side[:-1])
            assert body.flips == len(changed)
            assert np.isnan(body.tilt)
            if len(changed):
                # Inside the first step that changes the sign; its ends are rounded.
                begin, end = run.t[changed[0]], run.t[changed[0] + 1]
                assert begin * (1 - 1e-15) <= body.left <= end * (1 + 1e-15)
                assert body.status == "stopped"
            else:
                assert np.isnan(body.left)
                assert body.status == "finished"
        else:
            tilt = watched(result, run)
            # The tilt comes from the vertical that is carried, here it comes from the quaternion:
            # they part by the error of the method, which is that of the drift, and by rounding
            # where the arc cosine is steep (1e-8 near 0).
            assert body.tilt == pytest.approx(tilt.max(), abs=2e-5)
            assert isinstance(result.spec.stable, TiltBelow)
            limit = result.spec.stable.angle
            assert (body.status == "stopped") == (body.tilt > limit)
            if body.status == "stopped":
                # In the step that passes the limit, or beside it where the two tilts part.
                passed = run.t[np.argmax(tilt > limit)]
                assert passed - 2.0 * body.step <= body.left <= passed + body.step
        # A body is looked at after bursts of 16 steps and ends with one.
        assert body.steps % 16 == 0
        assert (body.status == "stopped") or body.steps == round(result.spec.t_end / body.step)
    assert seen["stopped"] >= 2
    assert seen["finished"] >= 2


@pytest.mark.parametrize("case", ["free, impossible bodies", "free, tilt, splitting"])
def test_the_drift_that_is_stated_is_that_of_the_motion(case: str) -> None:
    # At the ends of bursts of 16 steps. The energies and lengths here round by a few eps each.
    result = compute(case)
    for pixel in (3, 4, 6):
        body = result.replay(pixel, 1)
        run = every_step(body)
        scene = scene_from_dict(run.spec["scene"])
        energies = energy(scene, run.omega[::16])
        momenta = np.linalg.norm(angular_momentum(scene, run.omega[::16]), axis=1)
        for stated, values in ((body.energy_drift, energies), (body.momentum_drift, momenta)):
            measured = abs(values / values[0] - 1.0).max()
            assert stated == pytest.approx(measured, rel=1e-6, abs=8 * 2.0**-52)


# A body has the same bits in the whole map, in a part of its grid and in a batch of samples.


#: Closed forms, audits of groups, checks of some bodies, driven bodies, and deviation vectors.
NAMES = (
    "free, impossible bodies",
    "closed forms",
    "free, tilt, splitting",
    "top, tilt from the vertical",
    "driven and damped",
    "satellites",
    "regular",
)
BATCHES = range(64), range(64, 96)


@pytest.fixture(params=NAMES, scope="module")
def spec(request: pytest.FixtureRequest) -> rigid.MapSpec:
    return spec_of(**{"t_end": 5.0, **KINDS[request.param][0], "samples": 96})


def some_of(spec: rigid.MapSpec, *pixels: int) -> NDArray[np.int64]:
    """Pixels of the grid, counted anew after its last."""
    return np.array(pixels) % np.prod(spec.shape)


def columns(
    spec: rigid.MapSpec, pixels: NDArray[np.int64] | None = None, samples: range | None = None
) -> dict[str, NDArray[Any]]:
    """The reproducible columns of these samples of these pixels."""
    span = samples or range(spec.samples)
    job = to_core(spec, pixels, len(span), span.start)
    part: Any = job.run(0, len(job.status) * len(span), 2)
    return {one.name: part[one.name] for one in COLUMNS if one.reproducible}


@pytest.fixture(scope="module")
def full(spec: rigid.MapSpec) -> dict[str, NDArray[Any]]:
    return columns(spec)


def test_the_nominal_starts_of_some_pixels_are_rows_of_those_of_all(spec: rigid.MapSpec) -> None:
    pixels = some_of(spec, 5, 0, 3, 3)
    some = nominal_starts(spec.scene, spec.start.starts[0], spec.axes, pixels)
    for name in ("moments", "weight", "omega", "omega_size", "attitude", "tilt", "attitude_size"):
        np.testing.assert_array_equal(getattr(some, name), getattr(spec.grid, name)[pixels])
    if some.damping is not None:
        assert spec.grid.damping is not None
        np.testing.assert_array_equal(some.damping, spec.grid.damping[pixels])


def test_two_batches_merge_to_the_whole_map(
    spec: rigid.MapSpec, full: dict[str, NDArray[Any]]
) -> None:
    pixels = np.arange(len(full["stable"]))[::-1].copy()
    merged = _core.MapStatistics(len(pixels))
    for batch in reversed(BATCHES):
        nothing = {"nanoseconds": np.zeros(len(pixels)), "pixels": np.arange(len(pixels))}
        merged.merge({**columns(spec, pixels, batch), **nothing})
    arrays = merged.arrays()
    for name, values in full.items():
        np.testing.assert_array_equal(arrays[name], values[pixels], err_msg=name)


def test_rows_of_any_pixels_and_first_samples_are_one_request(
    spec: rigid.MapSpec, full: dict[str, NDArray[Any]]
) -> None:
    pixels, first = some_of(spec, 6, 1, 6, 1, 3), np.array([0, 0, 64, 0, 64])
    job = to_core(spec, pixels, 32, first)
    found: Any = job.run(0, 5 * 32, 2)
    for row, (pixel, begin) in enumerate(zip(pixels, first, strict=True)):
        alone = columns(spec, np.array([pixel]), range(begin, begin + 32))
        for name, values in alone.items():
            np.testing.assert_array_equal(found[name][row], values[0], err_msg=name)


def test_another_pixel_and_another_batch_draw_other_bodies(spec: rigid.MapSpec) -> None:
    # So the equalities above are not those of bodies that are all drawn alike.
    def drawn(pixel: int, sample: int) -> list[float]:
        job = to_core(spec, some_of(spec, pixel), 96 - sample, sample)
        omega, attitude = job.starts(np.zeros(1, np.uint64))
        return [*omega, *attitude]

    assert drawn(5, 0) != drawn(6, 0)
    assert drawn(5, 0) != drawn(5, 64)
