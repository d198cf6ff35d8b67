"""Attitudes as a message for other space-flight programs (CCSDS 504.0-B-1, AEM)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief
from .._files import published


def write_aem(
    path: str | os.PathLike[str],
    times: NDArray[np.float64],
    attitudes: NDArray[np.float64],
    *,
    epoch: str | datetime,
    entries: Mapping[str, str],
) -> Path:
    """Write one attitude ephemeris; see :meth:`rigid.Run.to_aem`.

    The frame of space is frame A and the body is frame B. The matrix of the message turns
    components in A into components in B. It is written with the same quaternion that turns the body
    from A to B (CCSDS 504.0-B-1, § 3.3 and annex on conventions). So the parts of a quaternion stay
    as they are, with the scalar last.
    """
    begin = _epoch(epoch)
    for name, value in entries.items():
        if (
            not isinstance(value, str)
            or not value.strip()
            or not (value.isascii() and value.isprintable())
        ):
            raise ValueError(f"{name} = {brief(value)}: must be a line of ASCII, not empty")
    known = int(np.isfinite(attitudes).all(axis=-1).cumprod().sum())
    if not known:
        raise ValueError(f"attitude: none of {len(times)} times has one, as t and status tell")
    times, attitudes = times[:known], attitudes[:known]
    stamps = [_stamp(begin, float(t)) for t in times]
    for k in range(1, len(stamps)):
        if stamps[k] == stamps[k - 1]:
            raise ValueError(
                f"t[{k}] = {times[k]!r}: is the same microsecond as t[{k - 1}], which a message "
                "cannot tell apart"
            )
    unit = attitudes / np.linalg.norm(attitudes, axis=-1, keepdims=True)
    # A quaternion and its negative are one attitude; readers interpolate between neighbours.
    turned = np.vecdot(unit[1:], unit[:-1]) < 0.0
    sign = np.where(np.cumsum(np.concatenate(([False], turned))) % 2 == 1, -1.0, 1.0)
    lines = [
        "CCSDS_AEM_VERS = 1.0",
        f"CREATION_DATE = {_stamp(datetime.now(UTC).replace(tzinfo=None), 0.0)}",
        f"ORIGINATOR = {entries['originator']}",
        "",
        "META_START",
        f"OBJECT_NAME = {entries['object_name']}",
        f"OBJECT_ID = {entries['object_id']}",
        f"REF_FRAME_A = {entries['frame']}",
        f"REF_FRAME_B = {entries['body_frame']}",
        "ATTITUDE_DIR = A2B",
        "TIME_SYSTEM = UTC",
        f"START_TIME = {stamps[0]}",
        f"STOP_TIME = {stamps[-1]}",
        "ATTITUDE_TYPE = QUATERNION",
        "QUATERNION_TYPE = LAST",
        "META_STOP",
        "",
        "DATA_START",
    ]
    for stamp, (w, x, y, z) in zip(stamps, (sign[:, np.newaxis] * unit).tolist(), strict=True):
        lines.append(f"{stamp} {x:.16e} {y:.16e} {z:.16e} {w:.16e}")
    lines.append("DATA_STOP")
    with published(path, (".aem", ".txt")) as file:
        file.write(("\n".join(lines) + "\n").encode("ascii"))
    return Path(path)


def _epoch(epoch: str | datetime) -> datetime:
    """The time of ``t = 0`` in UTC, without a time zone."""
    try:
        known = epoch if isinstance(epoch, datetime) else datetime.fromisoformat(epoch)
    except (TypeError, ValueError):
        raise ValueError(
            f"epoch = {brief(epoch)}: must be a datetime or a text such as '2026-01-31T12:00:00'"
        ) from None
    return known if known.tzinfo is None else known.astimezone(UTC).replace(tzinfo=None)


def _stamp(begin: datetime, seconds: float) -> str:
    try:
        return (begin + timedelta(seconds=seconds)).isoformat(timespec="microseconds")
    except OverflowError:
        raise ValueError(f"t = {seconds!r}: is beyond the calendar from epoch on") from None
