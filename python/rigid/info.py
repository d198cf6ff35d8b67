"""The build of this installation and its instruction set."""

from __future__ import annotations

from typing import Any

from . import _core
from ._checks.arguments import resolve_threads

__all__ = ["build_info"]


def build_info() -> dict[str, Any]:
    """Version, commit if known, build profile, instruction set in use, those available, threads.

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
    ['commit', 'isa', 'isa_available', 'profile', 'threads', 'version']
    """
    return {**_core.build_info(), "threads": resolve_threads(None)}
