"""Every refusal names the argument, its value and the rule; right values are taken in any dress."""

import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import rigid
from fuzz_targets import TARGETS
from physics import LISTED, METHODS
from processes import run_python
from refusals import refuses
from rigid import inertia, particles, rotations, springs
from rigid._checks import matrices
from rigid._checks.arguments import of_known
from rigid.model.scene import scene_from_dict
from small_maps import small_map

NAN, INF = float("nan"), float("inf")
BODY = rigid.Body((1.0, 1.5, 2.0))
FREE = rigid.FreeBody(BODY)
TOP = rigid.HeavyTop(BODY, mgl=3.0, com=(0.6, 0.0, 0.8))
RATES = [0.3, 1.0, 0.2]


def moments(*values: Any) -> Callable[[], Any]:
    return lambda: rigid.Body(values)


def tensor(values: Any) -> Callable[[], Any]:
    return lambda: rigid.Body.from_tensor(values)


def body(**options: Any) -> Callable[[], Any]:
    return lambda: rigid.Body((1.0, 1.0, 1.0), **options)


def box(*sides: Any, **options: Any) -> Callable[[], Any]:
    return lambda: rigid.Body.box(*sides, **options)


def top(body: Any = BODY, **options: Any) -> Callable[[], Any]:
    return lambda: rigid.HeavyTop(body, **{"mgl": 1.0, **options})


def run(*start: Any, scene: Any = FREE, **options: Any) -> Callable[[], Any]:
    start = start or (RATES,)
    return lambda: rigid.simulate(scene, *start, **{"t": [0.0, 1.0], **options})


POSITIVE = "every moment of inertia must be positive (a thin rod has zero about its axis and "
TRIANGLE = "no moment may exceed the sum of the other two (triangle inequality; "
UNSYMMETRIC = "a tensor of inertia is symmetric, to 1e-05 of the largest entry"

REFUSED: list[tuple[Any, ...]] = [
    # Bodies.
    (moments(NAN, 1, 1), ["moments = (NaN, 1, 1): ", "must be finite"]),
    (moments(1, INF, 1), ["moments = (1, inf, 1): ", "must be finite"]),
    (moments(1, -2, 1), ["moments = (1, -2, 1): ", POSITIVE]),
    (moments(0, 0, 0), ["moments = (0, 0, 0): ", "a mass point has no rotation"]),
    (moments(1, 1, 2.5), ["moments = (1, 1, 2.5): ", TRIANGLE]),
    (moments(5, 1, 2), ["moments = (5, 1, 2): ", TRIANGLE]),
    (moments(1e308, 1, -0.0), ["moments = (1e308, 1, -0): ", POSITIVE]),
    (moments(1, 1e-320, 1e9), ["moments = (1, 1e-320, 1000000000): ", TRIANGLE]),
    (moments(1, 4, 2), ["moments = (1, 4, 2): ", TRIANGLE]),
    (moments(1, 2), ["moments: expected shape (3,) or (..., 3), got (2,)"]),
    (lambda: rigid.Body(np.eye(2)), ["moments: expected shape (3,) or (..., 3), got (2, 2)"]),
    (lambda: rigid.Body("abc"), TypeError, ["moments = 'abc': must be real numbers"]),
    (lambda: rigid.Body([1j, 1, 1]), TypeError, ["moments = [1j, 1, 1]: must be real numbers"]),
    (moments(1, [2], 3), ["moments = (1, [2], 3): ", "must be"]),
    (body(mass=0.0), ["mass = 0.0: must be positive"]),
    (body(mass=NAN), ["mass = nan: must be finite"]),
    (body(mass="heavy"), TypeError, ["mass = 'heavy': must be a real number"]),
    (body(mass=True), TypeError, ["mass = True: must be a real number"]),
    (body(sides=(1, 2)), ["sides: expected shape (3,), got (2,)"]),
    (body(sides=(1, NAN, 2)), ["sides[1] = nan: must be finite"]),
    (body(sides=(1, -1, 2)), ["sides", "-1", "must be positive"]),
    (box(0.1, -0.2, 0.3), ["b = -0.2: must be positive"]),
    (box(0.1, 0.2, INF), ["c = inf: must be finite"]),
    (box("wide", 0.2, 0.3), TypeError, ["a = 'wide': must be a real number"]),
    (box(np.ones(2), np.ones(3), 0.3), ["a (2,), b (3,)", "do not broadcast"]),
    (box(0.1, 0.2, 0.3, mass=-1), ["mass = -1.0: must be positive"]),
    (tensor([[1, 2], [2, 1]]), ["tensor: expected shape (3, 3), got (2, 2)"]),
    (
        lambda: rigid.inertia.principal_axes(np.ones((2, 3))),  # one of both numbers is right
        ["tensor: expected shape (..., 3, 3), got (2, 3)"],
    ),
    (tensor(np.diag([1.0, NAN, 1.0])), ["tensor[1, 1] = nan: must be finite"]),
    (
        tensor([[2, 1, 0], [0, 2, 0], [0, 0, 2]]),
        ["tensor[0, 1] = 1.0, but its mirror entry is 0.0: ", UNSYMMETRIC],
    ),
    (
        tensor(np.diag([1.0, 1.0, 5.0])),
        [
            "moments = (1, 1, 5): ",
            TRIANGLE,
            "the excess is 60.00 % of the largest, the nearest possible moments are (2, 2, 4); ",
            "physical=False takes such moments as they are",
        ],
    ),
    (
        lambda: rigid.Body((1, 1, 2), physical=1),  # type: ignore[arg-type]
        TypeError,
        ["physical = 1: must be True or False"],
    ),
    (lambda: rigid.Body((3, -5, 9), physical=False), ["moments = (3, -5, 9): ", POSITIVE]),
    (tensor("abc"), TypeError, ["tensor = 'abc': must be real numbers"]),
    (tensor([[1, 2], [3]]), ["tensor = [[1, 2], [3]]: must be"]),
    (tensor(1j * np.eye(3)), TypeError, ["tensor = ", "must be real numbers"]),
    # Scenes.
    (lambda: rigid.FreeBody((1, 2, 3)), TypeError, ["body = (1, 2, 3): must be a rigid.Body"]),  # type: ignore[arg-type]
    (top((1, 2, 3)), TypeError, ["body = (1, 2, 3): must be a rigid.Body"]),
    (top(mgl=-1.0), ["mgl = -1.0: must not be negative"]),
    (top(mgl=INF), ["mgl = inf: must be finite"]),
    (top(mgl=None), TypeError, ["mgl = None: must be a real number"]),
    (top(mgl=np.complex64(1)), TypeError, ["mgl = ", "must be a real number"]),
    (top(mgl=np.True_), TypeError, ["mgl = ", "must be a real number"]),
    (
        top(com=(0, 0, 0)),
        ["com = [0.0, 0.0, 0.0]: must be a unit vector to 0.0001, its length is 0"],
    ),
    (top(com=(0, NAN, 1)), ["com[1] = nan: must be finite"]),
    (top(com=(0, 1)), ["com: expected shape (..., 3), got (2,)"]),
    (top(com=(1e300, 0, 0)), ["com = [1e+300, 0.0, 0.0]: must be a unit vector"]),
    (
        lambda: scene_from_dict({"kind": "tops", "body": BODY.to_dict()}),
        ["kind = 'tops': must be one of 'free', 'top'; did you mean 'top'?"],
    ),
    (lambda: scene_from_dict({"body": BODY.to_dict()}), ["kind = None: must be one of "]),
    # Scene and rates of a run.
    (run(scene=3), TypeError, ["scene = 3", "must be a rigid.FreeBody or rigid.HeavyTop"]),
    (run([1, NAN, 3]), ["omega[1] = nan: must be finite"]),
    (run([RATES, [1, 2, INF]]), ["omega[1, 2] = inf: must be finite"]),
    (run([1, 2]), ["omega: expected shape (..., 3), got (2,)"]),
    (run(5.0), ["omega: expected shape (..., 3), got ()"]),
    (run(np.ones((0, 5))), ["omega: expected shape (..., 3), got (0, 5)"]),
    (run([[1, 2, 3], [1, 2]]), ["omega = [[1, 2, 3], [1, 2]]: must be an array of real numbers"]),
    (run("fast"), TypeError, ["omega = 'fast': must be real numbers in rad/s, not a text"]),
    (
        run([True, False, True]),
        TypeError,
        ["omega = [True, False, True]: must be real numbers, got bool"],
    ),
    (run([1j, 0, 0]), TypeError, ["omega = [1j, 0, 0]: must be real numbers, got complex128"]),
    (run(None), TypeError, ["omega = None: must be real numbers, got object"]),
    (run(FREE), TypeError, ["omega = FreeBody(", ": must be real numbers, got object"]),
    # Attitude.
    (run(RATES, [0, 0, 0, 0]), ["attitude", "[0.0, 0.0, 0.0, 0.0]: a zero quaternion"]),
    (run(RATES, [[1, 0, 0, 0], [0, 0, 0, 0]]), ["attitude[1] = [0.0, 0.0, 0.0, 0.0]: a zero "]),
    (run(RATES, [1, 0, NAN, 0]), ["attitude[2] = nan: must be finite"]),
    (
        run(RATES, [1, 0, 0]),
        ["attitude: expected shape (..., 4), got (3,); rigid.rotations.euler_to_quaternion takes"],
    ),
    (
        lambda: rigid.rotations.attitude_from_omega(np.ones((5, 3)), np.arange(5.0)),  # type: ignore[arg-type]
        TypeError,
        ["omega = array(", "must be a function of the times; of samples take attitude_from"],
    ),
    (
        lambda: rigid.Orbit(1.0, 0.97),
        ["eccentricity = 0.97: must be at most 0.95", "near a parabola, 1, the anomaly does not"],
    ),
    (
        run(np.ones((3, 3)), np.ones((2, 4))),
        ["omega (3,), attitude (2,): the axes of the bodies do not broadcast"],
    ),
    # Times.
    (run(t=[0.0, 2.0, 1.0]), ["t[1] = 2.0 > t[2] = 1.0: times must be ascending"]),
    (run(t=[0.0, NAN]), ["t[1] = nan: must be finite"]),
    (run(t=INF), ["t[0] = inf: must be finite"]),
    (run(t="now"), TypeError, ["t = 'now': must be real numbers in s, not a text"]),
    # Names.
    (run(method="rk5"), [f"method = 'rk5': did you mean 'rk4'? must be one of {LISTED}"]),
    (run(method=4), [f"method = 4: must be one of {LISTED}"]),
    (
        run(record="atitude"),
        ["record = 'atitude': must be one of 'rates', 'axis', 'attitude'; did you mean 'att"],
    ),
    (run(record=None), ["record = None: must be one of 'rates', 'axis', 'attitude'"]),
    # Numbers.
    (run(step=0.0), ["step = 0.0: must be positive"]),
    (run(step=NAN), ["step = nan: must be finite"]),
    (run(step=INF), ["step = inf: must be finite"]),
    (run(step="short"), TypeError, ["step = 'short': must be a real number"]),
    (run(step=True), TypeError, ["step = True: must be a real number"]),
    (run(step=np.array([0.1, 0.2])), TypeError, ["step = ", "must be a real number"]),
    (run(max_steps=0), ["max_steps = 0: must be at least 1"]),
    (run(max_steps=1e3), TypeError, ["max_steps = 1000.0: must be a whole number"]),
    (run(max_steps=True), TypeError, ["max_steps = True: must be a whole number"]),
    (run(threads=0), ["threads = 0: must be at least 1"]),
    (run(threads=1025), ["threads = 1025: must be at most 1024"]),
    (run(threads=1.5), TypeError, ["threads = 1.5: must be a whole number"]),
]


test_refused = refuses(REFUSED)


@pytest.mark.parametrize("name", ["max_steps", "threads"])
@pytest.mark.parametrize("value", [2**63, 2**64, 10**30])
def test_whole_numbers_beyond_a_machine_word_are_refused(name: str, value: int) -> None:
    with pytest.raises(ValueError, match=rf"^{name} = {value}: must be below 2\*\*63$"):
        run(**{name: value})()


@pytest.mark.parametrize(("length", "words"), [(499, "omega1, omega2, omega3"), (500, "omega1 to")])
def test_names_by_number_are_one_in_a_list_of_500_characters(length: int, words: str) -> None:
    numbered = "omega1, omega2, omega3, "
    known = [*numbered.rstrip(", ").split(", "), "x" * (length - len(numbered))]
    assert f"(known: {words}" in of_known("nothing", known)


CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
SIXTEEN = np.arange(16.0)
MAP = functools.partial(small_map, axes={"spin": [1.0, 2.0]}, samples=2, t_end=1.0)


def one_masked(values: Any) -> Any:
    masked = np.ma.masked_array(values)
    masked[(0,) * masked.ndim] = np.ma.masked
    return masked


def masking(states: Any) -> Any:
    return one_masked(states.omega[:, -1, 0])


def masking_law(distance: Any) -> Any:
    return one_masked(distance), distance, distance


MASKED = np.ma.masked_array(RATES, mask=[False, True, False])
HUGE = [10**309, -(10**400), 10**5000]


@pytest.mark.parametrize("value", HUGE, ids=["309 digits", "400 digits", "5000 digits"])
def test_whole_numbers_beyond_doubles_are_refused(value: int) -> None:
    calls: list[Callable[[], Any]] = [box(value, 0.2, 0.3), top(mgl=value), run(step=value)]
    for name, call in zip(("a", "mgl", "step"), calls, strict=True):
        rule = r"(1|-1|a whole number of more).*: must be below 1\.8e308 in size"
        with pytest.raises(ValueError, match=f"^{name} = {rule}$"):
            call()


UNWRITTEN: Any = 10**5000


def flips(**changed: Any) -> Callable[[], Any]:
    return lambda: small_map(**changed)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("threads", run(threads=UNWRITTEN)),
        ("body", lambda: rigid.FreeBody(UNWRITTEN)),
        ("scene", lambda: rigid.simulate(UNWRITTEN, RATES, t=[1.0])),
        ("damping", lambda: rigid.FreeBody(BODY, damping=UNWRITTEN)),
        ("torque", lambda: rigid.FreeBody(BODY, torque=UNWRITTEN)),
        ("question", lambda: rigid.plan(FREE, UNWRITTEN)),
        ("axis", lambda: rigid.exact.flip_times(FREE, RATES, axis=UNWRITTEN)),
        ("title", flips(title=UNWRITTEN)),
        ("rng", flips(rng=UNWRITTEN)),
        ("start", flips(start=UNWRITTEN)),
        ("stable", flips(stable=UNWRITTEN)),
        ("axes: unknown parameter", flips(axes={UNWRITTEN: [1.0]})),
    ],
)
def test_whole_numbers_that_python_does_not_write_are_refused(
    name: str, call: Callable[[], Any]
) -> None:
    many = "a whole number of more than 4300 digits"
    with pytest.raises((TypeError, ValueError), match=rf"^{name}( =)? {many}"):
        call()


def test_rates_and_times_near_the_largest_double_warn_of_nothing() -> None:
    """What they are multiplied or divided to overflows: the run is refused, or says so."""
    body = rigid.Body((0.26, 0.8, 0.85))
    rounding = "^accuracy = 1e-06: must be at least inf; rounding errs by inf in inf rad$"
    weight = r"^mgl = 1e\+308: must be below 1e\+153 times the least moment, 0.26: count the time"
    heavy = rigid.HeavyTop(body, mgl=1e308)
    for scene, end, rule in ((heavy, 1.0, weight), (TOP, 1e308, rounding)):
        with pytest.raises(ValueError, match=rule):
            run(scene=scene, t=[end], accuracy=1e-6)()
    damped = rigid.FreeBody(body, damping=1e307)  # of 1e308 the rate is refused
    overflown = run([1e308] * 3, scene=damped, t=[0.0], method="taylor16", accuracy=1e-6)()
    assert overflown.status in (rigid.Status.NOT_FINITE, rigid.Status.STEP_LIMIT)
    stopped = run(scene=damped, t=[900.0], accuracy=1e-6)()
    assert stopped.status == rigid.Status.OK
    assert not stopped.omega.any()
    # It has turned by the time of the damping, I / c.
    turned = 2.0 * stopped.attitude[0, 1:] / (np.array(RATES) * body.moments / 1e307)
    assert np.abs(turned - 1.0).max() < 1e-6


@pytest.mark.skipif(np.finfo(np.longdouble).maxexp < 2000, reason="has no wider floats")
def test_a_weight_ends_where_squares_of_its_rates_near_the_largest_double() -> None:
    body = rigid.Body((1.0, 1.5, 2.0))
    assert rigid.simulate(rigid.HeavyTop(body, mgl=0.99e153), [0.0, 0.0, 1.0], t=[0.0]).steps == 0
    with pytest.raises(
        ValueError, match=r"mgl = 1.01e\+153: must be below 1e\+153 times the least"
    ):
        rigid.simulate(rigid.HeavyTop(body, mgl=1.01e153), [0.0, 0.0, 1.0], t=[0.0])


def test_wide_floats_beyond_doubles_are_not_finite() -> None:
    wide = np.longdouble("1e400")
    with pytest.raises(ValueError, match=r"^omega\[1\] = inf: must be finite$"):
        run(np.array([0.0, wide, 1.0], dtype=np.longdouble))()


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("omega", run(MASKED)),
        ("omega", run([MASKED, RATES])),
        ("omega", run([0.3, np.ma.masked, 0.2])),
        ("z", lambda: rigid.frequencies(SIXTEEN, one_masked(SIXTEEN))),
        (
            "pairs",
            lambda: springs.pair_system(
                [1, 1, 1], CORNERS[:3], pairs=one_masked(FACES), stiffness=1
            ),
        ),
        ("law", lambda: springs.pair_system([1, 1], CORNERS[:2], law=masking_law)),
        ("faces", lambda: rigid.Body.from_mesh(CORNERS, one_masked(FACES))),
        ("shape[1]", lambda: run()().animate("x.html", shape=(CORNERS, one_masked(FACES)))),
        ("sample", lambda: MAP().outcomes(one_masked([0, 1]))),
        ("stable", lambda: MAP(stable=rigid.judged(masking, [1.0]), method=None)),
        ("t", run(t=np.ma.masked_less([0.5, 1.0], 0.7))),
        (
            "moments",
            lambda: rigid.Body(np.ma.masked_array([1.0, 1.5, 2.0], mask=[False, False, True])),
        ),
    ],
)
def test_masked_elements_are_not_data(name: str, call: Callable[[], Any]) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(name)}: 1 elements are masked; fill"):
        call()


def test_times_of_any_size_are_times() -> None:
    for t in ([1e308], [-1e308, 1e308]):
        assert run(t=t)().status in (rigid.Status.FINISHED, rigid.Status.FLAGGED, 3)


def test_boxes_too_small_or_large_for_float64_are_impossible_bodies() -> None:
    for size in (1e-200, 1e200):
        with pytest.raises(ValueError, match=r"^moments = .*: every moment of inertia must be"):
            rigid.Body.box(size, size, size)


# --- accepted -------------------------------------------------------------------------------------


def test_flat_bodies_are_bodies() -> None:
    for moments in [
        (1, 1, 2),
        (3, 1, 2),
        (1.0, 3.0, 2.0),
        (0.1, 0.7, 0.8),
        (0.1, 0.2, 0.3),
        (0.3, 0.1, 0.2),
    ]:
        assert rigid.Body(moments).moments == moments
        run(scene=rigid.FreeBody(rigid.Body(moments)))()
    # The rounding of a computed flat body is taken away without a word.
    first, second, third = rigid.Body((1.0, 1.0, 2.0 + 1e-14)).moments
    assert first == second == 0.5 * third


def test_moments_of_any_size_are_moments() -> None:
    for size in (5e-324, 1e-300, 1e300, 1.7e308):
        assert rigid.Body((size, size, size)).moments == (size, size, size)


def unaligned(array: Any) -> Any:
    """The array at an odd address, as a field of a packed record has it."""
    record = np.zeros(array.shape[0], dtype=[("", np.int8), ("omega", np.float64, array.shape[1:])])
    record["omega"] = array
    field = record["omega"]
    assert not field.flags.aligned
    return field


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_arrays_in_any_dress_are_the_same_arrays(method: rigid.Method) -> None:
    def bits(omega: Any, attitude: Any = None) -> bytes:
        t = [0.5, 1.0]
        return rigid.simulate(TOP, omega, attitude, t=t, method=method.name).omega.tobytes()

    rng = np.random.default_rng(8)
    omega = rng.integers(-9, 9, (6, 3)).astype(np.float64)
    attitude = rng.standard_normal((6, 4))
    expected = bits(omega, attitude)

    wide = np.zeros((12, 6))
    wide[::2, ::2] = omega
    frozen = omega.copy()
    frozen.setflags(write=False)
    swapped = omega.astype(omega.dtype.newbyteorder())
    dressed: list[Any] = [
        omega.tolist(),
        [tuple(row) for row in omega],
        list(omega),
        omega.astype(int),
        omega.astype(np.int8),
        omega.astype(np.float32),
        omega.astype(np.float16),
        omega.astype(np.longdouble),
        np.asfortranarray(omega),
        wide[::2, ::2],
        omega[::-1][::-1],
        frozen,
        swapped,
        np.ma.masked_array(omega),
        unaligned(omega),
    ]
    for value in dressed:
        assert bits(value, attitude) == expected
    for other in (attitude.tolist(), np.asfortranarray(attitude), attitude[::-1][::-1]):
        assert bits(omega, other) == expected
    attitude.setflags(write=False)
    assert bits(frozen, attitude) == expected


def test_what_goes_in_is_not_changed() -> None:
    omega, attitude, t = np.ones((2, 3)), np.full((2, 4), 3.0), np.array([0.0, 1.0])
    result = rigid.simulate(FREE, omega, attitude, t=t)
    assert np.array_equal(omega, np.ones((2, 3)))
    assert np.array_equal(attitude, np.full((2, 4), 3.0))
    assert np.array_equal(t, [0.0, 1.0])
    # And what comes out is not what went in.
    result.omega[:] = 0.0
    assert np.array_equal(omega, np.ones((2, 3)))


def test_scalars_in_any_dress() -> None:
    plain = run(step=0.5, max_steps=100)()
    for step in (np.float64(0.5), np.float32(0.5), np.array(0.5)):
        assert run(step=step)().omega.tobytes() == plain.omega.tobytes()
    assert run(step=1)().steps == 1
    assert run(max_steps=2**63 - 1, step=0.5, threads=1024)().omega.tobytes() == (
        plain.omega.tobytes()
    )
    assert run(max_steps=np.int64(100), step=0.5)().omega.tobytes() == plain.omega.tobytes()
    assert rigid.HeavyTop(BODY, mgl=1).mgl == 1.0
    assert rigid.Body(np.array([1, 2, 3])).moments == (1.0, 2.0, 3.0)


def test_com_of_almost_unit_length_is_normalised() -> None:
    top = rigid.HeavyTop(BODY, mgl=1.0, com=(0.6 + 1e-12, 0.0, 0.8))
    assert np.linalg.norm(top.com) == pytest.approx(1.0, abs=2.0**-52)


def test_scenes_and_bodies_are_values() -> None:
    for scene in (FREE, TOP, rigid.FreeBody(rigid.Body.box(1, 2, 3, mass=4))):
        assert scene_from_dict(scene.to_dict()) == scene
        assert hash(scene_from_dict(scene.to_dict())) == hash(scene)
        with pytest.raises(AttributeError):
            scene.body = BODY  # type: ignore[misc]
    assert rigid.Body((1, 2, 3)) != rigid.Body((2, 1, 3))


# Odd arguments and damaged files: refused in words, or a result that is one. Some of many


SCRIPT = Path(__file__).parents[2] / "long" / "fuzz.py"


def test_whatever_comes_in_is_refused_or_understood() -> None:
    done = run_python(str(SCRIPT), "--cases", "150", check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert [row[0] for row in rows] == list(TARGETS)
    for _, _, accepted, refused, _, _ in rows:
        assert int(accepted) > int(refused) > 0  # most cases get past the door


# Directions and rotations with four decimals, or in single precision, are what they stand for.


Floats = NDArray[np.float64]

COUNT = 2000
TURNS = Rotation.random(COUNT, random_state=5)
ROUNDED: dict[str, Callable[[Floats], Any]] = {
    "single": lambda array: array.astype(np.float32),
    "four decimals": lambda array: array.round(4),
}
OFF = {"single": 2.0**-25, "four decimals": 0.5e-4}
"""Largest error of a number of size one."""


@pytest.mark.parametrize("kind", ROUNDED)
def test_rounded_directions_have_length_one(kind: str) -> None:
    exact = TURNS.as_matrix()[:, :, 0]
    given = ROUNDED[kind](exact)
    normal, across = ROUNDED[kind](TURNS.as_matrix()[:, :, 1]), given
    tops = rigid.HeavyTop(BODY, mgl=1.0, com=given)
    orbit = rigid.Orbit(1.0, normal=normal, periapsis=across)
    for found in (tops.com, orbit.normal, orbit.periapsis):
        assert np.abs(np.linalg.norm(found, axis=-1) - 1.0).max() < 1e-15
    assert np.abs(np.vecdot(orbit.normal, orbit.periapsis)).max() < 1e-15
    # The component across is off by the rounding of three numbers.
    assert np.abs(tops.com - exact).max() <= 2.0 * OFF[kind]
    assert rigid.HeavyTop(BODY, mgl=1.0, com=given[0]).com == tuple(np.array(tops.com)[0].tolist())
    again = rigid.HeavyTop(BODY, mgl=1.0, com=tops.com)
    assert np.array_equal(again.com, tops.com)


@pytest.mark.parametrize("kind", ROUNDED)
def test_rounded_matrices_are_the_nearest_rotations(kind: str) -> None:
    exact = TURNS.as_matrix()
    given = ROUNDED[kind](exact)
    nearest = rotations.nearest_rotation(given)
    quaternion = rotations.matrix_to_quaternion(given)
    # The singular vectors have errors of some 20 roundings.
    assert np.abs(rotations.quaternion_to_matrix(quaternion) - nearest).max() < 1e-14
    turned = inertia.rotate_tensor(given, np.diag([1.0, 2.0, 2.5]))
    assert np.abs(np.linalg.eigvalsh(turned) - [1.0, 2.0, 2.5]).max() < 2e-14
    assert np.abs(nearest - exact).max() <= 3.0 * OFF[kind]
    turn = particles.screw(given[0], [0.0, 0.0, 0.0])
    assert turn.angle == pytest.approx(Rotation.from_matrix(nearest[0]).magnitude(), abs=1e-14)
    start, times = [0.3, 1.0, 0.2], [0.0, 5.0]
    run: Any = rigid.simulate(BODY, start, t=times, frame=given[1])
    same: Any = rigid.simulate(BODY, start, t=times, frame=nearest[1])
    assert np.abs(run.omega - same.omega).max() < 1e-13
    assert np.abs(run.attitude - same.attitude).max() < 1e-13


def test_exact_rotations_keep_their_bits() -> None:
    exact = TURNS.as_matrix()
    assert (matrices.rotation_matrices("R", exact) == exact).all()
    products = exact @ np.roll(exact, 1, axis=0)
    assert (matrices.rotation_matrices("R", products) == products).all()


@pytest.mark.parametrize("kind", ROUNDED)
def test_rounded_samples_of_attitudes_are_unit_quaternions(kind: str) -> None:
    exact = TURNS.as_quat(scalar_first=True)
    taken = np.array(rigid.samples(None, ROUNDED[kind](exact)).attitude)
    assert np.abs(np.linalg.norm(taken, axis=1) - 1.0).max() < 1e-15
    assert np.abs(taken - exact).max() <= 2.0 * OFF[kind]
    assert np.array_equal(np.array(rigid.samples(None, taken).attitude), taken)


def test_what_is_further_off_is_refused_with_its_misfit() -> None:
    with pytest.raises(ValueError, match=r"must be a unit vector to 0.0001, its length is 1.0002;"):
        rigid.HeavyTop(BODY, mgl=1.0, com=(0.0, 0.0, 1.0002))
    with pytest.raises(ValueError, match=r"R - 1\| = 0.00347, must be at most 0.00031, det R"):
        rotations.matrix_to_quaternion(1.001 * np.eye(3))
    with pytest.raises(ValueError, match=r"their product is 0.0009, above 0.0002$"):
        rigid.Orbit(1.0, normal=(0.0, 0.0, 1.0), periapsis=(1.0, 0.0, 0.0009))
