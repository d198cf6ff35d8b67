"""Types of the compiled core. Arrays in, arrays out; checked against the binary by stubtest."""

from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from .maps.core_request import CoreRequest
from .model.bodies import Bodies
from .solve.request import Request

__all__ = [
    "BODIES_OF_A_FUNCTION",
    "BODIES_OF_A_ROW",
    "CHECKPOINT_PARTS",
    "CROSSING_TOLERANCE",
    "DRIFT_LIMIT",
    "ELSEWHERE",
    "FEWEST_STEPS",
    "FIXED_POINT",
    "LEAST_UNDER_FUNCTION",
    "MOST_STATES",
    "ROUNDING",
    "SERIES_TOLERANCE",
    "Forces",
    "MapJob",
    "MapStatistics",
    "Motion",
    "States",
    "__version__",
    "agreed_classes",
    "available_threads",
    "build_info",
    "check_method",
    "check_moments",
    "chosen_methods",
    "class_names",
    "clopper_pearson",
    "closed_form_names",
    "closed_forms",
    "closed_forms_for",
    "deviates",
    "deviation_starts",
    "distances",
    "elliptic",
    "errors_of_closed_forms",
    "fastest_rates",
    "first_not_finite",
    "first_slow",
    "first_tolerance",
    "flip_times",
    "free_quantities",
    "further_forces",
    "generic_deviations",
    "growth",
    "in_standard_floats",
    "is_set",
    "lagrange_axes",
    "listen",
    "map_columns",
    "methods",
    "moment_status",
    "moment_status_names",
    "nearest_possible",
    "orbit_anomalies",
    "plain_numbers",
    "planned_steps",
    "principal_axes",
    "rate_units",
    "saddles",
    "section",
    "simulate",
    "solve",
    "spline",
    "state_bytes",
    "status_names",
    "tilt_times",
    "top_quantities",
    "unit_quaternions",
    "unknown_outcomes",
    "verdicts",
]

BODIES_OF_A_FUNCTION: int
BODIES_OF_A_ROW: int
CHECKPOINT_PARTS: Sequence[int]
CROSSING_TOLERANCE: float
DRIFT_LIMIT: float
ELSEWHERE: float
FEWEST_STEPS: float
FIXED_POINT: float
LEAST_UNDER_FUNCTION: float
MOST_STATES: int
ROUNDING: float
SERIES_TOLERANCE: float
__version__: str

def available_threads() -> int: ...
def is_set(variable: str) -> bool: ...
def build_info() -> dict[str, Any]: ...
def methods() -> list[dict[str, Any]]: ...
def chosen_methods() -> dict[str, str]: ...
def map_columns() -> list[dict[str, Any]]: ...
def class_names() -> list[str]: ...
def agreed_classes() -> list[list[int]]: ...
def unknown_outcomes(count: int) -> dict[str, NDArray[Any]]: ...
def clopper_pearson(
    successes: NDArray[np.int64], trials: NDArray[np.int64], confidence: float
) -> list[NDArray[np.float64]]: ...
def deviates(
    distribution: str,
    seed: int,
    block: int,
    pixels: NDArray[np.uint64],
    samples: NDArray[np.uint64],
) -> NDArray[np.float64]: ...
def in_standard_floats(
    function: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
) -> Any: ...
def check_method(method: str, scene: str, watched: bool) -> None: ...
def check_moments(moments: Sequence[float]) -> None: ...
def moment_status(moments: NDArray[np.float64], physical: bool) -> NDArray[np.uint8]: ...
def moment_status_names() -> list[str]: ...
def nearest_possible(
    moments: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def unit_quaternions(quaternions: NDArray[np.float64]) -> NDArray[np.float64] | None: ...
def principal_axes(
    tensor: Sequence[Sequence[float]],
) -> tuple[list[float], list[list[float]]]: ...
def listen(
    listener: Callable[[float], object] | None,
) -> Callable[[float], object] | None: ...
def simulate(
    request: Request,
    step: NDArray[np.float64] | None,
    refinement: float = 1.0,
    deviations: NDArray[np.float64] | None = None,
    changes: NDArray[np.float64] | None = None,
    out: Mapping[str, NDArray[Any]] | None = None,
    single: bool = False,
) -> States: ...
def solve(
    request: Request,
    step: NDArray[np.float64] | None,
    accuracy: float | None,
    check: bool,
    free: bool,
    out: Mapping[str, NDArray[Any]] | None = None,
) -> States: ...
def first_tolerance(accuracy: float, method: str) -> float: ...
def state_bytes(
    *, scene: str, record: str, bodies: int, times: int, forces: Forces | None = None
) -> int: ...
def growth(
    bodies: Bodies,
    *,
    method: str,
    deviations: NDArray[np.float64],
    scale: NDArray[np.float64],
    of_attitude: bool,
    times: NDArray[np.float64],
    step: NDArray[np.float64],
    max_steps: int,
    threads: int,
) -> dict[str, Any]: ...
def section(
    bodies: Bodies,
    *,
    method: str,
    kinds: Sequence[tuple[bool, int, bool, NDArray[np.float64], bool, tuple[int, bool]]],
    surfaces: NDArray[np.float64],
    ends: NDArray[np.float64],
    count: int,
    closed: bool,
    check: bool,
    tolerance: float,
    max_steps: int,
    threads: int,
) -> dict[str, Any]: ...
def closed_form_names() -> list[str]: ...
def closed_forms(bodies: Bodies) -> NDArray[np.uint8]: ...
def first_not_finite(array: NDArray[np.float64]) -> int | None: ...
def plain_numbers(
    value: Any, width: int | None = None, ascending: bool = False, kept: bool = False
) -> NDArray[np.float64] | None: ...
def first_slow(omega: NDArray[np.float64], swing: float, least: float) -> int | None: ...
def generic_deviations() -> NDArray[np.float64]: ...
def deviation_starts(bodies: Bodies) -> NDArray[np.float64]: ...
def rate_units(bodies: Bodies) -> NDArray[np.float64]: ...
def verdicts(
    first: NDArray[np.float64],
    second: NDArray[np.float64] | None,
    limits: Sequence[float],
) -> list[str]: ...
def fastest_rates(
    bodies: Bodies,
    span: NDArray[np.float64] | None = None,
    method: str | None = None,
) -> NDArray[np.float64]: ...
def planned_steps(
    bodies: Bodies,
    method: str,
    span: NDArray[np.float64],
    of: str,
) -> NDArray[np.float64]: ...
def status_names() -> list[str]: ...
def closed_forms_for(
    question: str,
    moments: NDArray[np.float64],
    weight: NDArray[np.float64],
    axis: int | None = None,
) -> NDArray[np.uint8]: ...
def distances(
    states: Mapping[str, Any],
    other: Mapping[str, Any],
    scale: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]: ...
def errors_of_closed_forms(
    bodies: Bodies, times: NDArray[np.float64], omega: NDArray[Any]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def lagrange_axes(
    moments: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.int64]: ...
def free_quantities(moments: NDArray[np.float64], omega: NDArray[np.float64]) -> dict[str, Any]: ...
def flip_times(bodies: Bodies, axis: int | None, count: int) -> NDArray[np.float64]: ...
def top_quantities(bodies: Bodies) -> dict[str, Any]: ...
def saddles(bodies: Bodies) -> NDArray[np.float64]: ...
def tilt_times(bodies: Bodies, limit: float) -> NDArray[np.float64]: ...
def elliptic(name: str, arguments: Sequence[NDArray[np.float64]]) -> list[NDArray[np.float64]]: ...

@final
class States(MutableMapping[str, Any]):
    def __getitem__(self, name: str, /) -> Any: ...
    def __setitem__(self, name: str, value: Any, /) -> None: ...
    def __delitem__(self, name: str, /) -> None: ...
    def get(self, name: str, default: Any = None, /) -> Any: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    @property
    def worst(self) -> float | None: ...
    @property
    def error(self) -> NDArray[np.float64]: ...
    @property
    def lost_from(self) -> NDArray[np.float64]: ...

@final
class Motion:
    def __new__(
        cls,
        bodies: Bodies,
        *,
        method: str,
        time: float,
        units: NDArray[np.float64],
        threads: int,
    ) -> Motion: ...
    @property
    def time(self) -> float: ...
    def omega(self) -> NDArray[np.float64]: ...
    def attitude(self) -> NDArray[np.float64]: ...
    def step(self, dt: float, torque: Any = None) -> float | None: ...
    def numbers(self) -> tuple[NDArray[np.float64], bool]: ...
    def restore(self, numbers: NDArray[np.float64], pushed: bool) -> None: ...
    def begin(
        self,
        omega: NDArray[np.float64],
        attitude: NDArray[np.float64],
        omega_before: NDArray[np.float64],
        attitude_before: NDArray[np.float64],
    ) -> None: ...

def further_forces() -> tuple[dict[str, tuple[str, int, int]], int]: ...
def spline(
    knots: NDArray[np.float64], samples: NDArray[np.float64], times: NDArray[np.float64]
) -> NDArray[np.float64]: ...
def orbit_anomalies(
    numbers: NDArray[np.float64], times: NDArray[np.float64]
) -> NDArray[np.float64]: ...

@final
class Forces:
    def __new__(
        cls,
        *,
        times: NDArray[np.float64],
        body: NDArray[np.float64],
        space: NDArray[np.float64],
        damping: NDArray[np.float64],
        further: Mapping[str, NDArray[np.float64]] | None = None,
        knots: Mapping[str, NDArray[np.float64]] | None = None,
        function: tuple[
            int,
            bool,
            bool,
            NDArray[np.float64],
            NDArray[np.float64],
            float,
            NDArray[np.float64],
        ]
        | None = None,
    ) -> Forces: ...
    def select(self, bodies: NDArray[np.intp]) -> Forces: ...
    def doubted(self) -> Forces: ...
    def slows_evenly(self, moments: NDArray[np.float64]) -> NDArray[np.float64]: ...
    @property
    def calls(self) -> bool: ...
    @property
    def states(self) -> int: ...
    def kinds(self, bodies: int) -> NDArray[np.uint64]: ...
    def damping_rates(self, moments: NDArray[np.float64]) -> NDArray[np.float64]: ...

@final
class MapJob:
    def __new__(cls, request: CoreRequest) -> MapJob: ...
    @property
    def status(self) -> NDArray[np.uint8]: ...
    def run(
        self,
        start: int,
        stop: int,
        threads: int,
        interrupted: Callable[[], bool] | None = None,
    ) -> dict[str, Any] | None: ...
    def starts(self, samples: NDArray[np.uint64]) -> list[NDArray[np.float64]]: ...
    def measured(
        self, samples: NDArray[np.uint64], threads: int
    ) -> tuple[list[NDArray[np.float64]], NDArray[np.uint64]]: ...
    def outcomes(self, samples: NDArray[np.uint64], threads: int) -> dict[str, NDArray[Any]]: ...

@final
class MapStatistics:
    def __new__(cls, pixels: int, measures: int = 0) -> MapStatistics: ...
    def merge(self, part: dict[str, Any]) -> None: ...
    def add(
        self,
        measure: int,
        pixels: NDArray[np.uint64],
        values: NDArray[np.float64],
        errors: NDArray[np.float64],
    ) -> None: ...
    def arrays(self) -> dict[str, NDArray[Any]]: ...
    def bins(self) -> list[NDArray[np.int64]]: ...
