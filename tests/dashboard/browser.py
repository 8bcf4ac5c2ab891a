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
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Error,
    Page,
    Request,
    Response,
    ViewportSize,
    WebError,
    sync_playwright,
)

__all__ = ["Guard", "KeptPages", "check_accessibility", "chromium", "guarded_context"]

PROGRAMS = ("chromium-headless-shell", "chromium", "chromium-browser")
ARGUMENTS = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--force-color-profile=srgb"]
WAITED_OUT = "net::ERR_ABORTED"  # a stream or request that ended because the page went elsewhere

DESK: ViewportSize = {"width": 1440, "height": 900}

SERIOUS = """([place, options]) => {
    const told = ({ id, impact }) => ["serious", "critical"].includes(impact) || id === "landmark-unique";
    for (const rule of axe._audit.rules) if (!told(rule)) options.rules[rule.id] = { enabled: false };
    return axe.run(place, options).then(({ violations }) => violations
        .filter(told)
        .map(({ id, help, nodes }) => [id, help, ...nodes.slice(0, 3).map(({ html }) => html.slice(0, 160))]));
}"""

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

    @contextmanager
    def watching(self, context: BrowserContext) -> Iterator[None]:
        """Collect what goes wrong in a context, and complain at the end."""
        listeners: dict[Any, Any] = {
            "console": self._console,
            "weberror": self._error,
            "request": self._request,
            "requestfailed": self._failed,
            "response": self._response,
        }
        for event, listener in listeners.items():
            context.on(event, listener)
        try:
            yield
        finally:
            for event, listener in listeners.items():
                context.remove_listener(event, listener)
        self.check()

    def _error(self, error: WebError) -> None:
        self.faults.append(f"error: {error.error}")

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
    """The system's Chromium, without windows where that is installed: it takes a quarter less processor time."""
    program = next(filter(None, map(shutil.which, PROGRAMS)), None)
    assert program is not None, "the tests of the dashboard need Debian's package chromium-headless-shell or chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def guarded_context(browser: Browser, origin: str, **options: Any) -> Iterator[tuple[BrowserContext, Guard]]:
    """A browser profile of its own on one server; at the end nothing may have gone wrong in it."""
    context = _new_context(browser, origin, **options)
    guard = Guard(origin)
    with guard.watching(context):
        try:
            yield context, guard
        finally:
            context.close()


def _new_context(browser: Browser, origin: str, **options: Any) -> BrowserContext:
    defaults: dict[str, Any] = {"viewport": DESK, "reduced_motion": "reduce"}
    context = browser.new_context(base_url=origin, **(defaults | options))
    context.set_default_timeout(120_000)
    return context


class KeptPages:
    """One page for each server, which a test leaves as it found it: its process has read Plotly and axe already.

    A page in a new profile starts a process that reads these megabytes again, which takes most of a test's time.
    """

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self._pages: dict[str, Page] = {}

    @contextmanager
    def page(
        self, origin: str, viewport: ViewportSize = DESK, color_scheme: Any = "light"
    ) -> Iterator[tuple[Page, Guard]]:
        """The page of a server, without cookies and stored values; at the end nothing may have gone wrong in it."""
        page = self._pages.pop(origin, None) or _new_context(self._browser, origin).new_page()
        page.set_viewport_size(viewport)
        page.emulate_media(media="null", color_scheme=color_scheme, reduced_motion="reduce")
        guard = Guard(origin)
        try:
            with guard.watching(page.context):
                yield page, guard
        finally:
            if self._cleared(page, f"{origin}/health/live"):
                self._pages[origin] = page
            else:
                page.context.close()

    def _cleared(self, page: Page, blank: str) -> bool:
        """Whether the page could be left, at a short answer of its server, without a trace of the test.

        No route answers: while a page has one, Chromium forgets what it keeps of scripts, Plotly among them.
        """
        try:
            page.unroute_all()
            page.goto(blank)
            page.evaluate("localStorage.clear(); sessionStorage.clear()")
            page.mouse.move(0, 0)
            page.context.clear_cookies()
        except Error:
            return False
        return len(page.context.pages) == 1


def check_accessibility(page: Page, place: str = "html") -> None:
    """No serious or critical finding of axe-core, and landmarks told apart.

    What it finds in order is not gathered, which takes half its time, and what is less than serious not looked for.

    Where the rest of a page is examined by another test, ``place`` selects what is new; it is waited for.
    """
    page.locator(place).first.wait_for()
    options = {
        "resultTypes": ["violations"],
        "preload": False,
        "rules": {"label-content-name-mismatch": {"enabled": True}},
    }
    page.evaluate(Axe().axe_script)
    serious = page.evaluate(SERIOUS, [place, options])
    assert serious == [], serious
