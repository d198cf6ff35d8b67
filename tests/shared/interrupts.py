"""Maps that would take hours, interrupted."""

import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from processes import PATIENCE, environment, python_command


@contextmanager
def sigint(handler: Any) -> Iterator[None]:
    """SIGINT handled so, also in processes that are started: they inherit that it is ignored."""
    previous = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)


#: Hours of work on any machine: what returns was interrupted.
LONG = {
    "many bodies": 'axes={"spin": np.linspace(1.0, 2.0, 100)}, samples=10**5, t_end=5e3',
    # Hours for a single body: the interrupt has to get through to the kernel.
    "long bodies": 'axes={"spin": [1.0, 1.1]}, samples=200, t_end=1e12, max_steps=10**15',
    "one body": 'axes={"spin": [1.0]}, samples=1, t_end=1e12, max_steps=10**15, check=0.0',
}

#: Says "ready" as soon as Ctrl-C is heard by the map, or when some of many bodies are done.
INTERRUPTED = """
import signal, threading, time
import numpy as np, rigid

# A shell that starts the tests in the background lets them ignore it.
signal.signal(signal.SIGINT, signal.default_int_handler)

def ready(progress=None):
    global said
    if not said:
        print("ready", flush=True)
    said = True

def wait():
    while signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        time.sleep(0.001)
    ready()

said = False
many = {many}
if not many:
    threading.Thread(target=wait, daemon=True).start()
try:
    rigid.stability_map(
        rigid.FreeBody, {size}, stable=rigid.no_flip(), rng=1, progress=ready if many else False,
        method="rk4", start=rigid.Start(spin=1.0, axis=3, noise=rigid.normal(0.01)),
    )
except rigid.Interrupted as interrupted:
    result = interrupted.partial
done = int(result.samples.sum())
assert not result.complete and done == result.stable.sum() + result.unstable.sum()
assert done > 0 if many else done == 0
result.summary()
print("partial", flush=True)
"""


def seconds_until_interrupted(size: str) -> float:
    """Time from SIGINT to the end of a process that computes this map and keeps what is done."""
    code = INTERRUPTED.format(size=LONG[size], many=size == "many bodies")
    with subprocess.Popen(
        python_command("-c", code),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment(),
    ) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            time.sleep(0.3)  # on most machines the core is at work by then
            process.send_signal(signal.SIGINT)
            begun = time.monotonic()
            output, errors = process.communicate(timeout=PATIENCE)
            waited = time.monotonic() - begun
        finally:
            process.kill()
    assert output == b"partial\n", errors
    assert process.returncode == 0
    return waited
