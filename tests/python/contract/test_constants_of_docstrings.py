"""A number that a docstring repeats is the constant of the code."""

import inspect
import re
from pathlib import Path

import pytest

import rigid
from rigid import _core, planning
from rigid._checks import matrices
from rigid.maps import data, page, sequential, spec
from rigid.reports import compute, ensemble, stress, sweep
from rigid.reports import data as report_data
from rigid.reports import spec as report_spec
from rigid.sections.crossings import Crossings
from rigid.solve import (
    choose_method,
    frequencies,
    lyapunov,
    request,
    run,
    status,
)
from rigid.store.result import StabilityMap

CORE = Path(__file__).parents[3] / "src"

ANGLES = {method.name: method.angle_per_step for method in rigid.methods()}
CHOSEN = _core.chosen_methods()
#: The bytes of bodies in a page as text, 4 characters for 3 bytes, in MB.
PAGE = round(4e-6 / 3.0 * page.MOST_BYTES, 1)


def of_core(file: str, name: str) -> float:
    """A constant of the core that has no name in Python."""
    text = (CORE / file).read_text(encoding="utf-8")
    (found,) = re.findall(rf"const {name}: \w+ = ([-+.e\d_]+);", text)
    return float(found)


NUMBER = r"(\d+(?:\.\d+)?(?:e-?\d+)?|[a-z]+\d*)"
"""A number, or the name of a method."""


def said_in(phrase: str, text: str) -> list[str]:
    """What stands in the places ``{}`` of a phrase, which the text has once."""
    parts = (re.escape(part) for part in phrase.split("{}"))
    (found,) = {match.groups() for match in re.finditer(NUMBER.join(parts), text)}
    return list(found)


def docstring(of: object) -> str:
    return " ".join((inspect.getdoc(of) or "").split())


#: What the function or class says, with a place for each constant, and the constants.
SAID: list[tuple[object, str, tuple[float | str, ...]]] = [
    (rigid.stability_map, 'else ``"{}"`` in long steps', (CHOSEN["map"],)),
    (
        rigid.stability_map,
        'with :func:`regular` uses ``"{}"`` in steps of {} rad',
        (CHOSEN["map"], of_core("map/steps.rs", "GROWTH_STEPS") * ANGLES[CHOSEN["map"]]),
    ),
    (rigid.stability_map, "``{}`` does it with 0.8 of the steps", (CHOSEN["second"],)),
    (
        rigid.stability_map,
        "of each {} consecutive bodies of a pixel the first two and",
        (of_core("map/check.rs", "GROUP"),),
    ),
    (
        rigid.stability_map,
        "within {} times the root of this error of another class, or within {} rad",
        (of_core("map/check.rs", "CAUTION"), of_core("map/check.rs", "LEAST_MARGIN")),
    ),
    (rigid.stability_map, "counts as failed; by default {}", (spec.MapSpec.max_steps,)),
    (rigid.stability_map, "gets {}, 128, ... bodies until the interval", (sequential.LOOK,)),
    (
        rigid.stability_map,
        "confidence {}, in which undecided and failed bodies may be either. Looking after each {}",
        (sequential.CONFIDENCE, sequential.LOOK),
    ),
    (spec.MapSpec, "At most {} characters", (spec.MOST_TITLE,)),
    (StabilityMap, "a drift above {} is", (_core.DRIFT_LIMIT,)),
    (data.interval, "by default of {} %", (100.0 * data.CONFIDENCE,)),
    (StabilityMap.explore, "need {} MB, at least 1", (PAGE,)),
    (StabilityMap.explore, "at least 1 and at most {}", (page.MOST_SAMPLES,)),
    (rigid.simulate, "method and a step: {}", (request.USUAL_ACCURACY,)),
    (
        rigid.simulate,
        "begins with a tolerance of {} times",
        (of_core("accuracy/tolerances.rs", "SHARE"),),
    ),
    (
        rigid.simulate,
        "times the accuracy, at most {}, and",
        (of_core("accuracy/tolerances.rs", "LARGEST"),),
    ),
    (
        rigid.simulate,
        "with {} times the accuracy; a body",
        (of_core("accuracy/tolerances.rs", "SHARE_UNDER_FUNCTION"),),
    ),
    (rigid.simulate, '``"{}"`` if a step is given', (CHOSEN["default"],)),
    (rigid.simulate, '``"{}"`` if damping is ten times as fast', (CHOSEN["stiff"],)),
    (rigid.plan, "samples of the pixel; default: {}", (planning.SAMPLES,)),
    (rigid.plan, "without a method and a step: {}", (request.USUAL_ACCURACY,)),
    (rigid.Plan, "``{}`` per radian turned", (_core.ROUNDING,)),
    (rigid.Run, "or below {}", (status.COARSE_ERROR,)),
    (rigid.Run, "all below {} of the", (of_core("estimate/mod.rs", "REST"),)),
    (rigid.Run, "``{}`` per radian turned", (_core.ROUNDING,)),
    (rigid.Run.in_frame, "larger by {}, the rounding of a turn", (run._ROUNDING_OF_TURN,)),
    (rigid.Run.in_frame, "no rotation matrix to {}", (matrices.ROTATION_SLACK,)),
    (rigid.Events, "within {} of its scale", (of_core("trajectory/section/mod.rs", "NEAR"),)),
    (Crossings, "within {} of the scale of its", (of_core("trajectory/section/mod.rs", "NEAR"),)),
    (rigid.lyapunov, "at least {} steps until the first time", (lyapunov.FEWEST,)),
    (rigid.frequencies, "at equal distances; at least {}", (frequencies.FEWEST,)),
    (rigid.frequency_drift, "at least {} of them", (2 * frequencies.FEWEST - 1,)),
    (rigid.report, "differ by about {}, relatively", (ensemble.PERTURBATION,)),
    (rigid.report, "a call takes {} ms", (1e-6 * sweep.WORK,)),
    (
        rigid.report,
        "evaluated for {} bodies and compared with one step of {} bodies",
        (sweep.CLOSED_FORM_BODIES,) * 2,
    ),
    (rigid.report, "turns by {} rad, {} rad and so on", sweep.ANGLES[:2]),
    (rigid.report, "down to 1/{} rad", (1.0 / sweep.ANGLES[-1],)),
    (rigid.report, "off by more than {} after", (sweep.LOST_ENERGY,)),
    (
        rigid.report,
        "By default {}, and {} over",
        (report_spec.ReportSpec.bodies, report_spec.BODIES),
    ),
    (rigid.report, "at {} times of a run", (ensemble.OUTPUT_TIMES,)),
    (rigid.report, "by default {}, and {} over", (compute.SECONDS, compute.LONG_SECONDS)),
    (rigid.extremes, "accuracy of each run is {}", (stress.ACCURACY,)),
]


@pytest.mark.parametrize(("said", "phrase", "constants"), SAID, ids=[row[1] for row in SAID])
def test_a_docstring_repeats_the_constant_of_the_code(
    said: object, phrase: str, constants: tuple[float | str, ...]
) -> None:
    found = said_in(phrase, docstring(said))
    for word, constant in zip(found, constants, strict=True):
        assert (word if isinstance(constant, str) else float(word)) == constant


def test_numbers_in_words_are_the_constants() -> None:
    assert "of a pixel the first two and the one" in docstring(rigid.stability_map)
    assert of_core("map/check.rs", "AUDITED") == 2
    assert "if damping is ten times as fast" in docstring(rigid.simulate)
    assert choose_method.STIFFNESS == 10.0
    assert "more than twice the distances" in docstring(rigid.Report.cheapest)
    assert "there must be three at least" in docstring(rigid.Report.cheapest)
    assert (report_data.APART, report_data.REPEATS) == (2.0, 3)


def test_the_default_start_of_a_map_is_that_of_its_scene() -> None:
    free, top = (scene.example().default_start() for scene in (rigid.FreeBody, rigid.HeavyTop))
    text = docstring(rigid.stability_map)
    (spin,) = said_in("spins at {} rad/s about the axis of its middle moment with", text)
    assert float(spin) == free.spin
    assert free.axis == 2
    (noise,) = said_in("middle moment with ``noise=normal({})``", text)
    assert free.noise == rigid.normal(float(noise))
    spin, axis = said_in("a top at {} rad/s about axis {} with", text)
    assert (float(spin), int(axis)) == (top.spin, top.axis)
    (noise,) = said_in("``attitude_noise=normal({})``", text)
    assert top.attitude_noise == rigid.normal(float(noise))


def test_a_constant_that_differs_is_found() -> None:
    """The phrase is read with its number: another number does not match the constant."""
    assert said_in("within {} rad", "is within 0.02 rad of") == ["0.02"]
    with pytest.raises(ValueError, match="unpack"):
        said_in("within {} rad", "is within a part of a rad")
