"""The identity of a map: its key, its fingerprint, and ``head.json``, which never changes."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import one_line
from ..maps.axes import Axis, axis_letter
from ..maps.data import COLUMNS, STORED, MapData
from ..maps.sequential import LOOK
from ..maps.spec import MapSpec

FORMAT, FORMAT_VERSION = "rigid running map", 1

SEGMENT = 2**20
"""Most samples of a unit of work in the key of a map, whatever the division of its work."""


LABELS = ("title", "time_unit", "version")
"""Keys of a specification on which no number depends."""


UNITS = 1024
"""A map of fewer pixels is divided into about so many units, so that many parts can share it."""

FEWEST_SAMPLES = 1024
"""Fewest samples of a unit of a divided pixel: fewer cost more than they help."""

UNITS_IN_MEMORY = 2**14
"""As above, in memory: Ctrl-C loses little of a long map, and its rows take some megabytes."""

MOST_BYTES = 2**26
"""Most bytes of a head: axes of a million values have 25 MB."""

PIXELS_TOGETHER = 2**16
"""Pixels whose starts are made at a time, and kept if the map has no more."""


def canonical(value: Any) -> bytes:
    """JSON with sorted keys and without spaces: equal values are equal bytes."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return text.encode()


class StoreError(ValueError):
    """A running map is refused: it is damaged, it is another map, or rows contradict each other."""


@dataclass(frozen=True)
class Head:
    """The specification of a running map, its key and its units of work.

    Attributes
    ----------
    spec : MapSpec
    segment : int
        Most samples of a unit.
    """

    spec: MapSpec
    segment: int

    @property
    def content(self) -> dict[str, Any]:
        """All of ``head.json``."""
        spec, build = self.spec, _core.build_info()
        looks = None
        if spec.looks is not None:
            looks = [spec.looks.samples.tolist(), spec.looks.most.tolist()]
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "spec": spec.to_dict(),
            "segment": self.segment,
            "units": self.units,
            "looks": looks,
            "columns": [[one.name, one.dtype] for one in COLUMNS if one.reproducible],
            "version": build["version"],
            "commit": build.get("commit"),
        }

    @cached_property
    def key(self) -> bytes:
        """BLAKE2b-128 of what the numbers depend on, whatever the division into units."""
        return replace(self, segment=_whole(self.spec)).seal

    @cached_property
    def seal(self) -> bytes:
        """As ``key``, with the division that rows are numbered by: the key of digests in logs."""
        content = self.content
        for label in ("version", "commit"):
            del content[label]
        for label in LABELS:
            content["spec"].pop(label, None)
        return blake2b(canonical(content), digest_size=16).digest()

    @property
    def units(self) -> int:
        """Number of the units: each pixel has as many as its samples have segments."""
        return int(np.prod(self.spec.shape)) * self.segments

    @property
    def segments(self) -> int:
        """Units of a pixel."""
        return -(-self.spec.samples // self.segment)

    def samples_of(self, units: NDArray[np.int64]) -> NDArray[np.int64]:
        """Most samples of each unit: the last of a pixel may have fewer than the others."""
        first = units % self.segments * self.segment
        samples: NDArray[np.int64] = np.minimum(self.spec.samples - first, self.segment)
        return samples

    @classmethod
    def of(cls, spec: MapSpec) -> Head:
        """The head of a folder."""
        return cls(spec, divided(spec))

    @classmethod
    def read(cls, text: bytes, path: object) -> Head:
        """The head in the text of a file.

        Raises
        ------
        StoreError
            Naming the path.
        """
        if len(text) > MOST_BYTES:
            raise StoreError(f"{path} is no running map: its head has more than {MOST_BYTES} B")
        try:
            content = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise StoreError(f"{path} is no running map: {one_line(error)}") from None
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise StoreError(f"{path} is no running map: its head.json has another format")
        version = content.get("format_version")
        if version != FORMAT_VERSION:
            raise StoreError(
                f"{path} has format version {version}, this version of rigid reads "
                f"{FORMAT_VERSION}: take another folder, or go on with the version that made this "
                "one"
            )
        try:
            spec = MapSpec.from_dict(content["spec"])
            head = cls(spec, _segment(content["segment"], spec))
            expected = head.content
        except Exception as error:  # the text may hold anything
            raise StoreError(f"{path} holds a broken specification: {one_line(error)}") from None
        for name in ("columns", "looks", "segment", "units"):
            if content.get(name) != expected[name]:
                made = content.get("version")
                raise StoreError(
                    f"{path}: {name} differ from this version of rigid; version {made} made the map"
                )
        return head

    def require_spec(self, spec: MapSpec, path: object) -> None:
        """Refuse a specification that differs from the stored one, and name the difference.

        Raises
        ------
        StoreError
        """
        found = spec_differences(self.spec, spec, *LABELS)
        if found:
            shown = "; ".join(found[:5]) + (f"; and {len(found) - 5} more" if found[5:] else "")
            raise StoreError(
                f"{path} holds another map (there and asked for): {shown}; take another folder"
            )


def _whole(spec: MapSpec) -> int:
    """Most samples of a unit of work: all of them for a sequential map."""
    return SEGMENT if spec.looks is None else max(SEGMENT, spec.samples)


def divided(spec: MapSpec) -> int:
    """Most samples of a unit of a folder.

    Whole pixels are one unit each, unless they are few, or have millions of samples. The looks of a
    pixel depend on those before: it is one unit.
    """
    segment, whole = _even(spec, UNITS, FEWEST_SAMPLES), _whole(spec)
    return segment if spec.looks is None and segment < min(spec.samples, whole) else whole


def _segment(given: Any, spec: MapSpec) -> int:
    """Most samples of a unit of a stored head: of a map with more samples, those before."""
    is_older = type(given) is int and 0 < given < spec.samples and given % LOOK == 0
    return given if is_older and spec.looks is None else divided(spec)


def divided_in_memory(spec: MapSpec) -> int:
    """Most samples of a unit that is kept in memory: there are no more rows for more samples."""
    return (
        min(spec.samples, _even(spec, UNITS_IN_MEMORY, LOOK))
        if spec.looks is None
        else spec.samples
    )


def _even(spec: MapSpec, units: int, fewest: int) -> int:
    """Samples of each of so many units, in whole looks."""
    share = -(-spec.samples * int(np.prod(spec.shape)) // units)
    return max(fewest, -(-share // LOOK) * LOOK)


def moment_status(spec: MapSpec) -> NDArray[np.uint8]:
    """The status of the moments of each pixel in C order: 0 where the body is possible."""
    pixels = int(np.prod(spec.shape))
    if pixels <= PIXELS_TOGETHER:
        return spec.grid.status
    status = np.empty(pixels, np.uint8)
    for begin in range(0, pixels, PIXELS_TOGETHER):
        index = np.arange(begin, min(begin + PIXELS_TOGETHER, pixels))
        starts = spec.bodies(spec.start.starts[0], index)
        status[index] = starts.status
    return status


def fingerprint(data: MapData) -> str:
    """BLAKE2b-256 of the key and of all reproducible arrays, hexadecimal.

    It depends on neither instruction set, threads, engine nor order. No NaN of any bits but one is
    in the arrays.
    """
    digest = blake2b(Head.of(data.spec).key, digest_size=32)
    for name, dtype in STORED.items():
        array = np.ascontiguousarray(getattr(data, name), dtype=dtype.newbyteorder("<"))
        if array.dtype.kind == "f":
            array = np.where(np.isnan(array), np.nan, array)
        digest.update(array.tobytes())
    for measured in data.measures.values():
        digest.update(measured.bins.astype("<i8").tobytes())
    return digest.hexdigest()


def receipt(data: MapData) -> dict[str, Any]:
    """Versions, key and fingerprint of a map; see :meth:`rigid.StabilityMap.receipt`."""
    return {
        "spec": data.spec.to_dict(),
        "key": Head.of(data.spec).key.hex(),
        "fingerprint": fingerprint(data),
        "seed": data.spec.seed,
        "version": data.spec.version,
        "complete": data.complete,
        "writers": [dict(writer) for writer in data.writers],
    }


def spec_differences(one: MapSpec, other: MapSpec, *but: str) -> list[str]:
    """Where two specifications differ, in the words of their files, except in some keys.

    An axis differs in its ends and in the number of its values, before it differs in a value.
    """
    described = []
    for spec, beside in ((one, other), (other, one)):
        content = {key: value for key, value in spec.to_dict().items() if key not in but}
        del content["axes"]
        axes: dict[str, Any] = {}
        for place, axis in enumerate(spec.axes):
            twin = beside.axes[place : place + 1]
            axes[axis_letter(place)] = _axis(axis)
            if [_axis(theirs) for theirs in twin] == [_axis(axis)]:
                axes[axis_letter(place)]["values"] = list(axis.values)
        described.append({**axes, **content})
    kept, asked = described
    return _differences(kept, asked)


def _axis(axis: Axis) -> dict[str, Any]:
    ends = {"from": axis.values[0], "to": axis.values[-1]}
    return {"name": axis.name, **ends, "count": len(axis.values)}


def _differences(one: Any, other: Any, path: str = "") -> list[str]:
    """The paths at which two JSON values differ, with both values, in the order of the first."""
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        one, other = ({f"[{k}]": part for k, part in enumerate(value)} for value in (one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return [
            text
            for name in dict.fromkeys((*one, *other))
            for text in _differences(
                one.get(name), other.get(name), f"{path}.{name}".lstrip(".").replace(".[", "[")
            )
        ]
    return [] if one == other else [f"{path}: {_short(one)} and {_short(other)}"]


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
