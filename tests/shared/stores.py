"""What the tests of running maps share: small maps with their rows, and disks that fail."""

import errno
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

import rigid
from rigid.maps.spec import MapSpec
from rigid.store.disk import Buffer, Disk
from rigid.store.resume import Outcome, carry_on, result_of
from rigid.store.running import Folder
from small_maps import spec_of

#: Closed forms: 144 of 240 pixels have a possible body.
SPEC: MapSpec = spec_of(
    axes={"I2/I1": np.linspace(0.5, 3.5, 20), "noise": np.geomspace(1e-3, 0.1, 12)},
    method="auto",
    samples=20,
)


def request(**options: Any) -> dict[str, Any]:
    """The arguments of ``stability_map`` that ask for :data:`SPEC`."""
    return {
        "scene": SPEC.scene,
        "start": SPEC.start,
        "axes": {axis.name: axis.values for axis in SPEC.axes},
        "stable": SPEC.stable,
        "t_end": SPEC.t_end,
        "samples": SPEC.samples,
        "method": SPEC.method,
        "rng": SPEC.seed,
        "progress": False,
        **options,
    }


def go_on(
    path: Path,
    disk: Disk | None = None,
    *,
    spec: MapSpec = SPEC,
    stop: Callable[[], bool] = lambda: False,
    **options: Any,
) -> Outcome:
    """One sitting of a running map."""
    folder = Folder.at(path, spec, disk or Disk())
    return carry_on(folder, threads=1, stop=stop, progress=False, **options)


def stops_after(count: int) -> Callable[[], bool]:
    """A stop after so many questions: not by time."""
    left = iter(range(count))
    return lambda: next(left, None) is None


def numbers(path: Path) -> bytes:
    """The rows that a running map holds."""
    return Folder(path).table.rows.tobytes()


def stored_map(path: Path) -> rigid.StabilityMap:
    """The map of the rows that a folder holds."""
    return result_of(Folder(path), rigid.StabilityMap)


class FailingDisk(Disk):
    """A disk whose operation number ``fails`` fails, once or from then on.

    Attributes
    ----------
    done : int
        Operations so far.
    """

    def __init__(self, fails: int, how: str) -> None:
        self.fails, self.how, self.done = fails, how, 0

    def _next(self) -> bool:
        """Whether this operation is the one; raises an error unless it is to be short."""
        self.done += 1
        wrong = self.done == self.fails or (self.how == "full" and self.done > self.fails)
        if wrong and self.how != "short":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return wrong

    def make_folder(self, path: Path) -> None:
        self._next()
        super().make_folder(path)

    def publish(self, path: Path, content: bytes) -> None:
        self._next()
        super().publish(path, content)

    def create(self, path: Path) -> int:
        self._next()
        return super().create(path)

    def write(self, descriptor: int, buffers: Sequence[Buffer]) -> int:
        if self.how == "torn":
            self.done += 1
            if self.done == self.fails:  # a third is written, then the process is gone
                whole = b"".join(buffers)
                os.write(descriptor, whole[: len(whole) // 3])
                raise Gone
            return super().write(descriptor, buffers)
        if self._next():
            return super().write(descriptor, [bytes(buffers[0])[:1]])
        return super().write(descriptor, buffers)

    def cut(self, descriptor: int, size: int) -> None:
        if self.how != "torn":
            super().cut(descriptor, size)

    def synchronise(self, descriptor: int) -> None:
        self._next()
        super().synchronise(descriptor)

    def synchronise_folder(self, path: Path) -> None:
        self._next()
        super().synchronise_folder(path)

    def names(self, path: Path) -> list[str]:
        self._next()
        return super().names(path)

    def read(self, path: Path) -> bytes:
        self._next()
        return super().read(path)


class Gone(BaseException):
    """The process ends here."""


def damage(file: BinaryIO, at: int, content: bytes) -> None:
    """Overwrite bytes."""
    file.seek(at)
    file.write(content)
