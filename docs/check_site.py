"""Check the built pages: ``python docs/check_site.py FOLDER``.

No page asks another server for anything or holds a placeholder. In Chromium no page scrolls
sideways on a phone, no table is wider than its page, no code of a guide is cut on a desk (what
programs print may be), films show their view on a phone and have the theme of the page, and the
search finds for each term of ``search_terms.py`` its page first. A page with each of these faults
is checked first.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "shared"))

from search_terms import TERMS

from browsers import NoBrowserError, chromium

PHONES, DESK = (320, 375), 1280
NO_GUIDES = ("api/", "decisions/")
LEAST_VIEW = 100
"""Pixels that the view of a film is high, at least."""

Fault = tuple[str, str]
"""Its kind and what is wrong, where."""

PLACEHOLDER = re.compile(r"\b(?:OWNER|TODO|FIXME)\b")
"""What somebody forgot to fill in."""

FAULTY = """<!doctype html>OWNER<link rel="stylesheet" href="https://example.org/a.css">
<div style="width: 2000px">wide</div>
<div class="table-wrapper" style="width: 9px; overflow: auto"><table><td>wide</table></div>
<div class="highlight-python"><pre style="width: 9px; overflow: auto">wide</pre></div>
<iframe></iframe>
<div class="film"><iframe srcdoc="<canvas class=stage style='height: 9px'></canvas>"></iframe></div>
"""
FAULTY_SEARCH = """<!doctype html><script>
const Search = {hasIndex: () => true, _parseQuery: term => [term],
    _performSearch: () => [["another page"]]};
</script>"""
UNSEEN = {"other server", "placeholder"}
KINDS = {*UNSEEN, "request", "page", "table", "code", "bare film", "view", "theme", "search"}
"""The faults of these pages; some need no browser."""

FIRST_FOUND = "term => Search._performSearch(...Search._parseQuery(term)).at(-1)?.[0] ?? 'nothing'"
"""The page that the JavaScript of the site shows first."""

OVERFLOWS = """() => {
    const wide = (query) => [...document.querySelectorAll(query)]
        .filter(one => one.scrollWidth > one.clientWidth + 1).map(one => one.textContent.trim());
    const CODE = "[class*=highlight-]:not(.highlight-text, .highlight-none) pre";
    const excess = document.documentElement.scrollWidth - document.documentElement.clientWidth;
    return { page: excess, table: wide(".table-wrapper"), code: wide(CODE) };
}"""


class Resources(HTMLParser):
    """What a browser loads for a page."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            loads = name in ("src", "srcset", "poster", "data", "xlink:href")
            if loads or (name == "href" and tag in ("link", "use", "image")):
                self.names += re.split(r"[\s,]+", value or "")


def read(path: Path) -> Iterator[Fault]:
    """What this page or style sheet loads from elsewhere, and what was not filled in."""
    text = path.read_text(encoding="utf-8")
    for found in PLACEHOLDER.finditer(text):
        yield "placeholder", f"{path}: {text[max(0, found.start() - 40) : found.end() + 40]}"
    names = re.findall(r"(?:url\(|@import)\s*[\"']?([^\"')\s;]+)", text)
    if path.suffix == ".html":
        resources = Resources()
        resources.feed(text)
        names += resources.names
    for name in names:
        if re.match(r"(?:\w+:)?//", name):
            yield "other server", f"{path}: {name}"


def looks(browser: Any, folder: Path, paths: list[Path]) -> Iterator[Fault]:
    """What is wrong with these pages in the browser."""
    page = browser.new_page()
    asked: list[str] = []

    def local(route: Any) -> None:
        if route.request.url.startswith(("file:", "data:", "blob:")):
            route.continue_()
        else:
            asked.append(route.request.url)
            route.abort()

    page.route("**/*", local)
    page.on("requestfailed", lambda request: asked.append(request.url))
    for path in paths:
        name = path.relative_to(folder).as_posix()
        page.set_viewport_size({"width": PHONES[-1], "height": 800})
        page.goto(path.as_uri())
        phone = page.evaluate(OVERFLOWS)
        if phone["page"] > 0:
            yield "page", f"{name}: {phone['page']} pixels too wide for a phone"
        yield from (("table", f"{name}, phone: {text[:60]}") for text in phone["table"])
        if page.locator("iframe:not(.film > iframe)").count():
            yield "bare film", f"{name}: a film is not in the class film"
        if not page.locator(".film > iframe").count():
            page.set_viewport_size({"width": DESK, "height": 800})
        else:
            yield from films(page, name)
        desk = page.evaluate(OVERFLOWS)
        yield from (("table", f"{name}, desk: {text[:60]}") for text in desk["table"])
        if not name.startswith(NO_GUIDES):
            for text in desk["code"]:
                yield "code", f"{name}: {max(text.splitlines(), key=len)}"
        yield from (("request", f"{name}: {url}") for url in asked)
        asked.clear()
    page.close()


def searched(browser: Any, folder: Path) -> Iterator[Fault]:
    """Terms whose page the search does not find first."""
    page = browser.new_page()
    page.goto((folder / "search.html").as_uri())
    page.wait_for_function("Search.hasIndex()")
    for expected, terms in TERMS.items():
        for term in terms:
            found = page.evaluate(FIRST_FOUND, term)
            if found != expected:
                yield "search", f"{term!r} finds {found}, not {expected}"
    page.close()


def films(page: Any, name: str) -> Iterator[Fault]:
    """What is wrong with the films of a page, which is left as wide as a desk."""
    for place in page.locator(".film > iframe").all():
        place.scroll_into_view_if_needed()
        film = place.element_handle().content_frame()
        view = film.wait_for_selector("canvas.stage", state="attached")
        for width in (*PHONES, DESK):
            page.set_viewport_size({"width": width, "height": 800})
            page.wait_for_timeout(200)
            height = film.evaluate("view => view.getBoundingClientRect().height", view)
            if height < LEAST_VIEW:
                yield "view", f"{name}, {width} pixels wide: the film is {height} pixels high"
        for theme in ("dark", "light"):
            page.evaluate("theme => { document.body.dataset.theme = theme; }", theme)
            page.wait_for_timeout(200)
            if film.evaluate("document.documentElement.dataset.theme") != theme:
                yield "theme", f"{name}: the film is not {theme}"


def check(folder: Path, browser: Any) -> tuple[int, list[Fault]]:
    """The number of pages below a folder, and their faults."""
    pages = sorted(folder.rglob("*.html"))
    shown = [page for page in pages if not {"_static", "_modules"} & set(page.parts)]
    faults = [fault for path in [*pages, *folder.rglob("*.css")] for fault in read(path)]
    if browser is not None:
        faults += looks(browser, folder, shown)
        faults += searched(browser, folder)
    return len(pages), faults


def report(folder: Path, browser: Any) -> None:
    """Say what was checked; end the process if something is wrong."""
    with TemporaryDirectory() as name:
        (Path(name) / "faulty.html").write_text(FAULTY, encoding="utf-8")
        (Path(name) / "search.html").write_text(FAULTY_SEARCH, encoding="utf-8")
        found = {kind for kind, _ in check(Path(name), browser)[1]}
        expected = KINDS if browser is not None else UNSEEN
        if found != expected:
            sys.exit(f"the faults {sorted(expected - found)} of a faulty page were not found")
    count, faults = check(folder, browser)
    if faults or not count:
        sys.exit("\n".join(f"{kind}: {text}" for kind, text in faults) or f"{folder} has no pages")
    widths = "in Chromium too" if browser is not None else "but not in a browser: none starts here"
    print(f"{count} pages checked, {widths}")


if __name__ == "__main__":
    try:
        with chromium() as browser:
            report(Path(sys.argv[1]).resolve(), browser)
    except NoBrowserError:
        report(Path(sys.argv[1]).resolve(), None)
