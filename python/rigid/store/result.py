"""The result of a stability map: named arrays, with pictures, files, replays and theory.

This module combines the data of a map with its pictures, files, theory, replays and finer maps.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._checks.arguments import brief, positive_int, resolve_threads
from .._checks.progress import ProgressOption
from .._files import MAP, require_ending
from ..drawing.figure import html_with_picture
from ..maps.data import CLASSES, MapData, counted
from ..maps.dataset import map_dataset, map_table, write_zarr
from ..maps.file import read_map, write_map
from ..maps.plan import map_plan
from ..maps.plot import SHARE, plot_map
from ..maps.replay import Replay, replay
from ..maps.samples import Outcomes, Starts, condition, outcomes, starts
from ..maps.spec import MapSpec
from ..maps.summary import summary
from ..maps.theory import Theory, disagreement, predict
from ..model.scene import Scene
from ..solve.columns import write_table
from ..solve.plan import Plan
from .head import receipt

if TYPE_CHECKING:
    from pathlib import Path

    import xarray
    from matplotlib.axes import Axes

    from ..animation.explorer import Explorer


class StabilityMap(MapData):
    """Result of :func:`stability_map`: named arrays of grid shape, indexed ``[..., y, x]``.

    Every column of the core is an attribute; :data:`rigid.maps.data.COLUMNS` has their types, units
    and meanings.

    Attributes
    ----------
    spec : MapSpec
        Everything that the numbers depend on.
    status : ndarray of uint8
        0 possible body; 1 a moment is not finite; 2 not positive; 3 triangle inequality broken.
    stable, unstable, undecided, failed : ndarray of int64
        Bodies of each class. A body is undecided if the second method disagrees or, in closed form,
        if the body leaves stability within rounding of the horizon. With :func:`rigid.regular`
        stable bodies are regular, unstable ones chaotic, and undecided ones neither yet.
    step_limit, not_finite, drifted : ndarray of int64
        Failed bodies by reason: more than ``max_steps`` steps were needed; overflow; energy,
        momentum or unit lengths off by more than 0.1.
    checked : ndarray of int64
        Bodies that the second method has classified again: ``dop853`` in other steps, or
        ``taylor16`` under a criterion of the user.
    audited, audited_undecided : ndarray of int64
        Bodies that were checked whatever their outcome, the audit, and undecided bodies among
        these.
    samples : ndarray of int64
        Bodies done, the sum of the four classes.
    measures : Measures
        The requested measures by name: ``result.measures["time_to_leave"].mean``,
        ``.std``, ``.least``, ``.largest``, ``.count``, ``.error`` and ``.quantile(q)``; see
        :class:`rigid.maps.measured.Measured`.
    share : ndarray
        ``stable / (stable + unstable)``, NaN if there are none.
    chaotic_share : ndarray
        ``1 - share``.
    lower, upper : ndarray
        95 % Clopper-Pearson interval of the share, widened by the undecided: they count as unstable
        for ``lower`` and as stable for ``upper``. The interval of a pixel contains the true share
        with a chance of 95 % or more. This holds for each pixel alone: of 1000 intervals, up to 50
        miss on average.
    exponent, mean_megno, largest_exponent : ndarray
        With :func:`rigid.regular`: means over the integrated bodies of their exponent (1/s) and of
        their mean MEGNO, and the largest exponent. The numbers of a body are taken at the end of
        its run: runs that are clearly chaotic end at a quarter or at half of the horizon. NaN where
        no body was integrated.
    growth, megno : ndarray of int64
        The sums of exponent times horizon and of mean MEGNO in units of ``2**-20``: they do not
        depend on the order of the bodies.
    resolution : float
        The smallest exponent (1/s) that the horizon can show; NaN for other criteria.
    energy_drift, momentum_drift, unit_drift : ndarray
        Worst relative drift of the energy and of the conserved momentum, and worst deviation of the
        length of a direction from one, in each pixel, failed bodies included; a drift above 0.1 is
        the reason why a body counts as ``drifted``. NaN where no body was integrated, because
        closed forms do not drift.
    earliest : ndarray
        First time (s) at which a body left stability, or was found to be chaotic; inf for none.
    steps : ndarray of int64
        Time steps taken.
    exact : ndarray of int64
        Bodies classified in closed form; they take no steps and are not repeated.
    narrow : ndarray of bool
        With ``half_width``, pixels whose interval is no wider than twice this number.
    stage : ndarray of uint8
        With ``refine`` or ``budget``, the stage that computes a pixel; 255: omitted.
    complete : bool
        Whether all requested bodies are computed, and no budget omitted pixels.
    ended : bool
        Whether the computation is over: the map is complete, or its ``budget`` is spent.
    cut : int
        Number of pixels that the ``budget`` omitted; with ``refine`` in its last stage.
    filled : ndarray
        The share, interpolated in the pixels that refinement has omitted.
    nanoseconds : ndarray
        Processor time spent. A measurement of this machine: not saved, NaN in a loaded map.
    elapsed : float
        Wall time in s; NaN in a loaded map.
    threads : int
        Threads used; 0 in a loaded map.
    computed : int
        Bodies that the call computed: fewer than all if rows were stored; 0 in a loaded map.

    Examples
    --------
    >>> import rigid
    >>> result = rigid.stability_map(
    ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
    ...     stable=rigid.tilt_below(0.5), rng=2026,
    ... )
    >>> result.share, result.upper.round(3)
    (array([0., 0., 1.]), array([0.036, 0.036, 1.   ]))
    """

    __slots__ = ()

    def __repr__(self) -> str:
        """Scene, grid and the share of each class."""
        done = int(self.samples.sum())
        shares = ", ".join(
            f"{self.columns[name].sum() / done:.1%} {name}" for name in CLASSES if done
        )
        axes = " x ".join(axis.name for axis in self.spec.axes)
        size = " x ".join(str(len(axis.values)) for axis in self.spec.axes)
        return (
            f"<StabilityMap: {self.spec.scene.title}, {axes}, {size} pixels; "
            f"{done:,} bodies: {shares or 'none'}>"
        )

    def _repr_html_(self) -> str:
        axes = self.spec.axes
        first = {axis.name: axis.values[0] for axis in axes[2:]}

        def draw(ax: Axes) -> None:
            """Of more than two axes the first plane."""
            self.plot(ax, at=first)

        return html_with_picture(draw, self.summary())

    @property
    def plan(self) -> Plan:
        """The plan of this map: methods, omitted computations and reasons."""
        return map_plan(self.spec)

    def theory(self) -> Theory | None:
        """The prediction for this map, or None where no theory is known.

        Returns
        -------
        Theory or None

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
        ...     stable=rigid.tilt_below(0.5), rng=2026,
        ... )
        >>> result.theory().label
        'nutation of a symmetric top released at rest, until t = 20 s'
        """
        return predict(self.spec)

    def disagreement(self, theory: Theory | None = None) -> NDArray[np.bool_]:
        """Pixels whose predicted share lies outside the interval [lower, upper].

        Each interval misses a true prediction with a chance of up to 5 %, each pixel's own: so up
        to one pixel of twenty disagrees by chance. True shares of 0 and 1 are never missed.

        Parameters
        ----------
        theory : Theory, optional
            By default the result of :meth:`theory`; without a theory no pixel disagrees.

        Returns
        -------
        ndarray of bool, grid shape

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
        ...     stable=rigid.tilt_below(0.5), rng=2026,
        ... )
        >>> int(result.disagreement().sum())
        0
        """
        return disagreement(self, theory or self.theory())

    def replay(
        self, pixel: int | tuple[int, ...], sample: int, t: ArrayLike | None = None
    ) -> Replay:
        """Compute one body of the map again, with its trajectory.

        First the bodies of the pixel are classified again, or this body alone if the pixel took
        many steps, and so are the bodies that left stability first. The numbers must agree with the
        map, which another version of rigid may have computed.

        Parameters
        ----------
        pixel : int or tuple of int
            Index in the arrays, ``[..., y, x]``; one integer counts in C order.
        sample : int
            Number of the body in its pixel, from 0.
        t : array_like, optional
            Times of the trajectory in s, reached by steps no longer than the steps of the map. By
            default about 500 ends of the very steps that were taken, until ``t_end``, or 501 times
            by closed form or under a table over time. A body that was not run, for example because
            of ``max_steps``, has its start only.

        Returns
        -------
        Replay

        Raises
        ------
        IndexError
            If there is no such pixel or sample.
        ValueError
            If the body of this pixel is impossible, or if this build of rigid computes other
            numbers than the map has: the body would not be the body of the map.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
        ...     stable=rigid.no_flip(), rng=2026,
        ... )
        >>> body = result.replay(pixel=1, sample=3)
        >>> body.parameters, body.outcome, 0.0 < body.left < 50.0
        ({'spin': 2.0}, 'unstable', True)
        >>> body.run.omega.shape
        (501, 3)
        """
        return replay(self, pixel, sample, t)

    def starts(
        self, sample: ArrayLike = 0, *, pixel: int | tuple[int, ...] | None = None
    ) -> Starts:
        """Starts of some bodies of every pixel, or of one pixel, bit for bit as the map drew them.

        Parameters
        ----------
        sample : int or array_like of int
            Number of the body in its pixel, from 0, or an array of numbers.
        pixel : int or tuple of int, optional
            Index of one pixel, as in :meth:`replay`.

        Returns
        -------
        Starts
            ``omega`` and ``attitude`` of shape ``(*grid, *sample, 3)`` and ``(..., 4)``, without
            the grid for one pixel.

        Raises
        ------
        IndexError
            If the map has no such pixel or sample.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
        ...     stable=rigid.no_flip(), rng=2026,
        ... )
        >>> result.starts(range(10)).omega.shape
        (2, 10, 3)
        >>> bool((result.starts(3, pixel=1).omega == result.replay(1, 3).omega).all())
        True
        """
        return starts(self, sample, pixel)

    def outcomes(
        self,
        sample: ArrayLike = 0,
        *,
        pixel: int | tuple[int, ...] | None = None,
        threads: int | None = None,
    ) -> Outcomes:
        """Outcomes of some bodies of every pixel, or of one pixel; the bodies are classified again.

        Where a criterion audits groups of 64 bodies, the whole group of a body is classified.

        Parameters
        ----------
        sample : int or array_like of int
            Number of the body in its pixel, from 0, or an array of numbers.
        pixel : int or tuple of int, optional
            Index of one pixel, as in :meth:`replay`.
        threads : int, optional
            Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

        Returns
        -------
        Outcomes
            Arrays of shape ``(*grid, *sample)``, or of the shape of ``sample`` for one pixel.

        Raises
        ------
        IndexError
            If the map has no such pixel or sample.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=100, t_end=50.0,
        ...     stable=rigid.no_flip(), rng=2026,
        ... )
        >>> bodies = result.outcomes(range(100))
        >>> bool(((bodies.outcome == "stable").sum(axis=1) == result.stable).all())
        True
        """
        return outcomes(self, sample, pixel, resolve_threads(threads))

    @classmethod
    def from_counts(
        cls,
        spec: MapSpec,
        *,
        stable: ArrayLike,
        unstable: ArrayLike,
        undecided: ArrayLike = 0,
        **columns: ArrayLike,
    ) -> StabilityMap:
        """A map from counts that another program made, with intervals, picture, file and theory.

        Parameters
        ----------
        spec : MapSpec
            The request. ``spec.samples`` is at least the number of bodies of each pixel.
        stable, unstable, undecided : array_like of int, grid shape
            Bodies of each class; a single number holds for every pixel.
        **columns : array_like, grid shape
            Other arrays of the map by their names in :data:`rigid.maps.data.STORED`. Failed bodies
            are given by their reasons ``step_limit``, ``not_finite`` and ``drifted``. What is not
            given is 0 if it counts, and NaN else.

        Returns
        -------
        StabilityMap
            :meth:`replay` computes its bodies and refuses if their numbers are other ones.

        Raises
        ------
        TypeError
            If counts are not whole numbers, or a column is unknown.
        ValueError
            If a shape differs from the grid, or no computation can give such counts.

        Examples
        --------
        >>> import rigid
        >>> spec = rigid.MapSpec(
        ...     scene=rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), start=rigid.Start(spin=1.0),
        ...     axes={"spin": [1.0, 2.0]}, stable=rigid.no_flip(), t_end=50.0, samples=100, seed=0,
        ... )
        >>> made = rigid.StabilityMap.from_counts(spec, stable=[90, 20], unstable=[10, 80])
        >>> made.share, made.upper.round(3)
        (array([0.9, 0.2]), array([0.951, 0.292]))
        """
        given = {"stable": stable, "unstable": unstable, "undecided": undecided, **columns}
        return cls.from_arrays(spec, counted(spec, given))

    def condition(self, samples: int = 1, *, threads: int | None = None) -> NDArray[np.float64]:
        """Factor by which the motions of each pixel magnify a small change of their start.

        Use the factor to distinguish sensitive motions from errors of the method; see
        :func:`rigid.condition`.

        Parameters
        ----------
        samples : int
            Number of bodies of each pixel that are followed to ``t_end``, beginning with the first.
        threads : int, optional
            Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

        Returns
        -------
        ndarray
            Median of the factors at ``t_end``, grid shape; NaN where no body is possible.

        Raises
        ------
        ValueError
            If ``samples`` is not between 1 and the number of samples of the map.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"I2/I1": [1.2, 1.8]}, samples=4, t_end=50.0,
        ...     stable=rigid.no_flip(), rng=2026,
        ... )
        >>> result.condition().shape
        (2,)
        """
        count = positive_int("samples", samples)
        if count > self.spec.samples:
            raise ValueError(
                f"samples = {brief(count)}: the map has {self.spec.samples} in a pixel"
            )
        return condition(self, count, resolve_threads(threads))

    def plot(
        self,
        ax: Axes | None = None,
        *,
        cells: bool = False,
        what: str = SHARE,
        at: Mapping[str, float] | None = None,
    ) -> Any:
        """Draw the map; see :func:`rigid.maps.plot.plot_map`.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default the axes of a new figure.
        cells : bool
            Draw the borders of the cells of a refined map.
        what : str, optional
            ``"share"``; ``"cost"``: the processor time of each pixel; or a number of a measure such
            as ``"mean of flips"``, ``"std of flips"``, ``"median of flips"`` or
            ``"quantile 0.9 of flips"``; or of a map of :func:`rigid.regular` ``"exponent"``,
            ``"mean_megno"`` or ``"largest_exponent"``.
        at : dict of str to float, optional
            Values of axes by their names, to draw the slice of the map there.

        Returns
        -------
        matplotlib Axes, or an ndarray of them
            A notebook and ``plt.show()`` show the picture;
            ``plot().figure.savefig("map.png")`` writes it. A map with three or four axes is drawn
            as small pictures: an array of Axes of shape (values of the fourth axis, values of the
            third).

        Raises
        ------
        ImportError
            Without matplotlib.
        ValueError
            If the map has no such axis or value, or more axes are left than can be drawn.

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
        ...     stable=rigid.tilt_below(0.5), rng=2026,
        ... )
        >>> result.plot().get_ylabel()
        'share stable until t = 20 s'
        """
        return plot_map(self, ax=ax, cells=cells, what=what, at=at)

    @overload
    def explore(
        self,
        path: None = None,
        *,
        samples: int | None = None,
        threads: int | None = None,
        saved_as: str | os.PathLike[str] | None = None,
        progress: ProgressOption = None,
    ) -> Explorer: ...

    @overload
    def explore(
        self,
        path: str | os.PathLike[str],
        *,
        samples: int | None = None,
        threads: int | None = None,
        saved_as: str | os.PathLike[str] | None = None,
        progress: ProgressOption = None,
    ) -> Path: ...

    def explore(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        samples: int | None = None,
        threads: int | None = None,
        saved_as: str | os.PathLike[str] | None = None,
        progress: ProgressOption = None,
    ) -> Path | Explorer:
        """Write a page that shows the map, the bodies of its pixels, and their motions as films.

        A browser opens the page without a network. The page computes the motions from the exact
        starts, by a Taylor series of order 24; the outcomes come from the map. A chaotic motion may
        differ from the motion that the map has classified: :meth:`replay` gives this motion.
        Motions under the torque of a function are not in the page.

        Parameters
        ----------
        path : path-like, optional
            The page; its name must end in ``.html``. Without a path the page is returned, and a
            notebook shows it.
        samples : int, optional
            Bodies of each pixel that the page has, the first ones. By default as many as need
            0.7 MB, at least 1 and at most 64.
        threads : int, optional
            Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.
        saved_as : path-like, optional
            The file to which :meth:`save` writes the map. The Python code that the page offers
            reads this file. Default: the name of the page with the suffix ``.npz``.
        progress : None, bool or callable
            As in :func:`simulate`.

        Returns
        -------
        Path or rigid.animation.explorer.Explorer
            The file; without a path, the page.

        Raises
        ------
        OSError
            If the file cannot be written, or the path names something other than a file.
        ValueError
            If the name does not end in ``.html``, or the map has not so many samples.

        Examples
        --------
        >>> import os, tempfile, rigid
        >>> result = rigid.stability_map(
        ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
        ...     stable=rigid.tilt_below(0.5), rng=2026,
        ... )
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     result.explore(os.path.join(folder, "map.html")).name
        'map.html'
        """
        from ..maps.page import explore  # takes long to import, as all that draws

        return explore(
            self, path, samples=samples, threads=threads, saved_as=saved_as, progress=progress
        )

    def widget(self, *, threads: int | None = None) -> Any:
        """The view of :meth:`explore` in a notebook, where zooming computes a finer map.

        Half a second after a zoom the map of the visible region is computed, with as many pixels,
        samples and the seed of this map: a new map, by ``spec.replace(axes=...)``. Its values lie
        between the least and the largest value of this map; of axes after the second it has the
        values that are chosen. A further zoom replaces a computation that has not ended. *whole
        map* shows this map again. The view lists up to 64 bodies of a pixel.

        Parameters
        ----------
        threads : int, optional
            Default: ``RIGID_NUM_THREADS``, else the cores that this process may use.

        Returns
        -------
        rigid.animation.widget.MapWidget
            An ``anywidget``. Its attribute ``result`` is the map that the view shows.

        Raises
        ------
        ImportError
            Without anywidget.
        ValueError
            If a function that the map needs is not known; see :func:`load_map`.
        """
        from .zooms import widget_of

        return widget_of(self, threads)

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write a tidy table: a row for each pixel, with its axes, share, interval and counts.

        The mean, standard deviation, least and largest value of each measure, the number of its
        values and their largest error are columns too. An axis of the user with the name of a
        column, such as ``share``, becomes ``axis_share``; so in :meth:`to_xarray`.

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
        >>> result = rigid.stability_map(
        ...     rigid.FreeBody, axes={"I2/I1": [1.2, 1.8]}, samples=4, t_end=50.0,
        ...     stable=rigid.no_flip(), rng=2026,
        ... )
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = result.to_csv(os.path.join(folder, "map.csv"))
        ...     print(*path.read_text().splitlines()[0].split(",")[:5])
        I2/I1 share lower upper samples
        """
        return write_table(path, map_table(self))

    def to_xarray(self) -> xarray.Dataset:
        """The map as an xarray Dataset.

        Dimensions have the names of the axes with ``_over_`` for ``/``, because netCDF allows no
        slash; coordinates have units; the attributes hold the specification as JSON.

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
        >>> result = rigid.stability_map(
        ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
        ...     stable=rigid.tilt_below(0.5), rng=2026,
        ... )
        >>> result.to_xarray().share.dims
        ('spin',)
        """
        return map_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the map to one data-only ``.npz`` file; :func:`load_map` reads it.

        A name that ends in ``.zarr`` becomes a folder of Zarr version 3, for
        ``xarray.open_zarr(path, consolidated=False)``. Each array has a CRC-32C. The name must be
        new.

        The file holds the arrays, and the specification as JSON under the name ``spec.json``. It
        holds no measured times, so equal seeds give equal bytes on every machine.

        The file appears whole or not at all: it is written under another name, synchronised with
        the disk and renamed. It replaces an older file and keeps the mode of that file.

        Parameters
        ----------
        path : path-like
            The file.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            If the name ends in neither ``.npz`` nor ``.zarr``.
        FileExistsError
            If the path names something other than a file: a directory, a symbolic link, a pipe
            or a device.
        OSError
            If the file cannot be written, for example because the disk is full. An older file stays
            as it was.

        Examples
        --------
        >>> import os, tempfile, rigid
        >>> result = rigid.stability_map(
        ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
        ...     stable=rigid.tilt_below(0.5), rng=2026,
        ... )
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = result.save(os.path.join(folder, "map.npz"))
        ...     bool((rigid.load_map(path).stable == result.stable).all())
        True
        """
        require_ending(path, MAP)
        write = write_zarr if os.fspath(path).endswith(".zarr") else write_map
        return write(self, path)

    def receipt(self) -> dict[str, Any]:
        """Versions, key and fingerprint that identify the numbers of this map.

        Returns
        -------
        dict
            ``spec``; ``key``, BLAKE2b-128 of what the numbers depend on; ``fingerprint``,
            BLAKE2b-256 of the key and of all arrays that follow from it. Both are hexadecimal, and
            depend on neither machine, instruction set, threads, engine nor order: two computations
            of one map have one fingerprint. ``seed``, ``version`` and ``complete``; ``writers``,
            the receipts of the processes that computed it, if it comes from a store.

        Examples
        --------
        >>> import rigid
        >>> ask = dict(axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0, stable=rigid.no_flip())
        >>> one, other = (
        ...     rigid.stability_map(rigid.FreeBody, rng=1, threads=n, **ask) for n in (1, 2)
        ... )
        >>> one.receipt()["fingerprint"] == other.receipt()["fingerprint"]
        True
        """
        return receipt(self)

    def summary(self) -> str:
        """Summary of computation, largest drift, undecided samples and comparison with theory.

        Returns
        -------
        str

        Examples
        --------
        >>> import rigid
        >>> result = rigid.stability_map(
        ...     rigid.HeavyTop, axes={"spin": [1.0, 3.0, 5.0]}, samples=100, t_end=20.0,
        ...     stable=rigid.tilt_below(0.5), rng=2026,
        ... )
        >>> result.summary().splitlines()[0]
        'scene       heavy top, moments (1, 1, 0.5), mgl 1, com (0, 0, 1)'
        """
        return summary(self)


def load_map(
    path: str | os.PathLike[str],
    *,
    scene: Callable[..., Any] | Scene | None = None,
    stable: Callable[..., Any] | None = None,
) -> StabilityMap:
    """Read a map that :meth:`StabilityMap.save` wrote.

    Parameters
    ----------
    path : path-like
        The file.
    scene : callable, optional
        The function that made the scenes, if one did: the file has digests of it alone. Or the
        scene, if its torque is a function: the file does not have it. Without them the map can be
        read and drawn, but not computed again.
    stable : callable, optional
        The function of :func:`judged`, for the same.

    Returns
    -------
    StabilityMap
        Equal to the saved map, except for the measurements of the machine: ``nanoseconds`` and
        ``elapsed`` are NaN, ``threads`` and ``computed`` are 0.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        Naming the file: if it is not a stability map, is one of another format, is damaged, or
        holds counts that no computation gives. Nothing in the file is executed, and reading takes
        no more memory than a small multiple of its size. Or if a function is another one, or takes
        other values from outside: which.

    Examples
    --------
    >>> import pathlib, tempfile, rigid
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody, axes={"spin": [1.0, 2.0]}, samples=10, t_end=50.0,
    ...     stable=rigid.no_flip(), rng=2026,
    ... )
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = result.save(pathlib.Path(folder, "map.npz"))
    ...     rigid.load_map(path).spec == result.spec
    True
    """
    spec, arrays, bins = read_map(path)
    return StabilityMap.from_arrays(spec.with_functions(scene=scene, stable=stable), arrays, bins)
