"""The call of a stability map by Monte Carlo sampling."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .._checks.arguments import brief
from .._checks.progress import ProgressOption
from ..maps.axes import check_axis_name
from ..maps.own import own_scene
from ..maps.sequential import checked_half_width, stop_table
from ..maps.spec import MapSpec
from ..model.body import Body
from ..model.criterion import Criterion
from ..model.judged import Custom
from ..model.measures import Measure
from ..model.mixture import Mixture
from ..model.noise import Noise
from ..model.scene import Scene, check_scene
from ..model.seed import seed_from
from ..model.start import Start
from ..model.time_unit import TimeUnit
from .result import StabilityMap

ASKED = {*MapSpec.__dataclass_fields__, "rng"} - {"scene", "own", "seed", "version"}
"""The arguments that a specification has for itself."""


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
    time_unit: TimeUnit | None = None,
    measure: Measure | Iterable[Measure] | None = None,
    vary: Mapping[str, Noise] | None = None,
    partial: bool = False,
    store: str | os.PathLike[str] | None = None,
    executor: Any = None,
    threads_per_task: int = 1,
    part: str | tuple[int, int] | None = None,
    half_width: float | None = None,
    refine: int | None = None,
    budget: int | None = None,
) -> StabilityMap:
    """Compute a stability map by Monte Carlo: the share of stable bodies in each pixel of a grid.

    Memory grows with the pixels, not with the samples or the horizon. The same request gives the
    same bits for any number of threads. A coarse lattice of pixels is computed first. Ctrl-C ends
    the run within a fraction of a second and raises :class:`Interrupted`, a ``KeyboardInterrupt``
    with the map of the finished pieces, of 64 bodies or more. A second Ctrl-C ends the run at once.

    Parameters
    ----------
    scene : FreeBody, HeavyTop, Body, one of the first two classes, callable, or MapSpec
        The bodies and the forces on them.

        * A class means its example: ``FreeBody(Body((1.0, 1.5, 2.0)))`` or
          ``HeavyTop(Body((1.0, 1.0, 0.5)), mgl=1.0)``.
        * A function makes the scene. Its arguments are axes of the map: arrays with a number for
          each pixel. The function returns a scene of as many bodies, or a tuple of the scene, the
          rates of the starts, shape (n, 3), and perhaps their attitudes, shape (n, 4).
        * A specification, such as ``result.spec`` of an older map, holds all arguments but
          ``threads``, ``progress`` and ``partial``; :meth:`MapSpec.replace` changes it.
    axes : dict of str to array_like, shape (n,)
        Names of parameters and their values, increasing or decreasing; x first, then y, and so on.
        The values replace the values of the scene and the start. All horizons and limits see the
        same bodies, each in a separate run. Names:

        * Body: ``I1``, ``I2``, ``I3`` (kg m²); ratios such as ``I2/I1``, which sets ``I2``; sides
          ``a``, ``b``, ``c`` (m) and ``mass`` (kg) of a box; ratios ``a/b``, ``b/c`` of the
          semi-axes of an ellipsoid.
        * Top: ``mgl`` (J); the direction to the centre of mass by its components ``com1``,
          ``com2``, ``com3``, or by its angle ``com_tilt`` from axis 3 and its azimuth ``com_turn``.
        * Start: ``omega1``, ``omega2``, ``omega3``, ``spin`` (rad/s), ``tilt`` (rad); ``energy``
          and ``l_gamma`` without noise.
        * Perturbation: ``noise`` and ``attitude_noise``, the sizes of the given distributions; of
          one component ``noise1``, ``noise2``, ``noise3``, ``attitude_noise1``,
          ``attitude_noise2``, ``attitude_noise3``; ``kappa`` and ``attitude_kappa``, the
          concentrations of :func:`von_mises_fisher`.
        * Forces: ``damping`` (N m s) of the rates about all axes, or ``damping1``, ``damping2``,
          ``damping3``; ``torque1``, ``torque2``, ``torque3`` (N m), constant in the body;
          ``rotor1``, ``rotor2``, ``rotor3``; ``dissipation``, or ``dissipation1``,
          ``dissipation2``, ``dissipation3``; ``drag``, or ``drag1``, ``drag2``, ``drag3``;
          ``rate``, ``eccentricity`` and ``anomaly`` of the orbit.
        * Criterion: ``limit``, its angle (rad), and ``t_end``, the horizon (s).
    samples : int
        Bodies per pixel. Give this number or ``half_width``. A map needs it, ``axes``, ``t_end``
        and ``stable``, unless ``scene`` is a specification.
    t_end : float
        Horizon in s: *stable* means stable until then. By default the last time of :func:`judged`.
    stable : Criterion
        The criterion, such as :func:`no_flip`, :func:`tilt_below`, :func:`near_start` or
        :func:`pointing_within`, alone or joined by ``&``, ``|`` and ``~``; :func:`regular`; or a
        custom criterion by :func:`judged`. The guide of maps has a table of all.
    start : Start or Mixture, optional
        Nominal start and perturbations. By default a free body spins at 1 rad/s about the axis of
        its middle moment with ``noise=normal(1e-3)``, and a top at 5 rad/s about axis 3 with
        ``attitude_noise=normal(1e-3)``.
    method : str, optional
        ``"auto"``, the default, uses the closed form of each body if there is one for this
        criterion, else ``"dop853"`` in long steps. The error of these steps is seldom above 1e-8
        rad for each radian turned. A map with :func:`regular` uses ``"dop853"`` in steps of 1.25
        rad. On an orbit alone the steps are equal ones of the eccentric anomaly. A custom criterion
        is judged in the adaptive steps of ``"taylor12"``. ``"exact"`` uses closed forms only. Other
        names: :func:`rigid.methods`; a series is for these two criteria only, because a map does
        not look inside its steps.
    step : float, optional
        Time step of the integrated bodies (s); by default chosen for each body from a bound of its
        rates. On an orbit alone ``rk4`` and ``dop853`` take steps of the eccentric anomaly: this
        time times the mean motion.
    check : float, optional
        Share of the bodies of a pixel to classify a second time as a cross-check, in [0, 1].
        ``dop853`` does it with 0.8 of the steps of the first run. If you give a method, it does so
        in its default steps of maps, at most half of ``step``; with ``method="dop853"`` the steps
        are halved. A custom criterion is judged again by ``taylor16``. If the two classifications
        differ, the body is undecided. Bodies with a closed form are not cross-checked.

        If a tilt is limited, the default is an audit: of each 64 consecutive bodies of a pixel the
        first two and the one that ran longest. The difference between the two methods there is the
        error of these bodies (rad). Other bodies are classified again if their margin is small: the
        tilt, or the turn between leaving and the horizon, is
        within 30 times the root of this error of another class, or within 0.01 rad.

        A flip has no margin, so the default with ``no_flip`` is all bodies. With ``regular`` it is
        all bodies too: a second run has another deviation vector. It is made by ``dop853`` in steps
        of at most 1 rad, shorter for longer horizons, and of at most half of ``step``.
    rng : int, numpy.random.Generator or SeedSequence, optional
        The seed, or a source of its 128 bits; by default fresh entropy. ``result.spec.seed``
        stores the seed.
    threads : int, optional
        By default ``RIGID_NUM_THREADS``, else the processors that this process may use.
    progress : None, bool or callable
        ``None`` shows a tqdm bar in a terminal or a notebook if tqdm is installed, else a line on
        standard error every 10 s; ``False`` shows nothing; a callable gets a :class:`Progress`
        about three times a second.
    max_steps : int, optional
        A body that needs more steps counts as failed; by default 1e9.
    title : str, optional
        Title for plots and files.
    time_unit : str or (str, float), optional
        The unit in which words and pictures show times and rates of growth. ``"s"``, the default,
        shows them as they are. ``"min"``, ``"h"``, ``"d"`` and ``"a"`` (365.25 d) are for numbers
        in seconds. ``"orbit"`` is the period of the orbit of the scene; if its ``rate`` is 1, spins
        are labelled as multiples of the mean motion. ``("sol", 88775.2)`` is a name and its length.
        Arguments and results stay in the map's own unit, whatever this says.
    measure : Measure or sequence of Measure, optional
        Numbers to collect of each body besides its class: :func:`time_to_leave`, :func:`flips`,
        :func:`largest_tilt`, :func:`mean_rate`, :func:`drift`, :func:`libration_amplitude`,
        :func:`largest_roll`, :func:`largest_pitch`, :func:`largest_yaw`, :func:`time_to_settle`,
        :func:`obliquity`, :func:`spin_orbit_ratio`. The result holds them as ``result.measures``.
        Checked bodies are measured by both runs, whose difference is the error.
    vary : dict of str to Noise, optional
        Parameters that each body has at random, as ``{"I1": normal(0.05, relative=True)}``: names
        of body and forces as in ``axes``, with deviations from the value that the pixel has, by
        :func:`normal` or :func:`uniform`. A draw that no body can have is repeated;
        :meth:`StabilityMap.starts` has the values, and how often each body was drawn.
    partial : bool
        After Ctrl-C return the map of the finished pieces instead of raising :class:`Interrupted`;
        the program goes on. ``result.ended`` says whether the map is finished.
    store : path-like, optional
        Folder of a running map, made if there is none. Finished rows are stored at once, whatever
        ends the program; the same call goes on where the rows end. Without ``rng`` the seed of
        the folder is kept. See :func:`rigid.open_store`.
    executor : optional
        Where blocks of pixels are computed: any executor of ``concurrent.futures``, or a client of
        Dask. By default threads of this process. The numbers do not depend on the executor.
    threads_per_task : int
        Threads of each block on an executor.
    part : str or tuple of int, optional
        ``"k/n"`` or ``(k, n)``: compute only part k of n of the work, with ``store``, for jobs that
        run side by side. Pixels are dealt one by one, and a few pixels of many bodies in pieces.
        Together the parts are the map.
    half_width : float, optional
        Half width of intervals, in [0.002, 0.25], instead of ``samples``. A pixel gets 64, 128, ...
        bodies until the interval of its share is no wider than twice this.
        The interval is the Clopper-Pearson interval of
        confidence 0.97, in which undecided and failed bodies may be either. Looking after each 64
        bodies costs the difference: whatever the true share, the chance that it lies in the
        reported interval is 0.95 or more.
    refine : int, optional
        Of a map of one or two axes: distance of the rows and columns that are computed first;
        pixels without new information are then omitted. Where the intervals at the corners of a
        cell do not overlap, the pixels between are computed. Computed pixels have the bits of the
        full map. A feature that touches none of the first rows and columns is missed.
    budget : int, optional
        Most bodies of the map. The pixels with the most information come first, as long as the
        bodies that the next pixel may need fit. ``result.cut`` is then the number of omitted
        pixels, and ``result.complete`` is False.

    Returns
    -------
    StabilityMap

    Raises
    ------
    Interrupted
        After Ctrl-C, unless ``partial`` is set.
    OSError
        If rows cannot be stored; earlier rows are kept.
    RuntimeError
        If the workers of an executor die. A Dask cluster goes on with other workers, and raises
        ``rigid.store.store.PoisonedError`` at the end if a unit of work failed three times.
    TypeError
        If a required argument is missing, or an argument contradicts a specification.
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
    given = {name: value for name, value in locals().items() if name in ASKED and value is not None}
    spec = _as_it_is(scene, given) if isinstance(scene, MapSpec) else _spec_of(scene, given)
    spec = spec.renewed()  # values that a function takes may have changed since it was given
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


def _as_it_is(spec: MapSpec, given: Mapping[str, Any]) -> MapSpec:
    """A specification that this version of rigid runs again."""
    if given:
        name, value = next(iter(given.items()))
        field = "seed" if name == "rng" else name
        raise TypeError(
            f"{name} = {brief(value)}: the specification has its own; change it by "
            f"spec.replace({field}=...)"
        )
    return spec.replace()


def _spec_of(
    scene: Scene | Body | type[Scene] | Callable[..., Scene], given: dict[str, Any]
) -> MapSpec:
    """The specification of a new map, from the arguments that were given."""
    is_scene = isinstance(scene, type | Scene | Body)
    if isinstance(given.get("axes"), Mapping):
        for name in given["axes"] if is_scene else ():
            check_axis_name(name)  # before what is missing, which would hide a wrong name
        if "t_end" in given["axes"]:
            given.setdefault("t_end", 1.0)  # the longest one is taken from the values
    if isinstance(given.get("stable"), Custom):
        given.setdefault("t_end", given["stable"].times[-1])
    missing = [name for name in ("axes", "t_end", "stable") if name not in given]
    if missing:
        raise TypeError(f"stability_map() needs {' and '.join(missing)}")
    if ("samples" in given) == ("half_width" in given):
        raise TypeError("samples, half_width: give one of the two")
    if "samples" not in given:
        given["samples"] = stop_table(checked_half_width(given["half_width"])).last
    if not is_scene and callable(scene):
        known, own, given["axes"] = own_scene(scene, given["axes"])
        given |= {"own": own, "start": given.get("start") or own.default_start(known)}
    elif isinstance(scene, type) and issubclass(scene, Scene):
        known = scene.example()
    else:
        known = check_scene(scene)
    given.setdefault("start", known.default_start())
    return MapSpec(scene=known, seed=seed_from(given.pop("rng", None)), **given)
