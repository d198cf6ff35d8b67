"""The same request gives the same bits on any instruction set, thread count and in any company."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import pytest

import rigid
from physics import METHODS
from processes import python_process
from rigid.model.scene import Scene
from rigid.solve.status import ARRIVED

TOP = rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=3.0, com=(0.48, -0.64, 0.6))
SCENES: dict[str, Scene] = {
    "free": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
    "symmetric": rigid.FreeBody(rigid.Body((1.5, 1.0, 1.5))),
    "top": TOP,
    "symmetric top": rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=3.0),
}


def batch(scene: Scene, method: str, n: int = 103, **options: Any) -> rigid.Run:
    """Slow and fast bodies: own steps, large angles, and some that overflow with a step of one."""
    rng = np.random.default_rng(3)
    omega = rng.standard_normal((n, 3)) * 10.0 ** rng.uniform(-2, 1.5, (n, 1))
    attitude = rng.standard_normal((n, 4))
    return rigid.simulate(scene, omega, attitude, t=[-0.3, 0.0, 0.5, 1.0], method=method, **options)


def columns(run: rigid.Run) -> dict[str, np.ndarray]:
    names = [
        "omega",
        "gamma",
        "attitude",
        "energy_drift",
        "momentum_drift",
        "unit_drift",
        "status",
        "steps",
    ]
    found = {name: getattr(run, name) for name in names if getattr(run, name) is not None}
    # Whether the error of a body is estimated depends on its batch; how the body ended does not.
    found["status"] = np.where(np.isin(run.status, ARRIVED), rigid.Status.OK, run.status)
    return found


def content(run: rigid.Run) -> dict[str, bytes]:
    return {name: array.tobytes() for name, array in columns(run).items()}


def print_digests() -> None:
    """In a process of its own: the instruction set, and what every mixed batch comes to."""
    print(rigid.build_info()["isa"])
    for method in METHODS:
        for name, scene in SCENES.items():
            for step in (None, 1.0):
                for record in ("rates", "axis", "attitude"):
                    run = batch(scene, method.name, step=step, record=record)
                    arrays = content(run)
                    digest = hashlib.sha256(b"".join(arrays.values())).hexdigest()
                    print(method.name, name, step, record, *arrays, digest)


def test_every_instruction_set_gives_the_same_bytes() -> None:
    available = rigid.build_info()["isa_available"]
    output = {}
    for isa in available:
        code = "import test_same_bits; test_same_bits.print_digests()"
        used, *output[isa] = python_process(code, RIGID_ISA=isa).stdout.splitlines()
        assert used == isa
    for isa in available:
        assert len(output[isa]) == len(METHODS) * len(SCENES) * 2 * 3
        assert output[isa] == output[available[0]], isa


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


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_the_number_of_threads_does_not_matter(method: rigid.Method, scene: str) -> None:
    one = content(batch(SCENES[scene], method.name, threads=1))
    for threads in (2, 3, 7):
        assert content(batch(SCENES[scene], method.name, threads=threads)) == one


def test_threads_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    one = content(batch(TOP, "rk4", threads=1))
    monkeypatch.setenv("RIGID_NUM_THREADS", "3")
    assert rigid.build_info()["threads"] == 3
    assert content(batch(TOP, "rk4")) == one


@pytest.mark.parametrize("step", [None, 1.0])
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_body_alone_is_the_body_in_the_batch(
    method: rigid.Method, scene: str, step: float | None
) -> None:
    rng = np.random.default_rng(5)
    n = 67
    omega = rng.standard_normal((n, 3)) * 10.0 ** rng.uniform(-2, 1.5, (n, 1))
    attitude = rng.standard_normal((n, 4))
    options: dict[str, Any] = {"t": [-0.3, 0.0, 1.0], "method": method.name, "step": step}
    whole = columns(rigid.simulate(SCENES[scene], omega, attitude, **options))
    for k in (0, 1, 7, 8, 31, 32, 63, 66):
        alone = columns(rigid.simulate(SCENES[scene], omega[k], attitude[k], **options))
        ragged = columns(
            rigid.simulate(SCENES[scene], omega[: k + 1], attitude[: k + 1], **options)
        )
        for name, array in whole.items():
            assert array[k].tobytes() == alone[name].tobytes(), name
            assert array[: k + 1].tobytes() == ragged[name].tobytes(), name


def test_the_order_of_the_bodies_does_not_matter() -> None:
    rng = np.random.default_rng(6)
    omega, order = rng.standard_normal((50, 3)), rng.permutation(50)
    for method in METHODS:
        there = columns(rigid.simulate(TOP, omega, t=[0.5, 2.0], method=method.name))
        other = columns(rigid.simulate(TOP, omega[order], t=[0.5, 2.0], method=method.name))
        for name, array in there.items():
            assert array[order].tobytes() == other[name].tobytes()
