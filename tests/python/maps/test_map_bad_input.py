"""Refusals of the map layer: each names the argument, its value and the rule that it breaks.

What a call of Python and a table of a file both say stands in one table, for both doors.
"""

import dataclasses
import json
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import rigid
from map_texts import map_text
from physics import LISTED, NAMES
from refusals import refuses
from rigid import _core
from rigid.cli.toml_map import parse_spec
from rigid.cli.toml_table import SpecError
from rigid.maps.core_request import CoreRequest, CoreStarts
from rigid.model.bounds import NoFlip, TiltBelow
from rigid.model.criterion import Criterion
from rigid.model.parameters import PARAMETERS
from small_maps import small_map

FREE = rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0)))
BOX = rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01))
TOP = rigid.HeavyTop(rigid.Body((1.0, 1.0, 0.5)), mgl=1.0)
SPIN = rigid.Start(spin=1.0)
RATES = rigid.Start(omega=(1.0, 0.5, 0.0))
ANY: Any = None


def refusal(call: Callable[[], object], kind: type[Exception]) -> str:
    """The one line that a call is refused with."""
    with pytest.raises(kind) as caught:
        call()
    assert type(caught.value) is kind
    message = str(caught.value)
    assert "\n" not in message
    return message


# What a call and a file both say

#: The table of a file, its keys, the kind of the error of Python if it is no ValueError, the words.
BOTH: list[tuple[Any, ...]] = [
    ("start", {"spin": 1.0, "omega": [1, 2, 3]}, "omega, spin: give one of the two to a start"),
    ("start", {"spin": np.nan}, "spin = nan: must be finite"),
    ("start", {"spin": "fast"}, TypeError, "spin = 'fast': must be a"),
    ("start", {"spin": True}, TypeError, "spin = True: must be a"),
    ("start", {"omega": [1.0, 2.0]}, "omega: expected shape (3,), got (2,)"),
    ("start", {"omega": [1.0, np.inf, 0.0]}, "omega[1] = inf: must be finite"),
    ("start", {"spin": 1.0, "axis": 4}, "axis = 4: must be one of 1, 2, 3"),
    ("start", {"spin": 1.0, "axis": -1}, "axis = -1: must be one of 1, 2, 3"),
    ("start", {"spin": 1.0, "axis": 1.5}, TypeError, "= 1.5: must be a whole number, one of 1, 2"),
    ("start", {"spin": 1.0, "axis": True}, TypeError, "axis = True: must be a whole number"),
    ("start", {"spin": 1.0, "tilt": 4.0}, "tilt = 4.0: must lie in [-pi, pi] (rad)"),
    ("start", {"spin": 1.0, "tilt": np.inf}, "tilt = inf: must be finite"),
    ("start.noise", {"size": -1.0}, "size = -1.0: must not be negative"),
    ("start.noise", {"size": np.inf}, "size = inf: must be finite"),
    ("start.noise", {"size": "large"}, TypeError, "size = 'large': must be a"),
    ("start.noise", {"size": [1.0, 2.0]}, "size: expected shape (3,), got (2,)"),
    ("start.noise", {"size": [1.0, -2.0, 0.0]}, "size = -2.0: must not be negative"),
    ("start.noise", {"size": [1.0, np.nan, 0.0]}, "size[1] = nan: must be finite"),
    ("stable", {"axis": 0}, "axis = 0: must be one of 1, 2, 3"),
    ("stable", {"axis": -1}, "axis = -1: must be one of 1, 2, 3"),
    ("stable", {"axis": 1.5}, TypeError, "axis = 1.5: must be a whole number"),
    ("stable", {"angle": 0.0}, "angle = 0.0: must be positive"),
    ("stable", {"angle": 4.0}, "angle = 4.0: must lie in (0, pi] (rad)"),
    ("stable", {"angle": np.nan}, "angle = nan: must be finite"),
    ("stable", {"angle": "a"}, TypeError, "angle = 'a': must be a"),
    ("stable", {"angle": 0.5, "axis": 0}, "axis = 0: must be one of 1, 2, 3, -1, -2, -3"),
    (
        "stable",
        {"angle": 0.5, "reference": "vertikal"},
        "reference = 'vertikal': must be one of 'start', 'vertical'; did you mean 'vertical'?",
    ),
    ("run", {"samples": 0}, "samples = 0: must be at least 1"),
    ("run", {"samples": 2.0}, TypeError, "samples = 2.0: must be a whole number"),
    ("run", {"samples": True}, TypeError, "samples = True: must be a whole number"),
    ("run", {"samples": 2**63}, "samples = 9223372036854775808: must be below 2**63"),
    ("run", {"t_end": 0.0}, "t_end = 0.0: must be positive"),
    ("run", {"t_end": -1}, "t_end = -1.0: must be positive"),
    ("run", {"t_end": np.inf}, "t_end = inf: must be finite"),
    ("run", {"step": 0.0}, "step = 0.0: must be positive"),
    ("run", {"step": np.nan}, "step = nan: must be finite"),
    ("run", {"max_steps": 0}, "max_steps = 0: must be at least 1"),
    ("run", {"max_steps": 2**63}, "max_steps = 9223372036854775808: must be below 2**63"),
    ("run", {"check": -0.1}, "check = -0.1: must not be negative"),
    ("run", {"check": 1.5}, "check = 1.5: must lie in [0, 1]"),
    ("run", {"check": "all"}, TypeError, "check = 'all': must be a"),
    ("run", {"method": "rk5"}, f"did you mean 'rk4'? must be one of 'auto', {LISTED}"),
    ("run", {"method": 4}, "method = 4: must be one of 'auto', 'exact', 'rk4'"),
    ("run", {"seed": -1}, "rng = -1: must lie in 0 .. 2**128 - 1"),
    ("run", {"seed": 2**128}, f"rng = {2**128}: must lie in 0 .. 2**128 - 1"),
    ("run", {"seed": 1.5}, TypeError, "rng = 1.5: must be a whole number"),
    ("run", {"seed": True}, TypeError, "rng = True: must be a whole number"),
    ("run", {"time_unit": "days"}, "time_unit = 'days': must be one of 's', 'min', 'h'"),
    ("run", {"time_unit": "orbit"}, "'orbit': the scene must have one orbit with a per"),
    ("x", {"I1": ["one"]}, TypeError, "axes['I1'] = ['one']: must be"),
    ("x", {"I1": [[1], [2, 3]]}, "axes['I1'] = [[1], [2, 3]]: must be"),
    ("x", {"I1": [[1.0]]}, "axes['I1']: expected shape (n,) with n >= 1, got (1, 1)"),
    ("x", {"I1": []}, "axes['I1']: expected shape (n,) with n >= 1, got (0,)"),
    ("x", {"I1": 1.0}, "axes['I1']: expected shape (n,) with n >= 1, got ()"),
    ("x", {"I1": [1.0, np.nan]}, "axes['I1'][1] = nan: must be finite"),
    ("x", {"I1": [1.0, 1.0]}, "axes['I1']: must increase or decrease strictly"),
    ("x", {"I1": [1.0, 2.0, 1.5]}, "axes['I1']: must increase or decrease strictly"),
    ("x", {"noise": [0.1, -0.1]}, "axes['noise'][1] = -0.1: must not be negative"),
    ("x", {"tilt": [0.1, 4.0]}, "axes['tilt'][1] = 4: must lie in [-3.14159, 3.14159] (rad)"),
    ("x", {"b": [0.0, 1.0]}, "axes['b'][0] = 0: must be positive"),
    ("x", {"mass": [-2.0]}, "axes['mass'][0] = -2: must be positive"),
    ("x", {"mgl": [-2.0]}, "axes['mgl'][0] = -2: must not be negative"),
]


def by_call(table: str, given: dict[str, Any]) -> object:
    """What Python is asked with the keys of a table."""
    if table == "start":
        return rigid.Start(**given)
    if table == "start.noise":
        return rigid.normal(**given)
    if table == "stable":
        return rigid.tilt_below(**given) if "angle" in given else rigid.no_flip(**given)
    if table == "x":
        return small_map(BOX, axes=given)
    return small_map(**{"rng" if name == "seed" else name: one for name, one in given.items()})


def in_toml(value: Any) -> str:
    """A value as a file writes it."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{name} = {in_toml(one)}' for name, one in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(in_toml, value))}]"
    return json.dumps(value) if isinstance(value, str | bool) else repr(value)


def by_file(table: str, given: dict[str, Any]) -> object:
    """A file with the keys of a table."""
    start: dict[str, Any] = {"spin": 1.0}
    tables: dict[str, dict[str, Any]] = {
        "scene": {"kind": "free-body", "box": [0.25, 0.08, 0.01]},
        "x": {"name": "b", "values": [0.1, 0.2]},
        "start": start,
        "stable": {"criterion": "no_flip"},
        "run": {"t_end": 1.0, "samples": 2},
    }
    if table == "start":
        tables["start"] = given
    elif table == "start.noise":
        start["noise"] = {"kind": "normal", **given}
    elif table == "stable":
        tables["stable"] = {"criterion": "tilt_below" if "angle" in given else "no_flip", **given}
    elif table == "x":
        ((name, values),) = given.items()
        tables["x"] = {"name": name, "values": values}
    else:
        tables["run"] |= given
    lines = {
        name: "\n".join(f"{key} = {in_toml(one)}" for key, one in keys.items())
        for name, keys in tables.items()
    }
    return parse_spec(map_text(**lines), "wrong.toml")


def as_in_a_file(words: str) -> str:
    """Words of Python with the names that a file has for them."""
    return re.sub(r"axes\['.*?'\]", "values", words).replace("rng =", "seed =")


test_a_call_is_refused = refuses(BOTH, literal=True, by=by_call)
test_a_file_is_refused_by_the_same_rules = refuses(
    [
        (table, given, [as_in_a_file(words), f"wrong.toml: [{table}] "])
        for table, given, *_, words in BOTH
    ],
    kind=SpecError,
    by=by_file,
)


# Starts


test_starts = refuses(
    [
        ({}, "omega, spin: give one of the two to a start"),
        ({"spin": 1.0, "noise": 0.1}, TypeError, "noise = 0.1: must be a Noise such as"),
        (
            {"spin": 1.0, "attitude_noise": "normal"},
            TypeError,
            "attitude_noise = 'normal': must be a Noise such as",
        ),
        (
            {"spin": 1.0, "noise": rigid.uniform_attitude()},
            "noise = uniform_attitude(): rates have no attitude; use attitude_noise",
        ),
    ],
    literal=True,
    by=lambda options: rigid.Start(**options),
)


test_sizes_of_other_laws_are_those_of_a_normal_one = refuses(
    [
        (law, given, *told)
        for law in (rigid.uniform, rigid.direction)
        for table, given, *told in BOTH
        if table == "start.noise"
    ],
    literal=True,
    by=lambda law, given: law(**given),
)


def test_kinds_of_noise() -> None:
    message = refusal(lambda: rigid.Noise("norml"), ValueError)
    assert "kind = 'norml': must be one of 'normal', 'uniform', 'direction'" in message
    assert "did you mean 'normal'?" in message


def test_sizes_may_be_numbers_of_numpy() -> None:
    assert rigid.normal(np.float64(2.0)).size == rigid.normal(2).size == 2.0
    assert rigid.normal(np.array([1, 2, 3])).size == (1.0, 2.0, 3.0)
    assert rigid.normal((1, 2, 3)) == rigid.normal([1.0, 2.0, 3.0])


# Criteria


test_criteria = refuses(
    [
        (
            lambda: NoFlip().conditions(),
            "no_flip() without an axis needs a start: call resolved() first",
        ),
        (
            lambda: TiltBelow(0.5).conditions(),
            "tilt_below() without a reference needs a scene: call resolved() first",
        ),
        (
            lambda: small_map(stable=rigid.tilt_below(0.5, reference="vertical")),
            "reference = 'vertical': a free body knows no vertical; use 'start' or a HeavyTop",
        ),
        (
            lambda: small_map(axes={"I1": [1.0]}, start=rigid.Start(omega=(1.0, -1.0, 0.5))),
            "no_flip() cannot tell the axis: omega (1.0, -1.0, 0.5) has no single largest "
            "component; say no_flip(axis=...)",
        ),
        (lambda: small_map(t_ende=3.0), TypeError, "t_ende"),
        (lambda: rigid.stability_map(FREE, {"I1": [1.0]}), TypeError, "positional"),  # type: ignore[call-arg]
    ],
    literal=True,
)


# Axes


test_axes = refuses(
    [
        (3, TypeError, "axes = 3: must be a dict of names and values"),
        ([("I1", [1.0])], TypeError, "axes = [('I1', [1.0])]: must be a dict"),
        ({}, "axes: expected 1 to 32 parameters (x, then y, ...), got 0"),
        (
            {name: [1.0] for name in list(PARAMETERS)[:33]},
            "axes: expected 1 to 32 parameters (x, then y, ...), got 33",
        ),
        ({"I4": [1.0]}, "axes: unknown parameter 'I4'"),
        ({"spinn": [1.0]}, "axes: unknown parameter 'spinn'; did you mean 'spin'?"),
        ({"I1/I1": [1.0]}, "axes: unknown parameter 'I1/I1'"),
        ({"gain": [1.0]}, "give a function of it that returns the scene, instead of the scene"),
        ({"spinn": [1.0]}, "(known: I1 to I3, I1/I2"),
        ({3: [1.0]}, "axes: unknown parameter 3"),
        ({"I1": [1.0 + 1.0j]}, TypeError, "axes['I1'] = [(1+1j)]: must be"),
    ],
    literal=True,
    by=lambda axes: small_map(BOX, axes=axes),
)


test_axes_without_meaning_say_why = refuses(
    [
        (FREE, ["b"], SPIN, "'b' does not apply: the sides of the body are not known; make it"),
        (FREE, ["mass"], SPIN, "'mass' does not apply: the sides of the body are not known"),
        (FREE, ["mgl"], SPIN, "'mgl' does not apply: a free body feels no weight; use a HeavyTop"),
        (FREE, ["spin"], RATES, "'spin' does not apply: the start is given by omega; use omega1"),
        (FREE, ["tilt"], RATES, "'tilt' does not apply: the start is given by omega; use Start("),
        (FREE, ["omega1"], SPIN, "'omega1' does not apply: the start is given by spin"),
        (FREE, ["noise"], SPIN, "'noise' does not apply: the start has no noise; give a kind"),
        (
            FREE,
            ["noise"],
            rigid.Start(spin=1.0, noise=rigid.normal([1.0, 2.0, 3.0])),
            "'noise' does not apply: the noise of the start has a size for each component",
        ),
        (
            FREE,
            ["attitude_noise"],
            SPIN,
            "'attitude_noise' does not apply: the attitude of a free body without a torque in "
            "space has no effect; use noise",
        ),
        (TOP, ["attitude_noise"], SPIN, "does not apply: the start has no attitude noise"),
        (
            TOP,
            ["attitude_noise"],
            rigid.Start(spin=1.0, attitude_noise=rigid.uniform_attitude()),
            "'attitude_noise' does not apply: uniform_attitude() has no size",
        ),
        (
            FREE,
            ["I1"],
            rigid.Start(spin=1.0, attitude_noise=rigid.normal(0.1)),
            "attitude_noise = normal(0.1): the attitude of a free body without a torque in space "
            "has no effect",
        ),
        (
            rigid.FreeBody(
                FREE.body,
                torque=rigid.Torque.body((0.3, 0.0, 0.0)) + rigid.Torque.space((0.0, 0.0, 0.0)),
                damping=0.1,
            ),
            ["I1"],
            rigid.Start(spin=1.0, attitude_noise=rigid.normal(0.1)),
            "attitude_noise = normal(0.1): the attitude of a free body without a torque in space "
            "has no effect",
        ),
        (
            FREE,
            ["I1"],
            rigid.Start(omega=(1.0, 0.0, 0.0), tilt=0.1),
            "tilt: has no effect on a free body started by omega; use Start(spin=...)",
        ),
        (BOX, ["I1", "b"], SPIN, "axes: 'I1' and 'b' exclude each other: the moments of a box"),
        (BOX, ["mass", "I1/I2"], SPIN, "axes: 'I1/I2' and 'mass' exclude each other"),
        (FREE, ["I1", "I1/I2"], SPIN, "axes: 'I1' and 'I1/I2' both set I1"),
        (FREE, ["I1/I2", "I1/I3"], SPIN, "axes: 'I1/I2' and 'I1/I3' both set I1"),
        (FREE, ["I1/I2", "I2/I1"], SPIN, "axes: 'I1/I2' and 'I2/I1' set the same ratio"),
    ],
    literal=True,
    by=lambda scene, axes, start: small_map(
        scene,
        axes={name: [0.5, 1.0] for name in axes},
        start=start,
        stable=rigid.no_flip(1),
    ),
)


# The request


test_requests = refuses(
    [
        ({"scene": 3}, TypeError, "scene = 3: must be a rigid.FreeBody or rigid.HeavyTop"),
        ({"scene": rigid.Body}, TypeError, "must be a rigid.FreeBody or rigid.HeavyTop"),
        ({"start": 3}, TypeError, "start = 3: must be a rigid.Start"),
        (
            {"stable": "no_flip"},
            TypeError,
            "stable = 'no_flip': must be a criterion, rigid.no_flip() or rigid.tilt_below(angle)",
        ),
        ({"samples": 2**60}, "samples = 1152921504606846976: too many to count"),
        ({"t_end": None}, TypeError, "stability_map() needs t_end"),
        ({"rng": 1.5}, TypeError, "rng = 1.5: must be a whole number, a numpy Generator or"),
        ({"threads": 0}, "threads = 0: must be at least 1"),
        ({"threads": 1.5}, TypeError, "threads = 1.5: must be a whole number"),
        ({"progress": 3}, TypeError, "progress = 3: must be None, True, False or a callable"),
        ({"title": 3}, TypeError, "title = 3: must be a string"),
        ({"time_unit": ("", 2.0)}, "('', 2.0): the name must have 1 to 40 letters"),
        ({"time_unit": ("beat", 0.0)}, "time_unit[1] = 0.0: must be positive"),
    ],
    literal=True,
    by=lambda options: small_map(**options),
)


def test_the_variable_for_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    for value in ("0", "-1", "two", "1.5", "²", "٣"):
        monkeypatch.setenv("RIGID_NUM_THREADS", value)
        message = refusal(small_map, ValueError)
        expected = f"RIGID_NUM_THREADS = {value!r}: must be a whole number of at least 1"
        assert message == expected
    for value in ("1025", "9" * 5000):
        monkeypatch.setenv("RIGID_NUM_THREADS", value)
        message = refusal(small_map, ValueError)
        assert message.endswith(": must be at most 1024")
        assert len(message) < 130
    monkeypatch.setenv("RIGID_NUM_THREADS", "003")
    assert small_map().threads == 3
    assert small_map(threads=2).threads == 2


def test_threads_are_those_that_the_process_may_use(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("RIGID_NUM_THREADS", raising=False)
    monkeypatch.setattr("os.sched_getaffinity", lambda pid: {5}, raising=False)
    assert small_map().threads == 1


def test_times_of_a_replay() -> None:
    result = small_map()
    expected = "t[0] = 3.0 > t[1] = 1.0: times must be ascending"
    assert refusal(lambda: result.replay(0, 0, t=[3.0, 1.0]), ValueError) == expected
    assert "t[0] = nan: must be finite" in refusal(
        lambda: result.replay(0, 0, t=[np.nan]), ValueError
    )
    for pixel, sample in ((0.5, 0), ("a", 0), (0, "a"), ((0.5, 0), 0)):
        with pytest.raises(TypeError):
            result.replay(pixel, sample)  # type: ignore[arg-type]


def test_results_cannot_be_changed_by_accident() -> None:
    result = small_map()
    with pytest.raises(dataclasses.FrozenInstanceError):
        result.share = ANY  # type: ignore[misc]
    with pytest.raises((dataclasses.FrozenInstanceError, TypeError, AttributeError)):
        result.shares = ANY  # type: ignore[attr-defined]


# The core, which is only called with checked values, does not trust them all the same.

GOOD: dict[str, Any] = {
    "scene": "free",
    "method": "rk4",
    "moments": np.array([[1.0, 1.5, 2.0]]),
    "weight": np.zeros((1, 3)),
    "conditions": [("no_flip", 1, [])],
    "logic": "0",
    "measures": [],
    "t_end": 1.0,
    "step": None,
    "max_steps": 1000,
    "samples": 2,
    "checked": 0,
    "seed": 1,
}
STARTS: dict[str, Any] = {
    "omega": np.ones((1, 3)),
    "omega_noise": "none",
    "omega_size": np.zeros((1, 3)),
    "attitude": np.array([[1.0, 0.0, 0.0, 0.0]]),
    "attitude_noise": "none",
    "attitude_size": np.zeros((1, 3)),
}


def asked(**changes: Any) -> _core.MapJob:
    """The job of the request above with these changes."""
    starts = {name: changes.pop(name, value) for name, value in STARTS.items()}
    return _core.MapJob(CoreRequest(**{"starts": [CoreStarts(**starts)], **GOOD, **changes}))


test_the_core_checks_its_request = refuses(
    [
        ({"scene": "fre"}, "scene = 'fre': must be one of free, top"),
        ({"method": "rk5"}, f"method = 'rk5': must be one of {', '.join(NAMES)}"),
        ({"omega_noise": "norml"}, "omega_noise = 'norml': must be one of none, normal, uniform"),
        ({"attitude_noise": "x"}, "attitude_noise = 'x': must be one of none, normal, uniform"),
        (
            {"conditions": [("flip", 1, [])]},
            "criterion = 'flip': must be one of no_flip, tilt_from_start",
        ),
        ({"conditions": [("no_flip", 0, [])]}, "axis = 0: must be 1, 2, 3 or -1, -2, -3"),
        ({"conditions": [("no_flip", 1, [1.0])]}, "limits: expected shape (0,), got (1,)"),
        ({"conditions": [("regular_rates", 0, [1.0])]}, "limits: expected shape (4,), got (1,)"),
        ({"conditions": [("no_flip", -4, [])]}, "axis = -4: must be 1, 2, 3 or -1, -2, -3"),
        ({"logic": "0 1 &"}, "logic = '0 1 &': must consist of numbers of conditions, &, | and ~"),
        ({"logic": "0 ~ &"}, "logic = '0 ~ &': must have the operands before each operation"),
        ({"measures": [("flip", 1, ())]}, "measure = 'flip': must be one of time_to_leave, drift"),
        ({"measures": [("flips", 0, ())]}, "axis = 0: must be 1, 2, 3 or -1, -2, -3"),
        (
            {"measures": [("settled_no_flip", 1, ())]},
            "measure = settled_no_flip: must be of a rate",
        ),
        ({"measures": [("largest_roll", 1, ())]}, "criterion = 'roll': must be one of no_flip"),
        ({"measures": [("settled_speed_below", 0, ())]}, "limits: expected shape (1,), got (0,)"),
        ({"conditions": []}, "logic = '0': must join 1 to 16 conditions"),
        ({"samples": 0}, "samples = 0: must be at least 1"),
        ({"t_end": 0.0}, "t_end = 0: must be positive and finite"),
        ({"t_end": np.nan}, "t_end = NaN: must be positive and finite"),
        ({"moments": np.ones((1, 2))}, "moments: expected shape (n, 3), C-contiguous, got (1, 2)"),
        ({"weight": np.zeros((2, 3))}, "weight: expected shape (1, ...), got (2, ...)"),
        ({"omega": np.zeros((2, 3))}, "omega: expected shape (1, ...), got (2, ...)"),
        ({"omega_size": np.zeros((2, 3))}, "omega_size: expected shape (1, ...), got (2, ...)"),
        ({"attitude": np.zeros((2, 4))}, "attitude: expected shape (1, ...), got (2, ...)"),
        ({"attitude": np.zeros((1, 3))}, "attitude: expected shape (n, 4), C-contiguous"),
        (
            {"attitude_size": np.zeros((2, 3))},
            "attitude_size: expected shape (1, ...), got (2, ...)",
        ),
        ({"numbers": np.zeros(2, np.uint64)}, "numbers: expected shape (1, ...), got (2, ...)"),
        ({"first": np.array([32], np.uint64)}, "first = 32: must be a multiple of 64 below 2**63"),
        (
            {"first": np.array([2**63], np.uint64)},
            "first = 9223372036854775808: must be a multiple of 64 below 2**63",
        ),
        ({"starts": [], "shares": []}, "starts = (): must not be empty"),
    ],
    literal=True,
    by=lambda change: asked(**change),
)


def test_the_core_checks_its_ranges() -> None:
    job = asked()
    for start, stop in ((0, 3), (2, 1), (3, 3)):
        expected = f"start, stop = ({start}, {stop}): must be a range of the samples of the map"
        assert refusal(lambda a=start, b=stop: job.run(a, b, 1), ValueError) == expected  # type: ignore[misc]
    beyond = np.array([2], np.uint64)
    assert refusal(lambda: job.starts(beyond), ValueError) == "samples = 2 of 2: must be an index"
    message = refusal(lambda: job.outcomes(beyond, 1), ValueError)
    assert message == "samples = 2 of 2: must be an index"
    empty: Any = job.run(1, 1, 1)
    assert empty["stable"].sum() == 0


def test_a_wrong_axis_is_told_before_what_is_missing() -> None:
    incomplete: Any = {"axes": {"bb": [1.0, 2.0]}}
    message = refusal(lambda: rigid.stability_map(FREE, **incomplete), ValueError)
    assert message.startswith("axes: unknown parameter 'bb'; did you mean 'b'? (known: I1 to I3, ")


@pytest.mark.parametrize(
    ("stable", "left"),
    [
        (rigid.spin_above(0.5, axis=2), True),
        (~rigid.spin_above(0.5, axis=2), False),
        (~~rigid.spin_above(0.5, axis=2), True),
        (~(rigid.spin_above(0.5, axis=2) & rigid.no_flip()), False),
        (~rigid.spin_above(0.5, axis=2) & rigid.no_flip(), True),
        (~rigid.spin_above(0.5, axis=2) | ~rigid.no_flip(), False),
    ],
    ids=str,
)
def test_the_time_of_leaving_what_bodies_enter_is_refused(stable: Criterion, left: bool) -> None:
    """A body that fails ``~a`` has kept ``a`` all the time, and so has no time."""
    chosen: dict[str, Any] = {
        "axes": {"spin": [1.0, 2.0]},
        "samples": 2,
        "t_end": 1.0,
        "measure": rigid.time_to_leave(),
        "method": None,
    }
    if left:
        small_map(stable=stable, **chosen)
        return
    with pytest.raises(ValueError, match=r"measure: time_to_leave has no time of .* enter"):
        small_map(stable=stable, **chosen)
