"""Results as columns: each attribute with its unit and axes, once for files, datasets and tables.

A result is a class whose attributes are :class:`Column`. What saves it, makes a Dataset or a table
of it, or turns its rows into the axes of the bodies, reads this one list.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import replace
from io import StringIO
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, TypeAlias, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from .._archive import write_archive
from .._checks.extras import install_extra
from .._files import TABLE, published
from ..model.batch import Shape
from ..model.forces import FORCES
from ..model.scene import Scene, scene_from_dict

if TYPE_CHECKING:
    import xarray


Columns: TypeAlias = Mapping[str, Any]
"""Arrays by their names, None if not recorded; arrays of bodies have a row for each, (n, ...)."""

Array = TypeVar("Array")

_LABELS: Mapping[str, Any] = {
    "axis": [1, 2, 3],
    # Texts as objects: Zarr has no specification of texts of a fixed length, and warns of them.
    "part": np.array(list("wxyz"), dtype=object),
}
"""Coordinates of the axes of vectors and of quaternions."""

_PARTS: Mapping[str, str] = {
    "axis": "{name}{label}",
    "part": "{label}",
    "exponent": "exponent{label}",
    "order": "{name}{label}",
    "state": "state{label}",
}
"""Axes along which a table has a column for each number, and the names of these columns."""

ROWS = 65536
"""Number of rows of a table that are written at once."""


class Column(Generic[Array]):
    """An attribute of a result, with its unit and its axes.

    A first axis ``body`` or ``motion`` stands for all axes of the bodies: the attribute is the row
    of the only body, or the rows of all bodies in their axes. In a Dataset ``motion`` is one axis,
    where ``body`` is the name of a variable. Few columns are read, and a view takes as long as to
    check the input. An underscore before the name of the attribute is no part of the name of the
    column: a method returns it.
    """

    __slots__ = ("axes", "name", "of_bodies", "unit")

    def __init__(self, unit: str, *axes: str) -> None:
        self.unit, self.axes = unit, axes
        self.of_bodies = axes[0] in ("body", "motion")

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name.removeprefix("_")

    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...
    @overload
    def __get__(self, owner: HasColumns, kind: type) -> Array: ...
    def __get__(self, owner: HasColumns | None, kind: type) -> Self | Array:
        if owner is None:
            return self
        rows: Any = owner._columns.get(self.name)
        if rows is not None and self.of_bodies:
            shape = owner._shape
            rows = rows.reshape(*shape, *rows.shape[1:]) if shape else rows[0]
        view: Array = rows
        return view


class HasColumns:
    """Bodies of a shape, and their columns; a dataclass with these fields."""

    __slots__ = ()

    _columns: Columns
    _shape: Shape

    @classmethod
    def _known(cls) -> dict[str, Column[Any]]:
        """All columns by their names."""
        return {
            column.name: column
            for kind in reversed(cls.__mro__)
            for column in vars(kind).values()
            if isinstance(column, Column)
        }

    def _arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays that there are, by the names of the attributes."""
        known = {name: column.__get__(self, type(self)) for name, column in self._known().items()}
        return {name: np.asarray(array) for name, array in known.items() if array is not None}

    def with_arrays(self, **arrays: Any) -> Self:
        """The result with other arrays, as its attributes have them, by their names."""
        rows = self._rows_of(arrays, self._shape)
        return replace(self, _columns={**self._columns, **rows})  # type: ignore[type-var]

    @classmethod
    def _rows_of(cls, arrays: Mapping[str, Any], shape: Shape) -> dict[str, NDArray[Any] | None]:
        """Columns from arrays that have the axes of the bodies.

        Raises
        ------
        ValueError
            If an array has other axes.
        """
        known, rows = cls._known(), {}
        for name, array in arrays.items():
            if array is not None and known[name].of_bodies:
                own = np.shape(array)
                if own[: len(shape)] != shape:
                    wanted = ", ".join(map(str, (*shape, "...")))
                    raise ValueError(f"{name}: expected shape ({wanted}), got {own}")
                array = np.reshape(array, (prod(shape), *own[len(shape) :]))
            rows[name] = array
        return rows


class Result(HasColumns):
    """Columns that are saved, and given as a Dataset and as a tidy table."""

    __slots__ = ()

    _ROWS: ClassVar[tuple[str, ...]] = ("body", "t")
    """The axes that have a row of the table for each place."""

    if TYPE_CHECKING:

        @property
        def spec(self) -> dict[str, Any]:
            """The request."""

        @property
        def plan(self) -> Any:
            """The plan."""

    @property
    def _scene(self) -> Scene:
        """The scene, in principal axes."""
        return scene_from_dict(self.spec["scene"])

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Save the arrays as an ``.npz`` file, which :func:`numpy.load` reads.

        Its arrays are the attributes by name, and JSON texts. Nothing is pickled. The file appears
        whole or not at all; see :meth:`rigid.StabilityMap.save`.

        Parameters
        ----------
        path : path-like

        Returns
        -------
        Path
            The path.

        Raises
        ------
        ValueError
            If the name does not end in ``.npz``.
        OSError
            Naming the path, if the file cannot be written.

        Examples
        --------
        >>> import os, tempfile, numpy as np, rigid
        >>> box = rigid.FreeBody(rigid.Body((1.0, 2.0, 3.0)))
        >>> growth = rigid.lyapunov(box, [1.0, 0.1, 0.1], t=[100.0, 200.0])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     with np.load(growth.save(os.path.join(folder, "growth.npz"))) as file:
        ...         str(file["verdict"])
        'regular'
        """
        write_archive(path, self._saved())
        return Path(path)

    def to_xarray(self) -> xarray.Dataset:
        """The arrays as an xarray ``Dataset`` with names, units and coordinates.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        ImportError
            Without xarray.

        Examples
        --------
        >>> import rigid
        >>> run = rigid.simulate(rigid.Body((1.0, 1.5, 2.0)), [0.1, 1.0, 0.2], t=[0.0, 3.0])
        >>> run.to_xarray().omega.sel(t=3.0, axis=1).dims
        ()
        """
        spec = deepcopy(self.spec)
        return as_dataset(*self._dataset(spec), self._texts(spec))

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write a tidy table: a row for each body and time or for each point, named columns.

        Numbers have the digits that give their bits back. Components of vectors are columns such as
        ``omega1`` to ``omega3``, of quaternions ``w``, ``x``, ``y``, ``z``. Bodies of several
        leading axes have an index for each: ``body``, ``body1`` and so on. A body whose record an
        event has ended has no rows after its end.

        Parameters
        ----------
        path : path-like

        Returns
        -------
        Path
            The path.

        Raises
        ------
        ValueError
            If the name does not end in ``.csv`` or ``.txt``.
        OSError
            Naming the path, if the file cannot be written.

        Examples
        --------
        >>> import os, tempfile, rigid
        >>> run = rigid.simulate(rigid.Body((1.0, 1.5, 2.0)), [0.0, 0.0, 0.5], t=[0.0, 3.0])
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = run.to_csv(os.path.join(folder, "run.csv"))
        ...     print(path.read_text().splitlines()[0])
        t,omega1,omega2,omega3,w,x,y,z
        """
        return write_table(path, self._table())

    def _texts(self, spec: dict[str, Any]) -> dict[str, Any]:
        return {"spec": json.dumps(spec), "plan": self.plan.to_json()}

    def _saved(self) -> dict[str, Any]:
        """The arrays and texts of a file."""
        return {**self._texts(self.spec), **self._arrays()}

    def _labels(self) -> Mapping[str, Any]:
        """Coordinates of further axes."""
        return {}

    def _dataset(self, spec: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """The variables and coordinates of a Dataset, which may take parts of ``spec``."""
        bodies, known = _axes_of_bodies(self._shape), self._known()
        labels = {**_LABELS, **self._labels()}
        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {}
        for name, array in self._arrays().items():
            first, *others = known[name].axes
            axes = (*(bodies if first == "body" else (first,)), *others)
            values = array.ravel() if first == "motion" else array
            group = coordinates if axes == (name,) else variables
            group[name] = (axes, values, {"units": known[name].unit})
            coordinates |= {axis: labels[axis] for axis in others if axis in labels}
        return variables, coordinates

    def _table(self) -> dict[str, NDArray[Any]]:
        """The columns of a tidy table, which broadcast."""
        rows, table = self._ROWS, {}
        if rows[0] == "body":
            grids = np.indices(self._shape, sparse=True)
            for name, grid in zip(_axes_of_bodies(self._shape), grids, strict=True):
                table[name] = grid[..., np.newaxis]
        known, labels = self._known(), {**_LABELS, **self._labels()}
        for name, array in self._arrays().items():
            axes = known[name].axes
            if axes in (rows, rows[1:]):
                table[name] = array
            elif axes[:-1] == rows and axes[-1] in _PARTS:
                numbered = range(1, array.shape[-1] + 1)
                for k, label in enumerate(labels.get(axes[-1], numbered)):
                    table[_PARTS[axes[-1]].format(name=name, label=label)] = array[..., k]
        return table


def _axes_of_bodies(shape: Shape) -> tuple[str, ...]:
    """The names of the axes of bodies of this shape."""
    return tuple(f"body{k or ''}" for k in range(len(shape)))


def as_dataset(
    variables: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]
) -> xarray.Dataset:
    """Arrays with their axes and units as an xarray Dataset.

    Raises
    ------
    ImportError
        Without xarray.
    """
    try:
        import xarray
    except ImportError:
        raise ImportError(install_extra("to_xarray() needs xarray", "maps")) from None
    return xarray.Dataset(variables, coordinates, attributes)


def write_table(path: str | os.PathLike[str], columns: Mapping[str, NDArray[Any]]) -> Path:
    """Write arrays that broadcast as columns of a text; the file appears whole or not at all.

    A number has the digits that give its bits back; the lines end as RFC 4180 has it.
    """
    arrays = np.broadcast_arrays(*columns.values())
    flat = [array.reshape(-1) for array in arrays]

    def lines(rows: Iterable[Iterable[Any]]) -> bytes:
        text = StringIO(newline="")
        csv.writer(text).writerows(rows)
        return text.getvalue().encode()

    with published(path, TABLE) as file:
        file.write(lines([columns]))
        for start in range(0, flat[0].size, ROWS):
            part = [column[start : start + ROWS].tolist() for column in flat]
            file.write(lines(zip(*part, strict=True)))
    return Path(path)


_TORQUE = ("torque_time", "axis")
_OF_SCENE: Mapping[str, tuple[tuple[str, ...], str, tuple[str, ...], str]] = {
    "moments": (("body", "moments"), "kg m²", ("axis",), "principal moments of inertia"),
    "mass": (("body", "mass"), "kg", (), "mass"),
    "mgl": (("mgl",), "J", (), "mass times gravity times distance to the centre of mass"),
    "com": (("com",), "1", ("axis",), "direction to the centre of mass"),
    "torque": (("torque", "in_body"), "N m", _TORQUE, "applied torque in the body"),
    "torque_in_space": (("torque", "in_space"), "N m", _TORQUE, "applied torque in space"),
    "torque_data": (("torque", "function", "data"), "", ("number",), "data of the torque"),
    "start_states": (("torque", "function", "states"), "", ("state",), "states at the start"),
    "damping": (("damping",), "N m s", ("axis", "axis_of_rate"), "damping"),
    **{name: ((name,), force.unit, ("axis",), force.title) for name, force in FORCES.items()},
}
"""Place in the scene, unit, axes after the axes of the bodies, and meaning of numbers along
principal axes."""


def take_numbers(scene: dict[str, Any], shape: Shape) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables of the numbers of each body, and the coordinates that they need.

    In the scene the name of the variable replaces them. What all bodies have in common stays.
    """
    bodies = _axes_of_bodies(shape)
    times = (scene.get("torque") or {}).get("times")
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for name, (place, unit, axes, words) in _OF_SCENE.items():
        holder: Any = scene
        for part in place[:-1]:
            holder = holder.get(part) or {}
        values = holder.get(place[-1])
        if values is None or np.ndim(values) <= len(axes):
            continue
        holder[place[-1]] = f"variable {name}"
        array = np.asarray(values, dtype=np.float64)
        array = np.broadcast_to(array, (*shape, *array.shape[array.ndim - len(axes) :]))
        if axes == _TORQUE and times:
            coordinates["torque_time"] = ("torque_time", times, {"units": "s"})
        elif axes == _TORQUE:
            array, axes = array[..., 0, :], ("axis",)
        variables[name] = ((*bodies, *axes), array, {"units": unit, "long_name": words})
    return variables, coordinates
