"""The build of this installation and its instruction set."""

from __future__ import annotations

from typing import Any

from . import _core
from ._checks.arguments import resolve_threads
from ._checks.extras import DISTRIBUTION


def build_info() -> dict[str, Any]:
    """Names and version of this library, its build, and the processor features that it uses.

    ``distribution`` is the name to install, ``import`` the name in a program. ``commit`` is None
    if it is not known. ``isa`` is the instruction set in use, ``isa_available`` lists all.

    The environment variable ``RIGID_ISA`` (``avx512``, ``avx2``, ``scalar``) forces an instruction
    set; all give the same bits. On x86-64 ``scalar`` is compiled by the Cargo feature ``plain``
    only; other processors have it alone.

    Returns
    -------
    dict
        ``version``; ``commit``, None if unknown; ``profile`` of the build; ``isa``, the instruction
        set in use; ``isa_available``, all instruction sets of this processor and build;
        ``threads``, the default number of threads.

    Raises
    ------
    RuntimeError
        If ``RIGID_ISA`` names an instruction set that is unknown or not available here.

    Examples
    --------
    >>> import rigid
    >>> sorted(rigid.build_info())
    ['commit', 'distribution', 'import', 'isa', 'isa_available', 'profile', 'threads', 'version']
    """
    names = {"distribution": DISTRIBUTION, "import": __package__}
    return {**names, **_core.build_info(), "threads": resolve_threads(None)}
