"""Runs that are read from files."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from .._archive import Archive
from .._checks.arguments import brief, one_line
from .._checks.inputs import described
from ..model.events import Event
from ..model.frame import checked_frame
from ..model.scene import scene_from_dict
from .events import Events
from .plan import Lazy, Plan
from .run import FORMAT, Run

if TYPE_CHECKING:
    from os import PathLike


def load_run(path: str | PathLike[str]) -> Run:
    """Read a run that :meth:`Run.save` wrote.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        Naming the path, if the file is damaged or no run.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> import os, tempfile, rigid
    >>> run = rigid.simulate(rigid.Body((1.0, 2.0, 3.0)), [0.1, 1.0, 0.1], t=[0.0, 5.0])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = rigid.load_run(run.save(os.path.join(folder, "run.npz")))
    >>> bool((again.omega == run.omega).all())
    True
    """
    name = os.fspath(path)
    os.stat(name)
    what = described(name)
    if "load_run" not in what:
        raise ValueError(f"path = {name!r}: is no run that rigid has saved, it is {what}")
    try:
        with open(name, "rb") as file:
            archive = Archive(file)
            arrays = {key: archive.read(key) for key in archive.names}
        header = json.loads(str(arrays.pop("header")))
        known = header.pop("format")
        if known == FORMAT:
            return _run_of(arrays, header)
    except Exception as error:  # the file may hold anything
        raise ValueError(f"path = {name!r}: is a damaged run ({one_line(error)})") from None
    raise ValueError(
        f"path = {name!r}: has the format {known!r}, known is {FORMAT!r}: read it with the version "
        "of rigid that wrote it, or compute the run again"
    )


def _run_of(arrays: dict[str, NDArray[Any]], header: dict[str, Any]) -> Run:
    """The run of the arrays and the header of a file."""
    if strange := [name for name, array in arrays.items() if array.dtype.kind not in "bfiu"]:
        raise ValueError(f"{strange[0]} has no numbers")
    known = Run._known()
    watched = header.get("events", [])
    of_events = [
        {
            name: arrays.pop(f"events{k}_{name}")
            for name in Events._known()
            if name != "states" or f"events{k}_states" in arrays
        }
        for k in range(len(watched))
    ]
    if unknown := arrays.keys() - known.keys():
        raise ValueError(f"unknown arrays {sorted(unknown)}")
    scene_from_dict(header["spec"]["scene"])
    if "frame" in header["spec"]:
        checked_frame(header["spec"]["frame"])
    for name in ("t", "omega", "start_omega", "start_attitude", "status", "error"):
        if name not in arrays:
            raise ValueError(f"no array {name!r}")
    sizes = {"t": arrays["t"].shape[-1], "axis": 3, "part": 4}
    for name, array in arrays.items():
        axes = known[name].axes[1:]
        own = array.shape[array.ndim - len(axes) :]
        wanted = tuple(sizes.get(axis, size) for axis, size in zip(axes, own, strict=True))
        if own != wanted:
            raise ValueError(f"{name}: expected shape (..., {brief(wanted)[1:]}, got {own}")
    shape = arrays["status"].shape
    events = tuple(
        Events(Event.from_dict(entries), _columns=Events._rows_of(rows, shape), _shape=shape)
        for entries, rows in zip(watched, of_events, strict=True)
    )
    return Run(
        _shape=shape,
        _columns={"nanoseconds": int(header["nanoseconds"]), **Run._rows_of(arrays, shape)},
        _parameters=tuple(header["parameters"]),
        _events=events,
        _spec=Lazy.of(header["spec"]),
        _plan=Lazy.of(Plan.from_dict(header["plan"])),
    )
