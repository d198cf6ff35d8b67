"""What does not fit into memory is refused with its bytes, and the interpreter lives."""

import json
import platform
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import rigid
from processes import python_process, run_python
from rigid import _core
from rigid.model.bodies import bodies_of
from rigid.store.head import Head
from rigid.store.rows import FIELDS, Table
from small_maps import spec_of

FREE = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))

#: Runs statements, each in a process with that many more megabytes of address space than it has.
LIMITED = """
import json, os, resource, sys, traceback
import numpy as np, rigid
from rigid import _core

free = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
top = rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=3.0, com=(0.6, 0.0, 0.8))
rigid.simulate(top, [1.0, 2.0, 3.0], t=[1.0])

def outcome(statement, megabytes):
    with open("/proc/self/statm") as file:
        pages = int(file.read().split()[0])
    before = resource.getrlimit(resource.RLIMIT_AS)
    limit = pages * resource.getpagesize() + megabytes * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (limit, before[1]))
    said = "done"
    try:
        exec(statement, globals())
    except MemoryError as error:
        said = error
    resource.setrlimit(resource.RLIMIT_AS, before)
    print(said, flush=True)
    assert rigid.simulate(free, [1.0, 2.0, 3.0], t=[1.0]).status == 0

before, *cases = json.loads(sys.argv[1])
exec(before)
for case in cases:
    child = os.fork()
    if not child:
        code = 1
        try:
            outcome(*case)
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    assert os.waitpid(child, 0)[1] == 0, case
"""

limited = pytest.mark.skipif(sys.platform != "linux", reason="limits the address space")


def outcomes(*cases: tuple[str, int], before: str = "") -> list[str]:
    """What statements say in processes that have so many megabytes, which must survive."""
    return python_process(LIMITED, json.dumps([before, *cases])).stdout.splitlines()


def test_states_beyond_any_memory_are_refused_before_the_start() -> None:
    # 10^6 bodies at 10^6 times: rates and attitudes of 56 bytes, and of each body 33 bytes more.
    with pytest.raises(MemoryError) as error:
        rigid.simulate(FREE, np.ones((10**6, 3)), t=np.linspace(0.0, 1.0, 10**6))
    message = str(error.value)
    assert "states of 1000000 bodies at 1000000 times: 56000041000000 bytes" in message
    assert "divide the request" in message


def test_numbers_of_flips_beyond_any_memory_are_refused() -> None:
    with pytest.raises(MemoryError, match="flip times: 8000000000000000 bytes"):
        rigid.exact.flip_times(FREE, [1.0, 2.0, 3.0], axis=2, count=10**15)
    # More than there are addresses: the product with the bytes of a number does not wrap around.
    with pytest.raises(MemoryError, match=f"flip times: {2 * 8 * 2**63} bytes"):
        _core.flip_times(bodies_of(FREE, np.ones((2, 3))), 2, 2**63)


@limited
def test_a_limit_of_the_address_space_is_a_memory_error() -> None:
    words = {
        "rigid.simulate(free, np.ones((10**6, 3)), t=[0.0, 1.0], check=False)": "divide the",
        "rigid.simulate(free, [1.0, 2.0, 3.0], t=times, check=False)": "states of 1 bodies",
        "rigid.simulate(top, np.ones((10**4, 3)), t=some, method='rk4')": "states of 10000",
        "rigid.exact.jacobi(times, 0.5)": "",
        "_core.MapStatistics(10**8)": "pixels of the map: 16000000000 bytes",
    }
    before = "times, some = np.linspace(0.0, 1.0, 3 * 10**6), np.linspace(0.0, 1.0, 300)"
    messages = outcomes(*((statement, 150) for statement in words), before=before)
    for message, told in zip(messages, words.values(), strict=True):
        assert message != "done"
        assert told in message


@limited
def test_the_interpreter_survives_any_limit() -> None:
    """Wherever the memory ends, in Python or in the core, it is an exception.

    The run is not checked: NumPy's linear algebra ends a process that lacks its memory.
    """
    statement = (
        "rigid.simulate(top, omega, t=[0.5, 1.0], method='taylor16', tolerance=1e-9, threads=64, "
        "check=False)"
    )
    limits = [1, 3, 10, 30, 60, 100, 200]
    told = outcomes(*((statement, most) for most in limits), before="omega = np.ones((3000, 3))")
    assert len(told) == len(limits)


@limited
def test_a_unit_of_any_size_needs_no_memory() -> None:
    """A list of its blocks took 24 bytes for each 1024 bodies: 24 petabytes of this map."""
    before = """
import signal
def alarm(*_):
    raise TimeoutError
signal.signal(signal.SIGALRM, alarm)
"""
    statement = """
signal.setitimer(signal.ITIMER_REAL, 0.5)
try:
    rigid.stability_map(
        rigid.FreeBody, axes={"spin": [1.0]}, samples=10**18, t_end=5.0,
        stable=rigid.no_flip(), rng=1, threads=2, progress=False,
    )
except TimeoutError:
    print("still at work")
"""
    assert outcomes((statement, 300), before=before) == ["still at work", "done"]


@limited
def test_threads_that_cannot_start_are_done_without() -> None:
    """The stacks of 1023 more threads need 2 GB: the bodies are moved by those that start."""
    before = """
omega = np.random.default_rng(1).normal(size=(40000, 3))
def states(threads):
    return rigid.simulate(top, omega, t=[0.1], method="rk4", check=False, threads=threads).omega
def shares(threads):
    return rigid.stability_map(
        rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10000, t_end=3.0, method="rk4", rng=1,
        stable=rigid.no_flip(), progress=False, threads=threads,
    ).share
alone = states(1), shares(1)
"""
    statement = "assert (states(1024) == alone[0]).all() and (shares(1024) == alone[1]).all()"
    assert outcomes((statement, 600), before=before) == ["done"]


@pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc" or shutil.which("cc") is None,
    reason="replaces the allocator of the GNU C library",
)
def test_an_allocation_of_the_core_that_fails_harms_no_result() -> None:
    """The first of each call; ``tests/long/failed_allocations.py`` takes them all."""
    script = Path(__file__).parents[2] / "long" / "failed_allocations.py"
    done = run_python(str(script), "--most", "8", check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "stability_map: 8 allocations" in done.stdout


@limited
def test_a_section_without_end_is_refused_when_its_points_do_not_fit() -> None:
    statement = (
        "rigid.poincare(free, np.full((64, 3), 1e3), section='gamma1', t_end=1e9, check=False)"
    )
    assert "points of a section" in outcomes((statement, 16))[0]


# Memory of a map: that of its pixels, whatever the number of bodies or their horizon.


CODE = """
import sys
import rigid
pixels, samples, t_end = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
result = rigid.stability_map(
    rigid.FreeBody,
    axes={"spin": [1.0 + i / pixels for i in range(pixels)]},
    start=rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.01)),
    samples=samples, t_end=t_end, stable=rigid.no_flip(), method="rk4", step=0.05, check=0.0,
    rng=1, threads=2, progress=False,
)
assert result.complete and result.stable.sum() == pixels * samples
print([line for line in open("/proc/self/status") if line.startswith("VmHWM")][0].split()[1])
"""


def peak(pixels: int, samples: int, t_end: float) -> float:
    """The most memory that a process computing this map ever held (MB), which is told in kB."""
    return int(python_process(CODE, *map(str, (pixels, samples, t_end))).stdout) / 1024.0


@limited
def test_a_hundred_times_the_bodies_take_no_more_memory() -> None:
    # Two million rows of even one number would be 16 MB, of a start and a record 200 MB. What may
    # differ is the chunk in flight: a third of a second of bodies, and each thread's block of them.
    small, large = peak(100, 200, 1.0), peak(100, 20_000, 1.0)
    assert large - small < 10.0


@limited
def test_a_hundred_times_the_horizon_takes_no_more_memory() -> None:
    # A million steps of one body would be 24 MB of rates.
    short, long = peak(2, 8, 500.0), peak(2, 8, 50_000.0)
    assert long - short < 5.0


def test_a_map_that_is_too_large_tells_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no memory is left; a real request of this size might be granted, page by page."""
    spec = spec_of(axes={"spin": np.linspace(1.0, 2.0, 100)}, samples=64_000_000)
    head = Head(spec, segment=64)

    def refused(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(np, "zeros", refused)
    # Of each piece a number of eight bytes, and one for each column.
    needed = round(8 * 10**8 * (1 + len(FIELDS)) / 1024**3)
    words = f"axes: the columns of 100,000,000 pixels need {needed} GiB; take"
    with pytest.raises(MemoryError, match=words):
        Table(head)
