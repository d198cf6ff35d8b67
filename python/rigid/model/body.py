"""Bodies by their principal moments of inertia, from moments, solids, meshes, tensors or points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from .._checks.arguments import brief, finite_float, first_place, numbers, shaped, truth, vector
from .._checks.arrays import Floats
from .._checks.moments import (
    box_moments,
    checked_moments,
    hold_rods,
    possible_moments,
    refuse_rods,
    rods,
    symmetric_tensor,
    symmetry_axis,
)
from .._checks.quantities import LARGE_SIDE, LEAST_DENSITY, without_unit
from .._checks.warned import warn_caller
from .batch import (
    ByValue,
    Index,
    Shape,
    axes_of,
    batch_shape,
    frozen,
    holds,
    index_of_bodies,
    taken,
    vector_of,
)
from .forces import forces_in_words
from .gravity import checked_properties

if TYPE_CHECKING:
    from os import PathLike

    from ..solids.mass_properties import MassProperties


Moments: TypeAlias = tuple[float, float, float] | Floats
"""Principal moments of one body, or of many bodies with shape (..., 3)."""


@dataclass(frozen=True, slots=True, init=False, eq=False, repr=False)
class Body(ByValue):
    """A rigid body, known by its principal moments of inertia, or many bodies.

    Body axes are the principal axes, through the fixed point if there is one, else through the
    centre of mass. The moments keep your order; nothing is sorted.

    Moments of shape ``(n, 3)`` describe ``n`` bodies. ``len(body)`` is their number, ``body[i]`` is
    one of them, and a slice or an array of indices takes some; any leading axes will do.

    Parameters
    ----------
    moments : array_like, shape (3,) or (..., 3)
        Principal moments of inertia (kg m², or any consistent unit) about body axes 1, 2, 3.
    mass : float or array_like, shape (...), optional
        Mass (kg), kept for other functions; the rotation does not need it.
    sides : array_like, shape (3,), optional
        Sides (m) of a homogeneous box with this mass and these moments; :meth:`box` sets them. For
        one body only.
    physical : bool
        Whether a body must be able to have the moments. If False, any positive moments are taken,
        and Euler's equations are solved with them as they stand.

    Attributes
    ----------
    moments : tuple of float, or ndarray of shape (..., 3)
        Principal moments; the array of many bodies is read-only.
    mass : float, ndarray of shape (...), or None
        Mass.
    sides : tuple of float or None
        Sides along the axes 1, 2, 3 of a homogeneous box.
    physical : bool
        False if the moments may belong to no body.
    about : {"centre", "point"} or None
        The point of the moments, where it is known: the centre of mass (:meth:`box`, :meth:`cone`
        and the others that make a body from its shape), or another given point. It is neither
        compared nor saved.

    Raises
    ------
    ValueError
        If no body has these moments: each must be finite and positive, none above the sum of the
        other two (a flat body has equality). A rod may have zero about its axis: :meth:`rod`. A
        mass point, with three zeros, has no rotation.

    Warns
    -----
    MomentsWarning
        If the largest moment exceeds the sum of the other two by at most 1 % of itself, as
        measured or rounded moments of a flat body do. Then the nearest possible moments are taken:
        an excess ``e`` changes each moment by ``e/3``.

    Examples
    --------
    >>> import rigid
    >>> rigid.Body((1.0, 2.0, 2.5)).symmetry_axis is None
    True
    >>> rigid.Body((1.0, 1.0, 2.5))
    Traceback (most recent call last):
        ...
    ValueError: moments = (1, 1, 2.5): no moment may exceed the sum of the other two \
(triangle inequality; equality is a flat body); the excess is 20.00 % of the largest, the nearest \
possible moments are (1.1666666666666667, 1.1666666666666667, 2.3333333333333335); physical=False \
takes such moments as they are
    >>> rigid.Body((1.0, 1.0, 2.5), physical=False).gammas
    (-1.5, 1.5, 0.0)
    >>> bodies = rigid.Body([[1.0, 2.0, 2.5], [1.0, 1.0, 0.5]])
    >>> len(bodies), bodies[1].symmetry_axis
    (2, 3)
    """

    moments: Moments
    mass: float | Floats | None
    sides: tuple[float, float, float] | None
    physical: bool
    about: str | None = field(init=False, default=None, compare=False)

    def __init__(
        self,
        moments: ArrayLike,
        *,
        mass: ArrayLike | None = None,
        sides: ArrayLike | None = None,
        physical: bool = True,
    ) -> None:
        checked = _checked_moments(moments, truth("physical", physical))
        shape = np.shape(checked)[:-1]
        set_field = object.__setattr__  # the dataclass is frozen
        set_field(self, "moments", checked)
        set_field(self, "mass", None if mass is None else _checked_mass(mass, shape))
        if sides is not None:
            if shape or (mass is not None and np.ndim(mass)):
                raise ValueError(
                    f"sides: belong to one body, but the moments are of bodies {shape}"
                )
            a, b, c = vector("sides", sides, 3).tolist()
            sides = (a, b, c)
            if min(sides) <= 0.0:
                raise ValueError(f"sides = {sides}: every side must be positive")
            if mass is None or not np.allclose(box_moments(a, b, c, mass), checked, rtol=1e-12):
                raise ValueError(
                    f"sides = {sides}: no box of this mass has the moments {checked}; use Body.box"
                )
        set_field(self, "sides", sides)
        set_field(self, "physical", physical)
        set_field(self, "about", None)

    @property
    def shape(self) -> Shape:
        """The axes of the bodies: ``()`` of one body, ``(n,)`` of n bodies."""
        return axes_of(self.moments, 1)

    def __len__(self) -> int:
        return holds(self.shape)

    def __iter__(self) -> Iterator[Body]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: Index) -> Body:
        index_of_bodies(self.shape, index)
        return self.of(self.shape, index)

    def of(self, shape: Shape, index: Index) -> Body:
        """Some of the bodies of this shape."""
        if not self.shape:
            return self
        moments, mass = taken(self.moments, 1, shape, index), taken(self.mass, 0, shape, index)
        return Body(moments, mass=mass, physical=self.physical)._marked(self.about)

    def __repr__(self) -> str:
        physical = "" if self.physical else ", physical=False"
        if self.shape:
            return f"Body(moments of shape {(*self.shape, 3)}{physical})"
        return f"Body(moments={self.moments}, mass={self.mass}, sides={self.sides}{physical})"

    @classmethod
    def box(cls, a: ArrayLike, b: ArrayLike, c: ArrayLike, *, mass: ArrayLike = 1.0) -> Body:
        """A homogeneous box with sides ``a``, ``b``, ``c`` (m) along the body axes 1, 2, 3.

        ``I = mass/12 (b² + c², a² + c², a² + b²)``. Sizes and masses of the solids may be arrays,
        which broadcast: then there are many bodies.

        Parameters
        ----------
        a, b, c : array_like, shape (...)
            Sides (m), positive.
        mass : array_like, shape (...)
            Mass (kg), positive.

        Returns
        -------
        Body
            Many bodies if a size or the mass is an array.

        Raises
        ------
        ValueError
            If a side or a mass is not positive or not finite, the arguments do not broadcast, or no
            body has such moments.

        Warns
        -----
        UserWarning
            If a side is above 5 m and the box would be lighter than any solid, 0.1 kg/m³: the
            sides are probably not in m. A mass of 1 stands for any mass, and is not compared.

        Examples
        --------
        >>> import rigid
        >>> book = rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
        >>> [round(moment * 12e4 / 0.3) for moment in book.moments]
        [65, 626, 689]
        """
        a, b, c, mass = _size("a", a), _size("b", b), _size("c", c), _size("mass", mass)
        sizes = _together(a=a, b=b, c=c, mass=mass)
        if sizes == ():
            sides = (float(a), float(b), float(c))
            _warn_of_units(sides, float(mass))
            return cls(box_moments(a, b, c, mass), mass=mass, sides=sides)._marked("centre")
        return cls._of_solid("box", mass, a=a, b=b, c=c)

    @classmethod
    def from_tensor(
        cls, tensor: ArrayLike, *, physical: bool = True
    ) -> tuple[Body, NDArray[np.float64]]:
        """The body with a tensor of inertia, and its principal axes.

        Parameters
        ----------
        tensor : array_like, shape (3, 3)
            Symmetric tensor of inertia (kg m²), products with their minus signs. Entries that
            differ from their mirror entries by at most 1e-5 of the largest entry are averaged.
        physical : bool
            As for :class:`Body`.

        Returns
        -------
        body : Body
            Moments ascending.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 in the frame of the tensor; right-handed.

        Raises
        ------
        ValueError
            If the tensor is not finite and symmetric, or no body has its moments.

        Warns
        -----
        MomentsWarning
            As :class:`Body`.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> body, axes = rigid.Body.from_tensor([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.5]])
        >>> np.allclose(body.moments, (1.0, 2.5, 3.0))
        True
        >>> np.allclose(axes @ np.diag(body.moments) @ axes.T, [[2, 1, 0], [1, 2, 0], [0, 0, 2.5]])
        True
        """
        array = numbers("tensor", tensor)
        if array.shape != (3, 3):
            raise ValueError(f"tensor: expected shape (3, 3), got {array.shape}")
        moments, axes = _core.principal_axes(symmetric_tensor("tensor", array).tolist())
        if physical and moments[0] < 0.0:  # the zero of a rod, rounded
            moments = possible_moments("tensor", np.array(moments)).tolist()
        return cls(moments, physical=physical), np.array(axes)

    @classmethod
    def ellipsoid(cls, a: ArrayLike, b: ArrayLike, c: ArrayLike, *, mass: ArrayLike = 1.0) -> Body:
        """A homogeneous ellipsoid with semi-axes ``a``, ``b``, ``c`` (m) along the body axes.

        ``I = mass/5 (b² + c², a² + c², a² + b²)``. Sizes and masses may be arrays, as for
        :meth:`box`.

        Parameters
        ----------
        a, b, c : array_like, shape (...)
            Semi-axes (m), positive.
        mass : array_like, shape (...)
            Mass (kg), positive.

        Returns
        -------
        Body
            Many bodies if a size or the mass is an array.

        Raises
        ------
        ValueError
            As for :meth:`box`.

        Examples
        --------
        >>> import rigid
        >>> rigid.Body.ellipsoid(3.0, 2.0, 1.0, mass=5.0).moments
        (5.0, 10.0, 13.0)
        """
        return cls._of_solid("ellipsoid", mass, a=a, b=b, c=c)

    @classmethod
    def sphere(cls, radius: ArrayLike, *, inner: ArrayLike = 0.0, mass: ArrayLike = 1.0) -> Body:
        """A homogeneous ball, hollow up to the radius ``inner`` (m): :func:`rigid.solids.sphere`.

        Parameters
        ----------
        radius : array_like, shape (...)
            Outer radius (m), positive.
        inner : array_like, shape (...)
            Inner radius (m), from zero to the outer radius.
        mass : array_like, shape (...)
            Mass (kg), positive.

        Returns
        -------
        Body
            Many bodies if a size or the mass is an array.

        Raises
        ------
        ValueError
            As for :meth:`box`, or if the inner radius exceeds the outer.

        Examples
        --------
        >>> import rigid
        >>> rigid.Body.sphere(1.0, mass=5.0).moments
        (2.0, 2.0, 2.0)
        """
        return cls._of_solid("sphere", mass, ("inner",), radius=radius, inner=inner)

    @classmethod
    def rod(cls, length: ArrayLike, *, mass: ArrayLike = 1.0) -> Body:
        """A thin rod along axis 3, without a moment about this axis: :func:`rigid.solids.rod`.

        ``I = mass/12 (length², length², 0)``. A dumbbell is ``Body((I, I, 0))``. Such a body cannot
        spin about its own axis: ``omega3`` must be 0. It turns uniformly about its angular
        momentum; as a heavy top it is a spherical pendulum. What needs the spin is refused.

        Parameters
        ----------
        length : array_like, shape (...)
            Length (m), positive.
        mass : array_like, shape (...)
            Mass (kg), positive.

        Returns
        -------
        Body
            Many bodies if the length or the mass is an array.

        Raises
        ------
        ValueError
            As for :meth:`box`.

        Examples
        --------
        >>> import numpy as np, rigid
        >>> rod = rigid.Body.rod(2.0, mass=3.0)
        >>> rod.moments
        (1.0, 1.0, 0.0)
        >>> top, _ = rigid.HeavyTop.from_mass(rod, com=(0.0, 0.0, 1.0), g=9.81)
        >>> small = rigid.exact.pendulum_period(top, 0.0, axis=1)  # 2 pi sqrt(2 length / 3 g)
        >>> bool(np.isclose(small, 2.0 * np.pi * np.sqrt(4.0 / (3.0 * 9.81))))
        True
        """
        return cls._of_solid("rod", mass, length=length)

    @classmethod
    def cylinder(
        cls,
        radius: ArrayLike,
        height: ArrayLike,
        *,
        inner: ArrayLike = 0.0,
        mass: ArrayLike = 1.0,
    ) -> Body:
        """A homogeneous cylinder (m) about body axis 3: :func:`rigid.solids.cylinder`.

        Without height it is a disk, and with ``inner = radius`` a ring or a pipe.

        Parameters
        ----------
        radius, height : array_like, shape (...)
            Outer radius (m), positive, and height (m), not negative.
        inner : array_like, shape (...)
            Inner radius (m), from zero to the outer radius.
        mass : array_like, shape (...)
            Mass (kg), positive.

        Returns
        -------
        Body
            Many bodies if a size or the mass is an array.

        Raises
        ------
        ValueError
            As for :meth:`box`, or if the inner radius exceeds the outer.

        Examples
        --------
        >>> import rigid
        >>> rigid.Body.cylinder(1.0, 3.0, mass=2.0).moments
        (2.0, 2.0, 1.0)
        """
        sizes = {"radius": radius, "height": height, "inner": inner}
        return cls._of_solid("cylinder", mass, ("height", "inner"), **sizes)

    @classmethod
    def cone(cls, radius: ArrayLike, height: ArrayLike, *, mass: ArrayLike = 1.0) -> Body:
        """A homogeneous cone (m) about body axis 3, moments about its centre of mass.

        A top standing on its tip is the first of a pair, the top and its axes:
        ``top, axes = HeavyTop.from_mass(cone, com=(0, 0, 3 / 4 * height))``.

        Parameters
        ----------
        radius, height : array_like, shape (...)
            Radius of the base and height (m), positive.
        mass : array_like, shape (...)
            Mass (kg), positive.

        Returns
        -------
        Body
            Many bodies if a size or the mass is an array.

        Raises
        ------
        ValueError
            As for :meth:`box`.

        Examples
        --------
        >>> import rigid
        >>> rigid.Body.cone(1.0, 4.0, mass=20.0).moments
        (15.0, 15.0, 6.0)
        """
        return cls._of_solid("cone", mass, radius=radius, height=height)

    @classmethod
    def from_properties(
        cls, properties: MassProperties, *, about: ArrayLike | None = None
    ) -> tuple[Body, NDArray[np.float64]]:
        """The body with these mass properties, and its principal axes.

        Parameters
        ----------
        properties : MassProperties
            Mass properties of one body.
        about : array_like, shape (3,), optional
            The fixed point (m), in the coordinates of the centre of mass; without one, the moments
            are those about the centre of mass.

        Returns
        -------
        body : Body
            Moments ascending.
        axes : ndarray, shape (3, 3)
            As :meth:`from_tensor` gives them.

        Raises
        ------
        ValueError
            If there are several bodies, or for the reasons of :meth:`from_tensor` (a rod).

        Examples
        --------
        >>> import rigid
        >>> from rigid import solids
        >>> top, axes = rigid.Body.from_properties(
        ...     solids.cone(1.0, 2.0, mass=20.0), about=[0.0, 0.0, 0.0]
        ... )
        >>> top.moments, axes[:, 0]
        ((6.0, 51.0, 51.0), array([0., 0., 1.]))
        """
        tensor, mass, _ = checked_properties(properties)
        if about is not None:
            tensor = properties.about(vector("about", about, 3))
        body, axes = cls.from_tensor(tensor)
        where = "centre" if about is None else "point"
        return cls(body.moments, mass=mass)._marked(where), axes

    @classmethod
    def from_points(
        cls, masses: ArrayLike, points: ArrayLike, *, about: ArrayLike | None = None
    ) -> tuple[Body, NDArray[np.float64]]:
        """The rigid body that consists of mass points, and its principal axes.

        Parameters
        ----------
        masses : array_like, shape (n,)
            Masses (kg), none negative.
        points : array_like, shape (n, 3)
            Positions of the masses (m), not all on one line.
        about
            As for :meth:`from_properties`, whose results these are.

        Returns
        -------
        body : Body
            Moments ascending, and the mass.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 in the frame of the points; right-handed.

        Raises
        ------
        ValueError
            If the shapes do not fit, a number is not finite, a mass is negative, or all points lie
            on one line.

        Examples
        --------
        >>> import rigid
        >>> square = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
        >>> rigid.Body.from_points([1.0] * 4, square)[0].moments
        (2.0, 2.0, 4.0)
        """
        from ..solids.mass_properties import point_masses

        return cls.from_properties(point_masses(masses, points), about=about)

    @classmethod
    def from_mesh(
        cls,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        density: float | None = None,
        mass: float | None = None,
        unit: float | str | None = None,
        about: ArrayLike | None = None,
    ) -> tuple[Body, NDArray[np.float64]]:
        """The homogeneous body inside a closed triangle mesh, and its principal axes.

        Parameters
        ----------
        vertices, faces, density, mass, unit
            As for :func:`rigid.meshes.mesh_properties`.
        about
            As for :meth:`from_properties`, whose results these are.

        Returns
        -------
        body : Body
            Moments ascending, and the mass.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 in the frame of the mesh; right-handed.

        Raises
        ------
        ValueError
            As for :func:`rigid.meshes.mesh_properties`, such as for an open mesh.

        Examples
        --------
        >>> import rigid
        >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        >>> body, axes = rigid.Body.from_mesh(corners, faces, mass=80.0)
        >>> [round(moment, 12) for moment in body.moments]
        [5.0, 5.0, 8.0]
        """
        from ..meshes import mesh_properties

        return cls.from_properties(
            mesh_properties(vertices, faces, density=density, mass=mass, unit=unit), about=about
        )

    @classmethod
    def from_stl(
        cls,
        path: str | PathLike[str],
        *,
        density: float | None = None,
        mass: float | None = None,
        unit: float | str | None = None,
        about: ArrayLike | None = None,
    ) -> tuple[Body, NDArray[np.float64]]:
        """The homogeneous body in an STL file, and its principal axes; needs trimesh.

        Parameters
        ----------
        path : path-like
            File of a closed mesh whose triangles are counterclockwise seen from outside.
        density : float, optional
            Density (kg/m³); 1 if neither density nor mass is given.
        mass : float, optional
            Mass (kg). Pass either the mass or the density.
        unit : float or {"m", "cm", "mm", "in"}, optional
            The unit of the file, or its length in m; m if it is not given.
        about
            As for :meth:`from_properties`, whose results these are, in the axes of the file.

        Returns
        -------
        body : Body
            Moments ascending, and the mass.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 in the frame of the file; right-handed.

        Raises
        ------
        ValueError
            Naming the path, if the file has no triangles, or the mesh is open, not consistently
            oriented or inside out; see :func:`rigid.meshes.mesh_properties`.
        OSError
            If the file cannot be read.
        ImportError
            Without trimesh, extra ``mesh``.

        Warns
        -----
        UserWarning
            If a file without ``unit`` is longer than 5 m: see :func:`rigid.meshes.mesh_properties`.

        Examples
        --------
        >>> import os, tempfile, rigid, trimesh
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = os.path.join(folder, "box.stl")
        ...     _ = trimesh.creation.box((250.0, 80.0, 10.0)).export(path)
        ...     body, axes = rigid.Body.from_stl(path, mass=0.3, unit="mm")
        >>> [round(moment, 9) for moment in body.moments]
        [0.0001625, 0.001565, 0.0017225]
        """
        from ..meshes import file_properties

        properties = file_properties(path, density=density, mass=mass, unit=unit, kind="stl")
        return cls.from_properties(properties, about=about)

    @classmethod
    def from_obj(
        cls,
        path: str | PathLike[str],
        *,
        density: float | None = None,
        mass: float | None = None,
        unit: float | str | None = None,
        about: ArrayLike | None = None,
    ) -> tuple[Body, NDArray[np.float64]]:
        """The homogeneous body in an OBJ file, and its principal axes.

        Parameters, results and errors are as for :meth:`from_stl`; polygons become triangles.

        Polygons of the file become triangles.

        Parameters
        ----------
        path, density, mass, unit, about
            As for :meth:`from_stl`.

        Returns
        -------
        body : Body
            Moments ascending, and the mass.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 in the frame of the file; right-handed.

        Raises
        ------
        ValueError, OSError, ImportError
            As for :meth:`from_stl`.

        Examples
        --------
        >>> import os, tempfile, rigid, trimesh
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = os.path.join(folder, "box.obj")
        ...     _ = trimesh.creation.box((250.0, 80.0, 10.0)).export(path)
        ...     body, axes = rigid.Body.from_obj(path, mass=0.3, unit="mm")
        >>> [round(moment, 9) for moment in body.moments]
        [0.0001625, 0.001565, 0.0017225]
        """
        from ..meshes import file_properties

        properties = file_properties(path, density=density, mass=mass, unit=unit, kind="obj")
        return cls.from_properties(properties, about=about)

    @classmethod
    def from_urdf(
        cls, path: str | PathLike[str], *, link: str | None = None, about: ArrayLike | None = None
    ) -> tuple[Body, NDArray[np.float64]]:
        """A link of a robot in a URDF file, and its principal axes.

        Read is the element ``inertial``: ``mass``, ``inertia``, whose numbers are the entries of
        the matrix, and ``origin``, the centre of mass and the axes of ``inertia`` in the link.

        Parameters
        ----------
        path : path-like
        link : str, optional
            Name of the link; by default the only one with a mass.
        about : array_like, shape (3,), optional
            As for :meth:`from_properties`, in the axes of the link.

        Returns
        -------
        body : Body
            Moments ascending, and the mass.
        axes : ndarray, shape (3, 3)
            Column k is body axis k + 1 in the frame of the link; right-handed.

        Raises
        ------
        ValueError
            Naming the path, if it is no URDF or has a document type, no link or several links with
            a mass have the name, a number is missing or none, or no body has the inertia.
        OSError
            If the file cannot be read.

        Warns
        -----
        MomentsWarning
            As :class:`Body`.

        Examples
        --------
        >>> import os, tempfile, numpy as np, rigid
        >>> text = '''<robot name="arm"><link name="hand"><inertial>
        ... <origin xyz="0 0 0.1" rpy="0 1.5707963267948966 0"/><mass value="2"/>
        ... <inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="2.5"/>
        ... </inertial></link></robot>'''
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = os.path.join(folder, "arm.urdf")
        ...     with open(path, "w") as file:
        ...         _ = file.write(text)
        ...     body, axes = rigid.Body.from_urdf(path, link="hand")
        >>> body.mass, np.round(body.moments, 12).tolist()
        (2.0, [1.0, 2.0, 2.5])
        >>> bool(np.isclose(abs(axes[2, 0]), 1.0))  # the axis of the smallest is along z
        True
        """
        from ..inertia.urdf import link_properties

        return cls.from_properties(link_properties(path, link), about=about)

    @classmethod
    def _of_solid(
        cls, name: str, mass: ArrayLike, zero: tuple[str, ...] = (), **sizes: ArrayLike
    ) -> Body:
        """The body of a function of :mod:`rigid.solids`; of its sizes these may be zero."""
        from .. import solids

        sizes["mass"] = mass
        known = {size: _size(size, sizes[size], zero=size in zero) for size in sizes}
        _together(**known)
        properties = getattr(solids, name)(**known)
        moments = np.diagonal(properties.tensor, axis1=-2, axis2=-1)
        return cls(moments, mass=properties.mass)._marked("centre")

    def _marked(self, about: str | None) -> Body:
        """The body itself, just made, with the point of its moments recorded."""
        object.__setattr__(self, "about", about)  # the dataclass is frozen
        return self

    @property
    def gammas(self) -> tuple[float, float, float]:
        """Factors of Euler's equations: ``((I2-I3)/I1, (I3-I1)/I2, (I1-I2)/I3)``.

        Their sum and their product cancel (both terms of ``g1 + g2 + g3 + g1 g2 g3 = 0``).
        Of many bodies three arrays of shape ``(...)``.
        """
        refuse_rods(np.asarray(self.moments))
        i1, i2, i3 = np.moveaxis(np.asarray(self.moments), -1, 0) if self.shape else self.moments
        return (i2 - i3) / i1, (i3 - i1) / i2, (i1 - i2) / i3

    @property
    def symmetry_axis(self) -> int | None:
        """The axis 1, 2 or 3 about which two moments are exactly equal, or None.

        Raises
        ------
        ValueError
            If there are many bodies.
        """
        require_one(self)
        return symmetry_axis(self.moments)

    def to_dict(self) -> dict[str, Any]:
        """The body as a dict of numbers, for JSON; :meth:`from_dict` reads it.

        Returns
        -------
        dict
        """
        moments = self.moments
        data = {
            "moments": moments.tolist() if isinstance(moments, np.ndarray) else list(moments),
            "mass": self.mass.tolist() if isinstance(self.mass, np.ndarray) else self.mass,
            "sides": None if self.sides is None else list(self.sides),
        }
        return data if self.physical else {**data, "physical": False}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Body:
        """The body that :meth:`to_dict` described.

        Parameters
        ----------
        data : dict
            The dictionary.

        Returns
        -------
        Body

        Examples
        --------
        >>> import rigid
        >>> box = rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
        >>> rigid.Body.from_dict(box.to_dict()) == box
        True
        """
        known = {key: data[key] for key in ("mass", "sides", "physical") if key in data}
        return cls(data["moments"], **known)


def _warn_of_units(sides: tuple[float, float, float], mass: float) -> None:
    """Warn of a large box that is lighter than any solid."""
    density = mass / sides[0] / sides[1] / sides[2]
    if max(sides) > LARGE_SIDE and density < LEAST_DENSITY and mass != 1.0:
        warn_caller(
            f"sides = ({', '.join(f'{side:g}' for side in sides)}), mass = {mass:g}: a box of "
            f"{density:.2g} kg/m³ is lighter than any solid; lengths are in m, masses in kg"
        )


def _together(**sizes: float | Floats) -> Shape:
    """The axes of bodies with these sizes; ValueError if they do not broadcast."""
    return batch_shape({name: np.shape(size) for name, size in sizes.items()})


def _size(name: str, value: ArrayLike, *, zero: bool = False) -> float | Floats:
    """A length (m) or a mass (kg), or an array of them: positive, or not negative."""
    unit = "kg" if name == "mass" else "m"
    value = without_unit(name, value, unit)
    if np.ndim(value):
        return shaped(name, value, positive=not zero, nonnegative=zero, unit=unit)
    return finite_float(name, value, positive=not zero, nonnegative=zero, unit=unit)


def check_body(body: object) -> Body:
    """``body`` if it is a body; TypeError says what is given instead."""
    if isinstance(body, Body):
        return body
    raise TypeError(f"body = {brief(body)}: must be a rigid.Body{pair_hint(body)}")


def pair_hint(value: object) -> str:
    """What to write instead of the pair that ``from_mass`` and its like return, if it is one."""
    if not (isinstance(value, tuple) and len(value) == 2):
        return ""
    first = value[0]
    if not isinstance(getattr(first, "body", first), Body):
        return ""
    name = "body" if isinstance(first, Body) else "top"
    return (
        f"; this is a pair, the {name} and its axes: write {name}, axes = ..., and pass {name} "
        "(frame=axes gives states along the axes of the drawing)"
    )


def require_one(value: Any) -> None:
    """Raise ValueError for a body or a scene that holds many bodies."""
    if value.shape:
        name = "body" if isinstance(value, Body) else "scene"
        raise ValueError(
            f"{name}: expected one body, got bodies of shape {value.shape}; take one of them, "
            f"{name}[{', '.join('0' * len(value.shape))}]"
        )


ROUNDING = 8.0 * 2.0**-53
"""Share of the largest rate that rounding leaves about the axis of a rod in another frame."""


def rates_of_rods(
    name: str,
    rates: Floats,
    moments: Floats,
    weight: ArrayLike = 0.0,
    forces: tuple[str, ...] = (),
) -> Floats:
    """The rates, shape (..., 3); those about the axes of rods, if only rounding, become zero.

    ``weight`` is ``mgl * com``, and ``forces`` are the names of the forces that act.

    Raises
    ------
    ValueError
        Where a rod would spin about its axis, or begin to.
    """
    if not hold_rods(moments):
        return rates
    along = rods(moments)[..., np.newaxis] & (moments == 0.0)
    size = np.abs(rates).max(axis=-1, keepdims=True)
    spins = along & (np.abs(rates) > ROUNDING * size)
    if spins.any():
        (*body, axis), _ = first_place(spins)
        values = np.broadcast_to(rates, spins.shape)[tuple(body)].tolist()
        raise ValueError(
            f"{name} = {brief(values)}: a rod has no moment about its axis and cannot spin "
            f"about it; the rate about axis {axis + 1} must be 0"
        )
    if np.any(~along & along.any(axis=-1, keepdims=True) & (np.asarray(weight) != 0.0)):
        raise ValueError("com: the mass of a rod is on its axis, and so must be com")
    if forces:
        raise ValueError(
            f"scene: no rod moves under {forces_in_words(forces)}, which could spin it about its "
            "axis, where it has no moment; give a small moment"
        )
    kept: Floats = np.where(along, 0.0, rates)
    kept.setflags(write=False)
    return kept


def _checked_moments(value: ArrayLike, physical: bool) -> Moments:
    """The moments; the core checks them and names the broken rule."""
    array = numbers("moments", value)
    if not array.ndim or array.shape[-1] != 3:
        raise ValueError(f"moments: expected shape (3,) or (..., 3), got {array.shape}")
    return vector_of(checked_moments(array, physical))


def _checked_mass(value: ArrayLike, shape: Shape) -> float | Floats:
    if not np.ndim(value):
        return finite_float("mass", value, positive=True)
    array = shaped("mass", value, positive=True)
    if batch_shape({"moments": shape, "mass": array.shape}) != shape:
        raise ValueError(f"mass: expected shape {shape} or (), got {array.shape}")
    return frozen(np.broadcast_to(array, shape))
