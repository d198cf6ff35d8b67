"""The command ``rigid``: maps written, facts printed, mistakes told in one line."""

import json
import os
import re
import resource
import runpy
import shlex
import signal
import sys
from collections.abc import Callable
from importlib import metadata
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigid
from interrupts import sigint
from map_texts import SMALL as SPEC
from printed_text import facts_of, unwrapped
from processes import PATIENCE, Capture, run_python
from rigid._checks.progress import reporting
from rigid._checks.shown import WIDTH
from rigid.cli import main
from rigid.cli.output import (
    DONE,
    EXIT_CODES,
    REFUSED,
    SAYS_NO,
    UNFINISHED,
    WRITE_ERROR,
)
from rigid.cli.parser import GROUPS, make_parser
from rigid.cli.toml_table import names_of
from rigid.literature.validation import Compared, Validation, entries
from rigid.maps.data import MapData
from rigid.maps.file import write_map
from rigid.reports.stress import UNDETECTED_ERROR, Cell
from rigid.reports.stress_cases import cases
from rigid.store.call import run_map
from small_maps import assert_same_map, in_blocks
from terminals import in_terminal, read

pytestmark = pytest.mark.usefixtures("folder")
brief = pytest.mark.usefixtures("brief")


def made(folder: Path) -> set[str]:
    """The files that were written."""
    return {path.name for path in folder.iterdir()} - {"small.toml"}


def fails(arguments: list[str], capsys: Capture) -> str:
    """The one line on stderr of a command that is refused with exit code 2."""
    try:
        code: object = main(arguments)
    except SystemExit as stop:
        code = stop.code
    output, errors = capsys.readouterr()
    assert code == 2
    assert output == ""
    assert errors.endswith("\n")
    assert errors.count("\n") == 1, errors
    assert errors.startswith("rigid")
    return str(errors[:-1])


def test_the_entry_point_is_the_command() -> None:
    (entry,) = metadata.entry_points(group="console_scripts", name="rigid")
    assert entry.load() is main


def test_a_map_writes_picture_and_data_and_prints_what_was_computed(
    folder: Path, capsys: Capture
) -> None:
    assert main(["map", "small.toml"]) == 0
    assert made(folder) == {"small.npz", "small.png"}
    assert (folder / "small.png").read_bytes().startswith(b"\x89PNG\r\n")
    output, errors = capsys.readouterr()
    assert errors == ""
    facts = facts_of(output)
    assert facts["map"] == "A small map"
    assert facts["scene"] == "free body, moments (varied, 1.5, 2)"
    assert facts["start"] == "spin 1 rad/s about axis 2, rates + normal(varied)"
    assert facts["x"] == "I1 from 0.4 to 1.3 kg m² (4 values)"
    assert facts["y"] == "noise from 0.001 to 0.1 rad/s (3 values, geometric)"
    assert facts["stable"] == "no flip about axis 2 until t = 20 s"
    assert facts["plan"] == "exact, closed form: free asymmetric; every body has a closed form"
    assert facts["method"] == "auto: closed form"
    assert facts["samples"] == "10 per pixel; seed 5"
    assert facts["bodies"] == "90; 3 impossible pixels"
    result = rigid.load_map("small.npz")
    for name in ("stable", "unstable", "undecided", "failed"):
        count = int(getattr(result, name).sum())
        assert f"{count} {name} ({count / 90:.2%})" in facts["classes"]
    assert facts["worst"] == "drift none: closed form"
    theory: Any = result.theory()
    compared = int((~np.isnan(theory.share) & ~np.isnan(result.share)).sum())
    assert compared >= 5
    assert f": {result.disagreement().sum()} of {compared} pixels" in facts["theory"]
    assert "bodies per second" in facts["speed"]
    assert " s on " in facts["speed"]
    assert facts["data"] == "small.npz"
    assert facts["picture"] == "small.png"


@brief
def test_a_method_is_told_with_its_steps_and_drifts(folder: Path, capsys: Capture) -> None:
    (folder / "steps.toml").write_text(SPEC.replace("samples", 'method = "rk4"\nsamples'))
    assert main(["map", "steps.toml"]) == 0
    facts = facts_of(capsys.readouterr().out)
    assert facts["plan"].startswith("rk4, step ")
    assert facts["plan"].endswith(" steps; method = 'rk4' was asked for")
    assert facts["method"] == "rk4, step chosen for each body"
    assert facts["samples"] == "10 per pixel, all cross-checked by dop853; seed 5"
    result = rigid.load_map("steps.npz")
    assert f"energy {np.nanmax(result.energy_drift):.1e}" in facts["worst"]
    assert f"momentum {np.nanmax(result.momentum_drift):.1e}" in facts["worst"]
    assert f"unit lengths {np.nanmax(result.unit_drift):.1e}" in facts["worst"]


@brief
def test_the_map_is_that_of_python(capsys: Capture) -> None:
    assert main(["map", "small.toml", "--threads", "1", "--no-progress"]) == 0
    assert "on 1 thread\n" in capsys.readouterr().out
    result = rigid.stability_map(
        rigid.FreeBody(rigid.Body((1.0, 1.5, 2.0))),
        axes={"I1": [0.4, 0.9, 1.1, 1.3], "noise": [1e-3, 1e-2, 0.1]},
        start=rigid.Start(spin=1.0, axis=2, noise=rigid.normal(0.0)),
        stable=rigid.no_flip(),
        samples=10,
        t_end=20.0,
        rng=5,
        title="A small map",
        progress=False,
    )
    loaded = rigid.load_map("small.npz")
    assert loaded.spec == result.spec
    assert_same_map(loaded, result)


@brief
def test_options_replace_what_the_file_says(folder: Path, capsys: Capture) -> None:
    (folder / "there").mkdir()
    arguments = ["--samples", "3", "--threads", "2", "--seed", str(2**100), "--out", "there/b"]
    assert main(["map", "small.toml", *arguments]) == 0
    assert made(folder) == {"there"}
    assert {path.name for path in (folder / "there").iterdir()} == {"b.npz", "b.png"}
    result = rigid.load_map("there/b.npz")
    assert result.spec.samples == 3
    assert result.spec.seed == 2**100
    assert "on 2 threads" in capsys.readouterr().out


@brief
@pytest.mark.parametrize(
    ("out", "stem"), [("b.png", "b"), ("b.npz", "b"), ("v1.2", "v1.2"), ("b.toml", "b.toml")]
)
def test_the_suffix_of_the_output_is_ours(out: str, stem: str, folder: Path) -> None:
    assert main(["map", "small.toml", "--samples", "1", "--out", out]) == 0
    assert made(folder) == {f"{stem}.npz", f"{stem}.png"}


def test_built_in_maps_are_listed(capsys: Capture) -> None:
    assert main(["maps"]) == 0
    lines = unwrapped(capsys.readouterr().out, indent=18).splitlines()
    assert [line.split()[0] for line in lines] == [
        "apophis",
        "chaotic-com",
        "chaotic-top",
        "dimorphos",
        "falling-top",
        "gravity-gradient",
        "hyperion",
        "inertia-triangle",
        "separatrix-web",
        "sleeping-top",
        "spin-orbit",
        "thrown-box",
        "tumbling-debris",
    ]
    assert lines[11].endswith("A thrown box, spinning about its middle axis (b x noise)")


def test_info_describes_the_build(capsys: Capture) -> None:
    assert main(["info"]) == 0
    facts = facts_of(capsys.readouterr().out)
    info = rigid.build_info()
    assert set(facts) == set(info)
    assert facts["version"] == rigid.__version__
    assert facts["isa"] == info["isa"]
    assert facts["isa_available"] == ", ".join(info["isa_available"])
    assert facts["threads"] == str(info["threads"])


KNOWN = "apophis, chaotic-com, chaotic-top, dimorphos, falling-top, gravity-gradient, hyperion, "
OF_PARTS = "must be k/n with 1 <= k <= n <= 2147483648"


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("mapp", "COMMAND = 'mapp': unknown; did you mean 'map'? (known: map, "),
        ("map", "rigid map: needs NAME|FILE.toml; rigid map --help has examples"),
        ("map small.toml --sampels 3", "--sampels: this command has no such option; did you mean"),
        ("map small.toml --samples 0", "samples = 0: must be at least 1"),
        ("map small.toml --samples 1.5", "--samples = '1.5': must be a whole number"),
        ("map small.toml --threads 0", "threads = 0: must be at least 1"),
        ("map small.toml --threads two", "--threads = 'two': must be a whole number"),
        ("map small.toml --seed -1", "-1: must lie in 0 .. 2**128 - 1"),
        ("map small.toml --seed x", "--seed = 'x': must be a whole number"),
        ("map small.toml --half-width 0.7", "half_width = 0.7: must lie in [0.002, 0.25]"),
        (
            "map small.toml --samples 5 --half-width 0.1",
            "rigid: --samples, --half-width: give one of the two",
        ),
        ("map small.toml --out no/where/b", "--out: there is no directory 'no/where'"),
        ("map small.toml --out .", "--out: '.' names a directory, not a file"),
        ("map small.toml --out /", "--out: '/' names a directory, not a file"),
        ("map small.toml --what flips", "what = 'flips': must be one of 'share', 'cost', 'expon"),
        (
            "map small.toml --what 'mean of flips'",
            "what = 'mean of flips': 'flips' is not measured once (measured: none)",
        ),
        ("map small.toml --part 1/2", "rigid: --part: needs --store"),
        ("map small.toml --part 1/2 --check", "rigid: --part: needs --store"),
        ("map small.toml --dask tcp://x", "--dask: needs --store"),
        ("map small.toml --store new --part 5/4", f"part = '5/4': {OF_PARTS}"),
        ("map small.toml --store new --part 0/4 --check", f"part = '0/4': {OF_PARTS}"),
        ("map small.toml --store new --part a/2", f"part = 'a/2': {OF_PARTS}"),
        ("map small.toml --store new --part 1 --check", f"part = '1': {OF_PARTS}"),
        ("map thrown-bix", "'thrown-bix'; did you mean 'thrown-box'?"),
        ("map nonsense", f"'nonsense' (known: {KNOWN}"),
        ("map smal.toml", "smal.toml: there is no such file or folder; did you mean 'small.toml'?"),
        ("map ./here", "./here: there is no such file or folder"),
        ("map .", ".: cannot be read: Is a directory"),
        # Keys that are set
        ("map small.toml --set run.t_end", "--set 'run.t_end': must be KEY=VALUE, such as run.t"),
        ("map small.toml --set run.=3", "--set 'run.=3': must be KEY=VALUE"),
        ("map small.toml --set run.t_end.x=3", "--set 'run.t_end.x=3': 't_end' is not a table"),
        ("map small.toml --set rnu.t_end=3", "unknown key 'rnu'; did you mean 'run'?"),
        ("map small.toml --set t_end=3 --check", "unknown key 't_end'; did you mean 'run.t_end'?"),
        ("map small.toml --set run.t_ned=3", "[run] unknown key 't_ned'; did you mean 't_end'?"),
        ("map small.toml --set run.t_end=-3 --check", "[run] t_end = -3.0: must be positive"),
        ("map small.toml --set 'run.t_end=1\nseed = 4'", "[run] t_end = "),
        (
            "map small.toml --set y.name=nosie",
            "[y] name = 'nosie': did you mean 'noise'? must be one of 'I1' to 'I3', ",
        ),
        (
            "map small.toml --set 'y.from=\"1 rpm\"'",
            "[y] from = '1 rpm': must be a real number in rad/s, written without the unit; "
            "1 * rigid.units.rpm is 0.104719755",
        ),
        ("map old.npz --set run.t_end=3", "--set: changes a TOML file; an older result has --samp"),
        ("map --show thrown-box --set run.t_end=3", "--show prints the file as it is"),
    ],
)
def test_mistakes_are_one_line_before_any_work(
    command: str, told: str, folder: Path, capsys: Capture
) -> None:
    assert told in fails(shlex.split(command), capsys)
    assert made(folder) == set()


@pytest.mark.parametrize("options", [[], ["--show"]])
@pytest.mark.parametrize(
    ("line", "instead", "told"),
    [
        ("[start]", "[start", "small.toml: is not valid TOML"),
        ("[run]", "[runs]", "small.toml: unknown key 'runs'; did you mean 'run'?"),
        ('criterion = "no_flip"', 'both = "no_flip"', "[stable] unknown key 'both' (known: crit"),
        ('kind = "free-body"', 'kin = "free-body"', "[scene] unknown key 'kin'; did you mean 'kin"),
        ('{ kind = "normal" }', '{ kin = "normal" }', "[start.noise] unknown key 'kin'; did you"),
    ],
)
def test_an_invalid_file_is_not_shown_and_an_unknown_key_is_told_before_a_missing_one(
    line: str, instead: str, told: str, options: list[str], folder: Path, capsys: Capture
) -> None:
    (folder / "small.toml").write_text(SPEC.replace(line, instead, 1))
    assert told in fails(["map", *options, "small.toml"], capsys)
    assert made(folder) == set()


def test_folders_that_are_no_stores_and_maps_without_a_picture(
    folder: Path, capsys: Capture
) -> None:
    (folder / "full").mkdir()
    (folder / "full" / "notes.txt").write_text("mine")
    said = fails(["map", "small.toml", "--check", "--store", "full"], capsys)
    assert said == "rigid: full is no running map, and is not empty"
    (folder / "deep.toml").write_text(SPEC + '[z]\nname = "t_end"\nvalues = [1.0, 2.0]\n')
    said = fails(["map", "deep.toml", "--what", "cost"], capsys)
    assert "what = 'cost': a picture of more than two axes shows the share" in said


def test_a_file_that_is_no_text_is_refused(folder: Path, capsys: Capture) -> None:
    (folder / "small.toml").write_bytes(b"\xff\xfe\x00")
    assert "small.toml: is not UTF-8 text" in fails(["map", "small.toml"], capsys)


@pytest.mark.parametrize("suffix", [".npz", ".png"])
@pytest.mark.parametrize("make", [os.mkdir, os.mkfifo])
def test_an_output_that_cannot_be_written_is_one_line_before_any_work(
    make: Callable[[Path], None], suffix: str, folder: Path, capsys: Capture
) -> None:
    make(folder / f"b{suffix}")
    message = fails(["map", "small.toml", "--samples", "1", "--out", "b"], capsys)
    assert f"--out: path = 'b{suffix}': must be new or a regular file" in message
    assert made(folder) == {f"b{suffix}"}


def test_a_wrong_variable_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setenv("RIGID_NUM_THREADS", "many")
    expected = "RIGID_NUM_THREADS = 'many': must be a whole number of at least 1"
    assert expected in fails(["map", "small.toml"], capsys)
    assert expected in fails(["info"], capsys)


@brief
def test_threads_come_from_the_variable(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setenv("RIGID_NUM_THREADS", "3")
    assert main(["map", "small.toml"]) == 0
    assert "on 3 threads" in capsys.readouterr().out
    assert main(["map", "small.toml", "--threads", "1", "--force"]) == 0
    assert "on 1 thread\n" in capsys.readouterr().out


def test_an_instruction_set_that_is_not_there_is_one_line() -> None:
    done = run_python("-m", "rigid", "info", check=False, RIGID_ISA="sse9")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("rigid: RIGID_ISA = 'sse9' is not available here; available: ")
    assert done.stderr.count("\n") == 1


@brief
def test_an_ascii_terminal_is_no_reason_to_lose_a_map(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = BytesIO()
    monkeypatch.setattr("sys.stdout", TextIOWrapper(shown, encoding="ascii"))
    assert main(["map", "small.toml"]) == 0
    assert b"kg m\\xb2" in shown.getvalue()
    assert made(folder) == {"small.npz", "small.png"}


@pytest.mark.parametrize("what", ["map", "report"])
@pytest.mark.parametrize("failing", ["print", "plot"])
def test_data_is_saved_before_it_is_printed_and_drawn(
    what: str, failing: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    names = {
        ("map", "print"): "rigid.store.result.summary",
        ("map", "plot"): "rigid.store.result.plot_map",
        ("report", "print"): "rigid.reports.result.report_text",
        ("report", "plot"): "rigid.reports.result.plot_report",
    }
    monkeypatch.setattr(names[what, failing], fail)
    arguments = ["--seconds", "0.1", "--method", "rk4"] if what == "report" else ["--samples", "1"]
    source = "thrown-box" if what == "report" else "small.toml"
    with pytest.raises(ZeroDivisionError):
        main([what, source, "--out", "a", *arguments])
    assert made(folder) == {"a.npz" if what == "map" else "a.json"}


def test_ctrl_c_while_the_picture_is_drawn_leaves_the_data(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    def press(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("rigid.store.result.plot_map", press)
    assert main(["map", "small.toml"]) == 130
    output, errors = capsys.readouterr()
    assert errors == "rigid: interrupted; the map is safe in small.npz, there is no picture\n"
    assert output.endswith("data        small.npz\n")
    assert made(folder) == {"small.npz"}


@brief
@pytest.mark.parametrize(
    ("number", "code", "told", "files"),
    [
        (signal.SIGINT, 130, "rigid: interrupted\n", set()),
        (signal.SIGTERM, 143, "the map written is partial", {"small.npz", "small.png"}),
    ],
)
def test_a_second_ctrl_c_ends_a_command_without_a_file_and_sigterm_is_ctrl_c_once(
    number: signal.Signals,
    code: int,
    told: str,
    files: set[str],
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
) -> None:
    """Some programs send SIGTERM to a process and to its group: that must not lose the map."""

    def twice(progress: rigid.Progress) -> None:
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)

    def interrupted(spec: rigid.MapSpec, **options: Any) -> rigid.StabilityMap:
        with in_blocks(1):
            return run_map(spec, **{**options, "progress": twice})

    monkeypatch.setattr("rigid.cli.run_map", interrupted)
    with sigint(signal.default_int_handler):
        assert main(["map", "small.toml"]) == code
    assert told in capsys.readouterr().err
    assert made(folder) == files
    if files:
        assert rigid.load_map("small.npz").samples.sum() == 10


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_while_the_data_is_saved_waits_for_it(
    number: signal.Signals,
    code: int,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
) -> None:
    def pressed(data: MapData, path: Path) -> Path:
        os.kill(os.getpid(), number)
        return write_map(data, path)

    monkeypatch.setattr("rigid.store.result.write_map", pressed)
    with sigint(signal.default_int_handler):
        assert main(["map", "small.toml"]) == code
    assert "the map is safe in small.npz, there is no picture" in capsys.readouterr().err
    assert rigid.load_map("small.npz").complete
    assert made(folder) == {"small.npz"}
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@brief
@pytest.mark.parametrize(
    ("limit", "when", "told"),
    [
        (100, "at first", "'small.npz'"),
        (100, "then", "'small.npz'; the map is not saved"),
        (20_000, "then", "'small.png'; the map is safe in small.npz"),
    ],
)
def test_a_full_disk_is_told_with_what_is_safe(
    limit: int,
    when: str,
    told: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
) -> None:
    """Files cannot grow beyond a limit from a moment on."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))

    def computed(spec: rigid.MapSpec, **options: Any) -> rigid.StabilityMap:
        result = run_map(spec, **options)
        fill()
        return result

    for suffix in (".npz", ".png"):
        (folder / f"small{suffix}").write_bytes(b"old")
    monkeypatch.setattr("rigid.cli.run_map", computed)
    try:
        if when == "at first":
            fill()
        assert main(["map", "small.toml", "--force"]) == 74
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    output, errors = capsys.readouterr()
    assert errors == f"rigid: [Errno 27] File too large: {told}\n"
    assert (folder / "small.png").read_bytes() == b"old"
    assert made(folder) == {"small.npz", "small.png"}
    if "safe" in told:
        assert rigid.load_map(folder / "small.npz").complete
    else:
        assert (folder / "small.npz").read_bytes() == b"old"
    assert bool(output) == (when == "then")


def test_a_map_whose_folder_is_gone_is_saved_elsewhere(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    (folder / "there").mkdir()
    (folder / "spare").mkdir()

    def computed(spec: rigid.MapSpec, **options: Any) -> rigid.StabilityMap:
        result = run_map(spec, **options)
        (folder / "there").rmdir()
        return result

    monkeypatch.setattr("rigid.cli.run_map", computed)
    monkeypatch.setattr("tempfile.tempdir", str(folder / "spare"))
    assert main(["map", "small.toml", "--out", "there/a"]) == 74
    (spare,) = (folder / "spare").iterdir()
    assert f"'there/a.npz'; the map is safe in {spare}\n" in capsys.readouterr().err
    assert rigid.load_map(spare).complete


@brief
@pytest.mark.parametrize("arguments", [["info"], ["maps"], ["map", "small.toml"]])
def test_a_reader_that_went_away_is_no_error(
    arguments: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """As after ``rigid maps | head -1``; a map is written all the same."""
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as closed:
        monkeypatch.setattr("sys.stdout", closed)
        assert main(arguments) == 0
    assert capsys.readouterr().err == ""
    assert made(folder) == ({"small.npz", "small.png"} if arguments[0] == "map" else set())


def test_without_matplotlib_the_data_is_written_and_the_rest_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    for name in ("matplotlib", *filter(re.compile(r"matplotlib\.").match, sys.modules)):
        monkeypatch.setitem(sys.modules, name, None)
    assert main(["map", "small.toml"]) == 0
    told = capsys.readouterr().out
    assert "none: plotting needs matplotlib: pip install 'rigid-rotation[maps]'" in told
    assert made(folder) == {"small.npz"}


def test_the_module_is_the_command_too(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr("sys.argv", ["rigid", "map", "nothing"])
    with pytest.raises(SystemExit, match="2"):
        runpy.run_module("rigid", run_name="__main__")
    assert capsys.readouterr().err.startswith("rigid: no built-in map is called 'nothing'")


def test_measures_are_told_and_drawn(folder: Path, capsys: Capture) -> None:
    asked = ["map", "small.toml", "--set", 'run.measure=["flips", "time_to_leave"]']
    drawn = ["--what", "quantile 0.9 of flips", "--no-progress"]
    assert main([*asked, *drawn]) == 0
    told = capsys.readouterr().out
    assert "measured    flips(2): mean " in told
    assert "measured    time_to_leave: mean " in told
    assert made(folder) == {"small.npz", "small.png"}
    result = rigid.load_map("small.npz")
    bodies, mean, least, largest = result.measures["flips"].totals()
    assert (bodies, least, largest) == (
        result.samples.sum(),
        np.nanmin(result.measures["flips"].least),
        np.nanmax(result.measures["flips"].largest),
    )
    each = result.measures["flips"]
    assert mean == pytest.approx(np.nansum(each.mean * each.count) / bodies, rel=1e-15)
    assert main([*asked, "--json", "--force", "--no-progress"]) == 0
    facts = json.loads(capsys.readouterr().out)["measures"]
    assert facts["flips(2)"] == {"bodies": bodies, "mean": mean, "least": least, "largest": largest}


@pytest.mark.parametrize(
    "arguments",
    [
        ["map", "smal.npz"],
        ["map", "smal.toml"],
        ["section", "smal.toml"],
        ["report", "smal.toml"],
        ["explore", "smal.npz"],
        ["diff", "smal.npz", "small.toml"],
        ["diff", "small.toml", "smal.npz"],
        ["verify", "smal.npz"],
        ["status", "smal.rigid"],
        ["resume", "smal.rigid"],
        ["pack", "smal.rigid", "small.npz"],
        ["merge", "smal.rigid", "--into", "all.rigid"],
    ],
)
def test_a_missing_file_is_told_alike_by_all_commands(
    arguments: list[str], folder: Path, capsys: Capture
) -> None:
    said = fails(arguments, capsys)
    missing = next(name for name in arguments if name.startswith("smal."))
    assert said.startswith(f"rigid: {missing}: there is no such file or folder")
    assert made(folder) == set()


def test_a_map_that_is_not_computed_yet_is_computed_first(folder: Path, capsys: Capture) -> None:
    said = fails(["explore", "thrown-box"], capsys)
    assert said.endswith("is a built-in map and no file; compute it: rigid map thrown-box")
    (folder / "thrown-box.npz").touch()
    said = fails(["explore", "thrown-box"], capsys)
    assert said.endswith("is a built-in map and no file; did you mean thrown-box.npz?")


@brief
def test_a_map_is_checked_without_a_computation(folder: Path, capsys: Capture) -> None:
    """The plan is the map's, the bodies are those of three possible pixels in four."""
    assert main(["map", "small.toml", "--check"]) == 0
    shown = facts_of(capsys.readouterr().out)
    assert made(folder) == set()
    assert shown["map"] == "A small map"
    assert shown["bodies"] == "90 in 9 pixels"
    assert shown["would"] == "write small.npz, small.png"
    assert main(["map", "small.toml", "--check", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert main(["map", "small.toml", "--no-progress"]) == 0
    result = rigid.load_map("small.npz")
    assert facts["bodies"] == result.samples.sum()
    assert facts["plan"] == result.plan.to_dict()
    assert f"plan        {result.plan.method_words()}" in capsys.readouterr().out
    assert shown["plan"].startswith(result.plan.method_words())
    assert shown["left"] == f"out    {'; '.join(result.plan.left_out)}"
    assert "--out = 'small.npz': exists; take" in fails(["map", "small.toml", "--check"], capsys)


def test_a_check_tells_what_a_map_costs_at_most(folder: Path, capsys: Capture) -> None:
    method = ["--set", "run.method=rk4"]
    assert main(["map", "small.toml", "--check", "--threads", "1", *method]) == 0
    cost: Any = re.search(r"cost +about (\S+) s on 1 free thread\n", capsys.readouterr().out)
    assert float(cost[1]) > 0.0
    assert main(["map", "small.toml", "--check", "--half-width", "0.1", "--threads", "2"]) == 0
    shown = capsys.readouterr().out
    assert "bodies      at most 1,152 in 9 pixels" in shown
    assert main(["map", "small.toml", "--check", "--half-width", "0.1", "--budget", "50"]) == 0
    assert "bodies      at most 50 in 9 pixels" in capsys.readouterr().out
    assert re.search(r"cost +at most \S+ s on 2 free threads", shown)


@brief
def test_a_check_of_a_part_is_of_its_bodies(folder: Path, capsys: Capture) -> None:
    bodies = 0
    for part in ("1/2", "2/2"):
        asked = ["--check", "--json", "--store", "new.rigid", "--part", part]
        assert main(["map", "small.toml", *asked]) == 0
        facts = json.loads(capsys.readouterr().out)
        assert facts["seconds"] > 0.0
        bodies += facts["bodies"]
    assert bodies == 90
    assert made(folder) == set()


@brief
@pytest.mark.filterwarnings("default")
def test_a_warning_is_a_line_of_the_command(folder: Path, capsys: Capture) -> None:
    box = SPEC.replace("moments = [1.0, 1.5, 2.0]", "box = [250, 80, 10]\nmass = 0.3")
    (folder / "small.toml").write_text(box.replace('"I1"', '"b"'))
    assert main(["map", "small.toml", "--check"]) == 0
    assert capsys.readouterr().err.startswith("rigid: warning: sides = (250, 80, 10), mass = 0.3: ")


def test_help_explains_every_exit_code(capsys: Capture) -> None:
    assert main(["help", "exit-codes"]) == 0
    told = unwrapped(capsys.readouterr().out, 10).splitlines()
    codes = [line[:10].strip() for line in told]
    assert {code: line[10:] for code, line in zip(codes, told, strict=True)} == EXIT_CODES
    assert [int(code) for code in codes[:-1]] == [DONE, SAYS_NO, REFUSED, WRITE_ERROR, UNFINISHED]


# The command in a terminal: help, versions, templates, JSON, formats; no file is lost.


def test_the_version_is_that_of_the_library(capsys: Capture) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"rigid {rigid.__version__}\n"


def test_the_bare_command_shows_help(capsys: Capture) -> None:
    assert main([]) == 0
    output = capsys.readouterr().out
    assert output.startswith("usage: rigid")
    assert "rigid map thrown-box" in output
    assert main(["help"]) == 0
    assert capsys.readouterr().out == output


def test_each_command_stands_in_one_group_of_the_help(capsys: Capture) -> None:
    named = [name for names in GROUPS.values() for name in names]
    assert sorted(named) == sorted(make_parser().commands())
    assert main(["help"]) == 0
    output = capsys.readouterr().out
    groups = [output.index(f"\n{title}:\n") for title in GROUPS]
    assert groups == sorted(groups)
    assert all(output.count(f"\n  {name} ") == 1 for name in named)
    message = fails(["help", "mapp"], capsys)
    assert "TOPIC = 'mapp': did you mean 'map'? must be one of 'map'" in message


def test_help_on_a_command_is_its_own(capsys: Capture) -> None:
    for name in make_parser().commands():
        assert main(["help", name]) == 0
        told = capsys.readouterr().out
        with pytest.raises(SystemExit) as stop:
            main([name, "--help"])
        assert stop.value.code == 0
        assert capsys.readouterr().out.rstrip() == told.rstrip()


@pytest.mark.parametrize("command", ["map", "section", "report", "extremes", "validation", "new"])
def test_help_has_examples_and_they_are_understood(command: str, capsys: Capture) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    _, _, examples = capsys.readouterr().out.partition("examples:\n")
    lines = [line.split("   ")[0].strip() for line in examples.strip("\n").split("\n  ")]
    assert lines
    for line in lines:
        words = line.split(" > ")[0].split()
        assert words[0] == "rigid"
        make_parser().parse_args(words[1:])


@pytest.mark.parametrize(
    ("command", "names"),
    [(kind, names_of(kind)) for kind in ("map", "section", "report")],
)
def test_a_specification_that_is_shown_or_new_can_be_computed(
    command: str, names: list[str], folder: Path, capsys: Capture
) -> None:
    for name in names:
        assert main([command, "--show", name]) == 0
        shown = capsys.readouterr().out
        assert main(["new", command, f"{name}.toml", "--like", name]) == 0
        assert f"rigid {command} {name}.toml" in capsys.readouterr().out
        assert (folder / f"{name}.toml").read_text() == shown
    assert main(["new", command]) == 0
    assert (folder / f"my-{command}.toml").exists()


def test_a_new_file_replaces_none_unless_told(folder: Path, capsys: Capture) -> None:
    before = (folder / "small.toml").read_text()
    message = fails(["new", "map", "small.toml"], capsys)
    assert (
        "file = 'small.toml': exists; take another name, or replace the file with --force"
        in message
    )
    assert (folder / "small.toml").read_text() == before
    assert main(["new", "map", "small.toml", "--force"]) == 0
    assert (folder / "small.toml").read_text() != before
    capsys.readouterr()
    assert "file = 'small.txt': must end in .toml" in fails(["new", "map", "small.txt"], capsys)
    (folder / "d.toml").mkdir()
    assert "must be new or a regular file" in fails(["new", "map", "d.toml"], capsys)
    assert "no built-in map is called 'x'" in fails(["new", "map", "--like", "x"], capsys)


@brief
@pytest.mark.parametrize("suffix", [".npz", ".png"])
def test_results_replace_no_file_unless_told(suffix: str, folder: Path, capsys: Capture) -> None:
    (folder / f"small{suffix}").write_bytes(b"mine")
    message = fails(["map", "small.toml", "--samples", "1"], capsys)
    assert f"--out = 'small{suffix}': exists; take another name, or replace the file" in message
    assert (folder / f"small{suffix}").read_bytes() == b"mine"
    assert main(["map", "small.toml", "--samples", "1", "--force"]) == 0
    assert (folder / f"small{suffix}").read_bytes() != b"mine"


@pytest.mark.parametrize(
    ("suffix", "begins"),
    [(".pdf", b"%PDF"), (".svg", b"<?xml"), (".png", b"\x89PNG"), (".jpg", b"\xff\xd8")],
)
def test_the_suffix_chooses_the_format_of_the_picture(
    suffix: str, begins: bytes, folder: Path
) -> None:
    assert main(["map", "small.toml", "--samples", "1", "--out", f"a{suffix}"]) == 0
    assert (folder / f"a{suffix}").read_bytes().startswith(begins)
    assert rigid.load_map(folder / "a.npz").complete
    assert {path.name for path in folder.iterdir()} == {"small.toml", "a.npz", f"a{suffix}"}


@brief
def test_a_key_of_the_specification_is_set(folder: Path) -> None:
    changes = ["--set", "run.t_end=5", "--set", "run.method=rk4", "--set", "x.values=[0.9, 1.1]"]
    assert main(["map", "small.toml", "--set", "title=Other", *changes]) == 0
    spec = rigid.load_map(folder / "small.npz").spec
    assert (spec.t_end, spec.method, spec.title) == (5.0, "rk4", "Other")
    assert spec.axes[0].values == (0.9, 1.1)


@brief
def test_json_tells_a_map(folder: Path, capsys: Capture) -> None:
    assert main(["map", "small.toml", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    result = rigid.load_map(folder / facts["data"])
    assert rigid.MapSpec.from_dict(facts["spec"]) == result.spec
    assert facts["stable"] == int(result.stable.sum())
    assert facts["theory"]["disagreeing"] == int(result.disagreement().sum())
    assert (folder / facts["picture"]).exists()
    assert facts["complete"]


def test_json_tells_lists_sections_reports_and_the_build(folder: Path, capsys: Capture) -> None:
    def told(*arguments: str) -> dict[str, object]:
        assert main([*arguments, "--json"]) == 0
        facts: dict[str, object] = json.loads(capsys.readouterr().out)
        return facts

    assert list(told("maps")) == names_of("map")
    assert list(told("sections")) == names_of("section")
    assert list(told("reports")) == names_of("report")
    assert told("info")["version"] == rigid.__version__
    section = told("section", "kovalevskaya", "--bodies", "1", "--set", "run.points=5")
    assert (section["bodies"], section["points"]) == (1, 5)
    report = told("report", "lagrange-top", "--method", "rk4", "--seconds", "0.2")
    assert report["name"] == "lagrange-top"
    counts = told("extremes", "spin", "--method", "exact")["counts"]
    assert isinstance(counts, dict)
    assert sum(counts.values()) > 0


def test_an_undetected_error_is_told_and_is_no_success(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    case, words = cases()[0], "the error 2.0e-03 is above 1.0e-08, and the status does not tell\n"
    cell = Cell(
        case=case,
        method="rk4",
        error=2e-3,
        bound=1e-8,
        verdict=UNDETECTED_ERROR,
        reason="ok",
        seconds=0.1,
    )
    monkeypatch.setattr("rigid.cli.extremes", lambda *_, **__: rigid.Extremes((cell,)))
    assert main(["extremes"]) == SAYS_NO
    assert capsys.readouterr().err == f"rigid: {case.family}, {case.name}, rk4: {words}"


def test_without_a_terminal_a_line_tells_the_progress_every_ten_seconds(
    monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    elapsed = 0
    monkeypatch.setattr("time.perf_counter", lambda: float(elapsed))
    with reporting(None, 36) as tell:
        for elapsed in range(1, 36):
            tell(elapsed)
    assert capsys.readouterr().err.splitlines() == [
        "rigid: 28% done after 10 s, about 26 s to go",
        "rigid: 56% done after 20 s, about 16 s to go",
        "rigid: 83% done after 30 s, about 6 s to go",
    ]
    with reporting(False, 36, begun=-60.0) as tell:
        tell(1)
    assert capsys.readouterr().err == ""


def test_a_long_message_is_wrapped_in_a_terminal() -> None:
    code = "import sys; from rigid.cli import main; sys.exit(main(['mapp']))"
    with in_terminal("-c", code, columns=60) as (process, reader):
        shown = read(reader).decode()
        assert process.wait(PATIENCE) == 2
    lines = shown.replace("\r", "").splitlines()
    assert lines[0] == "rigid: COMMAND = 'mapp': unknown; did you mean 'map'?"
    assert all(line.startswith("  ") for line in lines[1:])
    assert len(lines) >= 2
    assert max(map(len, lines)) <= 60
    assert "validation" in shown


# Eighty columns


def widest(text: str) -> int:
    """Length of the longest line, of those that could be broken at a space."""
    return max((len(line) for line in text.splitlines() if " " in line.strip()), default=0)


QUICK = ["--no-progress", "--force"]
STORED = [*QUICK, "--samples", "2", "--store", "run.rigid"]


@pytest.mark.parametrize("topic", [*make_parser().commands(), "exit-codes", ""])
def test_help_has_eighty_columns(topic: str, capsys: Capture) -> None:
    assert main(["help", topic] if topic else []) == 0
    assert 0 < widest(capsys.readouterr().out) <= WIDTH


@brief
@pytest.mark.parametrize(
    "command",
    [
        ["maps"],
        ["sections"],
        ["reports"],
        ["info"],
        ["new", "map", "a-map-with-a-long-name-of-many-words.toml"],
        ["section", "kovalevskaya", "--bodies", "1", *QUICK, "--set", "run.points=3"],
        ["report", "satellite", "--seconds", "0.3", *QUICK],
        ["report", "lagrange-top", "--long", "--method", "rk4", "--seconds", "0.3", *QUICK],
        ["extremes", "lamina", "--method", "dop853"],
        ["validation", "flip-period", "geometric-phase"],
        *(["map", name, "--check"] for name in ("small.toml", "apophis", "hyperion")),
        ["map", "small.toml", "--check", "--part", "1/2", "--store", "new.rigid"],
    ],
    ids=" ".join,
)
def test_a_command_prints_eighty_columns(command: list[str], capsys: Capture) -> None:
    assert main(command) == 0
    assert 0 < widest(capsys.readouterr().out) <= WIDTH


@pytest.mark.parametrize("name", names_of("map"))
def test_a_built_in_map_prints_eighty_columns(name: str, capsys: Capture) -> None:
    few = ["--set", "x.count=2", "--set", "y.count=2", "--samples", "2", *QUICK]
    assert main(["map", name, *few]) == 0
    told = capsys.readouterr().out
    assert 0 < widest(told) <= WIDTH
    assert "\nleft out    " in told


@brief
def test_the_commands_of_a_store_print_eighty_columns(capsys: Capture) -> None:
    for command, code in (
        (["map", "small.toml", *STORED, "--part", "1/2"], 75),
        (["status", "run.rigid"], 0),
        (["pack", "run.rigid", "run.npz"], 75),
        (["resume", "run.rigid", *QUICK], 0),
        (["status", "run.rigid"], 0),
        (["pack", "run.rigid", "run.npz", "--force"], 0),
        (["verify", "run.rigid"], 0),
        (["map", "small.toml", *QUICK, "--samples", "3", "--out", "other"], 0),
        (["diff", "run.npz", "other.npz"], 1),
        (["merge", "run.rigid", "--into", "all.rigid"], 0),
    ):
        assert main(command) == code, command
        assert widest(capsys.readouterr().out) <= WIDTH, command


def test_all_numbers_of_the_literature_have_eighty_columns() -> None:
    """Of each entry the number of its model, where it has one, else half of the number."""
    compared = [
        Compared(entry=entry, number=entry.model if entry.reason else entry.value / 2, seconds=0.0)
        for entry in entries()
    ]
    table = str(Validation(tuple(compared)))
    assert widest(table) <= WIDTH
    for row in compared:
        assert row.agrees or f"* {row.entry.name}: {row.verdict}; " in table


def test_all_extreme_cases_have_eighty_columns() -> None:
    verdicts = ["right", "flagged", "step limit", "not finite", "drifted", "refused", "unknown"]
    cells = tuple(
        Cell(case=case, method="", error=1e-9, bound=1e-8, verdict=one, reason="", seconds=99.0)
        for case in cases()
        for one in [*verdicts, *verdicts, UNDETECTED_ERROR]
    )
    table = str(rigid.Extremes(cells))
    assert widest(table) <= WIDTH
    assert all(case.name in table for case in cases())


@pytest.mark.parametrize(
    "command",
    [
        ["mapp"],
        ["map", "small.toml", "--set", "y.name=nosie"],
        ["map", "thrown-bix"],
        ["map", "small.toml", "--what", "mean of flips"],
        ["report", "lagrange-top", "--method", "rk5"],
        ["extremes", "pancake"],
        ["validation", "moon"],
        ["help", "x"],
    ],
    ids=" ".join,
)
def test_a_message_has_eighty_columns(
    command: list[str], monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    try:
        code: object = main(command)
    except SystemExit as stop:
        code = stop.code
    told = capsys.readouterr().err
    assert code == 2
    assert 0 < widest(told) <= WIDTH
    assert not told.endswith("\n\n")
