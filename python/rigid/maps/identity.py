"""The identity of a map: its key, which follows from the specification, and its fingerprint."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from .. import _core
from .axes import Axis, axis_letter
from .data import COLUMNS, STORED, MapData
from .spec import MapSpec

FORMAT = "rigid running map"
FORMAT_VERSIONS = (1, 2, 3)
"""Version 2 is written for maps with measures, whose logs have bins beside the rows. Version 3 is
written for maps with a function, whose digests include the values that the function uses."""

SEGMENT = 2**20
"""Most samples of a unit of work in the key of a map, whatever the division of its work."""


def canonical(value: Any) -> bytes:
    """JSON with sorted keys and without spaces: equal values are equal bytes."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return text.encode()


def segment_of(spec: MapSpec) -> int:
    """Most samples of a unit of work: all of them for a sequential map."""
    return SEGMENT if spec.looks is None else max(SEGMENT, spec.samples)


def head_of(spec: MapSpec, segment: int | None = None) -> dict[str, Any]:
    """The content of ``head.json`` of a running map whose units have so many samples at most."""
    build = _core.build_info()
    pixels = int(np.prod(spec.shape))
    segment = segment_of(spec) if segment is None else segment
    looks = None
    if spec.looks is not None:
        looks = [spec.looks.samples.tolist(), spec.looks.most.tolist()]
    return {
        "format": FORMAT,
        "format_version": 3 if spec.tells_captured else 2 if spec.measure else 1,
        "spec": spec.to_dict(),
        "segment": segment,
        "units": pixels * -(-spec.samples // segment),
        "looks": looks,
        "columns": [[one.name, one.dtype] for one in COLUMNS if one.reproducible],
        "version": build["version"],
        "commit": build.get("commit"),
    }


LABELS = ("title", "time_unit", "version")
"""Keys of a specification on which no number depends."""


def key_of(head: Mapping[str, Any]) -> bytes:
    """BLAKE2b-128 of everything that the numbers depend on, without labels, version and commit."""
    from hashlib import blake2b  # here and below: takes longer to import than this module

    of_numbers = {name: value for name, value in head.items() if name not in ("version", "commit")}
    of_numbers["spec"] = {name: value for name, value in head["spec"].items() if name not in LABELS}
    return blake2b(canonical(of_numbers), digest_size=16).digest()


def fingerprint(data: MapData) -> str:
    """BLAKE2b-256 of the key and of all reproducible arrays, hexadecimal.

    It depends on neither instruction set, threads, engine nor order. No NaN of any bits but one is
    in the arrays.
    """
    from hashlib import blake2b

    digest = blake2b(key_of(head_of(data.spec)), digest_size=32)
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
        "key": key_of(head_of(data.spec)).hex(),
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
    if isinstance(one, dict) and isinstance(other, dict):
        names = [*one, *(name for name in other if name not in one)]
        return [
            text
            for name in names
            for text in _differences(one.get(name), other.get(name), f"{path}.{name}".lstrip("."))
        ]
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        return [
            text
            for index, (first, second) in enumerate(zip(one, other, strict=True))
            for text in _differences(first, second, f"{path}[{index}]")
        ]
    return [] if one == other else [f"{path}: {_short(one)} and {_short(other)}"]


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
