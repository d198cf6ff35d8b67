"""How often the rule of ``rigid.regular`` is wrong.

    python tests/long/regular.py            # some minutes; prints the tables of docs/chaos.md

Four families without chaos, 4096 motions each: none may be called chaotic by two runs, and the
share of the undecided is bounded. An asymmetric top, 64 x 64 starts, against its classes over a
horizon of 12 800: by two methods, where they agree.
"""

import sys
from typing import Any

import numpy as np

import rigid
from rigid.model.scene import Scene

HORIZONS = (100.0, 200.0, 400.0, 800.0)

TRUTH = 12800.0
"""The horizon over which the classes of the asymmetric top are taken for true."""

MOST_UNDECIDED = {"euler": 0.002, "lagrange": 0.002, "kovalevskaya": 0.005, "goryachev": 0.005}
"""Over a time of 100."""

COM = np.array([0.3, 0.2, 0.93]) / np.linalg.norm([0.3, 0.2, 0.93])
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.6, 0.7)), mgl=1.2, com=COM)
MOMENTS: dict[str, tuple[float, float, float]] = {
    "euler": (1.0, 2.0, 3.0),
    "lagrange": (1.0, 1.0, 0.5),
    "kovalevskaya": (2.0, 2.0, 1.0),
    "goryachev": (4.0, 4.0, 1.0),
}


def integrable(kind: str) -> tuple[Scene, dict[str, Any]]:
    """A scene without chaos, and 4096 starts."""
    body = rigid.Body(MOMENTS[kind])
    if kind == "goryachev":
        # Integrable without momentum about the vertical: rates about axis 1, which is level.
        grid = {"com_turn": np.linspace(0.0, 6.2, 64), "omega1": np.linspace(0.05, 3.0, 64)}
        start = rigid.Start(omega=(1.0, 0.0, 0.0), axis=3, tilt=0.9)
        return rigid.HeavyTop(body, mgl=1.0, com=(1.0, 0.0, 0.0)), {"axes": grid, "start": start}
    grid = {"tilt": np.linspace(0.05, 3.09, 64), "spin": np.linspace(0.0, 8.0, 64)}
    cells: dict[str, Any] = {"axes": grid, "start": rigid.Start(spin=0.0)}
    if kind == "euler":
        return rigid.FreeBody(body), cells
    if kind == "lagrange":
        return rigid.HeavyTop(body, mgl=1.0), cells
    # Random starts: those of the grid lie on separatrices of this top, where deviation vectors grow
    # exponentially again and again, and two runs call some chaotic.
    start = rigid.Start(
        omega=(0, 0, 0), noise=rigid.normal(1.0), attitude_noise=rigid.uniform_attitude()
    )
    top = rigid.HeavyTop(body, mgl=1.0, com=(1.0, 0.0, 0.0))
    return top, {"axes": {"mgl": [1.0]}, "samples": 4096, "start": start}


def map_of(scene: Scene, t_end: float, **options: Any) -> rigid.StabilityMap:
    """A map of which all bodies are integrated."""
    chosen: dict[str, Any] = {"samples": 1, "rng": 2026, "stable": rigid.regular()}
    return rigid.stability_map(scene, t_end=t_end, progress=False, **{**chosen, **options})


def families() -> bool:
    """Whether none is called chaotic and few are undecided, more of them with the time."""
    good = True
    print("family          T  runs  chaotic  undecided, %")
    for kind, most in MOST_UNDECIDED.items():
        scene, options = integrable(kind)
        for check in (0.0, 1.0):
            for t_end in HORIZONS:
                # Not in closed form.
                found = map_of(scene, t_end, **options, method="dop853", check=check)
                chaotic, undecided = found.unstable.sum(), found.undecided.sum() / 4096
                runs = 1 + int(check)
                print(
                    f"{kind:12} {t_end:4g} {runs:5} {chaotic:8} {100 * undecided:13.2f}", flush=True
                )
                good &= found.failed.sum() == 0
                if check:
                    good &= chaotic == 0 and undecided <= most
    return bool(good)


def asymmetric() -> bool:
    """Whether no regular top is called chaotic, and few chaotic ones are called regular."""
    axes = {"tilt": np.linspace(0.05, 3.09, 64), "spin": np.linspace(0.0, 8.0, 64)}
    options: dict[str, Any] = {"axes": axes, "start": rigid.Start(spin=0.0)}
    first = map_of(TOP, TRUTH, **options, check=0.0)
    second = map_of(TOP, TRUTH, **options, check=0.0, method="taylor16")
    regular = (first.stable == 1) & (second.stable == 1)
    chaotic = (first.unstable == 1) & (second.unstable == 1)
    print(
        f"asymmetric top, T = {TRUTH:g}: {regular.mean():.4f} regular, {chaotic.mean():.4f} chaotic"
    )
    print("   T  falsely chaotic  falsely regular, %  their largest exponent  10/T  undecided, %")
    good = True
    for t_end in HORIZONS:
        found = map_of(TOP, t_end, **options)
        wrong = (found.stable == 1) & chaotic
        falsely = int(((found.unstable == 1) & regular).sum())
        largest = found.exponent[wrong].max(initial=0.0)
        shares = 100.0 * wrong.mean(), 100.0 * found.undecided.mean()
        print(
            f"{t_end:4g} {falsely:16} {shares[0]:19.2f} {largest:23.4f} "
            f"{found.resolution:5.4f} {shares[1]:13.2f}",
            flush=True,
        )
        good &= falsely == 0 and largest < found.resolution
        if t_end == 200.0:
            good &= shares[0] <= 1.2 and shares[1] <= 4.0
    return good


if __name__ == "__main__":
    passed = [families(), asymmetric()]
    print("passed" if all(passed) else "FAILED")
    sys.exit(not all(passed))
