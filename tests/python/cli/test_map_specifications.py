"""Specifications in TOML: what they mean, and one line with the place for every mistake."""

import dataclasses
import math
import re
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from map_texts import FREE, TABLES, map_text
from refusals import refuses
from rigid._checks.arguments import MESSAGE
from rigid.cli.toml_map import parse_spec, read_spec
from rigid.cli.toml_scene import KINDS
from rigid.cli.toml_table import SpecError, keys
from rigid.model.criterion import Criterion
from rigid.store.call import run_map

BOX = """
title = "A box"
[scene]
kind = "free-body"
box = [0.25, 0.08, 0.01]
mass = 0.3
[x]
name = "b"
from = 0.012
to = 0.248
count = 4
[y]
name = "noise"
from = 1e-4
to = 1.0
count = 5
scale = "log"
[start]
spin = 10.0
axis = 2
noise = { kind = "normal" }
[stable]
criterion = "no_flip"
axis = 2
[run]
t_end = 1.0
samples = 64
seed = 2026
"""

TOP = """
[scene]
kind = "heavy-top"
moments = [1, 1.1, 0.5]
mgl = 2
com = [0.6, 0.0, 0.8]
[x]
name = "tilt"
values = [0.3, 0.2, 0.1]
[start]
omega = [0.1, 0.2, 5]
noise = { kind = "uniform", size = [0.1, 0.2, 0.3] }
attitude_noise = { kind = "uniform_attitude" }
[stable]
criterion = "tilt_below"
angle = 0.5
axis = -3
reference = "start"
[run]
t_end = 40
samples = 10
method = "splitting"
step = 0.01
check = 0.25
max_steps = 5000
"""


def test_a_specification_of_a_box_means_what_it_says() -> None:
    spec = parse_spec(BOX, "box.toml")
    assert spec == rigid.MapSpec(
        scene=rigid.FreeBody(rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)),
        start=rigid.Start(spin=10.0, axis=2, noise=rigid.normal(0.0)),
        axes=spec.axes,
        stable=rigid.no_flip(2),
        t_end=1.0,
        samples=64,
        seed=2026,
        title="A box",
    )
    assert [axis.name for axis in spec.axes] == ["b", "noise"]
    assert spec.shape == (5, 4)
    assert (spec.method, spec.step, spec.check) == ("auto", None, None)


def test_a_specification_of_a_top_means_what_it_says() -> None:
    spec = parse_spec(TOP, "top.toml")
    assert spec.scene == rigid.HeavyTop(rigid.Body((1.0, 1.1, 0.5)), mgl=2.0, com=(0.6, 0.0, 0.8))
    assert spec.start == rigid.Start(
        omega=(0.1, 0.2, 5.0),
        noise=rigid.uniform([0.1, 0.2, 0.3]),
        attitude_noise=rigid.uniform_attitude(),
    )
    assert spec.axes[0].values == (0.3, 0.2, 0.1)
    assert spec.stable == rigid.tilt_below(0.5, axis=-3, reference="start")
    assert (spec.t_end, spec.samples, spec.method, spec.step) == (40.0, 10, "splitting", 0.01)
    assert (spec.check, spec.max_steps, spec.title) == (0.25, 5000, None)
    assert spec.seed != parse_spec(TOP, "top.toml").seed  # fresh entropy, kept


@pytest.mark.parametrize(
    ("line", "drag"),
    [("drag = 0.02", (0.02, 0.02, 0.02)), ("drag = [0.1, 0.2, 0.3]", (0.1, 0.2, 0.3))],
)
def test_quadratic_drag_of_a_specification(line: str, drag: tuple[float, ...]) -> None:
    spec = parse_spec(BOX.replace("mass = 0.3", f"mass = 0.3\n{line}"), "box.toml")
    box = rigid.Body.box(0.25, 0.08, 0.01, mass=0.3)
    assert spec.scene.drag == drag == rigid.FreeBody(box, drag=drag).drag
    assert rigid.MapSpec.from_json(spec.to_json()).scene == spec.scene
    with pytest.raises(ValueError, match="drag"):
        parse_spec(BOX.replace("mass = 0.3", "mass = 0.3\ndrag = -1.0"), "box.toml")


def test_tables_over_time_are_tables_of_a_specification() -> None:
    path = [[float(t) - 4.0, 1.5, 0.0] for t in range(9)]
    tables = (
        f"orbit = {{ t = {list(range(9))}, positions = {path}, gm = 0.5 }}\n"
        "rotor = { t = [0, 8], momentum = [[0, 0, 0], [0, 0, 0.4]] }"
    )
    body = "moments = [1.0, 2.0, 2.5]"
    text = (
        f'[scene]\nkind = "free-body"\n{body}\n{tables}\n'
        '[x]\nname = "spin"\nvalues = [0.1, 0.2]\n'
        "[start]\nspin = 0.1\n"
        '[stable]\ncriterion = "no_flip"\naxis = 2\n[run]\nt_end = 8\nsamples = 4\n'
    )
    scene = parse_spec(text, "flyby.toml").scene
    assert scene.orbit == rigid.Orbit.table(np.arange(9.0), path, gm=0.5)
    assert scene.rotor == rigid.RotorTable([0.0, 8.0], [(0.0, 0.0, 0.0), (0.0, 0.0, 0.4)])
    with pytest.raises(SpecError, match="momenta"):
        parse_spec(text.replace("momentum", "momenta"), "flyby.toml")


def test_a_flyby_of_a_specification_is_the_hyperbola_of_its_keys() -> None:
    flyby = "orbit = { gm = 0.5, periapsis = 2.0, speed = 0.4, time = 3.0, towards = [0, 1, 0] }"
    text = BOX.replace("mass = 0.3", f"mass = 0.3\n{flyby}")
    orbit = parse_spec(text, "flyby.toml").scene.orbit
    assert orbit == rigid.Orbit.flyby(0.5, 2.0, 0.4, time=3.0, towards=(0.0, 1.0, 0.0))
    assert orbit.eccentricity == pytest.approx(1.0 + 2.0 * 0.4**2 / 0.5, rel=1e-15)
    for old, new, words in [
        ("speed", "sped", r"flyby.toml: \[scene.orbit\] unknown key 'sped'; did you mean 'speed'"),
        ("speed = 0.4, ", "", r"flyby.toml: \[scene.orbit\] needs the key 'speed'"),
        (
            "speed = 0.4",
            "speed = -1",
            r"\[scene.orbit\] speed = -1.0: must be positive",
        ),
    ]:
        with pytest.raises(SpecError, match=words):
            parse_spec(text.replace(old, new), "flyby.toml")


def test_what_a_specification_may_leave_out() -> None:
    text = TOP.replace("com = [0.6, 0.0, 0.8]\n", "").replace("axis = -3\n", "")
    text = text.replace('reference = "start"\n', "")
    spec = parse_spec(text, "top.toml")
    assert isinstance(spec.scene, rigid.HeavyTop)
    assert spec.scene.com == (0.0, 0.0, 1.0)
    assert spec.stable == rigid.tilt_below(0.5, axis=3, reference="vertical")
    spec = parse_spec(BOX.replace("mass = 0.3\n", "").replace("axis = 2\n[run]", "[run]"), "b.toml")
    assert spec.scene.body.mass == 1.0
    assert spec.stable == rigid.no_flip(2)


def test_criteria_are_joined_by_lists() -> None:
    def stable(text: str) -> object:
        begin, end = BOX.index("criterion"), BOX.index("[run]")
        return parse_spec(BOX[:begin] + text + "\n" + BOX[end:], "box.toml").stable

    flip = '{ criterion = "no_flip" }'
    near = '{ criterion = "near_start", angle = 0.5 }'
    spin = '{ criterion = "spin_above", rate = 2, axis = 3 }'
    one, other, third = rigid.no_flip(2), rigid.near_start(0.5), rigid.spin_above(2.0, axis=3)
    assert stable(f"all = [{flip}, {near}, {spin}]") == one & other & third
    assert stable(f"any = [{flip}, {near}]") == one | other
    assert stable(f"not = {near}") == ~other
    nested = f"all = [{flip}, {{ not = {{ any = [{near}, {spin}] }} }}]"
    assert stable(nested) == one & ~(other | third)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("all = 3", "[stable] all = 3: must be a list of tables"),
        ("all = [3]", "[stable] all = [3]: must be a list of tables"),
        ("all = []", "[stable] all: joins two criteria or more"),
        ('any = [{ criterion = "no_flip" }]', "[stable] any: joins two criteria or more"),
        ("not = []", "[stable] not = []: must be a table"),
        ("not = {}", "[stable.not] needs the key 'criterion'"),
        ("all = [{}, {}]\naxis = 2", "[stable] unknown key 'axis'"),
        ('not = { criterion = "no_flip", angle = 2 }', "[stable.not] unknown key 'angle'"),
        ('any = [{ criterion = "noflip" }, {}]', "[stable.any[0]] criterion = 'noflip'"),
        (
            'all = [{ criterion = "regular" }, { criterion = "no_flip" }]',
            "[stable] regular() integrates a deviation vector: it is not joined with others",
        ),
        ("not = { " * 17 + 'criterion = "no_flip"' + " }" * 17, "criteria are joined more than 16"),
    ],
)
def test_mistakes_about_joined_criteria(text: str, message: str) -> None:
    begin, end = BOX.index("criterion"), BOX.index("[run]")
    assert message in complaint(BOX[:begin] + text + "\n" + BOX[end:])


def test_measures_are_names_or_tables() -> None:
    listed = '["time_to_leave", "flips", { name = "mean_rate", axis = 3 }]'
    spec = parse_spec(f"{BOX}measure = {listed}\n", "box.toml")
    assert [*map(str, spec.measure)] == ["time_to_leave", "flips(2)", "mean_rate(3)"]
    changed = parse_spec(BOX, "box.toml", ['run.measure=["drift"]'])
    assert changed.measure == (rigid.drift(),)
    assert parse_spec(BOX, "box.toml").measure == ()


test_mistakes_about_measures = refuses(
    [
        ("'flips'", "[run] measure = 'flips': must be a list of names or of tables"),
        ("[3]", "[run] measure = [3]: must be a list of names or of tables"),
        ("['flip']", "[run.measure[0]] name = 'flip': did you mean 'flips'? must be one of"),
        ("[{name = 'drift', axis = 1}]", "[run.measure[0]] unknown key 'axis' (known: name)"),
        (
            "[{name = 'flips', axes = 1}]",
            "[run.measure[0]] unknown key 'axes'; did you mean 'axis'? (known: name, axis)",
        ),
        ("['drift', 'mean_rate']", "[run.measure[1]] needs the key 'axis'"),
        ("[{name = 'mean_rate', axis = 4}]", "[run.measure[0]] axis = 4: must be one of"),
        ("[{axis = 3}]", "[run.measure[0]] needs the key 'name'"),
        ("['flips', 'flips']", "[run] measure: flips(2) is asked for 2 times"),
    ],
    literal=True,
    kind=SpecError,
    by=lambda measure: parse_spec(f"{BOX}measure = {measure}\n", "box.toml"),
)


@pytest.mark.parametrize(
    ("stable", "criterion", "measure", "measures"),
    [
        (
            'criterion = "pointing_within"\nangle = 1.5\neither = true',
            rigid.pointing_within(1.5, 1, either=True),
            '["libration_amplitude", { name = "obliquity", axis = 3 }]',
            ["libration_amplitude(1)", "obliquity(3)"],
        ),
        (
            'criterion = "yaw_within"\nangle = 1.5',
            rigid.yaw_within(1.5, (1, 3)),
            '["largest_roll", { name = "time_to_settle", limit = 0.2, of = "pitch" }]',
            ["largest_roll", "time_to_settle(0.2, pitch)"],
        ),
    ],
)
def test_questions_in_the_frame_of_an_orbit(
    stable: str, criterion: Criterion, measure: str, measures: list[str]
) -> None:
    """Axes that the file leaves out are those of the least and of the largest moment."""
    text = map_text(
        scene=f"{FREE}\norbit = {{ rate = 1.0, eccentricity = 0.1 }}",
        x='name = "eccentricity"\nvalues = [0.0, 0.1]',
        stable=stable,
        run=f"{TABLES['run']}\nmeasure = {measure}",
    )
    spec = parse_spec(text, "x.toml")
    assert spec.stable == criterion
    assert [str(one) for one in spec.measure] == measures
    assert rigid.MapSpec.from_json(spec.to_json()) == spec


def test_a_spin_on_an_axis_need_not_be_said_again() -> None:
    text = BOX.replace('name = "b"', 'name = "spin"').replace("spin = 10.0\n", "")
    assert parse_spec(text, "box.toml").start.starts[0].spin == 0.0


def test_evenly_spaced_values_are_correctly_rounded() -> None:
    # So that they are the same on every machine; NumPy's are good to a few ulp.
    spec = parse_spec(BOX.replace("count = 4", "count = 160"), "box.toml")
    linear, logarithmic = (np.array(axis.values) for axis in spec.axes)
    np.testing.assert_allclose(linear, np.linspace(0.012, 0.248, 160), rtol=1e-15)
    np.testing.assert_allclose(logarithmic, np.geomspace(1e-4, 1.0, 5), rtol=1e-15)
    assert logarithmic.tolist() == [1e-4, 1e-3, 1e-2, 1e-1, 1.0]
    assert (linear[0], linear[-1]) == (0.012, 0.248)
    assert spec.axes[1].geometric
    assert not spec.axes[0].geometric


def test_the_page_of_files_has_a_row_for_every_key() -> None:
    docs = Path(__file__).parents[3] / "docs"
    tables = runpy.run_path(str(docs / "generated_pages.py"))["toml_tables"]()

    def rows(*names: str) -> set[str]:
        lines = [line for name in names for line in tables[name].splitlines()[2:]]
        return {line.split("`")[1] for line in lines}

    assert rows("scene", "free_scene") == {key for make in KINDS.values() for key in keys(make)}
    assert rows("start") == keys(rigid.Start).keys()
    assert rows("orbit") == keys(rigid.Orbit).keys()
    assert rows("orbit_flyby") == keys(rigid.Orbit.flyby).keys()
    assert rows("orbit_table") == keys(rigid.Orbit.table).keys()
    assert rows("rotor_table") == keys(rigid.RotorTable).keys()
    assert rows("axis") == {"name", "values", "from", "to", "count", "scale"}
    run = "samples", "half_width", "refine", "budget", "method", "step", "check", "max_steps"
    assert rows("map_run") == {"t_end", "time_unit", *run, "seed", "measure"}
    report_run = "t_end", "revolutions", "unit", "bodies", "errors", "seed", "methods"
    assert rows("report_run") == {*report_run}
    assert rows("surface") == keys(rigid.section).keys()
    assert rows("section_start") == {"energy", "l_gamma", "bodies", "seed"}
    assert rows("section_run", "plot") == {"points", "t_end", "x", "y"}


def test_parameters_vary_from_body_to_body() -> None:
    vary = '[vary]\nmass = { kind = "normal", size = 0.05, relative = true }\n'
    spec = parse_spec(BOX.replace("[stable]", f"{vary}[stable]"), "x.toml")
    (one,) = spec.vary
    assert (one.name, one.noise) == ("mass", rigid.normal(0.05, relative=True))
    ends = '[vary]\nmass = { kind = "uniform", size = 0.2, high = 0.4 }\n'
    (one,) = parse_spec(BOX.replace("[stable]", f"{ends}[stable]"), "x.toml").vary
    assert one.noise == rigid.uniform(0.2, 0.4)
    for wrong, words in (
        ('spin = { kind = "normal", size = 1.0 }', "[vary] vary: 'spin' belongs to the start"),
        (
            'mass = { kind = "direction", size = 1.0 }',
            "[vary.mass] kind = 'direction': must",
        ),
        ("mass = 0.1", "[vary] mass = 0.1: must be a table"),
    ):
        with pytest.raises(SpecError, match=re.escape(words)):
            parse_spec(BOX.replace("[stable]", f"[vary]\n{wrong}\n[stable]"), "x.toml")


# Noise and mixtures of starts


def test_tables_say_a_covariance() -> None:
    text = map_text(
        scene=FREE,
        start='noise = { kind = "normal", cov = [[1, 0, 0], [0, 2, 1], [0, 1, 4]] }',
        stable='criterion = "no_flip"',
    )
    noise = rigid.normal(cov=[[1, 0, 0], [0, 2, 1], [0, 1, 4]])
    assert parse_spec(text, "a.toml").start.starts[0].noise == noise


FIRST_START = "weight = 3\nspin = 2.0"
OF_A_MIXTURE = map_text(x='name = "mgl"\nvalues = [1.0, 2.0]', start=FIRST_START).replace(
    f"[start]\n{FIRST_START}",
    f"[[start]]\n{FIRST_START}\n[[start]]\nspin = 1.0\n"
    'attitude_noise = { kind = "normal", size = 0.1 }',
)


def test_a_mixture_is_said_in_toml() -> None:
    spec = parse_spec(OF_A_MIXTURE, "top.toml")
    other = rigid.Start(spin=1.0, attitude_noise=rigid.normal(0.1))
    assert spec.start == rigid.mixture([rigid.Start(spin=2.0), other], weights=[3, 1])
    with pytest.raises(SpecError, match=r"weights\[0\] = -3: must be positive"):
        parse_spec(OF_A_MIXTURE.replace("weight = 3", "weight = -3"), "top.toml")
    with pytest.raises(SpecError, match=r"\[start\[0\]\] unknown key 'weigth'; did you mean"):
        parse_spec(OF_A_MIXTURE.replace("weight", "weigth"), "top.toml")
    with pytest.raises(SpecError, match="unknown key 'weight'"):
        parse_spec(
            OF_A_MIXTURE.replace("[[start]]\nspin = 1.0", "")
            .replace("[[", "[")
            .replace("]]", "]")
            .replace('attitude_noise = { kind = "normal", size = 0.1 }', ""),
            "top.toml",
        )


OF_DIRECTIONS = map_text(
    x='name = "attitude_kappa"\nvalues = [1.0, 2.0]',
    start="""spin = 2.0
attitude_noise = { kind = "von_mises_fisher" }
noise = { kind = "von_mises_fisher", kappa = 4.0 }""",
)


def test_directions_are_said_in_toml() -> None:
    (start,) = parse_spec(OF_DIRECTIONS, "top.toml").start.starts
    assert start.noise == rigid.von_mises_fisher(4.0)
    assert start.attitude_noise == rigid.von_mises_fisher(0.0)
    with pytest.raises(SpecError, match="kappa: an axis of the map sets kappa; omit the key here"):
        parse_spec(OF_DIRECTIONS.replace('fisher" }', 'fisher", kappa = 1.0 }', 1), "top.toml")
    with pytest.raises(SpecError, match="needs the key 'kappa'"):
        parse_spec(OF_DIRECTIONS.replace(", kappa = 4.0", ""), "top.toml")
    with pytest.raises(SpecError, match="unknown key 'size'"):
        parse_spec(OF_DIRECTIONS.replace("kappa = 4.0", "size = 4.0"), "top.toml")


def test_large_seeds_can_be_said() -> None:
    text = BOX.replace("seed = 2026", f"seed = {2**128 - 1}")
    assert parse_spec(text, "box.toml").seed == 2**128 - 1


def test_files_are_named_after_themselves(tmp_path: Path) -> None:
    path = tmp_path / "my.box.toml"
    path.write_text(BOX, encoding="utf-8")
    named = read_spec(str(path))
    assert named.name == "my.box"
    assert named.spec == parse_spec(BOX, "any")


def complaint(text: str, file: str = "box.toml") -> str:
    """What is wrong with a text, in one line that begins with the file."""
    with pytest.raises(SpecError) as caught:
        parse_spec(text, file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ")
    assert "\n" not in message
    return message[len(file) + 2 :]


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        # the text
        ("[run]", "[run", "is not valid TOML: "),
        ("t_end = 1.0", "t_end = 1.0\nt_end = 2.0", "is not valid TOML: "),
        # unknown and missing names
        ("[start]", "[strat]", "unknown key 'strat'; did you mean 'start'? (known: title, scene,"),
        ("title =", "titel =", "unknown key 'titel'; did you mean 'title'?"),
        ('kind = "free', 'kid = "free', "[scene] unknown key 'kid'; did you mean 'kind'"),
        ("spin =", "spinn =", "[start] unknown key 'spinn'; did you mean 'spin'? (known: omega,"),
        ("seed =", "sed =", "[run] unknown key 'sed'; did you mean 'seed'?"),
        ("mass =", "mas =", "[scene] unknown key 'mas'; did you mean 'mass'?"),
        ("mass = 0.3", "mass = 0.3\nmgl = 1.0", "[scene] unknown key 'mgl'"),
        ("scale =", "scala =", "[y] unknown key 'scala'; did you mean 'scale'?"),
        ("axis = 2\n[run]", "axes = 2\n[run]", "[stable] unknown key 'axes'; did you mean 'axis'?"),
        ('{ kind = "normal" }', '{ kin = "normal" }', "[start.noise] unknown key 'kin'; did"),
        (
            '{ kind = "normal" }',
            '{ kind = "normal", siez = 1.0 }',
            "[start.noise] unknown key 'siez'; did you mean 'size'?",
        ),
        ("t_end = 1.0", "", "[run] needs the key 't_end'"),
        ("samples = 64", "", "[run] needs the key 'samples'"),
        ("to = 0.248", "", "[x] needs the key 'to'"),
        ('name = "b"', "", "[x] needs the key 'name'"),
        ('criterion = "no_flip"', "", "[stable] needs the key 'criterion'"),
        # unknown words
        ('"free-body"', '"freebody"', "[scene] kind = 'freebody': must be one of 'free-body', '"),
        ('"no_flip"', '"noflip"', "[stable] criterion = 'noflip': did you mean 'no_flip'? must"),
        ('name = "noise"', 'name = "niose"', "[y] name = 'niose': did you mean 'noise'? must"),
        ('kind = "normal"', 'kind = "norml"', "[start.noise] kind = 'norml': must be one of"),
        ('"log"', '"lgo"', "[y] scale = 'lgo': must be one of 'linear', 'log'; did you mean 'log'"),
        # wrong types
        ('"A box"', "3", "title = 3: must be a string"),
        ("spin = 10.0", "spin = 2026-01-01", "[start] spin = datetime.date(2026, 1, 1): must be a"),
        ("count = 4", "count = 4.0", "[x] count = 4.0: must be a whole number"),
        ("box = [0.25, 0.08, 0.01]", "box = 3", "[scene] box: expected shape (3,), got ()"),
        ("box = [0.25, 0.08, 0.01]", 'box = ["a", "b", "c"]', "[scene] box"),
        ('noise = { kind = "normal" }', "noise = 3", "[start] noise = 3: must be a table"),
        # impossible values
        ("box = [0.25, 0.08, 0.01]", "box = [0.25, -0.08, 0.01]", "[scene] b = -0.08: must be pos"),
        ("mass = 0.3", "mass = 0.0", "[scene] mass = 0.0: must be positive"),
        ("count = 4", "count = 1", "[x] count = 1: must be at least 2"),
        ("from = 0.012", "from = 0.248", "[x] from = 0.248, to = 0.248: must differ"),
        ("from = 0.012", "from = -1.0", "[x] from = -1: must be positive"),
        ("to = 0.248", "to = -1.0", "[x] values[1] = "),
        ("from = 0.012", "from = inf", "[x] from = inf: must be finite"),
        ("from = 1e-4", "from = 0.0", "[y] scale = 'log': the ends must be positive, got 0.0"),
        # what does not go together
        ("box = [0.25, 0.08, 0.01]", "", "[scene] needs either 'moments' or 'box' (with 'mass')"),
        (
            "mass = 0.3",
            "moments = [1.0, 1.0, 1.0]",
            "[scene] needs either 'moments' or 'box' (with 'mass')",
        ),
        (
            "box = [0.25, 0.08, 0.01]",
            "moments = [1.0, 1.0, 1.0]",
            "[scene] mass: belongs to a box; omit the mass beside moments",
        ),
        (
            "box = [0.25, 0.08, 0.01]\nmass = 0.3",
            "moments = [1.0, 1.0, 3.0]",
            "[scene] moments = (1, 1, 3): no moment may exceed the sum of the other two",
        ),
        ('name = "noise"', 'name = "b"', "[y] name = 'b': the axis [x] has this name"),
        ('name = "b"', 'name = "mgl"', "axes: 'mgl' does not apply: a free body feels no weight"),
        ("count = 4", "count = 4\nvalues = [1.0]", "[x] unknown key 'from'"),
        ("mass = 0.3", "mass = 0.3\ndissipation = {}", "[scene] dissipation = {}: must be real"),
        ("mass = 0.3", "mass = 0.3\ndissipation = -1", "[scene] dissipation = -1.0: must not be"),
        (
            '{ kind = "normal" }',
            '{ kind = "normal", size = 3.0 }',
            "[start.noise] size: an axis of the map sets the size; omit",
        ),
        ("spin = 10.0", "", "[start] needs the key 'omega' or 'spin'"),
        (
            'noise = { kind = "normal" }',
            'noise = { kind = "uniform_attitude" }',
            "[start] noise = uniform_attitude(): rates have no attitude; use attitude_noise",
        ),
        (
            'criterion = "no_flip"\naxis = 2',
            'criterion = "tilt_below"\nangle = 0.5\nreference = "vertical"',
            "[stable] reference = 'vertical': a free body knows no vertical",
        ),
    ],
)
def test_mistakes(line: str, instead: str, message: str) -> None:
    assert line in BOX
    assert message in complaint(BOX.replace(line, instead, 1))


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        ("mgl = 2", "", "[scene] needs the key 'mgl'"),
        ("mgl = 2", "mgl = [1, 2]", "[scene] mgl = [1, 2]: must be a real number"),
        ("mgl = 2", "mgl = 2\ntorque = [nan, 0, 0]", "[scene] torque"),
        ("mgl = 2", "mgl = 2\ndrag = [[1, 1, 1], [2, 2, 2]]", "[scene] expected one body, got"),
        ("mgl = 2", "mgl = 2\nframe = 3", "[scene] unknown key 'frame'"),
        ("mgl = 2", "mgl = -2", "[scene] mgl = -2.0: must not be negative"),
        ("com = [0.6, 0.0, 0.8]", "com = [1, 1, 1]", "[scene] com = [1.0, 1.0, 1.0]: must be a"),
        (", size = [0.1, 0.2, 0.3] }", " }", "[start.noise] needs the key 'size'"),
        (
            '{ kind = "uniform_attitude" }',
            '{ kind = "uniform_attitude", size = 1.0 }',
            "[start.attitude_noise] unknown key 'size'",
        ),
        ("angle = 0.5", "", "[stable] needs the key 'angle'"),
    ],
)
def test_mistakes_about_tops(line: str, instead: str, message: str) -> None:
    assert line in TOP
    parse_spec(TOP, "top.toml")
    assert message in complaint(TOP.replace(line, instead, 1), "top.toml")


#: A file with a place for more keys of the scene, an axis, and the start.
PLAIN = """
[scene]
kind = "free-body"
moments = [1.0, 1.5, 2.0]
[x]
name = "spin"
from = 1.0
to = 2.0
count = 3
[start]
spin = 1.0
[stable]
criterion = "no_flip"
[run]
t_end = 2.0
samples = 1
"""


@pytest.mark.parametrize(
    ("line", "instead", "message"),
    [
        ('"spin"', '"omega3"', "the start is given by spin; use omega in [start]"),
        ("spin = 1.0", "omega = [1, 0, 0]", "use omega1, omega2, omega3 or spin in [start]"),
        ('"spin"', '"noise"', "give a kind, as in noise = { kind = 'normal' } in [start]"),
        ('"spin"', '"kappa"', "the start has no noise = { kind = 'von_mises_fisher' }"),
        ('"spin"', '"mgl"', "a free body feels no weight; use kind = 'heavy-top'"),
        ('"spin"', '"b"', "the sides of the body are not known; give box instead of moments"),
        ('"spin"', '"anomaly"', "the scene has no orbit; give it orbit = { rate = ... }"),
        ("2.0]", "9.0]", "physical = false takes such moments as they are"),
    ],
)
def test_a_remedy_is_told_in_the_words_of_the_file(line: str, instead: str, message: str) -> None:
    parse_spec(PLAIN, "plain.toml")
    said = complaint(PLAIN.replace(line, instead, 1), "plain.toml")
    assert message in said
    assert "rigid." not in said


def test_an_axis_of_a_rate_needs_the_rates() -> None:
    """Neither was given: to be told to give one of two would not help."""
    text = PLAIN.replace('"spin"', '"omega3"').replace("spin = 1.0", "")
    wanted = "[start] needs the key 'omega': the axis omega3 varies a component of it"
    assert complaint(text, "plain.toml").endswith(wanted)


def test_the_centre_of_mass_of_a_top_is_a_direction() -> None:
    text = PLAIN.replace('"free-body"', '"heavy-top"\nmgl = 1.0\ncom = [0.0, 0.0, 0.05]')
    assert complaint(text, "plain.toml").endswith("0.05; mgl has the distance in it")
    box = text.replace("moments = [1.0, 1.5, 2.0]", "box = [1, 2, 3]").replace("0.05", "1")
    assert "box: a top needs moments about its fixed point" in complaint(box, "plain.toml")


def test_tables_that_are_missing_or_no_tables() -> None:
    tables = BOX.split("\n[")
    for name in ("scene", "x", "start", "stable", "run"):
        rest = [table for table in tables if not table.startswith(f"{name}]")]
        assert len(rest) == len(tables) - 1
        assert complaint("\n[".join(rest)) == f"needs the key {name!r}"
    lines = [table for table in tables if not table.startswith("x]")]
    assert complaint("x = 3\n" + "\n[".join(lines)) == "x = 3: must be a table"
    lines = [table for table in tables if not table.startswith("y]")]
    assert parse_spec("\n[".join(lines).replace('"normal"', '"normal", size = 0.1'), "").shape == (
        4,
    )


# Texts that want to take time or memory


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a = " + "[" * 3000, "hostile.toml: arrays or tables are nested too deeply"),
        ("a = " + "{a = " * 3000, "hostile.toml: arrays or tables are nested too deeply"),
        (".".join(["a"] * 20_000) + " = 1", "hostile.toml: a key has more than 16 parts"),
        ("[" + " . ".join(["a"] * 20_000) + "]", "hostile.toml: a key has more than 16 parts"),
        ("x = {" + ".".join([r'"a \" b"'] * 20_000), "hostile.toml: a key has more than 16 parts"),
        (".".join(["'a b'"] * 20_000), "hostile.toml: a key has more than 16 parts"),
        ("a = " + "1" * 5000, "hostile.toml: is not valid TOML: Exceeds the limit"),
        ("k" * 10**6 + " = 1", "hostile.toml: unknown key 'kkkkk"),
        (BOX.replace("count = 4", f"count = {10**12}"), "count = 1000000000000: must be at most"),
        (BOX.replace("count = 4", "count = " + "1" * 4000), "[x] count = 1111"),
        (BOX.replace("t_end = 1.0", "t_end = " + "1" * 4000), "[run] "),
    ],
)
def test_a_hostile_text_is_refused_in_a_line_with_the_name_of_the_file(
    text: str, told: str
) -> None:
    with pytest.raises(SpecError) as caught:
        parse_spec(text, "hostile.toml")
    message = str(caught.value)
    assert message.startswith("hostile.toml: ")
    assert told in message
    assert "\n" not in message
    assert len(message) < MESSAGE + 100


def test_a_key_with_as_many_parts_as_any_table_needs_is_none_of_them() -> None:
    text = BOX + ".".join(["deep"] * 16) + " = 1\n"
    with pytest.raises(SpecError, match="unknown key 'deep'"):
        parse_spec(text, "deep.toml")


def test_a_long_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "long.toml"
    with path.open("wb") as file:
        file.truncate(10**10)  # takes no room on the disk
    with pytest.raises(SpecError, match=r"long\.toml: is longer than 8388608 bytes"):
        read_spec(str(path))


@pytest.fixture(scope="module", params=["inertia-triangle", "sleeping-top", "thrown-box"])
def built_in(request: pytest.FixtureRequest) -> tuple[str, rigid.StabilityMap]:
    """A built-in map with two bodies a pixel."""
    spec = dataclasses.replace(read_spec(request.param).spec, samples=2)
    return request.param, run_map(spec, progress=False)


def test_built_in_maps_run_and_nothing_fails(built_in: tuple[str, rigid.StabilityMap]) -> None:
    name, result = built_in
    assert result.complete
    assert result.failed.sum() == 0
    assert result.undecided.sum() == 0
    # Every body of these maps has a closed form: no step, no repetition, no drift.
    assert result.plan.method == "exact"
    assert result.exact.sum() == result.samples.sum()
    assert result.steps.sum() == result.checked.sum() == 0
    assert np.isnan(result.energy_drift).all()
    assert np.isnan(result.momentum_drift).all()
    assert np.isnan(result.unit_drift).all()
    assert result.stable.sum() > 0.1 * result.samples.sum()
    assert result.unstable.sum() > 0.1 * result.samples.sum()
    assert result.spec.title
    assert result.spec.seed == 2026
    theory: Any = result.theory()
    compared = ~np.isnan(theory.share) & ~np.isnan(result.share)
    assert result.disagreement().sum() <= 0.05 * compared.sum()
    assert compared.sum() > 0.4 * (result.status == 0).sum()
    assert (result.status != 0).any() == (name == "inertia-triangle")
    assert theory.curves


def test_built_in_maps_have_the_promised_size() -> None:
    spec = read_spec("thrown-box").spec
    assert math.prod(spec.shape) * spec.samples >= 10**6
    box: Any = spec.scene.body
    assert box.sides == (0.25, 0.08, 0.01)
