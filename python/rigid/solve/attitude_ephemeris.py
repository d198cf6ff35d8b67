"""Attitudes as a message for other space-flight programs (CCSDS 504.0-B-2, AEM)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._checks.arguments import brief, one_line
from .._checks.arrays import Floats
from .._checks.shown import short_repr
from .._files import published

_WIDTHS = {"QUATERNION": 4, "QUATERNION/DERIVATIVE": 8, "QUATERNION/ANGVEL": 7}
"""Numbers of a line of data after its time, by the ``ATTITUDE_TYPE``; first the quaternion."""

_KNOWN = {
    "ATTITUDE_TYPE": tuple(_WIDTHS),
    "ATTITUDE_DIR": ("A2B", "B2A"),
    "QUATERNION_TYPE": ("LAST", "FIRST"),
}
"""Entries with a choice; the first is meant where version 1 may leave one out."""

_OFF = 1e-3
"""Largest deviation of the length of a quaternion from 1: three digits of it are written."""

_NEEDED = ("REF_FRAME_A", "REF_FRAME_B", "TIME_SYSTEM", "ATTITUDE_TYPE")


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
    from A to B (CCSDS 504.0-B-2, annex F2). So the parts of a quaternion stay as they are, with the
    scalar last.
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
                f"t[{k}] = {float(times[k])}: is the same microsecond as t[{k - 1}], which a "
                "message cannot tell apart"
            )
    unit = attitudes / np.linalg.norm(attitudes, axis=-1, keepdims=True)
    # A quaternion and its negative are one attitude; readers interpolate between neighbours.
    turned = np.vecdot(unit[1:], unit[:-1]) < 0.0
    sign = np.cumprod(np.concatenate(([1.0], np.where(turned, -1.0, 1.0))))
    lines = [
        "CCSDS_AEM_VERS = 2.0",
        f"CREATION_DATE = {_stamp(datetime.now(UTC).replace(tzinfo=None), 0.0)}",
        f"ORIGINATOR = {entries['originator']}",
        "",
        "META_START",
        f"OBJECT_NAME = {entries['object_name']}",
        f"OBJECT_ID = {entries['object_id']}",
        f"REF_FRAME_A = {entries['frame']}",
        f"REF_FRAME_B = {entries['body_frame']}",
        "TIME_SYSTEM = UTC",
        f"START_TIME = {stamps[0]}",
        f"STOP_TIME = {stamps[-1]}",
        "ATTITUDE_TYPE = QUATERNION",
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


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class AttitudeEphemeris:
    """Attitudes at times, read from a message by :func:`rigid.load_aem`.

    Attributes
    ----------
    t : ndarray, shape (m,)
        Times since ``epoch`` (s), ascending from 0.
    attitude : ndarray, shape (m, 4)
        Unit quaternions, scalar first, that take components in ``REF_FRAME_B`` (mostly the body) to
        components in ``REF_FRAME_A`` (mostly space).
    epoch : datetime
        The first time, in the ``TIME_SYSTEM`` of the message, to the microsecond.
    entries : dict of str to str
        Header and metadata: ``OBJECT_NAME``, ``REF_FRAME_A``, ``TIME_SYSTEM`` and so on.
    """

    t: Floats
    attitude: Floats
    epoch: datetime
    entries: dict[str, str]


def load_aem(path: str | os.PathLike[str], *, segment: int | None = None) -> AttitudeEphemeris:
    """Read attitudes from an attitude ephemeris message (AEM) of CCSDS 504.0-B-1 or B-2.

    Read are messages of ``keyword = value`` with quaternions; rates and derivatives beside these
    are left. Of version 1, ``ATTITUDE_DIR`` and ``QUATERNION_TYPE`` are heeded.
    :func:`rigid.rotations.omega_from_attitudes` makes rates of the attitudes.

    Parameters
    ----------
    path : path-like
    segment : int, optional
        Which segment, where the message has several.

    Returns
    -------
    AttitudeEphemeris

    Raises
    ------
    ValueError
        Naming the file and the line: no such message; another attitude type; a number, time or
        entry that is missing or wrong; times that do not ascend; several segments, and ``segment``
        names none.
    OSError
        If the file cannot be read.

    Notes
    -----
    A time in a leap second of UTC counts as the first second after it.

    Examples
    --------
    >>> import os, tempfile, rigid
    >>> run = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.0, 0.0, 0.2], t=[0.0, 5.0, 10.0])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = run.to_aem(os.path.join(folder, "body.aem"), epoch="2026-01-31T12:00:00")
    ...     read = rigid.load_aem(path)
    >>> read.t.tolist(), bool(abs(read.attitude - run.attitude).max() < 1e-15)
    ([0.0, 5.0, 10.0], True)
    """
    lines = Path(path).read_text(encoding="ascii", errors="replace").splitlines()
    number, header = 0, dict[str, str]()
    segments: list[tuple[dict[str, str], list[tuple[datetime, float, list[float]]]]] = []
    inside = ""
    try:
        for number, line in enumerate(map(str.strip, lines), 1):  # noqa: B007
            if not line or line.split()[0] == "COMMENT":
                continue
            if not header and not line.startswith("CCSDS_AEM_VERS"):
                raise ValueError("is no attitude ephemeris message: CCSDS_AEM_VERS must be first")
            if line in ("META_START", "DATA_START"):
                inside = line[:4]
                if inside == "META":
                    segments.append(({}, []))
                elif not segments:
                    raise ValueError("data before their metadata")
                else:
                    width = _width(segments[-1][0])
            elif line in ("META_STOP", "DATA_STOP"):
                inside = ""
            elif inside == "DATA":
                row, rows = _row(line, width), segments[-1][1]
                if rows and row[:2] <= rows[-1][:2]:
                    raise ValueError("the times must ascend")
                rows.append(row)
            else:
                name, equals, value = (part.strip() for part in line.partition("="))
                if not equals:
                    raise ValueError(f"{brief(line)}: must be keyword = value")
                (segments[-1][0] if inside else header)[name] = value
        if inside or not segments or not all(rows for _, rows in segments):
            raise ValueError("the message ends before its data do")
        if segment is None and len(segments) > 1:
            raise ValueError(f"segment = None: the message has {len(segments)}, choose one")
        if not -len(segments) <= (segment or 0) < len(segments):
            raise ValueError(f"segment = {segment}: the message has {len(segments)}")
        entries, rows = segments[segment or 0]
        return _ephemeris({**header, **entries}, rows)
    except ValueError as error:
        where = f", line {number}" if number < len(lines) else ""
        raise ValueError(f"{os.fspath(path)}{where}: {one_line(error)}") from None


def _width(entries: Mapping[str, str]) -> int:
    """Numbers in a line of data; ValueError for an entry that is missing or wrong."""
    missing = [name for name in _NEEDED if name not in entries]
    if missing:
        raise ValueError(f"{missing[0]} is missing")
    for name, known in _KNOWN.items():
        kind = entries.get(name, known[0]).upper()
        if kind not in known:
            raise ValueError(f"{name} = {brief(kind)}: must be one of {', '.join(known)}")
    return _WIDTHS[entries["ATTITUDE_TYPE"].upper()]


def _row(line: str, width: int) -> tuple[datetime, float, list[float]]:
    """Time, to the second and beyond it, and the quaternion of a line of data."""
    stamp, *numbers = line.split()
    values = [float(number) for number in numbers]
    if len(values) != width or not np.isfinite(values).all():
        raise ValueError(f"{brief(line)}: must be a time and {width} finite numbers")
    if abs(np.linalg.norm(values[:4]) - 1.0) > _OFF:
        raise ValueError("a quaternion has not the length 1")
    minute, _, seconds = stamp.removesuffix("Z").rpartition(":")
    whole, _, rest = seconds.partition(".")
    try:
        begin = datetime.strptime(minute, f"%Y-{'%j' if minute.count('-') == 1 else '%m-%d'}T%H:%M")
        if not (whole + rest).isdecimal() or int(whole) > 60:  # 60 is a leap second
            raise ValueError
    except ValueError:
        raise ValueError(
            f"{brief(stamp)}: must be a time such as 2026-01-31T12:00:00.5 or 2026-031T12:00:00"
        ) from None
    return begin + timedelta(seconds=int(whole)), float(f"0.{rest or 0}"), values[:4]


def _ephemeris(
    entries: dict[str, str], rows: list[tuple[datetime, float, list[float]]]
) -> AttitudeEphemeris:
    """The attitudes of the rows of a segment."""
    first, beyond, _ = rows[0]
    # Whole seconds are subtracted exactly, then their fractions.
    t = np.array([(at - first).total_seconds() + (rest - beyond) for at, rest, _ in rows])
    parts = np.array([values for _, _, values in rows])
    if entries.get("QUATERNION_TYPE", "LAST").upper() == "LAST":
        parts = np.roll(parts, 1, axis=1)
    length = np.linalg.norm(parts, axis=1, keepdims=True)
    if entries.get("ATTITUDE_DIR", "A2B").upper() == "B2A":
        parts = parts * [1.0, -1.0, -1.0, -1.0]
    return AttitudeEphemeris(t, parts / length, first + timedelta(seconds=beyond), entries)
