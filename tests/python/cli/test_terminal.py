"""The command in a terminal: help, versions, templates, JSON, formats; no file is lost."""

import json
from pathlib import Path

import pytest
from test_command_line import fails

import rigid
from processes import PATIENCE, Capture
from rigid._checks.progress import reporting
from rigid._checks.shown import WIDTH
from rigid.cli import main
from rigid.cli.parser import GROUPS, make_parser
from rigid.cli.toml_table import names_of
from rigid.literature.validation import Compared, Validation, entries
from rigid.reports.stress import UNDETECTED_ERROR, Cell
from rigid.reports.stress_cases import cases
from terminals import in_terminal, read

pytestmark = pytest.mark.usefixtures("folder")


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
        with pytest.raises(SystemExit):
            main([name, "--help"])
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


def test_a_key_of_the_specification_is_set(folder: Path) -> None:
    changes = ["--set", "run.t_end=5", "--set", "run.method=rk4", "--set", "x.values=[0.9, 1.1]"]
    assert main(["map", "small.toml", "--set", "title=Other", *changes]) == 0
    spec = rigid.load_map(folder / "small.npz").spec
    assert (spec.t_end, spec.method, spec.title) == (5.0, "rk4", "Other")
    assert spec.axes[0].values == (0.9, 1.1)


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
