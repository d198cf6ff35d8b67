"""Every bench runs for a moment, and refuses what no measurement can be. No test asserts a time."""

import importlib.util
import itertools
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from physics import Floats
from processes import python_process, run_python

FOLDER = Path(__file__).parents[3] / "benches"
FILES = sorted(FOLDER.rglob("*.py"))
BENCHES = [
    path
    for path in FILES
    # It reads machine code and measures nothing: what refuses calls is tested below.
    if "__main__" in path.read_text() and path.name != "kernel_calls.py"
]
WRITTEN = FOLDER / "peers" / "measured.json"
"""What a bench writes when it measures."""


def loaded(name: str) -> Any:
    """A script of the folder as a module."""
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


timing, kernel_calls = loaded("timing"), loaded("kernel_calls")

WITHOUT_PEERS = """
import runpy, sys
sys.modules["numba"] = sys.modules["heyoka"] = None  # as if they were not installed
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def rows(printed: str) -> list[str]:
    """The lines with numbers that a quick run prints."""
    head, *lines = [line for line in printed.splitlines() if "not installed" not in line]
    assert head == "quick run: not a measurement"
    assert not re.search(r"\b(nan|inf)\b", printed)
    return [line for line in lines if re.search(r"\d", line)]


def path_of(bench: Path) -> str:
    """The search path with the folder of a bench first, as for the user who runs it."""
    return os.pathsep.join([str(bench.parent), *filter(None, sys.path)])


@pytest.mark.parametrize("bench", BENCHES, ids=lambda bench: bench.stem)
def test_a_quick_run_prints_rows_and_keeps_what_was_measured(bench: Path, tmp_path: Path) -> None:
    before = WRITTEN.read_bytes()
    done = run_python(str(bench), "--quick", PYTHONPATH=path_of(bench), TMPDIR=str(tmp_path))
    assert rows(done.stdout)
    assert WRITTEN.read_bytes() == before


def test_what_needs_a_peer_that_is_missing_is_left_out() -> None:
    """The gate has no peers, so there the quick runs above show it of the other benches."""
    bench = FOLDER / "peers" / "compare.py"
    done = python_process(WITHOUT_PEERS, str(bench), "--quick", PYTHONPATH=path_of(bench))
    assert rows(done.stdout)
    assert re.search("(numba|heyoka) is not installed: what needs it is omitted", done.stdout)


LOST = """
import numpy as np
from compare import SCENES, Sweep

class Side:
    take = prepare = run = lambda self, _: None

    def state(self):
        return rates, np.tile(np.eye(3), (len(rates), 1, 1))

rates = np.ones((3, 3))
truth = rates * (1 + 1e-9), Side().state()[1]
print(Sweep(Side(), SCENES[0], truth).at(1)[0] < 1e-8)
rates = rates * [[1.0], [1.0], [np.nan]]
print(Sweep(Side(), SCENES[0], truth).at(1)[0])
"""


def test_a_side_that_loses_a_body_does_not_reach_the_error_of_the_others() -> None:
    done = python_process(LOST, PYTHONPATH=path_of(FOLDER / "peers" / "compare.py"))
    assert done.stdout.splitlines()[-2:] == ["True", "inf"]


def test_every_other_file_is_used_by_a_bench() -> None:
    used = "".join(path.read_text() for path in FILES)
    for path in set(FILES) - set(BENCHES) - {FOLDER / "kernel_calls.py"}:
        assert re.search(rf"^\s*(import|from) {path.stem}\b", used, re.MULTILINE)


class Clock:
    """A clock that shows what has passed, a nanosecond later each time that it is read."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 1e-9
        return self.now


def test_sides_take_turns_and_their_times_are_those_of_a_call() -> None:
    clock, order = Clock(), []

    def side(name: str, seconds: float) -> Callable[[], str]:
        def call() -> str:
            clock.now += seconds
            order.append(name)
            return name

        return call

    checked: list[str] = []
    times = timing.in_turns(
        {"one": side("one", 1.0), "two": side("two", 2.0)},
        checked.append,
        repeats=3,
        calls=2,
        clock=clock,
    )
    assert order == ["one", "two", *["one", "one", "two", "two"] * 3]
    assert checked == ["one", "two"] * 3
    # Two readings of the clock are 1e-9 s of a turn of two calls; sums up to 20 are exact to 4e-15.
    np.testing.assert_allclose(times["one"], np.full(3, 1.0 + 0.5e-9), rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(times["two"], np.full(3, 2.0 + 0.5e-9), rtol=0.0, atol=1e-14)
    assert timing.over("two over one", times["two"], times["one"]) == pytest.approx(2.0, abs=1e-9)


def test_a_call_that_takes_no_time_and_a_clock_that_stands_still_are_refused() -> None:
    for clock, words in (
        (itertools.count(0.0, 1e-6).__next__, r"turn of nothing = 1\.0e-06 s: must be 100 ticks"),
        (lambda: 7.0, r"clock = 7 s: stands still"),
    ):
        with pytest.raises(SystemExit, match=words):
            timing.in_turns({"nothing": lambda: None}, lambda _: None, repeats=1, clock=clock)


def test_a_coarse_clock_is_read_until_it_goes_on() -> None:
    readings = itertools.count()
    assert timing.tick(lambda: 2.0**-6 * (next(readings) // 5000)) == 2.0**-6


def test_states_of_the_start_and_those_that_are_not_finite_are_refused() -> None:
    start = np.array([[0.1, 1.0, 0.2], [0.3, 1.0, 0.4]])
    end = start + np.array([[0.0, 0.5, 0.0], [0.0, 0.0, -0.5]])
    timing.moved(end, start, [3, 1])
    for wrong, steps, named in (
        (start, 1, "body 0"),
        ([end[0], start[1]], 1, "body 1"),
        ([end[0], [0.1, np.nan, 0.2]], 1, "body 1"),
        ([[np.inf, 0.0, 0.0], end[1]], 1, "body 0"),
        (end, [3, 0], "body 1"),
        (end, 0, "body 0"),
    ):
        with pytest.raises(SystemExit, match=rf"state of {named} = .*not that of the start"):
            timing.moved(wrong, start, steps)
    with pytest.raises(SystemExit, match="of one body or more"):
        timing.moved(np.empty((0, 3)), np.empty((0, 3)))


def test_the_result_of_each_turn_is_checked() -> None:
    start = np.ones((2, 3))
    clock, ends = Clock(), iter([2.0 * start, 2.0 * start, start])

    def side() -> Floats:
        clock.now += 1.0
        return next(ends)

    with pytest.raises(SystemExit, match="state of body 0"):
        timing.in_turns(
            {"body": side}, lambda end: timing.moved(end, start), repeats=2, clock=clock
        )
    assert not list(ends)


def test_a_map_without_some_of_its_bodies_is_refused() -> None:
    classes = {"stable": [3, 4], "unstable": [2, 1], "undecided": [0, 1], "failed": [1, 0]}
    timing.counted(classes, 12)
    with pytest.raises(SystemExit, match="must be 13 together"):
        timing.counted(classes, 13)
    nothing = {**classes, "stable": 0, "unstable": 0}
    with pytest.raises(SystemExit, match="some must be decided"):
        timing.counted(nothing, 2)


@pytest.mark.parametrize("number", [np.nan, np.inf, 0.0, -0.1])
def test_a_ratio_is_positive_and_finite(number: float) -> None:
    message = rf"call over core = {number:g}: must be positive and finite"
    with pytest.raises(SystemExit, match=re.escape(message)):
        timing.positive("call over core", number)
    with pytest.raises(SystemExit, match=re.escape(message)):
        timing.over("call over core", [number] * 3, np.ones(3))


def test_no_share_is_above_one() -> None:
    assert timing.share("share of the peak", 1.0) == 1.0
    with pytest.raises(SystemExit, match=r"share of the peak = 1\.2: must be at most 1"):
        timing.share("share of the peak", 1.2)


def test_a_refusal_ends_the_bench_with_its_words() -> None:
    refused = "import timing; timing.share('share of the peak', 37.0); print('printed')"
    done = python_process(refused, check=False, PYTHONPATH=path_of(FOLDER / "timing.py"))
    assert done.returncode == 1
    assert done.stderr == "share of the peak = 37: must be at most 1\n"
    assert not done.stdout


def test_a_peer_that_is_there_but_does_not_work_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "broken_peer.py").write_text("import absent_peer\n")
    assert timing.installed("absent_peer") is None
    assert "absent_peer is not installed" in capsys.readouterr().out
    with pytest.raises(ModuleNotFoundError, match="absent_peer"):
        timing.installed("broken_peer")


# The command that refuses calls inside kernels reads machine code: it must see what is wrong.


KERNEL = "rigid::kernel::registry::kernels_of::Taylor::avx2::advance"
TABLE = {0x9000: "memcpy@GLIBC_2.14", 0x9008: "fma@GLIBC_2.2.5", 0x9010: "rigid::method::only"}


def refused(*instructions: str, name: str = KERNEL) -> list[tuple[str, str]]:
    """What is refused of a function of these instructions, which begin at 0x100."""
    listing = [f"{0x100:016x} <{name}>:"]
    listing += [f"     {0x100 + 4 * i:x}:\t{text}" for i, text in enumerate(instructions)]
    (function,) = kernel_calls.functions(listing, TABLE)
    assert kernel_calls.KERNEL.search(function.name)
    why = [(name, kernel_calls.why_refused(function, at, name)) for at, name in function.calls]
    return [(name, reason) for name, reason in why if reason is not None]


@pytest.mark.parametrize(
    "call",
    [
        "call   200 <rigid::method::only>",
        "addr32 call 200 <rigid::method::only>",
        "call   *0x8f10(%rip)        # 9010 <_GLOBAL_OFFSET_TABLE_+0x10>",
        "jmp    200 <rigid::method::only>",
        "jmp    210 <rigid::method::only+0x10>",
        "jmp    *0x8f10(%rip)        # 9010 <_GLOBAL_OFFSET_TABLE_+0x10>",
    ],
)
def test_a_call_inside_a_kernel_is_refused(call: str) -> None:
    assert refused("push   %rbp", call, "ret") == [("rigid::method::only", "not inlined")]


def test_a_call_to_an_address_that_is_computed_is_refused() -> None:
    assert refused("call   *%rax") == [("call   *%rax", "not inlined")]


def test_kernels_under_the_torque_of_a_function_call_its_address() -> None:
    called = (
        "rigid::kernel::registry::kernels_of::Rk4::avx2::advance::<rigid::scene::FunctionFrame>"
    )
    assert not refused("call   *0x28(%rax)", name=called)
    assert refused("call   200 <rigid::method::only>", name=called)


def test_a_call_of_a_register_is_one_of_what_is_loaded_there() -> None:
    fma = "mov    0x8f08(%rip),%rbx        # 9008 <_GLOBAL_OFFSET_TABLE_+0x8>"
    other = "mov    0x8f10(%rip),%r12        # 9010 <_GLOBAL_OFFSET_TABLE_+0x10>"
    plain = "rigid::kernel::registry::kernels_of::Taylor::scalar::advance"
    assert not refused(fma, "call   *%rbx", name=plain)
    assert refused(fma, other, "call   *%r12", name=plain) == [
        ("rigid::method::only", "not inlined")
    ]


def test_jumps_within_a_kernel_and_refused_indices_are_no_calls() -> None:
    assert not refused(
        "je     10c <rigid::kernel::registry::kernels_of::Taylor::avx2::advance+0xc>",
        "jmp    100 <rigid::kernel::registry::kernels_of::Taylor::avx2::advance>",
        "call   300 <core::panicking::panic_bounds_check>",
        "call   400 <core::slice::index::slice_end_index_len_fail>",
    )


def test_a_kernel_may_be_the_code_of_another() -> None:
    assert not refused("jmp    200 <rigid::kernel::registry::kernels_of::Taylor::avx2::advance>")


def test_a_copy_is_refused_in_every_step_only() -> None:
    copy = "call   *0x8f00(%rip)        # 9000 <_GLOBAL_OFFSET_TABLE_>"
    loop = "jne    104 <rigid::kernel::registry::kernels_of::Taylor::avx2::advance+0x4>"
    assert refused("push   %rbp", copy, loop, loop) == [("memcpy@GLIBC_2.14", "in every step")]
    assert not refused("push   %rbp", copy, loop)
    assert not refused(copy, "push   %rbp", loop, loop)


def test_only_the_plain_path_rounds_with_the_c_library() -> None:
    call = "call   *0x8f08(%rip)        # 9008 <_GLOBAL_OFFSET_TABLE_+0x8>"
    fused = "vfmadd231pd %ymm0,%ymm1,%ymm2"
    assert refused(fused, call) == [("fma@GLIBC_2.2.5", "although it has FMA")]
    assert not refused(
        "mulsd  %xmm0,%xmm1",
        call,
        name="rigid::kernel::registry::kernels_of::Taylor::scalar::advance",
    )
