"""The name under which this library is installed, and how to install one of its extras."""

from __future__ import annotations

DISTRIBUTION = "rigid-rotation"
"""The name on the package index, where ``rigid`` is another project; the import is ``rigid``."""


def install_extra(need: str, extra: str) -> str:
    """What is needed, and the command that installs it.

    Parameters
    ----------
    need : str
        Such as ``"plotting needs matplotlib"``.
    extra : str
        The extra of ``pyproject.toml`` that has it.
    """
    return f"{need}: pip install '{DISTRIBUTION}[{extra}]'"
