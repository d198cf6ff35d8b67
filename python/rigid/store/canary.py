"""Canaries: stored units that a process computes again before it adds rows.

Another version, a faulty machine or a mixed cluster gives other bytes, and is refused.
"""

from __future__ import annotations

from collections.abc import Callable
from hashlib import blake2b

import numpy as np

from ..maps.spec import MapSpec
from .compute import compute
from .head import StoreError
from .rows import Block, Table, unequal

__all__ = ["canaries", "check_canaries"]

MOST_UNITS = 16
MOST_SECONDS = 0.5
"""Most rows that are computed again, and most processor time (s) of these rows."""

MOST_CANDIDATES = 4096
"""Units whose digests are compared: evenly spaced among those that are known."""


def canaries(table: Table) -> Block:
    """Up to 16 known rows with the least digests, which depend on the rows alone.

    Rows that took long are omitted; the first is kept.
    """
    known = np.flatnonzero(table.known)
    known = known[:: -(-len(known) // MOST_CANDIDATES) or 1]

    def order(unit: int) -> bytes:
        return blake2b(unit.to_bytes(8, "little"), digest_size=8, key=table.head.key).digest()

    chosen = np.array(sorted(known.tolist(), key=order)[:MOST_UNITS], dtype=np.int64)
    seconds = 1e-9 * np.cumsum(np.nan_to_num(table.nanoseconds[chosen]))
    within = seconds <= MOST_SECONDS
    within[:1] = True
    return table.block(np.sort(chosen[within]))


def check_canaries(
    spec: MapSpec,
    known: Block,
    threads: int = 1,
    stop: Callable[[], bool] | None = None,
    *,
    segment: int | None = None,
) -> None:
    """Compute rows again.

    Raises
    ------
    StoreError
        Naming the first unit and the fields that come out otherwise here, and a function of the
        user that is the cause.
    """
    if not len(known.rows):
        return
    again = compute(spec, known.rows["unit"].copy(), threads, stop, segment=segment)
    found = "" if again is None else unequal(known, again, spec.measure)
    if found:
        who = "this build of rigid, or this machine, does not compute the numbers that are stored"
        raise StoreError(f"{spec.doubt or who}: stored and computed: {found}")
