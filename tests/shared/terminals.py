"""Processes whose standard error is a terminal."""

import fcntl
import os
import pty
import select
import struct
import subprocess
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager

from processes import PATIENCE, environment, python_command


@contextmanager
def in_terminal(
    *arguments: str, columns: int = 100
) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """This Python, its standard error being a terminal, and the end to read the terminal from."""
    reader, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    process = subprocess.Popen(
        python_command(*arguments), stdout=subprocess.PIPE, stderr=terminal, env=environment()
    )
    os.close(terminal)
    try:
        yield process, reader
    finally:
        process.kill()
        process.communicate()
        os.close(reader)


def read(reader: int, *, until: bytes = b"") -> bytes:
    """What the terminal shows until it has shown ``until``, or the process has closed it."""
    shown, end = b"", time.monotonic() + PATIENCE
    while time.monotonic() < end and not (until and until in shown):
        if select.select([reader], [], [], 0.1)[0]:
            try:
                shown += os.read(reader, 65536)
            except OSError:  # Linux: the other end is closed
                break
    return shown
