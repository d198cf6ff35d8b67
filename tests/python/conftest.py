"""What holds for every test."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from map_texts import SMALL
from rigid.model import compiling


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Chromium; a test without it is skipped."""
    from browsers import NoBrowserError, chromium

    try:
        with chromium() as opened:
            yield opened
    except NoBrowserError as reason:
        pytest.skip(str(reason))


@pytest.fixture
def opens(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens pages, which at the end have neither complained nor asked for anything."""
    from browsers import Opened

    every: list[Opened] = []

    def open_page(*page: Any, **options: Any) -> Opened:
        every.append(Opened(browser, *page, **options))
        return every[-1]

    yield open_page
    for opened in every:
        opened.close()


@pytest.fixture
def folder(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder of commands, with the specification of their tests in ``small.toml``."""
    (tmp_path / "small.toml").write_text(getattr(request.module, "SPEC", SMALL))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands draw no map and measure its cost once, which take most of the time of small maps."""
    for name in ("BUDGET", "REPEATED"):
        monkeypatch.setattr(f"rigid._timing.{name}", 0.0)

    def save(content: Any, **_: object) -> None:
        content.write(bytes(30_000))

    axes = SimpleNamespace(figure=SimpleNamespace(savefig=save))
    monkeypatch.setattr("rigid.store.result.plot_map", lambda *_, **__: axes)


@pytest.fixture
def no_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if numba were not installed: Python calls its functions, and none was compiled before."""
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setattr(compiling, "_made", compiling._made.__wrapped__)


@pytest.fixture(params=["called", "compiled"])
def way(request: pytest.FixtureRequest) -> str:
    """With and without numba, if it is installed."""
    if request.param == "called":
        request.getfixturevalue("no_numba")
    else:
        pytest.importorskip("numba")
    return str(request.param)


@pytest.fixture(autouse=True)
def _pyplot_keeps_no_figure() -> Iterator[None]:
    """Where a test has imported pyplot, it keeps the figures of all later tests too."""
    yield
    pyplot: Any = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")
