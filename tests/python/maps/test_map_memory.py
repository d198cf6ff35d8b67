"""Memory of a map: that of its pixels, whatever the number of bodies or their horizon."""

import sys
from typing import Any

import numpy as np
import pytest

from processes import python_process
from rigid.store.head import Head
from rigid.store.rows import FIELDS, Table
from small_maps import spec_of

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

MEGABYTE = 1024.0  # in the unit of /proc

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/status")


def peak(pixels: int, samples: int, t_end: float) -> float:
    """The most memory that a process computing this map ever held (MB)."""
    arguments: list[Any] = [pixels, samples, t_end]
    return int(python_process(CODE, *map(str, arguments)).stdout) / MEGABYTE


def test_a_hundred_times_the_bodies_take_no_more_memory() -> None:
    # Two million rows of even one number would be 16 MB, of a start and a record 200 MB. What may
    # differ is the chunk in flight: a third of a second of bodies, and each thread's block of them.
    small, large = peak(100, 200, 1.0), peak(100, 20_000, 1.0)
    assert large - small < 10.0


def test_a_hundred_times_the_horizon_takes_no_more_memory() -> None:
    # A million steps of one body would be 24 MB of rates.
    short, long = peak(2, 8, 500.0), peak(2, 8, 50_000.0)
    assert long - short < 5.0


def test_a_map_that_is_too_large_tells_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no memory is left; a real request of this size might be granted, page by page."""
    spec = spec_of(axes={"spin": np.linspace(1.0, 2.0, 100_000)}, samples=64_000)
    head = Head(spec, segment=64)

    def refused(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(np, "zeros", refused)
    # Of each piece a number of eight bytes, and one for each column.
    needed = round(8 * 10**8 * (1 + len(FIELDS)) / 1024**3)
    words = f"axes: the columns of 100,000,000 pixels need {needed} GiB; take"
    with pytest.raises(MemoryError, match=words):
        Table(head)
