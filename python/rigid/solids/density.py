"""Mass, centre and tensor of inertia of a given density, by quadrature with an error estimate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief, finite_float, shaped, vector
from .._checks.arrays import Floats
from .mass_properties import MassProperties, point_masses

ORDERS = (4, 6, 8, 12, 16, 24, 32, 48, 64)
"""Numbers of Gauss points along each coordinate, tried in this order."""


@dataclass(frozen=True, slots=True)
class Region:
    """A part of space as the image of the unit cube.

    :func:`box_region`, :func:`ellipsoid_region` and :func:`cylinder_region` make regions.

    Attributes
    ----------
    name : str
        Description of the region.
    image : callable
        Function of points of the unit cube, shape (n, 3), that returns the points in space (m),
        shape (n, 3), and the Jacobian determinant of the map, shape (n,). Write your own function
        for other regions.
    """

    name: str
    image: Callable[[Floats], tuple[Floats, Floats]]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DensityIntegral:
    """Mass properties of a density, with an error estimate.

    Attributes
    ----------
    properties : MassProperties
        Mass (kg), centre of mass (m), tensor of inertia about it (kg m²).
    error : float
        Estimated relative error of mass and tensor: the last change between two orders, or one
        standard error of samples.
    converged : bool
        Whether the error is within the tolerance; for samples, whether the error is finite.
    points : tuple of int
        Number of points of each order.
    changes : tuple of float
        Relative change from each order to the next.
    """

    properties: MassProperties
    error: float
    converged: bool
    points: tuple[int, ...]
    changes: tuple[float, ...]


def box_region(lower: ArrayLike, upper: ArrayLike) -> Region:
    """The box between two corners.

    Parameters
    ----------
    lower, upper : array_like, shape (3,)
        Corners (m), the upper one above the lower in each coordinate.

    Returns
    -------
    Region

    Raises
    ------
    ValueError
        If the region is empty.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.box_region([0, 0, 0], [1, 2, 3]).name
    'box from [0.0, 0.0, 0.0] to [1.0, 2.0, 3.0]'
    """
    low, high = vector("lower", lower, 3), vector("upper", upper, 3)
    if not np.all(high > low):
        raise ValueError(
            f"upper = {high.tolist()}: must lie above lower = {low.tolist()} in each coordinate, "
            "the region is empty"
        )
    sides = high - low

    def image(u: Floats) -> tuple[Floats, Floats]:
        return low + sides * u, np.full(len(u), sides.prod())

    return Region(f"box from {low.tolist()} to {high.tolist()}", image)


def ellipsoid_region(a: float, b: float, c: float) -> Region:
    """The ellipsoid with semi-axes ``a, b, c`` (m) about the origin, in spherical coordinates.

    Parameters
    ----------
    a, b, c : float
        Semi-axes (m), positive.

    Returns
    -------
    Region

    Raises
    ------
    ValueError
        If a semi-axis is not positive.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.ellipsoid_region(3.0, 2.0, 1.0).name
    'ellipsoid with semi-axes [3.0, 2.0, 1.0]'
    """
    axes = np.array(
        [finite_float(*pair, positive=True) for pair in zip("abc", (a, b, c), strict=True)]
    )

    def image(u: Floats) -> tuple[Floats, Floats]:
        radius, height, angle = u[:, 0], 2.0 * u[:, 1] - 1.0, 2.0 * pi * u[:, 2]
        across = np.sqrt(1.0 - height * height)
        unit = np.stack([across * np.cos(angle), across * np.sin(angle), height], axis=-1)
        return axes * radius[:, None] * unit, 4.0 * pi * axes.prod() * radius * radius

    return Region(f"ellipsoid with semi-axes {axes.tolist()}", image)


def cylinder_region(radius: float, height: float) -> Region:
    """The cylinder about axis 3 between ``-height/2`` and ``height/2`` (m).

    Parameters
    ----------
    radius, height : float
        Sizes (m), positive.

    Returns
    -------
    Region

    Raises
    ------
    ValueError
        If a size is not positive.

    Examples
    --------
    >>> from rigid import solids
    >>> solids.cylinder_region(1.0, 2.0).name
    'cylinder of radius 1.0 and height 2.0'
    """
    radius = finite_float("radius", radius, positive=True)
    height = finite_float("height", height, positive=True)

    def image(u: Floats) -> tuple[Floats, Floats]:
        distance, angle = radius * u[:, 0], 2.0 * pi * u[:, 1]
        points = [distance * np.cos(angle), distance * np.sin(angle), height * (u[:, 2] - 0.5)]
        return np.stack(points, axis=-1), 2.0 * pi * radius * height * distance

    return Region(f"cylinder of radius {radius} and height {height}", image)


def density_integral(
    density: float | Callable[[Floats], ArrayLike], region: Region, *, tolerance: float = 1e-10
) -> DensityIntegral:
    """Mass, centre and tensor of a density over a region, by Gauss–Legendre quadrature.

    ``I = ∭ rho (r² 1 - r ⊗ r) dV`` (Ercan 2016, §§ 1, 7.1; lecture notes, eq. (5.9)). The function
    raises the order until neither mass nor tensor changes by more than the tolerance. This is fast
    for a density that is smooth in the region. If the density jumps, integrate over one region for
    each smooth part and combine the properties by :func:`rigid.inertia.compose`.

    Parameters
    ----------
    density : float or callable
        Density (kg/m³), or a function of points of shape (n, 3) that returns it, shape (n,); not
        negative.
    region : Region
        The result of :func:`box_region`, :func:`ellipsoid_region` or :func:`cylinder_region`, or
        your own region.
    tolerance : float
        Relative error to reach.

    Returns
    -------
    DensityIntegral
        ``converged`` is false if 64 points along each coordinate do not reach the tolerance; see
        ``changes``.

    Raises
    ------
    TypeError
        If the region is none.
    ValueError
        If the density is negative, not finite or has the wrong shape, or there is no mass.

    Examples
    --------
    >>> from rigid import solids
    >>> ball = solids.density_integral(3.0, solids.ellipsoid_region(1.0, 1.0, 1.0))
    >>> float((ball.properties.tensor[0, 0] / ball.properties.mass).round(9)), ball.converged
    (0.4, True)
    """
    if not isinstance(region, Region):
        raise TypeError(f"region = {brief(region)}: must be a rigid.solids.Region")
    tolerance = finite_float("tolerance", tolerance, positive=True)
    function = density if callable(density) else _constant(finite_float("density", density))
    points: list[int] = []
    changes: list[float] = []
    before: MassProperties | None = None
    for order in ORDERS:
        masses, places = _gauss(function, region, order)
        points.append(order**3)
        if not masses.any() and order < ORDERS[-1]:
            continue  # so few points may miss all mass
        now = point_masses(masses, places)
        if before is not None:
            changes.append(_change(before, now))
            if changes[-1] <= tolerance:
                break
        before = now
    error = changes[-1] if changes else np.inf
    return DensityIntegral(
        properties=now,
        error=error,
        converged=error <= tolerance,
        points=tuple(points),
        changes=tuple(changes),
    )


def sampled_density(density: ArrayLike, points: ArrayLike, volume: float) -> DensityIntegral:
    """Mass, centre and tensor from a density known at points spread evenly over a region.

    Parameters
    ----------
    density : array_like, shape (n,)
        Density at the points (kg/m³), not negative.
    points : array_like, shape (n, 3)
        Points drawn uniformly from the region (m). For points on a regular grid the error estimate,
        which assumes random points, is too large.
    volume : float
        Volume of the region (m³).

    Returns
    -------
    DensityIntegral
        ``error`` is the larger relative standard error of mass and tensor.

    Raises
    ------
    ValueError
        If there are fewer than two points, the mass is zero, a density is negative, or the shapes
        do not match.

    Examples
    --------
    >>> import numpy as np
    >>> from rigid import solids
    >>> points = np.random.default_rng(1).uniform(-1.0, 1.0, (100_000, 3))
    >>> inside = (np.linalg.norm(points, axis=1) < 1.0).astype(float)
    >>> ball = solids.sampled_density(inside, points, volume=8.0)
    >>> ball.properties.mass.round(2), bool(ball.error < 0.01)
    (np.float64(4.18), True)
    """
    r = shaped("points", points, 3)
    rho = shaped("density", density, nonnegative=True)
    volume = finite_float("volume", volume, positive=True)
    if r.ndim != 2 or rho.shape != r.shape[:1] or len(r) < 2:
        raise ValueError(
            f"points: expected shape (n, 3) with n densities, at least two, got {r.shape} and "
            f"{rho.shape}"
        )
    properties = point_masses(rho * (volume / len(r)), r)
    away = r - properties.centre
    square = np.vecdot(away, away)[:, None, None] * np.eye(3) - away[:, :, None] * away[:, None, :]
    scale = volume / np.sqrt(len(r) - 1)
    mass_error = rho.std() * scale / properties.mass
    tensor_error = (rho[:, None, None] * square).std(axis=0).max() * scale
    error = float(max(mass_error, tensor_error / np.abs(properties.tensor).max()))
    return DensityIntegral(
        properties=properties,
        error=error,
        converged=bool(np.isfinite(error)),
        points=(len(r),),
        changes=(),
    )


def _constant(density: float) -> Callable[[Floats], Floats]:
    return lambda points: np.full(len(points), density)


def _gauss(
    density: Callable[[Floats], ArrayLike], region: Region, order: int
) -> tuple[Floats, Floats]:
    """Masses and places of the points of an order."""
    node, weight = np.polynomial.legendre.leggauss(order)
    node, weight = 0.5 * (node + 1.0), 0.5 * weight
    cube = np.stack(np.meshgrid(node, node, node, indexing="ij"), axis=-1).reshape(-1, 3)
    weights = np.einsum("i,j,k->ijk", weight, weight, weight).ravel()
    points, volume = region.image(cube)
    rho = shaped("density", density(points), nonnegative=True)
    if rho.shape != volume.shape:
        raise ValueError(
            f"density: expected shape {volume.shape} for points of shape {points.shape}, "
            f"got {rho.shape}"
        )
    return weights * volume * rho, points


def _change(before: MassProperties, now: MassProperties) -> float:
    """The largest relative change of mass, tensor and centre (relative to the gyration radius)."""
    scale = np.abs(now.tensor).max()
    tensor = np.abs(now.tensor - before.tensor).max() / scale
    gyration = np.sqrt(scale / now.mass)
    centre = np.linalg.norm(now.centre - before.centre) / gyration
    return float(max(abs(now.mass / before.mass - 1.0), tensor, centre))
