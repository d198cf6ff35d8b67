"""Rounding modes and flush modes of the processor, as other libraries leave them."""

import ctypes
import ctypes.util
import platform
from collections.abc import Iterator
from contextlib import contextmanager

#: Bits of MXCSR: round down, up, to zero; flush results to zero, read subnormal numbers as zero.
MODES = {"down": 0x2000, "up": 0x4000, "to zero": 0x6000, "flush": 0x8000, "flush reads": 0x0040}

#: Whether modes can be set here: glibc keeps MXCSR at the end of its environment.
CAN_BE_SET = platform.machine() == "x86_64" and platform.libc_ver()[0] == "glibc"

_AT = 28
"""Where MXCSR lies in `fenv_t` of glibc on x86-64, which has 32 bytes."""


def control_word() -> int:
    """MXCSR of this thread, without the sticky flags."""
    return int.from_bytes(_environment()[_AT:], "little") & ~0x3F


@contextmanager
def float_mode(name: str) -> Iterator[None]:
    """The mode of that name in this thread, until the end of the block."""
    before = _environment()
    word = int.from_bytes(before[_AT:], "little") & ~0xE040 | MODES[name]
    _set(before[:_AT] + word.to_bytes(4, "little"))
    try:
        yield
    finally:
        _set(before)


def _library() -> ctypes.CDLL:
    return ctypes.CDLL(ctypes.util.find_library("m"))


def _environment() -> bytes:
    room = ctypes.create_string_buffer(32)
    assert _library().fegetenv(room) == 0
    return room.raw


def _set(environment: bytes) -> None:
    assert _library().fesetenv(ctypes.create_string_buffer(environment, 32)) == 0
