"""Python in processes of its own, which find the same ``rigid`` and the same tests."""

import os
import subprocess
import sys

import pytest

Capture = pytest.CaptureFixture[str]
"""What a test is given that reads what a call prints."""

#: Ends a process that hangs. No process of the tests needs a tenth of it, even on a slow machine.
PATIENCE = 600.0


def python_command(*arguments: str) -> list[str]:
    """This Python, in which every warning is an error and the working folder hides no module."""
    return [sys.executable, "-P", "-W", "error", *arguments]


def environment(**variables: str) -> dict[str, str]:
    """The environment of this process, with its search path and ``variables``."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), **variables}


def run_python(
    *arguments: str, check: bool = True, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run this Python with ``arguments``; unless told otherwise it must succeed."""
    done = subprocess.run(
        python_command(*arguments),
        capture_output=True,
        text=True,
        env=environment(**variables),
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0 or not check, done.stderr
    return done


def python_process(
    code: str, *arguments: str, check: bool = True, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run ``code``, whose ``sys.argv[1:]`` are ``arguments``, in a process of its own."""
    return run_python("-c", code, *arguments, check=check, **variables)
