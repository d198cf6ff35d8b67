"""The specification of a stability map: everything that its numbers depend on."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .._checks.arguments import brief, finite_float, of_known, one_of, positive_int
from .._checks.moments import refuse_rods
from ..model.body import Body
from ..model.criteria import check_criterion, criterion_from_dict
from ..model.criterion import Criterion, can_be_left
from ..model.function import TorqueFunction
from ..model.judged import Custom
from ..model.measures import Measure, asks_for_an_axis, check_distinct, make_measures
from ..model.mixture import Mixture, start_from_dict
from ..model.noise import Noise
from ..model.orbit import Orbit
from ..model.parameters import OF_RUN
from ..model.scene import FreeBody, Scene, scene_from_dict
from ..model.seed import checked_seed
from ..model.sourced import Sourced
from ..model.start import Start
from ..model.time_unit import ORBIT, SECONDS, Clock, TimeUnit, clock_of
from ..solve.choose_method import NO_BOUND
from ..solve.closed_form import FORCED_RULE, NO_FORM, closed_forms, question_words, rule
from ..solve.methods import (
    AUTO,
    EXACT,
    GROWTH_SECOND,
    MANY_TIMES,
    MAP_FALLBACK,
    SECOND,
    STIFF,
    TO_ROUNDING,
    check_method,
    map_methods,
    method_named,
)
from ..solve.request import MOST_STEPS
from ..solve.tangent import check_tangent
from .axes import Axis, check_applicable, make_axes
from .grid import Pixels, acting_forces, grid_shape, nominal_starts
from .own import OwnScene, own_scene
from .sequential import Looks, checked_half_width, stop_table
from .vary import Draws, Varied, check_varied, make_varied


@dataclass(frozen=True, slots=True, eq=False)
class MapPart:
    """The pixels of a map with one horizon and one limit, as a separate map.

    Attributes
    ----------
    spec : MapSpec
        The map without the axes ``t_end`` and ``limit``.
    pixels : ndarray of int64
        Numbers of its pixels in the whole map, in C order of both.
    fixed : dict of str to float
        Its values of these axes.
    """

    spec: MapSpec
    pixels: NDArray[np.int64]
    fixed: Mapping[str, float] = field(default_factory=dict)


Resolvable = TypeVar("Resolvable", Criterion, Measure)

MOST_TITLE = 1000
"""Most characters of a title, so that a file of a map has a known size."""


def _share(name: str, value: object) -> float:
    """A number in [0, 1], checked."""
    share = finite_float(name, value, nonnegative=True)
    if share > 1.0:
        raise ValueError(f"{name} = {share}: must lie in [0, 1]")
    return share


_NUMBERS: Mapping[str, Callable[[str, Any], float]] = {
    "t_end": partial(finite_float, positive=True),
    "samples": positive_int,
    "max_steps": positive_int,
    "half_width": lambda _, value: checked_half_width(value),
    "refine": partial(positive_int, minimum=2),
    "budget": positive_int,
    "step": partial(finite_float, positive=True),
    "check": _share,
    "seed": checked_seed,
}
"""The numbers of a specification, and what checks each."""


@dataclass(frozen=True, kw_only=True)
class MapSpec:
    """Everything that the numbers of a map depend on; can be written as JSON and read back.

    Attributes
    ----------
    scene : FreeBody or HeavyTop
        The constructor takes a function of the axes too, as :func:`rigid.stability_map` does.
    start : Start or Mixture
    axes : tuple of Axis
        x first, then y, and so on. The constructor takes a dict of names and values too.
    stable : NoFlip, TiltBelow or Regular
        The criterion, with no default left open.
    t_end : float
        Horizon in s; the longest one if it is an axis.
    samples : int
        Bodies per pixel.
    method : str
        ``"auto"``: the closed form for each body that has one, else ``"dop853"``, or
        ``"taylor12"`` under a criterion of the user; ``"exact"``: closed forms only; or the name
        of another method. A series is refused, but for deviation vectors and such a criterion.
    step : float or None
        Time step of the bodies that are integrated, s; None: the core picks one for each body from
        a bound of its rates.
    check : float or None
        Share of the bodies of a pixel that a second run classifies too, as a cross-check, in
        [0, 1]; None: the bodies whose class an error could change, and an audit of the others.
        Bodies with a closed form need none.
    max_steps : int
        A body that needs more steps counts as failed.
    half_width : float or None
        A pixel gets bodies until the interval of its share is no wider than twice this;
        ``samples`` is the most that it gets.
    refine : int or None
        Every so many rows and columns are computed first, and between them what differs.
    budget : int or None
        Most bodies of the map.
    seed : int
        Key of the random numbers, 0 <= seed < 2**128.
    title : str or None
        At most 1000 characters.
    time_unit : str or (str, float)
        The unit in which words and pictures show times: ``"s"``, ``"min"``, ``"h"``, ``"d"``,
        ``"a"``, ``"orbit"``, or a name and its length. All numbers stay in the map's own unit.
    own : OwnScene or None
        The function that makes the scenes of the pixels from its arguments, the axes; ``scene`` is
        then the scene of the first pixel.
    measure : tuple of Measure
        The measures of each body besides its class, with all defaults filled in.
    vary : tuple of Varied
        The parameters that each body has at random; the constructor takes a dict of names and
        distributions too.
    version : str
        Version of rigid.
    """

    scene: Scene
    start: Start | Mixture
    axes: tuple[Axis, ...]
    stable: Criterion
    t_end: float
    samples: int
    seed: int
    method: str = AUTO
    step: float | None = None
    check: float | None = None
    max_steps: int = MOST_STEPS
    half_width: float | None = None
    refine: int | None = None
    budget: int | None = None
    title: str | None = None
    time_unit: TimeUnit = SECONDS.name
    own: OwnScene | None = None
    measure: tuple[Measure, ...] = ()
    vary: tuple[Varied, ...] = ()
    version: str = field(default_factory=lambda: str(_core.build_info()["version"]))

    def __post_init__(self) -> None:
        self._take_bodies()
        check_criterion("stable", self.stable)
        if not isinstance(self.vary, tuple):
            self._put("vary", make_varied(self.vary))
        for start in self.start.starts:
            check_applicable(self.scene, start, self.axes)
            check_varied(self.scene, start, self.vary, self.axes)
        asked, measures = self.stable, make_measures(self.measure)
        self._take_question(asked, measures, self.scene)
        check_distinct(self.measure)
        self._take_numbers()
        self._check_question()
        self._check_method()
        if asks_for_an_axis(asked) or any(asks_for_an_axis(one) for one in measures):
            # The default axis follows from the bodies of all pixels.
            grid = self.grid
            rows = np.unique(grid.moments[grid.possible], axis=0)
            if len(rows):
                every = FreeBody(Body(rows, physical=grid.physical), orbit=Orbit(1.0))
                self._take_question(asked, measures, every)
        self._check_words()

    def _put(self, name: str, value: object) -> None:
        """Set a field of the specification, just made."""
        object.__setattr__(self, name, value)  # the dataclass is frozen

    def _take_bodies(self) -> None:
        """Take the scene, or what the function of the scene gives, and the axes."""
        if not isinstance(self.start, Start | Mixture):
            raise TypeError(f"start = {brief(self.start)}: must be a rigid.Start, or a mixture")
        if not isinstance(self.scene, Scene) and callable(self.scene):
            for name, made in zip(
                ("scene", "own", "axes"), own_scene(self.scene, self.axes), strict=True
            ):
                self._put(name, made)
        arguments = () if self.own is None else self.own.names
        if not isinstance(self.axes, tuple):
            self._put("axes", make_axes(self.axes, arguments))
        names = [axis.name for axis in self.axes]
        if self.own is not None:
            for start in self.start.starts:
                self.own.check_start(start, names)
        self._put("scene", self._started(self.scene))
        for name in arguments:
            if name not in names:
                raise ValueError(f"axes: the function of the scene needs an axis {name!r}")

    def _take_question(
        self, stable: Criterion, measures: tuple[Measure, ...], scene: Scene
    ) -> None:
        """Take the criterion and the measures with their defaults in a scene."""
        self._put("stable", self._resolved("stable", stable, scene))
        own = [self._resolved("measure", one, scene) for one in measures]
        self._put("measure", tuple(own))

    def _take_numbers(self) -> None:
        """Take the numbers of the request as they are checked."""
        for axis in self.axes:
            if axis.name == "t_end":
                self._put("t_end", max(axis.values))
        for name, check in _NUMBERS.items():
            value = getattr(self, name)
            if value is not None or self.__dataclass_fields__[name].default is not None:
                self._put(name, check(name, value))
        for name, count in (
            ("samples", self.samples * math.prod(self.shape)),
            ("max_steps", self.max_steps),
        ):
            if count >= 2**63:
                raise ValueError(f"{name} = {getattr(self, name)}: too many to count")
        if self.half_width is not None:
            last = stop_table(self.half_width).last
            if self.samples != last:
                raise ValueError(
                    f"samples = {self.samples}: must be {last}, which half_width = "
                    f"{self.half_width} needs"
                )

    def _check_question(self) -> None:
        """Refuse a horizon, a limit or a time of leaving that the criterion does not have."""
        stable = self.stable
        if isinstance(stable, Custom):
            self._check_times(stable)
        if any(one.name == "time_to_leave" for one in self.measure):
            if isinstance(stable, Custom):
                raise ValueError("measure: judged() has no time_to_leave; leave the measure out")
            if not can_be_left(stable.logic()):
                raise ValueError(
                    f"measure: time_to_leave has no time of '{stable}', which bodies enter and do "
                    "not leave; ask for the time of the criterion without ~"
                )
        if "limit" in self.varied and stable.limited is None and not self.is_judged:
            raise ValueError(f"axes: 'limit' does not apply: {stable} limits no angle")

    def _check_times(self, stable: Custom) -> None:
        """Refuse horizons at which a function of states at given times is not asked."""
        ends = [axis.values for axis in self.axes if axis.name == "t_end"]
        for values in ends:
            for place, value in enumerate(values):
                if value not in stable.times:
                    raise ValueError(
                        f"axes['t_end'][{place}] = {value:g}: must be a time of judged()"
                    )
        if not ends and self.t_end != stable.times[-1]:
            raise ValueError(
                f"t_end = {self.t_end:g}: must be {stable.times[-1]:g}, the last time of judged(), "
                "or left out"
            )

    def _check_method(self) -> None:
        """Refuse a method that does not serve the scene, the criterion or the measures."""
        one_of("method", self.method, map_methods())
        if self.forces:
            self.stable.check_forced(self.scene, self.forces)
            for one in self.measure:
                one.check_forced(self.scene, self.forces)
        chosen = self.step is not None or (self.is_judged and self.method == AUTO)
        if not (chosen or self.whole.bounds_rates):
            raise ValueError(NO_BOUND)
        has_deviation = self.stable.has_deviation
        check_method(
            self.method,
            self.scene.kind,
            watched=not (self.is_judged or has_deviation),
            forces=self.forces,
        )
        if has_deviation and (self.method != AUTO or self.is_called):
            check_tangent(self.method, forces=self.forces)
        if self.misses_functions:
            return
        if has_deviation:
            refuse_rods(self.grid.moments)
        if self.method == EXACT:
            self._require_closed_forms()

    def _check_words(self) -> None:
        """Check the title, the unit of times and the version."""
        if self.title is not None and not isinstance(self.title, str):
            raise TypeError(f"title = {brief(self.title)}: must be a string")
        if self.title is not None and len(self.title) > MOST_TITLE:
            raise ValueError(
                f"title of {len(self.title)} characters: must have at most {MOST_TITLE}"
            )
        clock = clock_of(self.time_unit, self.scene)
        if isinstance(self.time_unit, list | tuple):
            self._put("time_unit", (clock.name, clock.size))
        if clock.name == ORBIT and (self.own is not None or "rate" in self.varied):
            raise ValueError("time_unit = 'orbit': the orbits of this map have several periods")
        if not isinstance(self.version, str):
            raise TypeError(f"version = {brief(self.version)}: must be a string")

    def _resolved(self, name: str, asked: Resolvable, scene: Scene) -> Resolvable:
        """A criterion or a measure with the defaults of the start, equal for all of a mixture."""
        first, *others = (asked.resolved(scene, start) for start in self.start.starts)
        if any(other != first for other in others):
            raise ValueError(
                f"{name}: the starts of the mixture turn about different axes; give axis=..."
            )
        return first

    def _started(self, scene: Scene) -> Scene:
        """A scene whose function begins at the states of the start, if any are given."""
        first, *others = (start.states for start in self.start.starts)
        if any(other != first for other in others):
            raise ValueError("states: must be the same in all starts of the mixture")
        if first is not None and self.own is not None:
            raise ValueError("states: are not given to scenes that a function makes")
        return scene if first is None else scene.started(first)

    @property
    def forces(self) -> tuple[str, ...]:
        """The names of the forces that act in some pixel."""
        return acting_forces(self.whole, self.axes, self.vary)

    @property
    def is_called(self) -> bool:
        """Whether a callback gives the torque."""
        return "function" in self.forces

    @property
    def is_judged(self) -> bool:
        """Whether a criterion of the user judges the bodies, from states at given times."""
        return isinstance(self.stable, Custom)

    @property
    def whole(self) -> Scene:
        """The scene of all pixels as far as it is known, without the values of the axes."""
        return self._made[0]

    @cached_property
    def _made(self) -> tuple[Scene, Mapping[str, NDArray[np.float64]]]:
        """The scene of all pixels, and the rates and attitudes that a function gives for them."""
        if self.own is None or self.own.source.function is None:
            return self.scene, {}
        return self.own.made(self.values())

    def values(self, pixels: NDArray[np.int64] | None = None) -> dict[str, NDArray[np.float64]]:
        """The values of the axes in every pixel, or in some by their numbers."""
        every = np.arange(math.prod(self.shape)) if pixels is None else pixels
        places = np.unravel_index(every, self.shape) if self.shape else ()
        return {
            axis.name: np.array(axis.values)[place]
            for axis, place in zip(self.axes, reversed(places), strict=True)
        }

    @property
    def sources(self) -> dict[str, Sourced]:
        """The functions that the numbers depend on, by their arguments of ``with_functions``."""
        found = {} if self.own is None else {"scene": self.own.source}
        return {**found, "stable": self.stable.source} if isinstance(self.stable, Custom) else found

    @property
    def functions(self) -> dict[str, Any]:
        """The functions that are known, as :meth:`with_functions` takes them."""
        known = {name: source.function for name, source in self.sources.items()}
        found: dict[str, Any] = {name: one for name, one in known.items() if one is not None}
        if self._torque is not None and self._torque.is_known:
            found["scene"] = self.scene
        return found

    @property
    def _torque(self) -> TorqueFunction | None:
        """The function of the torque of the scene, which no file has; None if there is none."""
        torque = None if self.own is not None else self.scene.torque
        return None if torque is None else torque.function

    @property
    def left_out(self) -> dict[str, str]:
        """Names of what a file of the map leaves out, by the arguments of ``with_functions``."""
        names = {argument: source.name for argument, source in self.sources.items()}
        return names if self._torque is None else {**names, "scene": "scene"}

    @property
    def misses_functions(self) -> bool:
        """Whether the map cannot be computed until its functions are given again."""
        return len(self.functions) < len(self.left_out)

    def require_functions(self) -> None:
        """Raise ValueError if a function must be given again."""
        for name, source in self.sources.items():
            source.call(name)
        self.require_torque()

    def require_torque(self) -> None:
        """Raise ValueError if the torque of the scene is a function that is not known."""
        if self._torque is not None and not self._torque.is_known:
            raise ValueError(
                "scene: its torque is a function, which no file has; give the scene again, as "
                "scene= of load_map or open_store"
            )

    def renewed(self) -> MapSpec:
        """The specification with its functions as they are now, if they are known."""
        now = {name: one.renewed(name) for name, one in self.sources.items()}
        return self._with_sources(
            {name: one for name, one in now.items() if one != self.sources[name]}
        )

    @property
    def doubt(self) -> str:
        """Why a function may give other numbers than before, in words; empty without a reason."""
        return "; ".join(filter(None, (one.doubt(name) for name, one in self.sources.items())))

    def with_functions(
        self,
        *,
        scene: Callable[..., Any] | Scene | None = None,
        stable: Callable[..., Any] | None = None,
        carried: bool = False,
    ) -> MapSpec:
        """The specification of a file with its functions, which a file cannot hold.

        Parameters
        ----------
        scene : callable or Scene, optional
            The function that makes the scenes; or the scene, whose torque is a function.
        stable : callable, optional
            The function of a custom criterion.
        carried : bool
            The functions came from another process, where their sources were compared. They are
            compared here only if the sources are here too.

        Returns
        -------
        MapSpec

        Raises
        ------
        ValueError
            If the map has no such function, or one of another source, or one that takes other
            values from outside; or if the scene is another one.
        """
        if isinstance(scene, Scene):
            if scene.states:
                scene = self._started(scene)
            if self._torque is None or scene.to_dict() != self.scene.to_dict():
                raise ValueError(
                    "scene: differs from the scene of the map, whose torque is a function"
                )
            return dataclasses.replace(self, scene=scene).with_functions(
                stable=stable, carried=carried
            )
        known = self.sources
        if stable is not None and "stable" not in known:
            raise ValueError("stable: this map has no custom criterion")
        if scene is not None and "scene" not in known:
            raise ValueError("scene: no function makes the scenes of this map")
        given = {"stable": stable, "scene": scene}
        return self._with_sources(
            {
                name: known[name].given(name, function, carried=carried)
                for name, function in given.items()
                if function is not None
            }
        )

    def _with_sources(self, sources: Mapping[str, Sourced]) -> MapSpec:
        """The specification with other functions."""
        if not sources:
            return self
        changed: dict[str, Any] = {}
        if self.own is not None and "scene" in sources:
            changed["own"] = dataclasses.replace(self.own, source=sources["scene"])
        if isinstance(self.stable, Custom) and "stable" in sources:
            changed["stable"] = dataclasses.replace(self.stable, source=sources["stable"])
        return dataclasses.replace(self, **changed)

    @property
    def scene_words(self) -> str:
        """The scene in words."""
        if self.own is not None:
            return self.own.words(self.scene.title)
        return self.scene.words(self.varied)

    @cached_property
    def parts(self) -> tuple[MapPart, ...]:
        """The maps of one horizon and one limit that this map consists of.

        Each part draws by the numbers of its pixels: the bodies of all parts are the same.
        """
        runs = [axis for axis in self.axes if axis.parameter.place == OF_RUN]
        if not runs:
            return (MapPart(self, np.arange(math.prod(self.shape))),)
        others = tuple(axis for axis in self.axes if axis not in runs)
        values, parts = self.values(), []
        for ends in itertools.product(*(axis.values for axis in runs)):
            fixed = {axis.name: end for axis, end in zip(runs, ends, strict=True)}
            mine = np.logical_and.reduce([values[name] == end for name, end in fixed.items()])
            changes: dict[str, Any] = {"axes": others, "t_end": fixed.get("t_end", self.t_end)}
            if isinstance(self.stable, Custom):
                changes["stable"] = self.stable.until_time(changes["t_end"])
            elif "limit" in fixed and self.stable.limited is not None:
                limited: Any = {self.stable.limited: fixed["limit"]}
                changes["stable"] = dataclasses.replace(self.stable, **limited)  # type: ignore[type-var]
            parts.append(MapPart(self.replace(**changes), np.flatnonzero(mine), fixed))
        return tuple(parts)

    def by_part(
        self, pixels: NDArray[np.int64]
    ) -> Iterator[tuple[MapPart, NDArray[np.intp], NDArray[np.int64]]]:
        """Pixels by their numbers: each part, the places of its pixels, and their numbers there."""
        if len(self.parts) == 1:
            yield self.parts[0], np.arange(len(pixels)), pixels
            return
        for part in self.parts:
            mine = np.flatnonzero(np.isin(pixels, part.pixels))
            if len(mine):
                yield part, mine, np.searchsorted(part.pixels, pixels[mine])

    @property
    def horizons(self) -> NDArray[np.float64]:
        """The horizon of every pixel, s; grid shape."""
        ends = np.empty(math.prod(self.shape))
        for part in self.parts:
            ends[part.pixels] = part.spec.t_end
        return ends.reshape(self.shape)

    @cached_property
    def grid(self) -> Pixels:
        """The nominal start of every pixel, computed once; for a mixture its first start."""
        return self._nominal(self.start.starts[0])

    def bodies(
        self,
        start: Start,
        pixels: NDArray[np.int64] | None = None,
        samples: NDArray[np.int64] | None = None,
    ) -> Pixels:
        """The nominal start of every pixel, or of some, by one of the starts of a mixture.

        With the numbers of the samples the bodies have the parameters that vary.
        """
        if self.vary and pixels is not None and samples is not None:
            draws = Draws(self.vary, self.seed, pixels.astype(np.uint64), samples.astype(np.uint64))
            return self._nominal(start, pixels, draws)
        if start is self.start.starts[0] and (pixels is None or "grid" in self.__dict__):
            return self.grid if pixels is None else self.grid.of_pixels(pixels)
        # Not the starts of other pixels, of which there may be millions.
        return self._nominal(start, pixels)

    def _nominal(
        self,
        start: Start,
        pixels: NDArray[np.int64] | None = None,
        draws: Draws | None = None,
    ) -> Pixels:
        if self.own is not None:
            self.own.source.call("scene")  # which must be given again, if it is not known
        scene, given = self._made
        return nominal_starts(scene, start, self.axes, pixels, given, draws)

    def __getstate__(self) -> dict[str, Any]:
        """The fields without the values that follow from them."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays: ``(..., ny, nx)``, the first axis last."""
        return grid_shape(self.axes)

    @property
    def varied(self) -> tuple[str, ...]:
        """The numbers of scene and start that axes set or that vary; a ratio sets its numerator."""
        every: tuple[Axis | Varied, ...] = (*self.axes, *self.vary)
        return tuple(name for one in every for name in one.parameter.sets(one.name))

    def checked_before(self, count: int, first: NDArray[np.int64]) -> int | None:
        """Bodies of a pixel with a smaller number are classified by the second method, too.

        None if it depends on the margins of the bodies. Of a sequential map it is a share of the
        samples of one look.
        """
        if self.check is None:
            return None
        # 0.07 * 100 is a little more than 7.
        if self.looks is None:
            return math.ceil(self.check * self.samples * (1.0 - 1e-12))
        return int(first.max(initial=0)) + math.ceil(self.check * count * (1.0 - 1e-12))

    @property
    def looks(self) -> Looks | None:
        """The rule that stops the pixels of a sequential map; None if ``samples`` is given."""
        return None if self.half_width is None else stop_table(self.half_width)

    @property
    def clock(self) -> Clock:
        """How words and pictures show times."""
        return clock_of(self.time_unit, self.scene)

    @property
    def horizon(self) -> str:
        """The horizon in words."""
        return f"t = {self.clock.time(self.t_end)}"

    @property
    def criterion(self) -> str:
        """Criterion and horizon in words."""
        words = self.stable.until(self.t_end, self.clock)
        varied = [name for name in ("limit", "t_end") if name in self.varied]
        return f"{words}, {' and '.join(varied)} varied" if varied else words

    @property
    def scheme(self) -> str:
        """The method of the bodies without a closed form."""
        if self.method not in (AUTO, EXACT):
            return self.method
        return MANY_TIMES if self.is_judged and not self.is_called else MAP_FALLBACK

    @property
    def second(self) -> str:
        """The method that classifies these bodies again; for a callback the same in other steps."""
        if self.stable.has_deviation:
            return GROWTH_SECOND
        if self.is_called:
            return self.scheme
        if self.is_judged:
            return TO_ROUNDING
        return STIFF if self.forces and method_named(self.scheme).stiff else SECOND

    def _require_closed_forms(self) -> None:
        """Raise ValueError for the first possible body without a closed form."""
        if self.forces:
            raise ValueError(f"method = {EXACT!r}: {FORCED_RULE}")
        for one in self.measure:
            if one.runs:
                raise ValueError(f"method = {EXACT!r}: {one} is measured along steps")
        moments, weight = self.grid.moments, self.grid.weight
        missing = self.grid.possible & (closed_forms(self.stable, moments, weight) == NO_FORM)
        if missing.any():
            flat = int(np.argmax(missing))
            pixel = tuple(int(i) for i in np.unravel_index(flat, self.shape))
            which = f" of pixel {pixel}" if pixel else ""
            values = ", ".join(f"{moment:g}" for moment in moments[flat])
            raise ValueError(
                f"method = {EXACT!r}: no closed form of {question_words(self.stable)} for the "
                f"body{which}, moments ({values}); {rule(self.stable)}"
            )

    def replace(self, **changes: Any) -> MapSpec:
        """The specification with changed fields; :func:`rigid.stability_map` runs it.

        Parameters
        ----------
        **changes
            Fields by their names; ``axes`` may be a dict of names and values.

        Returns
        -------
        MapSpec
            Of this version of rigid, which would compute it.

        Raises
        ------
        TypeError
            For an unknown field.
        ValueError
            As :func:`rigid.stability_map`.

        Examples
        --------
        >>> import rigid
        >>> spec = rigid.MapSpec(
        ...     scene=rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), start=rigid.Start(spin=1.0),
        ...     axes={"spin": [1.0, 2.0]}, stable=rigid.no_flip(), t_end=50.0, samples=4, seed=1,
        ... )
        >>> rigid.stability_map(spec.replace(samples=10)).samples
        array([10, 10])
        """
        known = [name for name in self.__dataclass_fields__ if name != "version"]
        for name in changes:
            if name not in known:
                raise TypeError(f"{name}: is no field of a specification{of_known(name, known)}")
        kept = {name: getattr(self, name) for name in known}
        return MapSpec(**{**kept, **changes})

    def to_dict(self) -> dict[str, Any]:
        """The specification as a JSON-able dictionary; :meth:`from_dict` reads it.

        Returns
        -------
        dict
        """
        measured = {"measure": [one.to_dict() for one in self.measure]} if self.measure else {}
        vary = {one.name: one.noise.to_dict() for one in self.vary}
        unit = self.time_unit if isinstance(self.time_unit, str) else list(self.time_unit)
        return {
            **measured,
            **({"vary": vary} if vary else {}),
            "scene": self.scene.to_dict(),
            "start": self.start.to_dict(),
            "axes": [{"name": axis.name, "values": list(axis.values)} for axis in self.axes],
            "stable": self.stable.to_dict(),
            "t_end": self.t_end,
            "samples": self.samples,
            "method": self.method,
            "step": self.step,
            "check": self.check,
            "max_steps": self.max_steps,
            # Maps without these have the bytes that they had before there were any.
            **{
                name: getattr(self, name)
                for name in ("half_width", "refine", "budget")
                if getattr(self, name) is not None
            },
            "seed": self.seed,
            "title": self.title,
            **({} if self.time_unit == SECONDS.name else {"time_unit": unit}),
            **({} if self.own is None else {"own": self.own.to_dict()}),
            "version": self.version,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> MapSpec:
        """The specification that :meth:`to_dict` described.

        Parameters
        ----------
        data : dict
            The dictionary.

        Returns
        -------
        MapSpec
        """
        values = dict(data)
        values["scene"] = scene_from_dict(values["scene"])
        values["start"] = start_from_dict(values["start"])
        if values.get("own") is not None:
            values["own"] = OwnScene.from_dict(values["own"])
        names = values["own"].names if values.get("own") else ()
        axes = {axis["name"]: axis["values"] for axis in values["axes"]}
        values["axes"] = make_axes(axes, names)
        values["stable"] = criterion_from_dict(values["stable"])
        values["measure"] = tuple(Measure(**one) for one in values.get("measure", ()))
        vary = values.get("vary", {})
        values["vary"] = make_varied({name: Noise(**one) for name, one in vary.items()})
        return cls(**values)

    def to_json(self) -> str:
        """The specification as JSON text; floats keep all their digits.

        Returns
        -------
        str
        """
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> MapSpec:
        """The specification that :meth:`to_json` wrote.

        Parameters
        ----------
        text : str
            The JSON text.

        Returns
        -------
        MapSpec

        Examples
        --------
        >>> import rigid
        >>> spec = rigid.MapSpec(
        ...     scene=rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))), start=rigid.Start(spin=1.0),
        ...     axes={"spin": [1.0, 2.0]}, stable=rigid.no_flip(), t_end=50.0, samples=100, seed=0,
        ... )
        >>> rigid.MapSpec.from_json(spec.to_json()) == spec
        True
        """
        return cls.from_dict(json.loads(text))
