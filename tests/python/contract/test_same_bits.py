"""The same request gives the same bits: of any body, whoever is beside it, on any machine.

Every door (a way to ask for motions) is asked for bodies that differ, alone and together, in
another order, on other threads and instruction sets, in other units, and after another library has
left the processor in another mode.
"""

import hashlib
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

import rigid
from doors import CASES, COUNT, DOORS, OMEGA, SCENES, asked, opens, parameters
from float_modes import CAN_BE_SET, MODES, control_word, float_mode
from physics import METHODS, Floats
from processes import python_process
from rigid import _core
from rigid.model.scene import Scene


def assert_equal(one: dict[str, Any], other: dict[str, Any], of: object) -> None:
    """The bits of one body; without a force on any body of a call there is no work."""
    for name in one.keys() | other.keys():
        if name in one and name in other:
            assert np.asarray(one[name]).tobytes() == np.asarray(other[name]).tobytes(), (of, name)
        else:
            assert name == "work"
            assert not (one | other)[name].any(), of


@cache
def together(scene: str, door: str) -> list[dict[str, Any]]:
    return asked(scene, door, slice(None))


@pytest.mark.parametrize(("scene", "door"), CASES)
def test_neither_neighbours_nor_threads_nor_the_order_of_the_bodies_matter(
    scene: str, door: str
) -> None:
    bodies = together(scene, door)
    for k in (0, 1, 5, 31, 32, COUNT - 1):
        (alone,) = asked(scene, door, k)
        assert_equal(alone, bodies[k], k)
    backward = asked(scene, door, slice(None, None, -1), threads=3)
    for k, arrays in enumerate(bodies):
        assert_equal(arrays, backward[-1 - k], k)


UNITS = {
    "omega": (0, -1), "work": (1, -2), "start_omega": (0, -1), "lost_from": (0, 1), "end": (0, 1),
    "t": (0, 1), "error of an event": (0, 1), "slope": (0, -2), "spectrum": (0, -1),
}  # fmt: skip
"""Powers of the units of mass and of time; all other arrays are pure numbers."""

UNITS_OF_PARAMETERS = {
    "I1": (1, 0), "damping": (1, -1), "torque1": (1, -2), "mgl": (1, -2), "com3": (0, 0)
}  # fmt: skip


USUAL = [(2.0**40, 1.0), (1.0, 2.0**-20), (2.0**-20, 2.0**10)]
EXTREME = [
    *((2.0**power, 1.0) for power in (-1000, -301, 1020)),
    *((1.0, 2.0**power) for power in (60, -40)),
]
"""To the ends of the doubles."""


def units_for(scene: str, door: str) -> list[tuple[float, float]]:
    """Units of mass and time in which a door is asked for a scene."""
    by_a_method = door in (method.name for method in METHODS)
    steps = by_a_method or door.endswith(("checked steps", "method"))
    return [
        *(USUAL if scene in ("lagrange", "tops", "satellites") else []),
        *(EXTREME if steps and scene in ("lagrange", "top", "driven") else []),
    ]


@pytest.mark.parametrize(("scene", "door"), [case for case in CASES if units_for(*case)])
def test_units_of_mass_and_time_change_no_digit(scene: str, door: str) -> None:
    """They are powers of two: numbers change their exponents only."""
    rows, known = slice(0, 6), parameters(SCENES[scene](1.0, 1.0))
    powers = np.array([UNITS_OF_PARAMETERS[name] for name in known])
    plain = asked(scene, door, rows)
    for mass, time in units_for(scene, door):
        rate = np.array([1.0 / time] * 3 + [1.0] * 3)
        scaled_bodies = asked(scene, door, rows, mass, time)
        for here, there in zip(plain, scaled_bodies, strict=True):
            for name, array in here.items():
                kind = "error of an event" if "error of" in name else name.split(" of ")[0]
                of_mass, of_time = UNITS.get(kind, (0, 0))
                scaled = np.asarray(array)
                if scaled.dtype.kind == "f":
                    scaled = scaled * mass**of_mass * time**of_time
                if name == "tangent":
                    scaled = array * rate[:, None] / rate
                elif name == "sensitivity":
                    scaled = array * rate[:, None] / (mass ** powers[:, 0] * time ** powers[:, 1])
                np.testing.assert_array_equal(there[name], scaled, f"{name}, {mass}, {time}")


A_GROUP_AND_MORE = slice(0, 38)
"""Bodies of a group of 32, and a part of another: a pack of eight is not full."""


def digest(bodies: list[dict[str, Any]]) -> str:
    found = hashlib.sha256()
    for arrays in bodies:
        found.update(b"".join(np.asarray(arrays[name]).tobytes() for name in sorted(arrays)))
    return found.hexdigest()


def print_digests() -> None:
    """In a process of its own: the instruction set, and what every door comes to."""
    print(rigid.build_info()["isa"])
    for scene, door in CASES:
        print(digest(asked(scene, door, A_GROUP_AND_MORE)))


def test_every_instruction_set_gives_the_same_bytes() -> None:
    here = [digest(together(scene, door)[A_GROUP_AND_MORE]) for scene, door in CASES]
    assert len(here) > 200
    build = rigid.build_info()
    for isa in set(build["isa_available"]) - {build["isa"]}:
        code = "import test_same_bits; test_same_bits.print_digests()"
        assert python_process(code, RIGID_ISA=isa).stdout.splitlines() == [isa, *here]


@pytest.mark.parametrize("call", ["rigid.build_info()", "rigid.simulate(scene, [1, 2, 3], t=1.0)"])
def test_an_unknown_instruction_set_is_refused(call: str) -> None:
    code = f"import rigid; scene = rigid.FreeBody(rigid.Body((1, 2, 3))); {call}"
    done = python_process(code, RIGID_ISA="nonsense", check=False)
    assert done.returncode == 1
    available = ", ".join(rigid.build_info()["isa_available"])
    message = f"RuntimeError: RIGID_ISA = 'nonsense' is not available here; available: {available}"
    assert done.stderr.strip().endswith(message)


def test_a_variable_that_is_no_text_is_no_instruction_set() -> None:
    # A byte that no UTF-8 has, as Python names it.
    done = python_process("import rigid; rigid.build_info()", RIGID_ISA="\udcff", check=False)
    assert done.returncode == 1
    assert "RuntimeError: RIGID_ISA = '\ufffd' is not available here" in done.stderr


def test_an_empty_variable_is_no_choice() -> None:
    done = python_process("import rigid; print(rigid.build_info()['isa'])", RIGID_ISA="")
    assert done.stdout.strip() == rigid.build_info()["isa_available"][0]


def test_threads_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIGID_NUM_THREADS", "3")
    assert rigid.build_info()["threads"] == 3
    top = SCENES["top"](1.0, 1.0)
    asked_for: dict[str, Any] = {"t": [1.0], "method": "rk4", "check": False}
    there = rigid.simulate(top, OMEGA, **asked_for).omega
    assert there.tobytes() == rigid.simulate(top, OMEGA, threads=1, **asked_for).omega.tobytes()


# Modes of rounding and of flushing

with_modes = pytest.mark.skipif(not CAN_BE_SET, reason="needs glibc on x86-64")

#: Rates near the least normal number, beside rates of one: flushed, they would stop.
TINY = np.array([[1e-308, 1.0, 3e-308], [2e-308, 1e-309, 1.0]])
BOX = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=(0.6, 0.0, 0.8))
LAGRANGE = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.7)), mgl=1.2)
FORCED = rigid.FreeBody(
    rigid.Body((1.0, 2.0, 3.0)),
    torque=rigid.Torque.space((0.1, 0.2, 0.3)),
    damping=np.diag([0.1, 0.2, 0.3]),
)
MAP: dict[str, Any] = {
    "axes": {"spin": np.linspace(2.0, 6.0, 4)},
    "start": rigid.Start(spin=5.0, attitude_noise=rigid.normal(0.1)),
    "t_end": 20.0,
    "samples": 64,
    "rng": 2026,
}
FINISHED_BY_NUMPY = ("other times", "section of a rate", "section of the height")
"""Doors with numbers that NumPy rounds, as the processor is told to."""

TENSOR = [[2.0, 0.1, 0.3], [0.1, 3.0, 0.2], [0.3, 0.2, 4.0]]
ONE = np.array([[0.9, 0.3, 0.2, 0.1]])
COUNTS = np.arange(1, 4000)


def mapped(stable: Any) -> list[Floats]:
    result = rigid.stability_map(TOP, stable=stable, **MAP)
    names = ["share", "lower", "upper", "energy_drift", "earliest"]
    return [np.asarray(getattr(result, name)) for name in names]


def through(scene: Scene, door: str) -> list[Floats]:
    bodies = DOORS[door](scene, slice(0, 2), 1.0, 1.0, 1)
    return [np.asarray(array) for body in bodies for array in body.values()]


COMPUTED: dict[str, Callable[[], list[Floats]]] = {
    "tiny rates": lambda: [rigid.simulate(BOX, TINY, t=[0.0, 20.0], check=False).omega],
    "flips": lambda: [np.asarray(rigid.exact.flip_times(BOX, [0.1, 1.0, 2.0], count=3))],
    "map": lambda: mapped(rigid.tilt_below(0.5)),
    "map of verdicts": lambda: mapped(rigid.regular()),
    "principal axes": lambda: [np.array(_core.principal_axes(TENSOR)[1])],
    "unit quaternions": lambda: [np.asarray(_core.unit_quaternions(ONE))],
    "intervals": lambda: list(_core.clopper_pearson(COUNTS, np.full_like(COUNTS, 4000), 0.95)),
    "closed form": lambda: through(BOX, "chosen method"),
    "closed form of a top": lambda: through(LAGRANGE, "chosen method"),
    **{
        f"{door} of a top": partial(through, TOP, door)
        for door in DOORS
        if opens(door, TOP) and door not in FINISHED_BY_NUMPY
    },
    **{
        f"{door} under forces": partial(through, FORCED, door)
        for door in DOORS
        if opens(door, FORCED) and door not in FINISHED_BY_NUMPY
    },
}


@with_modes
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", COMPUTED)
def test_no_bit_follows_the_mode_of_the_processor(name: str, mode: str) -> None:
    expected = COMPUTED[name]()
    with float_mode(mode):
        before = control_word()
        found = COMPUTED[name]()
        assert control_word() == before
    for array, same in zip(found, expected, strict=True):
        assert array.tobytes() == same.tobytes()


@with_modes
def test_the_modes_are_those_of_the_thread() -> None:
    # Else the test above would show nothing.
    one, three, tiny = np.float64(1.0), np.float64(3.0), np.float64(2.0**-1022)
    thirds = {}
    for mode in MODES:
        with float_mode(mode):
            thirds[mode] = (one / three, tiny * np.float64(0.5) == 0.0, -one / three)
    assert thirds["up"][0] > thirds["down"][0] == thirds["to zero"][0]
    assert thirds["down"][2] < thirds["to zero"][2]
    assert thirds["flush"][1]
    assert not thirds["up"][1]
