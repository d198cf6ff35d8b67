"""Monte Carlo stability maps: the call."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief
from .._checks.progress import ProgressOption
from ..maps.request import as_it_is, spec_of
from ..maps.result import StabilityMap
from ..maps.spec import MapSpec
from ..model.body import Body
from ..model.criteria import Criterion
from ..model.measures import Measure, make_measures
from ..model.mixture import Mixture
from ..model.scene import Scene
from ..model.start import Start

__all__ = ["run_map", "stability_map"]


def stability_map(
    scene: Scene | Body | type[Scene] | Callable[..., Scene] | MapSpec,
    *,
    axes: Mapping[str, ArrayLike] | None = None,
    samples: int | None = None,
    t_end: float | None = None,
    stable: Criterion | None = None,
    start: Start | Mixture | None = None,
    method: str | None = None,
    step: float | None = None,
    check: float | None = None,
    rng: int | np.random.Generator | np.random.SeedSequence | None = None,
    threads: int | None = None,
    progress: ProgressOption = None,
    max_steps: int | None = None,
    title: str | None = None,
    measure: Measure | Iterable[Measure] | None = None,
    partial: bool = False,
    store: str | os.PathLike[str] | None = None,
    executor: Any = None,
    threads_per_task: int = 1,
    part: str | tuple[int, int] | None = None,
    half_width: float | None = None,
    refine: int | None = None,
    budget: int | None = None,
) -> StabilityMap:
    """Monte Carlo stability map: an ensemble of perturbed bodies in every pixel of a grid.

    Nothing is kept per body: memory grows with the pixels, not with the samples or the horizon. The
    same request gives the same bits for any number of threads. A coarse lattice of pixels comes
    first. Ctrl-C ends the run within a fraction of a second and raises :class:`Interrupted`, a
    ``KeyboardInterrupt`` with the map of the pieces done, of 64 bodies or more. A second Ctrl-C
    ends the run at once.

    Parameters
    ----------
    scene : FreeBody, HeavyTop, Body, one of the first two classes, callable, or MapSpec
        A class means its example: ``FreeBody(Body((1.0, 1.5, 2.0)))`` or
        ``HeavyTop(Body((1.0, 1.0, 0.5)), mgl=1.0)``. A function makes the scene from its own
        parameters: its arguments are axes of the map, arrays with a number for each pixel, and it
        returns a scene of as many bodies, or a tuple of the scene, the rates of the starts, shape
        (n, 3), and perhaps their attitudes, (n, 4). A specification, such as ``result.spec`` of an
        older map, says everything but ``threads``, ``progress`` and ``partial``;
        :meth:`MapSpec.replace` changes it.
    axes : dict of str to array_like, shape (n,)
        Parameters and their values, increasing or decreasing; x first, then y, and so on. The
        values replace those of the scene and the start. Names: ``I1``, ``I2``, ``I3``; ratios such
        as ``I2/I1`` (which sets ``I2``); sides ``a``, ``b``, ``c`` and ``mass`` of a box; ``mgl``
        of a top, ``com1``, ``com2``, ``com3``: components towards its centre of mass, of which the
        direction counts, or ``com_tilt``, ``com_turn``: angle of the centre of mass from axis 3,
        and its azimuth; ``a/b``, ``b/c``: ratios of the semi-axes of an ellipsoid; ``energy``,
        ``l_gamma`` of the start without noise; ``spin``,
        ``tilt``, ``omega1``, ``omega2``, ``omega3``; ``noise``,
        ``attitude_noise``: the size of the perturbation that the start names, or of one component:
        ``noise1``, ``noise2``, ``noise3``, ``attitude_noise1``, ``attitude_noise2``,
        ``attitude_noise3``; ``damping1``, ``damping2``, ``damping3`` (N m s): damping of the rates
        about the axes; ``kappa``, ``attitude_kappa``: concentration of the directions of
        :func:`von_mises_fisher`; ``torque1``, ``torque2``, ``torque3`` (N m): constant torque about
        them; ``rotor1``, ``rotor2``, ``rotor3`` and ``dissipation``; ``eccentricity``, ``anomaly``
        of the orbit; ``limit``: the angle of the criterion; ``t_end``: the horizon. All horizons
        and limits see the same bodies, each by a run of its own.
    samples : int
        Bodies per pixel; or give ``half_width``. One of them is required, as ``axes``, ``t_end``
        and ``stable`` are, unless ``scene`` is a specification.
    t_end : float
        Horizon in s: *stable* means stable until then. By default that of :func:`judged`.
    stable : Criterion
        The criterion: :func:`no_flip`, :func:`tilt_below`, :func:`tilt_between`,
        :func:`rate_within`, :func:`near_start`, :func:`returns`, :func:`spin_above`,
        :func:`pointing_within`, :func:`librates`, joined by ``&``, ``|`` and ``~`` or alone, or
        :func:`regular`; or :func:`judged` by a function.
    start : Start or Mixture, optional
        By default a free body spins at 1 rad/s about the axis of its middle moment with
        ``noise=normal(1e-3)``, and a top at 5 rad/s about axis 3 with
        ``attitude_noise=normal(1e-3)``.
    method : str, optional
        ``"auto"``, the default: each body by closed form where it has one for this criterion, else
        ``"taylor12"`` in long steps, with an error of about 1e-8 rad for each radian turned, or
        with :func:`regular` ``"dop853"`` in steps of 1.25 rad.
        ``"exact"``: closed forms only. Or one of :func:`rigid.methods`.
    step : float, optional
        Time step of the bodies that are integrated, s; by default chosen for each body from a bound
        of its rates.
    check : float, optional
        Share of the bodies of a pixel to classify a second time as a cross-check, in [0, 1].
        ``taylor16`` does it in steps of its own, at most half of ``step``; with
        ``method="taylor16"`` the steps are halved. If the two classifications differ, the body is
        undecided. Bodies with a closed form are not cross-checked.

        By default, if a tilt is limited: of each 64 consecutive bodies of a pixel the first two and
        the one that ran longest, the audit. What the two methods differ by there is the error of
        these bodies (rad). Of the others, those are classified again whose tilt, or whose turn
        between leaving and the horizon, is within 30 times the root of this error of another class,
        or within 0.01 rad.
        A flip does not tell by how much it was missed: with ``no_flip`` the default is all bodies,
        and so it is with ``regular``, whose second run has another deviation vector too. That is by
        ``dop853`` in steps of its own, of 1 rad and less, the less the longer the horizon, and at
        most half of ``step``.
    rng : int, numpy.random.Generator or SeedSequence, optional
        The seed, or a source of its 128 bits; by default fresh entropy. ``result.spec.seed``
        stores the seed.
    threads : int, optional
        By default ``RIGID_NUM_THREADS``, else the processors this process may use.
    progress : None, bool or callable
        ``None``: a tqdm bar if tqdm is installed, in a terminal or a notebook; ``False``: silence;
        a callable gets a :class:`Progress` about three times a second.
    max_steps : int, optional
        A body that needs more steps counts as failed; by default 1e9.
    title : str, optional
        For plots and files.
    measure : Measure or sequence of Measure, optional
        Numbers to collect of each body besides its class: :func:`time_to_leave`, :func:`flips`,
        :func:`largest_tilt`, :func:`mean_rate`, :func:`drift`, :func:`libration_amplitude`,
        :func:`obliquity`, :func:`spin_orbit_ratio`. ``result.measures`` has them.
    partial : bool
        Return the map of what is done after Ctrl-C, instead of raising :class:`Interrupted`:
        the program goes on. ``result.ended`` tells whether all was done.
    store : path-like, optional
        Folder of a running map, made if there is none. What was computed is there at once, whatever
        ends the program, and the same call goes on where the rows end. Without ``rng`` the seed of
        the folder is kept. See :func:`rigid.open_store`.
    executor : optional
        Where blocks of pixels are computed: any executor of ``concurrent.futures``, or a client of
        Dask. By default threads of this process. The numbers do not depend on it.
    threads_per_task : int
        Threads of each block on an executor.
    part : str or tuple of int, optional
        ``"k/n"`` or ``(k, n)``: only part k of n of the work, with ``store``, for jobs that run
        side by side. Pixels are dealt one by one, and a few of many bodies in pieces. Together the
        parts are the map.
    half_width : float, optional
        Instead of ``samples``: a pixel gets 64, 128, ... bodies until the interval of its share is
        no wider than twice this, in [0.002, 0.25]. The interval is the Clopper-Pearson interval of
        confidence 0.97, in which undecided and failed bodies may be either. Looking after each 64
        bodies costs the difference: whatever the true share, the chance that it lies in the
        reported interval is 0.95 or more.
    refine : int, optional
        Leave out pixels that tell nothing new: first every so many rows and columns are computed,
        and then, where the intervals of the corners of a cell do not meet, what is between. The
        pixels that are computed have the bits of the full map. A feature between the first rows and
        columns that touches none of them is not seen.
    budget : int, optional
        Most bodies. What tells most is computed first, as long as the most bodies that the next
        pixel may need fit. ``result.cut`` tells how many pixels are omitted then, and
        ``result.complete`` is False.

    Returns
    -------
    StabilityMap

    Raises
    ------
    Interrupted
        After Ctrl-C, unless ``partial`` is set.
    OSError
        If rows cannot be stored; those before are kept.
    RuntimeError
        If the workers of an executor die. A Dask cluster goes on with other workers, and raises
        ``rigid.store.store.PoisonedError`` at the end if some blocks always killed theirs.
    TypeError
        If a required argument is missing, or one contradicts a specification.
    ValueError
        For an unknown name (the nearest is suggested), a name without meaning for this scene and
        start, a value out of range, or ``"exact"`` where a body has no closed form. Impossible
        bodies inside the grid are no error: they get a ``status``.

    Examples
    --------
    >>> import numpy as np, rigid
    >>> result = rigid.stability_map(
    ...     rigid.FreeBody,
    ...     axes={"I2/I1": np.linspace(1.1, 1.9, 5), "noise": np.geomspace(1e-3, 0.1, 3)},
    ...     samples=64, t_end=100.0, stable=rigid.no_flip(), rng=2026,
    ... )
    >>> result.share.shape, result.complete
    ((3, 5), True)
    >>> result.replay(pixel=(2, 3), sample=0).outcome
    'unstable'
    >>> result.plot().get_ylabel()
    'perturbation of the rates (rad/s)'
    """
    asked = {
        "axes": axes,
        "samples": samples,
        "t_end": t_end,
        "stable": stable,
        "start": start,
        "method": method,
        "step": step,
        "check": check,
        "rng": rng,
        "max_steps": max_steps,
        "half_width": half_width,
        "refine": refine,
        "budget": budget,
        "title": title,
        "measure": None if measure is None else make_measures(measure),
    }
    given = {name: value for name, value in asked.items() if value is not None}
    spec = as_it_is(scene, given) if isinstance(scene, MapSpec) else spec_of(scene, given)
    spec = spec.renewed()  # what a function takes may have changed since it was told
    if part is not None and store is None:
        raise ValueError(f"part = {brief(part)}: needs store=..., the folder of all parts")
    return run_map(
        spec,
        store=store,
        seeded=rng is not None or isinstance(scene, MapSpec),
        executor=executor,
        threads=threads,
        threads_per_task=threads_per_task,
        part=part,
        progress=progress,
        partial=partial,
    )


def run_map(spec: MapSpec, **options: Any) -> StabilityMap:
    """Compute the map of a specification; see :func:`rigid.store.store.run_map`."""
    from .store import run_map  # what stores takes long to import

    return run_map(spec, **options)
