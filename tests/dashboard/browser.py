"""A page that fails its test when the browser complains, and the check of accessibility."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page, Request, Response, sync_playwright

__all__ = ["Guard", "check_accessibility", "chromium", "guarded_context"]

ARGUMENTS = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--force-color-profile=srgb"]
WAITED_OUT = "net::ERR_ABORTED"  # a stream or request that ended because the page went elsewhere

DRIVER = "GL Driver Message"  # Chromium without a graphics card says how slow it is


@dataclass
class Guard:
    """Collects what must not happen; ``allow`` names, as regular expressions, what a test provokes on purpose."""

    origin: str
    faults: list[str] = field(default_factory=list)
    allowed: list[str] = field(default_factory=list)

    def allow(self, *patterns: str) -> None:
        self.allowed += patterns

    def check(self) -> None:
        left = [fault for fault in self.faults if not any(re.search(pattern, fault) for pattern in self.allowed)]
        assert left == [], left

    def watch(self, context: BrowserContext) -> None:
        context.on("console", self._console)
        context.on("weberror", lambda error: self.faults.append(f"error: {error.error}"))
        context.on("request", self._request)
        context.on("requestfailed", self._failed)
        context.on("response", self._response)

    def _console(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and DRIVER not in message.text:
            self.faults.append(f"console {message.type}: {message.text} ({message.location.get('url', '')})")

    def _request(self, request: Request) -> None:
        address = urlsplit(request.url)
        if address.scheme not in ("data", "blob") and f"{address.scheme}://{address.netloc}" != self.origin:
            self.faults.append(f"request to another host: {request.url}")

    def _failed(self, request: Request) -> None:
        if request.failure != WAITED_OUT:
            self.faults.append(f"failed: {request.method} {request.url}: {request.failure}")

    def _response(self, response: Response) -> None:
        if response.status >= 400:
            self.faults.append(f"answer {response.status}: {response.request.method} {response.url}")


@contextmanager
def chromium() -> Iterator[Browser]:
    """The system's Chromium; nothing is downloaded."""
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    assert program is not None, "the tests of the dashboard need Debian's package chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def guarded_context(browser: Browser, origin: str, **options: Any) -> Iterator[tuple[BrowserContext, Guard]]:
    """A browser profile of its own on one server; at the end nothing may have gone wrong in it."""
    defaults: dict[str, Any] = {"viewport": {"width": 1440, "height": 900}, "reduced_motion": "reduce"}
    context = browser.new_context(base_url=origin, **(defaults | options))
    context.set_default_timeout(120_000)
    guard = Guard(origin)
    guard.watch(context)
    try:
        yield context, guard
    finally:
        context.close()
    guard.check()


def check_accessibility(page: Page, place: str = "html") -> None:
    """No serious or critical finding of axe-core, and landmarks told apart.

    What it finds in order is not gathered, which takes half its time.

    Where the rest of a page is examined by another test, ``place`` selects what is new; it is waited for.
    """
    page.locator(place).first.wait_for()
    options = {
        "resultTypes": ["violations"],
        "preload": False,
        "rules": {"label-content-name-mismatch": {"enabled": True}},
    }
    found = Axe().run(page, place, options).response["violations"]
    serious = [
        f"{violation['id']}: {violation['help']}: {[node['html'][:160] for node in violation['nodes'][:3]]}"
        for violation in found
        if violation["impact"] in ("serious", "critical") or violation["id"] == "landmark-unique"
    ]
    assert serious == [], serious
