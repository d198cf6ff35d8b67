"""Types of the compiled core. Arrays in, arrays out; checked against the binary by stubtest."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "MapJob",
    "Outside",
    "__version__",
    "build_info",
    "check_method",
    "check_moments",
    "closed_forms",
    "elliptic",
    "fastest_rates",
    "flip_times",
    "free_quantities",
    "methods",
    "principal_axes",
    "simulate",
    "tilt_times",
    "top_quantities",
]

__version__: str

def build_info() -> dict[str, Any]: ...
def methods() -> list[dict[str, Any]]: ...
def check_method(method: str, scene: str, watched: bool) -> None: ...
def check_moments(moments: Sequence[float]) -> None: ...
def principal_axes(
    tensor: Sequence[Sequence[float]],
) -> tuple[list[float], list[list[float]]]: ...
def simulate(
    *,
    scene: str,
    method: str,
    record: str,
    moments: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
    step: NDArray[np.float64] | None,
    max_steps: int,
    threads: int,
    times: Sequence[float] | None = None,
    strides: Sequence[int] | None = None,
    tolerance: float | None = None,
    outside: Outside | None = None,
) -> dict[str, Any]: ...
def closed_forms(
    *,
    scene: str,
    moments: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
) -> list[str]: ...
def fastest_rates(
    *,
    scene: str,
    moments: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
    outside: Outside | None = None,
    span: Sequence[float] | None = None,
    method: str | None = None,
) -> NDArray[np.float64]: ...
def free_quantities(
    *, moments: NDArray[np.float64], omega: NDArray[np.float64]
) -> dict[str, Any]: ...
def flip_times(
    *,
    scene: str,
    moments: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
    axis: int,
    count: int,
) -> NDArray[np.float64]: ...
def top_quantities(
    *,
    moments: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
) -> dict[str, Any]: ...
def tilt_times(
    *,
    moments: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    attitude: NDArray[np.float64],
    limit: float,
) -> NDArray[np.float64]: ...
def elliptic(name: str, arguments: Sequence[NDArray[np.float64]]) -> list[NDArray[np.float64]]: ...

@final
class Outside:
    def __new__(
        cls,
        *,
        times: Sequence[float],
        body: NDArray[np.float64],
        space: NDArray[np.float64],
        damping: Sequence[float],
    ) -> Outside: ...
    def slows_evenly(self, moments: Sequence[float]) -> float | None: ...
    def damping_rates(self, moments: Sequence[float]) -> list[float]: ...

@final
class MapJob:
    def __new__(
        cls,
        *,
        scene: str,
        method: str,
        moments: NDArray[np.float64],
        weight: NDArray[np.float64],
        omega: NDArray[np.float64],
        omega_noise: str,
        omega_size: NDArray[np.float64],
        attitude: NDArray[np.float64],
        attitude_noise: str,
        attitude_size: NDArray[np.float64],
        criterion: str,
        axis: int,
        limit: float,
        t_end: float,
        step: float | None,
        max_steps: int,
        samples: int,
        checked: int,
        seed: int,
        outside: Sequence[Outside] | None = None,
    ) -> MapJob: ...
    @property
    def status(self) -> NDArray[np.uint8]: ...
    def run(
        self,
        start: int,
        stop: int,
        threads: int,
        interrupted: Callable[[], bool] | None = None,
    ) -> dict[str, Any] | None: ...
    def sample(self, pixel: int, sample: int) -> dict[str, Any]: ...
