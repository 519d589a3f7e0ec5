"""The page that `chatter explore` opens, in a real browser."""

from __future__ import annotations

import json
import os
import re
import subprocess
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Route, sync_playwright

ROOT = Path(__file__).parents[2]
BINARY = os.environ.get("CHATTER", str(ROOT / "target/release/chatter"))
CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
# A page that is being worked on, in place of the one that is built in.
FOLDER = os.environ.get("CHATTER_PAGE")
KINDS = {".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml"}
# Nothing here takes nearly so long, in seconds; a machine that does other work may be slow.
LONGEST = 120.0


def until(holds: Callable[[], Any], what: str) -> Any:
    """Waits until something holds, and gives it."""
    end = time.monotonic() + LONGEST
    while time.monotonic() < end:
        found = holds()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"waited for {what}")


def chatter(*arguments: str, folder: Path | None = None) -> str:
    """What the command line says."""
    done = subprocess.run([BINARY, *arguments], capture_output=True, text=True, cwd=folder, check=False)
    return done.stdout + done.stderr


class Explorer:
    """A running explorer."""

    def __init__(self, model: str) -> None:
        self.process = subprocess.Popen(
            [BINARY, "explore", model, "--no-open"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()

    def questions(self) -> int:
        """How many questions are being answered."""
        with urllib.request.urlopen(self.address + "work") as reply:
            return int(json.load(reply)["questions"])


class View:
    """The page, as one uses it."""

    def __init__(self, page: Page, explorer: Explorer) -> None:
        self.page, self.explorer = page, explorer
        self.faults: list[str] = []
        page.on("pageerror", lambda error: self.faults.append(str(error)))
        page.on("console", lambda message: self.faults.append(message.text) if message.type == "error" else None)
        if FOLDER:
            page.route("**/*", self.from_folder)

    def from_folder(self, route: Route) -> None:
        name = re.sub(r"^http://[^/]+/\w+/", "", route.request.url).split("#")[0] or "index.html"
        path = Path(str(FOLDER)) / name
        if route.request.method == "GET" and path.is_file():
            route.fulfill(path=path, content_type=KINDS[path.suffix])
        else:
            route.continue_()

    def open(self, where: str = "") -> View:
        # A new hash alone is no new page.
        self.page.goto("about:blank")
        self.page.goto(self.explorer.address + where)
        return self

    def data(self, panel: str) -> dict[str, str]:
        """What a plot says of what it shows."""
        found = self.page.evaluate(f"({{ ...document.querySelector('#{panel} canvas')?.dataset }})")
        return dict(found)

    def complete(self) -> dict[str, str]:
        """Waits until the diagram is there."""

        def done() -> dict[str, str] | None:
            data = self.data("diagram")
            return data if data.get("state") in ("complete", "refused") else None

        # What was found: after a zoom it may be computing again at once.
        data: dict[str, str] = until(done, "the diagram")
        assert data["state"] == "complete", self.page.locator("#diagram .error").text_content()
        return data

    def motion(self, changed_from: str | None = None) -> dict[str, str]:
        """Waits until a motion is there, another than one of before."""
        until(lambda: self.data("history").get("end") not in (None, changed_from), "the motion")
        return self.data("history")

    def box(self) -> tuple[float, float]:
        """The ends of the swept parameter."""
        ends = [self.page.locator(f"#diagram input[aria-label={name}]").input_value() for name in ("from", "to")]
        return float(ends[0]), float(ends[1])

    def middle(self, panel: str) -> tuple[float, float]:
        canvas = self.page.locator(f"#{panel} canvas")
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        assert box is not None
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


@pytest.fixture(scope="session")
def explorer() -> Iterator[Explorer]:
    running = Explorer("pressure_relief_valve")
    yield running
    running.process.kill()
    running.process.wait()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        # Its own sandbox needs rights that a container has not.
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextmanager
def viewed(browser: Browser, explorer: Explorer, size: tuple[int, int] = (1440, 1000)) -> Iterator[View]:
    """A page that nothing is shown on yet; in the end it has had no fault."""
    wide, high = size
    context = browser.new_context(viewport={"width": wide, "height": high}, accept_downloads=True)
    view = View(context.new_page(), explorer)
    yield view
    # What is aborted by hand is told by the browser itself.
    assert [fault for fault in view.faults if "ERR_" not in fault] == []
    context.close()


@pytest.fixture
def view(browser: Browser, explorer: Explorer, request: pytest.FixtureRequest) -> Iterator[View]:
    with viewed(browser, explorer, getattr(request, "param", (1440, 1000))) as view:
        yield view
