"""The cases of ``result_hashes.py``: what is computed, through the public interface only."""

import contextlib
import dataclasses
import hashlib
import io
import tempfile
from collections.abc import Callable, Iterator
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import rigid
from rigid import cli, figures
from rigid.cli.toml_table import names_of
from rigid.model.criteria import Regular
from rigid.solve.status import ARRIVED

Floats = NDArray[np.float64]
Case = tuple[str, Callable[[], Any]]

WHEEL = rigid.Body((1.0, 1.0, 0.5))
TORQUE = rigid.Torque.body(
    [[0.0, 0.2, -0.1], [0.3, 0.0, 0.4], [0.1, 0.1, 0.0], [0.0, 0.1, 0.3]],
    times=[-1.0, 0.25, 2.0, 200.0],
)
SCENES: dict[str, Any] = {
    "free": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
    "free-needle": rigid.FreeBody(rigid.Body((2.0, 1.999, 0.001))),
    "free-symmetric": rigid.FreeBody(rigid.Body((1.5, 1.0, 1.5))),
    "free-sphere": rigid.FreeBody(rigid.Body((1.5, 1.5, 1.5))),
    "lagrange-top": rigid.HeavyTop(WHEEL, mgl=3.0),
    "lagrange-top-axis-1": rigid.HeavyTop(rigid.Body((0.5, 2.0, 2.0)), mgl=3.0, com=(-1, 0, 0)),
    "symmetric-top": rigid.HeavyTop(WHEEL, mgl=3.0, com=(0.6, 0.0, 0.8)),
    "top": rigid.HeavyTop(rigid.Body((1.0, 1.5, 2.0)), mgl=3.0, com=(0.48, -0.64, 0.6)),
    "damped-free": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=(0.1, 0.2, 0.05)),
    "damped-evenly": rigid.FreeBody(WHEEL, damping=np.diag([0.2, 0.2, 0.1])),
    "damped-strongly": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), damping=(0.0, 50.0, 900.0)),
    "torque-in-body": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), torque=TORQUE),
    "torque-in-space": rigid.FreeBody(WHEEL, torque=rigid.Torque.space((0.1, 0.0, 0.5))),
    "damped-top": rigid.HeavyTop(
        rigid.Body((1.0, 1.5, 2.0)),
        mgl=3.0,
        com=(0.48, -0.64, 0.6),
        torque=TORQUE + rigid.Torque.space((0.0, 0.1, 0.0)),
        damping=[[0.2, 0.05, 0.0], [0.05, 0.1, 0.0], [0.0, 0.0, 0.3]],
    ),
    "free-with-drag": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)), drag=(0.1, 0.2, 0.05)),
    "top-with-drag": rigid.HeavyTop(WHEEL, mgl=3.0, com=(0.6, 0.0, 0.8), drag=0.1),
    "damped-lagrange-top": rigid.HeavyTop(WHEEL, mgl=1.0, damping=(0.0, 0.0, 0.05)),
    "gyrostat-with-sink": rigid.FreeBody(
        rigid.Body((1.0, 1.5, 2.0)),
        rotor=(0.3, -0.2, 0.5),
        dissipation=rigid.EnergySink((0.05, 0.1, 0.02)),
    ),
    "satellite": rigid.FreeBody(
        rigid.Body((1.0, 1.5, 2.0)),
        torque=TORQUE,
        orbit=rigid.Orbit(0.7, 0.4, 1.0, normal=(0.0, 0.6, 0.8)),
        damping=(0.1, 0.2, 0.05),
        rotor=(0.3, -0.2, 0.5),
        dissipation=rigid.EnergySink(0.05),
    ),
}
"""Of every kind that the core moves by kernels or closed forms of its own."""

TIMES = (-0.3, 0.0, 0.5, 1.0)
FORWARD = TIMES[1:]
"""Backwards, strong damping lets rates grow by 1e58, and a run by a tolerance takes 1e9 steps."""
RECORDS = ("rates", "axis", "attitude")
MAX_STEPS = 5000
REFUSED = "refused"
"""What stands in place of a hash where a call raises ValueError."""


def cases() -> Iterator[Case]:
    """All cases: a name, and the function that computes the values."""
    yield from _runs()
    yield from _estimates()
    yield from _plans()
    yield from _closed_forms()
    yield from _maps()
    yield from _builtin_maps()
    yield from _limits()
    yield from _events()
    yield from _conditions()
    yield from _reports()
    yield from _textbook()


def digest(values: Any, *, flip: bool = False) -> str:
    """128 bits of BLAKE2b over the bytes of all arrays, numbers and words in nested values."""
    if isinstance(values, str) and values == REFUSED:
        return REFUSED
    parts = list(_bytes(values))
    if flip:
        index = next(k for k, part in enumerate(parts) if len(part) > 7)
        parts[index] = bytes([parts[index][0] ^ 1]) + parts[index][1:]
    state = hashlib.blake2b(digest_size=16)
    for part in parts:
        state.update(len(part).to_bytes(8, "little") + part)
    return state.hexdigest()


def _bytes(values: Any) -> Iterator[bytes]:
    if dataclasses.is_dataclass(values) and not isinstance(values, type):
        values = {item.name: getattr(values, item.name) for item in dataclasses.fields(values)}
    if isinstance(values, figures.Picture):
        values = {name: value for name, value in vars(values).items() if name[0] != "_"}
    if isinstance(values, dict):
        for name, value in values.items():
            yield str(name).encode()
            yield from _bytes(value)
    elif isinstance(values, (list, tuple)):
        yield b"sequence %d" % len(values)
        for value in values:
            yield from _bytes(value)
    elif isinstance(values, Enum):
        yield str(values).encode()
    elif values is None or isinstance(values, str):
        yield repr(values).encode()
    else:
        array = np.asarray(values)
        if array.dtype == object:
            raise TypeError(f"cannot hash {values!r}")
        yield f"{array.dtype} {array.shape}".encode()
        # The sign and the payload of a NaN are not specified by any processor.
        if array.dtype.kind == "f":
            array = np.where(np.isnan(array), np.nan, array)
        yield np.ascontiguousarray(array).tobytes()


def _starts() -> tuple[Floats, Floats]:
    """Rates and attitudes that are the same on every machine: whole numbers and powers of two.

    The first bodies are special: at rest, about a principal axis, next to the unstable one, on the
    separatrix of the moments 1, 1.5, 2, very slow and very fast.
    """
    count = 71
    words = np.random.Philox(key=11).random_raw(9 * count).reshape(count, 9)
    whole = (words >> np.uint64(44)).astype(np.int64) - 2**19
    omega = whole[:, :3] * 2.0 ** (whole[:, 3:4] % 14 - 26)
    omega[:12] = (
        (0.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
        (0.0, 2.0, 0.0),
        (0.0, 0.0, -2.0),
        (2.0**-30, 2.0, 2.0**-31),
        (1.0, 1.0, 1.0),
        (2.0, 1.0, -0.0),
        (2.0**-460, 2.0**-461, 2.0**-462),
        (2.0**8, 2.0**7, -(2.0**8)),
        (2.0**300, 2.0**299, 2.0**300),
        (0.0, 2.0**-20, 2.0),
        (1.0, -1.0, 0.0),
    )
    attitude = whole[:, 4:8].astype(np.float64)
    attitude[0] = (1.0, 0.0, 0.0, 0.0)
    attitude[1] = (0.0, 1.0, 0.0, 0.0)
    attitude[2] = (1.0, 1.0, 1.0, 1.0)
    return omega, attitude


OMEGA, ATTITUDE = _starts()
EXTREMES = ("needle", "near spherical", "separatrix", "unit", "sleeping top", "pole", "damping")
"""Families of extreme bodies that take less than a second."""

ORDINARY = slice(20, 25)
"""Some bodies that are not special."""


def _answered(compute: Callable[[], Any]) -> Any:
    """What a call returns, or that it was refused; the words of a refusal may change."""
    try:
        return compute()
    except ValueError:
        return REFUSED


def _states(run: rigid.Run) -> dict[str, Any]:
    """Everything that the core computes of a run, without what the estimate of the error says."""
    status = np.where(np.isin(run.status, ARRIVED), rigid.Status.OK, run.status)
    names = ("t", "omega", "gamma", "attitude", "work", "steps")
    drifts = ("energy_drift", "momentum_drift", "unit_drift")
    return {name: getattr(run, name) for name in (*names, *drifts)} | {
        "status": status.astype(np.uint8),
        "method": run.plan.method,
        "carried": run.plan.carried,
    }


def _growth(growth: rigid.Growth) -> dict[str, Any]:
    """What the core computes of the growth of a deviation vector."""
    names = ("t", "log_growth", "mean_megno", "fli", "status", "energy_drift")
    return {name: getattr(growth, name) for name in names}


def _estimate(run: rigid.Run) -> dict[str, Any]:
    return {
        "status": run.status,
        "error": run.error,
        "lost_from": run.lost_from,
        "flagged": run.flagged,
        "energy": run.energy() if run.gamma is not None or run.attitude is None else None,
    }


def _run(scene: str, some: slice = slice(None), **options: Any) -> rigid.Run:
    options = {"t": TIMES, "max_steps": MAX_STEPS, **options}
    return rigid.simulate(SCENES[scene], OMEGA[some], ATTITUDE[some], **options)


def _runs() -> Iterator[Case]:
    """Every method with every scene and record: by its own step, a given one, a tolerance."""

    def states(scene: str, some: slice = slice(None), **options: Any) -> Any:
        return _answered(lambda: _states(_run(scene, some, check=False, **options)))

    for scene in SCENES:
        for record in RECORDS:
            yield (
                f"core/run/{scene}/exact/{record}",
                partial(states, scene, method="exact", record=record),
            )
            yield (
                f"core/run/{scene}/exact/{record}/long",
                partial(states, scene, method="exact", record=record, t=(-7e3, 40.0, 1e6)),
            )
        for method in rigid.methods():
            steps: dict[str, dict[str, Any]] = {"own-step": {}, "step-0.03": {"step": 0.03}}
            if method.name.startswith("taylor"):
                steps["tolerance-1e-9"] = {"tolerance": 1e-9, "max_steps": 300}
            for name, options in steps.items():
                for record in RECORDS:
                    yield (
                        f"core/run/{scene}/{method.name}/{name}/{record}",
                        partial(states, scene, method=method.name, record=record, **options),
                    )
            # Steps far too long: iterations that fail, overflow, drift.
            yield (
                f"core/run/{scene}/{method.name}/step-2/attitude",
                partial(states, scene, method=method.name, step=2.0, t=(20.0,)),
            )
    for axis in (1, 2):
        swing = partial(_swinging, axis)
        yield f"core/run/pendulum/{axis}", partial(_answered, swing)
    for scene in SCENES:
        yield (
            f"core/run/{scene}/rk4/threads-3",
            partial(states, scene, method="rk4", threads=3),
        )


def _swinging(axis: int) -> Any:
    """Tops that swing as pendulums about a principal axis, by closed form."""
    scene = rigid.HeavyTop(rigid.Body((1.0, 2.0, 2.5)), mgl=4.0, com=(0, 0, -1))
    omega = np.zeros((5, 3))
    omega[:, axis - 1] = (0.0, 0.5, 2.0**-20, 4.0, -9.0)
    attitude = np.zeros((5, 4))
    attitude[:, 0] = (3.0, 1.0, 2.0, 0.0, 5.0)
    attitude[:, axis] = (1.0, 0.0, 1.0, 1.0, -2.0)
    times = (-7.0, 0.0, 0.5, 60.0)
    return _states(rigid.simulate(scene, omega, attitude, t=times, method="exact"))


def _estimates() -> Iterator[Case]:
    """Estimates of the error, and runs whose steps follow from them."""

    def estimate(scene: str, **options: Any) -> Any:
        return _answered(lambda: _estimate(_run(scene, **options)))

    def accurate(scene: str, **options: Any) -> Any:
        def both() -> Any:
            run = _run(scene, ORDINARY, max_steps=10**6, **options)
            return [_states(run), _estimate(run)]

        return _answered(both)

    for scene in SCENES:
        yield f"machine/estimate/{scene}/exact", partial(estimate, scene, method="exact")
        for method in ("rk4", "dop853", "splitting", "taylor16", "midpoint", "etd4"):
            yield f"machine/estimate/{scene}/{method}", partial(estimate, scene, method=method)
        yield (
            f"machine/estimate/{scene}/taylor16/tolerance-1e-9",
            partial(estimate, scene, method="taylor16", tolerance=1e-9, max_steps=300),
        )
        for accuracy in (1e-4, 1e-10):
            yield (
                f"machine/accuracy/{scene}/{accuracy:g}/own-method",
                partial(accurate, scene, accuracy=accuracy),
            )
        for method in rigid.methods():
            yield (
                f"machine/accuracy/{scene}/1e-07/{method.name}",
                partial(accurate, scene, accuracy=1e-7, method=method.name),
            )


def _plans() -> Iterator[Case]:
    """Method, variables, step and number of steps; the words of a plan may change."""

    def planned(scene: str, question: Any, **options: Any) -> Any:
        def made() -> Any:
            plan = rigid.plan(SCENES[scene], question, **options)
            names = ("closed_form", "method", "carried", "step", "steps", "tolerance")
            return {name: getattr(plan, name) for name in names}

        return _answered(made)

    known = {"omega": OMEGA[ORDINARY], "attitude": ATTITUDE[ORDINARY], "t_end": 1.5}
    asked: dict[str, dict[str, Any]] = {
        "nothing-known": {},
        "start-known": known,
        "accuracy": {**known, "accuracy": 1e-6},
        "rk4": {**known, "method": "rk4"},
        "step": {**known, "step": 0.01},
    }
    started = {"omega": OMEGA[ORDINARY][0], "t_end": 1.5}
    of_a_map: dict[str, dict[str, Any]] = {
        "nothing-known": {"t_end": 1.5},
        "start-known": started,
        "rk4": {**started, "method": "rk4"},
        "step": {**started, "step": 0.01},
    }
    questions = {name: name for name in RECORDS} | {
        "no-flip": rigid.no_flip(),
        "tilt-below": rigid.tilt_below(0.5),
    }
    for scene in SCENES:
        for question, value in questions.items():
            for name, options in (asked if question in RECORDS else of_a_map).items():
                yield (
                    f"machine/plan/{scene}/{question}/{name}",
                    partial(planned, scene, value, **options),
                )


def _closed_forms() -> Iterator[Case]:
    """The quantities of ``rigid.exact``."""
    exact = rigid.exact
    fine = OMEGA[:60:2]
    turned = ATTITUDE[:60:2]

    def asked(call: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
        return _answered(lambda: call(*arguments, **options))

    def steady(*arguments: Any) -> Any:
        slow, fast = exact.steady_precession(*arguments)
        return slow, fast

    for name, scene in SCENES.items():
        free = isinstance(scene, rigid.FreeBody)
        if free:
            yield f"core/exact/free_body/{name}", partial(asked, exact.free_body, scene, fine)
        else:
            yield (
                f"core/exact/lagrange_top/{name}",
                partial(asked, exact.lagrange_top, scene, fine, turned),
            )
            yield f"core/exact/sleeping_spin/{name}", partial(asked, exact.sleeping_spin, scene)
            for limit in (0.3, 1.5, 3.0):
                yield (
                    f"core/exact/tilt_time/{name}/{limit}",
                    partial(asked, exact.tilt_time, scene, fine, turned, limit=limit),
                )
            yield (
                f"machine/exact/steady_precession/{name}",
                partial(asked, steady, scene, [0.1, 1.0, 2.0], [9.0, 1.0, -7.0]),
            )
        for axis in (None, 1, 2, 3):
            yield (
                f"core/exact/flip_times/{name}/{axis or 'largest'}",
                partial(asked, exact.flip_times, scene, fine, turned, axis=axis, count=3),
            )
    pendulum = rigid.HeavyTop(rigid.Body((1.0, 2.0, 2.5)), mgl=4.0, com=(0, 0, -1))
    swings = partial(asked, exact.pendulum_period, pendulum, [0.0, 1e-6, 1.5, 3.0], axis=1)
    yield "machine/exact/pendulum_period", swings
    x, y, z, p = np.ldexp(np.abs(OMEGA[20:60]), 3).T[[0, 1, 2, 0]]
    unit = x / (1.0 + x)
    yield "core/exact/carlson_rf", partial(asked, exact.carlson_rf, x, y, z)
    yield "core/exact/carlson_rc", partial(asked, exact.carlson_rc, x, -y)
    yield "core/exact/carlson_rd", partial(asked, exact.carlson_rd, x, y, z)
    yield "core/exact/carlson_rj", partial(asked, exact.carlson_rj, x, y, z, p)
    yield "core/exact/agm", partial(asked, exact.agm, x, y)
    yield "core/exact/jacobi", partial(asked, exact.jacobi, y, unit)


LONG_MAPS = ("chaotic-com", "chaotic-top", "dimorphos", "hyperion", "separatrix-web", "spin-orbit")
"""Built-in maps that would take hours in plain code; smaller ones are among the requests."""

MAP_ARRAYS = (
    *("status", "stable", "unstable", "undecided", "failed"),
    *("step_limit", "not_finite", "drifted", "checked"),
    *("samples", "share", "lower", "upper"),
    *("energy_drift", "momentum_drift", "unit_drift", "earliest", "steps", "exact"),
)
"""The arrays of a map that are hashed; a further output of maps changes no hash."""


def _numbers_of(result: rigid.StabilityMap) -> dict[str, Any]:
    """The arrays of a map but for the measured times."""
    return {name: getattr(result, name) for name in MAP_ARRAYS}


def _map_requests() -> dict[str, dict[str, Any]]:
    even = [round(0.3 + 0.4 * k, 12) for k in range(9)]
    free, top = SCENES["free"], SCENES["top"]
    normal, uniform = rigid.normal, rigid.uniform
    spun = rigid.Start(spin=1.0, axis=2, noise=normal(0.0625))
    tumbling = rigid.Start(spin=1.0, noise=uniform(0.1), attitude_noise=rigid.uniform_attitude())
    leaning = rigid.Start(spin=1.0, tilt=0.3, attitude_noise=normal(0.05))
    upright = rigid.Start(spin=1.0, attitude_noise=normal(0.1))
    flip, tilt = rigid.no_flip, rigid.tilt_below
    free_flips = {"scene": free, "start": spun, "stable": flip(2)}
    top_flips = {"scene": top, "axes": {"spin": even}, "start": tumbling, "stable": flip(3)}
    top_tilts = {"scene": rigid.HeavyTop, "axes": {"spin": even}, "start": upright}
    damped = {
        "scene": rigid.HeavyTop,
        "axes": {"spin": even, "damping3": [0.0, 0.01, 0.2]},
        "start": upright,
        "stable": tilt(0.5),
    }
    return {
        "free-flips": {**free_flips, "axes": {"I1": even, "noise": [0.01, 0.1, 0.3]}},
        "free-flips-direction": {
            **free_flips,
            "axes": {"I2/I1": [1.1, 1.4, 2.5]},
            "start": rigid.Start(spin=1.0, axis=2, noise=rigid.direction(0.2)),
        },
        "free-tilts-of-start": {
            "scene": free,
            "axes": {"tilt": [0.0, 0.1, 0.3, 0.6]},
            "start": rigid.Start(spin=1.0, axis=3, noise=rigid.direction(0.2)),
            "stable": tilt(0.4),
        },
        "box-sides": {
            "scene": rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)),
            "axes": {"b": [0.03, 0.08, 0.2], "mass": [0.1, 0.3]},
            "start": spun,
            "stable": flip(2),
        },
        "top-flips": top_flips,
        "top-tilts-of-vertical": {**top_tilts, "stable": tilt(0.5)},
        "top-tilts-of-start": {
            "scene": top,
            "axes": {"omega3": even, "mgl": [0.5, 2.0]},
            "start": rigid.Start(omega=(0.1, 0.0, 1.0), tilt=0.3, attitude_noise=normal(0.05)),
            "stable": tilt(0.8, axis=-3, reference="start"),
        },
        "top-leaning": {**top_tilts, "start": leaning, "stable": tilt(0.5)},
        "damped-top": damped,
        "driven-flips": {
            "scene": rigid.FreeBody(
                rigid.Body((1.0, 1.5, 2.0)), torque=rigid.Torque.body((0.0, 0.02, 0.01))
            ),
            "axes": {"spin": even, "damping1": [0.0, 0.1]},
            "start": spun,
            "stable": flip(2),
        },
        "top-regular": {
            "scene": top,
            "axes": {"spin": even, "com_tilt": [0.0, 0.7]},
            "start": leaning,
            "stable": rigid.regular(),
        },
        "strongly-damped": {
            "scene": rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
            "axes": {"damping2": [1.0, 100.0, 1e4]},
            "start": spun,
            "stable": flip(1),
        },
    }


def _maps() -> Iterator[Case]:
    """Small maps of every criterion by every method, and some of their bodies again."""

    def made(request: dict[str, Any], **options: Any) -> rigid.StabilityMap:
        fixed = {"samples": 21, "t_end": 20.0, "rng": 2026, "progress": False, "max_steps": 50_000}
        return rigid.stability_map(**{**fixed, **request, **options})

    def numbers(request: dict[str, Any], **options: Any) -> Any:
        return _answered(lambda: _numbers_of(made(request, **options)))

    def replayed(request: dict[str, Any], **options: Any) -> Any:
        def bodies() -> Any:
            result = made(request, **options)
            is_growth = isinstance(request["stable"], Regular)
            found = []
            for pixel in range(result.share.size):
                if result.status.flat[pixel]:
                    continue
                # The growth of a deviation vector begins after the start.
                for times in (None, [0.5, 2.0] if is_growth else [0.0, 0.5, 2.0]):
                    body = result.replay(pixel, pixel % 21, t=times)
                    values = dataclasses.asdict(dataclasses.replace(body, run=None))  # type: ignore[arg-type]
                    # Nothing is joined or measured: their hashes are as old as the other numbers.
                    assert len(values.pop("parts")) == 1
                    assert not values.pop("measures")
                    if is_growth:
                        found.append([values, _growth(body.run)])
                        continue
                    # Nor is anything known of what grew.
                    assert np.isnan([values.pop("exponent"), values.pop("mean_megno")]).all()
                    found.append([values, _states(body.run)])
            return found

        return _answered(bodies)

    def predicted(request: dict[str, Any]) -> Any:
        result = made(request)
        theory = result.theory()
        if theory is None:
            return [None, result.disagreement()]
        return [theory.share, result.disagreement()]

    methods = ("auto", "exact", *(method.name for method in rigid.methods()))
    for name, request in _map_requests().items():
        for method in methods:
            yield f"core/map/{name}/{method}", partial(numbers, request, method=method)
        yield f"core/map/{name}/step-0.05", partial(numbers, request, method="rk4", step=0.05)
        yield f"core/map/{name}/check-0.1", partial(numbers, request, check=0.1)
        yield f"core/map/{name}/few-steps", partial(numbers, request, max_steps=40)
        yield f"core/map/{name}/chunks", partial(numbers, request, threads=2)
        for method in ("auto", "rk4", "splitting", "dop853"):
            yield f"core/replay/{name}/{method}", partial(replayed, request, method=method)
        yield f"machine/theory/{name}", partial(predicted, request)
        yield (
            f"machine/map-condition/{name}",
            partial(lambda request: made(request).condition(2), request),
        )


def _builtin_maps() -> Iterator[Case]:
    """The built-in maps on their own grids with few bodies, through the command line."""

    def arrays(name: str, samples: int) -> Any:
        with tempfile.TemporaryDirectory() as folder:
            stem = str(Path(folder) / "map")
            command = ["map", name, "--samples", str(samples), "--no-progress", "--out", stem]
            with contextlib.redirect_stdout(io.StringIO()):
                code = cli.main(command)
            assert code == 0, name
            return _numbers_of(rigid.load_map(f"{stem}.npz"))

    for name in names_of("map"):
        if name in LONG_MAPS:
            continue
        samples = 1 if name == "falling-top" else 3
        yield f"core/builtin-map/{name}", partial(arrays, name, samples)


def _limits() -> Iterator[Case]:
    """Maps of criteria that watch limits inside steps, joined ones, and measures."""
    spun = rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.0625))
    leaning = rigid.Start(spin=1.0, tilt=0.3, attitude_noise=rigid.normal(0.05))
    scenes: dict[str, dict[str, Any]] = {
        "free": {"scene": SCENES["free"], "axes": {"I1": [0.3, 0.7, 1.1]}, "start": spun},
        "top": {"scene": SCENES["top"], "axes": {"spin": [0.7, 1.1, 2.3]}, "start": leaning},
        "damped-top": {
            "scene": rigid.HeavyTop,
            "axes": {"spin": [0.7, 1.1, 2.3], "damping3": [0.01, 0.2]},
            "start": leaning,
        },
    }
    questions: dict[str, Any] = {
        "rates-in-body": rigid.rate_within(0.4),
        "rates-in-space": rigid.rate_within(0.4, frame="space"),
        "momentum-in-body": rigid.rate_within(0.6, of="L", frame="body"),
        "near-start": rigid.near_start(1.5),
        "returns": rigid.returns(0.7, after=2.0),
        "spin-above": rigid.spin_above(0.5, axis=2),
        "joined": rigid.no_flip(2) & ~rigid.near_start(2.5) | rigid.spin_above(0.2),
    }
    measures = [rigid.time_to_leave(), rigid.flips(3), rigid.mean_rate(2), rigid.drift()]

    def numbers(request: dict[str, Any], **options: Any) -> Any:
        fixed = {"samples": 21, "t_end": 10.0, "rng": 2026, "progress": False, "max_steps": 50_000}

        def made() -> Any:
            result = rigid.stability_map(**{**fixed, **request, **options})
            found = [
                [m.count, m.mean, m.std, m.least, m.largest, m.quantile([0.1, 0.5])]
                for m in result.measures.values()
            ]
            return [_numbers_of(result), found]

        return _answered(made)

    for scene, request in scenes.items():
        for question, stable in questions.items():
            for method in ("auto", "rk4", "splitting", "dop853"):
                yield (
                    f"core/limits/{scene}/{question}/{method}",
                    partial(numbers, {**request, "stable": stable}, method=method),
                )
        watched = {**request, "stable": questions["joined"], "measure": measures}
        yield f"core/limits/{scene}/measures", partial(numbers, watched)
        yield f"core/limits/{scene}/chunks", partial(numbers, watched, threads=2)


def _events() -> Iterator[Case]:
    """Events of runs by closed forms and series, the ends that they set, and other times."""
    omega = np.array(
        [[0.5, 2.0, -0.25], [0.03125, 1.0, 0.0625], [1.0, -0.5, 3.0], [0.0, 0.25, 2.0]]
    )
    attitude = np.array([[3.0, 1.0, 0.0, 0.5], [1.0, 0.25, -1.0, 0.0]] * 2)
    asked = [
        rigid.crosses("omega2"),
        rigid.crosses("tilt3", 0.75, 1),
        rigid.turns("gamma1", -1),
        rigid.crosses(omega=(1.0, 0.5, -0.25), value=0.125),
    ]

    def run(scene: str, **options: Any) -> rigid.Run:
        options = {"t": (0.0, 4.0, 9.0), "check": False, **options}
        return rigid.simulate(SCENES[scene], omega, attitude, **options)

    def found(scene: str, **options: Any) -> Any:
        made = run(scene, **options)
        names = ("t", "body", "count", "omega", "gamma", "attitude", "direction", "grazing")
        return {
            "ends": getattr(made, "end", None),
            "states": _states(made),
            "events": [{name: getattr(one, name) for name in names} for one in made.events],
        }

    def between(scene: str, **options: Any) -> Any:
        other = run(scene, **options).at([3.0, 0.5, 8.75])
        return {name: getattr(other, name) for name in ("omega", "attitude")}

    for scene in ("free", "free-symmetric", "lagrange-top", "top", "torque-in-space", "damped-top"):
        for method in ("exact", "taylor16", "taylor12"):
            options = {"method": method}
            for name, more in {
                "all": {"events": asked},
                "until": {"events": asked[:1], "until": asked[3], "count": 2},
                "threads": {"events": asked, "threads": 2},
            }.items():
                yield (
                    f"core/events/{scene}/{method}/{name}",
                    partial(_answered, partial(found, scene, **options, **more)),
                )
            yield (
                f"core/at/{scene}/{method}",
                partial(_answered, partial(between, scene, **options)),
            )


def _conditions() -> Iterator[Case]:
    """How much motions magnify small changes of their start."""

    def factors(scene: str) -> Any:
        some = slice(20, 32)
        return _answered(
            lambda: rigid.condition(SCENES[scene], OMEGA[some], ATTITUDE[some], t=FORWARD)
        )

    for scene in SCENES:
        yield f"machine/condition/{scene}", partial(factors, scene)


def _reports() -> Iterator[Case]:
    """Errors of reports, not their times; and the verdicts over extreme bodies."""

    def errors(scene: str, methods: list[str]) -> Any:
        def stop_before_timing(progress: rigid.Progress) -> None:
            if progress.done >= 20:  # all runs are done: what follows only repeats them for timing
                raise KeyboardInterrupt

        start = ([0.3, 1.2, 0.5], [0.8, 0.4, -0.4, 0.2])
        options = {"bodies": 8, "errors": [1e-2, 1e-5, 1e-8], "methods": methods, "partial": True}
        report = rigid.report(
            SCENES[scene], *start, t_end=1.0, seconds=600.0, progress=stop_before_timing, **options
        )
        measured = ("nanoseconds", "spread", "total")
        rows = [dataclasses.asdict(row) for row in report.rows]
        kept = [{n: v for n, v in row.items() if n not in measured} for row in rows]
        return [kept, report.reference, list(report.refused), sorted(report.ended)]

    def judged(family: str, method: str) -> Any:
        cells = rigid.extremes(family, method=method, progress=False).cells
        return [[cell.case.name, cell.error, cell.bound, cell.verdict] for cell in cells]

    for scene in ("free", "lagrange-top", "top", "damped-lagrange-top"):
        for method in ("exact", *(method.name for method in rigid.methods())):
            yield (
                f"machine/report/{scene}/{method}",
                partial(lambda *given: _answered(lambda: errors(*given)), scene, [method]),
            )
    for family in EXTREMES:
        for method in ("exact", "dop853", "chin4a", "taylor16"):
            yield f"machine/extremes/{family}/{method}", partial(judged, family, method)


def _textbook() -> Iterator[Case]:
    """Quantities of the textbook modules; see ``result_cases_textbook.py``."""
    from result_cases_textbook import textbook_cases

    yield from textbook_cases()
