"""Random runs whose true error is compared with the error that they state."""

from typing import Any

import numpy as np

import rigid
from physics import EVERY_METHOD, NAMES, Floats, present, rotation_angle
from rigid.model.bodies import bodies_of
from rigid.model.scene import Scene


def final_error(run: rigid.Run, omega: Floats, attitude: Floats, fastest: float) -> float:
    """Error of the last state: of the rates relative to the fastest, of the attitude in rad."""
    of_rates = float(np.linalg.norm(run.omega[-1] - omega)) / fastest
    of_attitude = float(rotation_angle(present(run.attitude)[-1], attitude))
    return max(of_rates, of_attitude)


def random_scene(rng: np.random.Generator) -> tuple[Scene, Floats, Floats]:
    """A body of any class with moment ratios up to 30, its rates and its attitude."""
    parts = 10.0 ** rng.uniform(-1.5, 0.0, 3)
    moments = parts.sum() - parts
    kind = rng.choice(["free", "lagrange", "top", "top"])
    direction = rng.normal(size=3)
    mgl = 10.0 ** rng.uniform(-1.0, 1.0)
    omega = rng.normal(size=3) * 10.0 ** rng.uniform(-1.0, 1.0)
    attitude = rng.normal(size=4)
    if kind == "free":
        return rigid.FreeBody(rigid.Body(moments)), omega, attitude
    if kind == "lagrange":
        moments[1] = moments[0]
        moments[2] = min(moments[2], 1.95 * moments[0])
        return rigid.HeavyTop(rigid.Body(moments), mgl=mgl), omega, attitude
    com = direction / np.linalg.norm(direction)
    return rigid.HeavyTop(rigid.Body(moments), mgl=mgl, com=com), omega, attitude


def survey(count: int, seed: int) -> tuple[Floats, list[Any]]:
    """Ratios of true to estimated errors of random runs, and the runs that missed.

    The truth is the closed form, or taylor26 with steps of a quarter of a radian.
    """
    rng = np.random.default_rng(seed)
    ratios, missed = [], []
    for _ in range(count):
        scene, omega, attitude = random_scene(rng)
        start: tuple[Any, ...] = (scene, omega, attitude)
        rate = float(bodies_of(*start).fastest_rates((0.0, 0.0))[0])
        t = [rng.uniform(2.0, 100.0) / rate]
        accuracy = 10.0 ** rng.uniform(-10.0, -3.0)
        method = str(rng.choice(NAMES))
        order = next(one.order for one in EVERY_METHOD if one.name == method)
        if order <= 4:
            accuracy = max(accuracy, {2: 1e-5, 4: 1e-8}[order])
        options: dict[str, Any] = {"method": method, "max_steps": 10**7}
        if rng.random() < 0.7:
            options["accuracy"] = accuracy
        centre = getattr(scene, "com", (0.0, 0.0, 1.0))  # a free body has none
        has_closed_form = centre == (0.0, 0.0, 1.0)
        if not has_closed_form and "accuracy" in options and rng.random() < 0.7:
            options["method"] = None
        try:
            run = rigid.simulate(*start, t=t, **options)
        except ValueError:
            continue  # refused: a method that does not move this body
        if has_closed_form:
            truth = rigid.simulate(*start, t=t, method="exact")
        else:
            truth = rigid.simulate(*start, t=t, method="taylor26", step=0.25 / rate, check=False)
        fastest = float(np.linalg.norm(truth.omega, axis=-1).max())
        error = final_error(run, truth.omega[-1], present(truth.attitude)[-1], fastest)
        ratios.append(error / float(run.error))
        if "accuracy" in options and not run.flagged and error > accuracy:
            missed.append((start, t, options, error, float(run.error)))
    return np.array(ratios), missed
