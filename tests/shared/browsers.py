"""Chromium for the tests of pages: Playwright's own, or that of the system.

``python tests/shared/browsers.py`` says whether it starts, and which version it is.
"""

import io
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

__all__ = ["NoBrowserError", "Opened", "chromium"]

# The software renderer of Chromium: machines that run tests have no graphics card.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


class NoBrowserError(Exception):
    """Why pages cannot be opened on this machine."""


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser with WebGL2; NoBrowserError if there is none."""
    try:
        from playwright import sync_api as playwright
    except ImportError as error:
        raise NoBrowserError("needs playwright") from error
    found = shutil.which("chromium") or shutil.which("google-chrome")
    with playwright.sync_playwright() as driver:
        try:
            browser = driver.chromium.launch(executable_path=found, args=FLAGS)
        except playwright.Error as error:
            reason = f"Chromium does not start: {str(error).splitlines()[0]}"
            raise NoBrowserError(reason) from error
        try:
            page = browser.new_page()
            drawn = page.evaluate("!!document.createElement('canvas').getContext('webgl2')")
            page.close()
            if not drawn:
                raise NoBrowserError("Chromium has no WebGL2")
            yield browser
        finally:
            browser.close()


class Opened:
    """A page in the browser, once it shows an element, and what it said and asked for."""

    def __init__(
        self,
        browser: Any,
        path: Path,
        *,
        address: str = "",
        width: int = 1280,
        height: int = 720,
        scheme: str = "light",
        touch: bool = False,
        before: str | None = None,
        functions: Mapping[str, Callable[..., object]] | None = None,
        shows: str | None = None,
    ) -> None:
        self.page = browser.new_page(
            viewport={"width": width, "height": height},
            color_scheme=scheme,
            reduced_motion="reduce",
            has_touch=touch,
            is_mobile=touch,
        )
        if before is not None:
            self.page.add_init_script(before)
        for name, function in (functions or {}).items():
            self.page.expose_function(name, function)
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(path.as_uri() + address)
        self.settle()
        if shows is not None:
            self.page.wait_for_selector(shows)

    def __getattr__(self, name: str) -> Any:
        """What the page of Playwright can do."""
        return getattr(self.page, name)

    def settle(self) -> None:
        """Wait until the page has drawn its state."""
        self.page.evaluate(
            "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )

    def press(self, key: str) -> None:
        """Press a key and wait."""
        self.page.keyboard.press(key)
        self.settle()

    def pixels(self, selector: str) -> NDArray[np.int64]:
        """The picture of the first such element, shape (height, width, 3)."""
        png = self.page.locator(selector).first.screenshot()
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), dtype=np.int64)

    def close(self) -> None:
        """Close the page, which has neither complained nor asked for anything."""
        # Drivers say in the console how they read pixels; that is no fault of a page.
        said = [text for text in self.said if "GL Driver Message" not in text]
        assert not said, f"the page said {said}"
        asked = [url for url in self.asked if not url.startswith(("file:", "data:"))]
        assert not asked, f"the page asked for {asked}"
        self.page.close()


if __name__ == "__main__":
    with chromium() as browser:
        print(f"Chromium {browser.version}")
