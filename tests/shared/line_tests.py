"""Which tests run which lines of the library, and how long each takes: a plugin of pytest.

    LINE_TESTS=FILE python -m pytest -n0 -p line_tests TESTS

A test is a function with all its cases. What a file of tests computes once, in a fixture or behind
a cache, may be on record for the first of its tests only: ask for the files of the tests, too.
"""

from __future__ import annotations

import ast
import json
import os
import re
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from difflib import SequenceMatcher
from functools import cache
from pathlib import Path

import pytest
from coverage import Coverage

ROOT = Path(__file__).parents[2]
LIBRARY = ROOT / "python" / "rigid"


class _Recorder:
    """Writes the lines of each test when the session ends."""

    def __init__(self, target: Path) -> None:
        self.target = target
        self.seconds: dict[str, float] = defaultdict(float)
        self.coverage = Coverage(data_file=None, source=[str(LIBRARY)], messages=False)
        self.coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        name = item.nodeid.partition("[")[0]
        self.coverage.switch_context(name)
        began = time.perf_counter()
        yield
        self.seconds[name] += time.perf_counter() - began
        self.coverage.switch_context("")

    def pytest_sessionfinish(self) -> None:
        self.coverage.stop()
        data = self.coverage.get_data()
        lines = {
            Path(file).relative_to(LIBRARY).as_posix(): {
                line: sorted(filter(None, names))
                for line, names in data.contexts_by_lineno(file).items()
            }
            for file in data.measured_files()
        }
        self.target.write_text(json.dumps({"seconds": self.seconds, "lines": lines}))


def pytest_configure(config: pytest.Config) -> None:
    if "LINE_TESTS" in os.environ:
        config.pluginmanager.register(_Recorder(Path(os.environ["LINE_TESTS"])))


class LineTests:
    """The tests of each line, as they were recorded.

    Parameters
    ----------
    records : list of Path
        What the plugin wrote.
    sources : Path
        The library as it was then; lines that have moved since are found.
    """

    def __init__(self, records: list[Path], sources: Path) -> None:
        self._sources = sources
        self.seconds: dict[str, float] = {}
        self._lines: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
        for record in records:
            found = json.loads(record.read_text())
            self.seconds |= found["seconds"]
            for module, lines in found["lines"].items():
                for line, names in lines.items():
                    self._lines[module][int(line)].update(names)
        self._size = Counter(
            name for lines in self._lines.values() for names in lines.values() for name in names
        )

    def of_line(self, module: str, line: int) -> list[str]:
        """Tests that run a line, those first that run little else than its module."""
        names = set[str]()
        for place, number in self._run_with(module, line):
            names |= self._lines[place].get(number, set())
        within = Counter(name for run in self._lines[module].values() for name in run & names)
        return sorted(names, key=lambda name: (-within[name] / self._size[name], name))

    def _run_with(self, module: str, line: int) -> Iterator[tuple[str, int]]:
        """The recorded lines that tell who runs this line."""
        path = [node for node in _nodes(LIBRARY / module) if _holds(node, line)]
        functions = [node for node in path if isinstance(node, ast.FunctionDef)]
        if functions:
            first = functions[-1].body[0].lineno
            body = range(first, (functions[-1].end_lineno or first) + 1)
            known = [n for n in body if self._then(module, n) in self._lines[module]]
            if line < first or not known:  # an argument's default, or a function that is compiled
                yield from ((module, self._then(module, number) or number) for number in known)
                yield from self._with_name(module, [functions[-1].name] if not known else [])
            else:
                # A line within a statement may not be on record; the next one above is.
                found = max((number for number in known if number <= line), default=line)
                yield module, self._then(module, found) or found
            return
        # A constant or an attribute: where its name stands.
        named = [node for node in path if isinstance(node, ast.Assign | ast.AnnAssign)]
        targets = [
            ast.unparse(target)
            for node in named[-1:]
            for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        ]
        yield from self._with_name(module, targets)

    def _with_name(self, module: str, names: list[str]) -> Iterator[tuple[str, int]]:
        """The lines with one of the names; without names, those of the module."""
        word = re.compile("|".join(rf"\b{re.escape(name)}\b" for name in names))
        for place in sorted(LIBRARY.rglob("*.py")) if names else [LIBRARY / module]:
            inside = place.relative_to(LIBRARY).as_posix()
            for number, text in enumerate(place.read_text().splitlines(), 1):
                if word.search(text):
                    yield inside, self._then(inside, number) or number

    def _then(self, module: str, line: int) -> int | None:
        """The number that a line had when the tests were recorded."""
        return self._moved(module).get(line)

    @cache  # noqa: B019  # one object for each run
    def _moved(self, module: str) -> dict[int, int]:
        old = self._sources / module
        if not old.is_file():
            return {}
        before, now = (place.read_text().splitlines() for place in (old, LIBRARY / module))
        return {
            block.b + k + 1: block.a + k + 1
            for block in SequenceMatcher(None, before, now, autojunk=False).get_matching_blocks()
            for k in range(block.size)
        }


@cache
def _nodes(path: Path) -> list[ast.AST]:
    """Statements of a module, the outer ones first."""
    return [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.stmt)]


def _holds(node: ast.AST, line: int) -> bool:
    assert isinstance(node, ast.stmt)
    return node.lineno <= line <= (node.end_lineno or 0)
