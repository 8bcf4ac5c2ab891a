"""Servers for the dashboard, embedded and complete, and a browser.

The fixtures live as long as the tests of this folder: Playwright keeps an event loop in the main thread, beside which
tests elsewhere could not run their own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from geoswarm.api import ApiSettings
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.api.conftest import LiveServer
from tests.dashboard.browser import Guard, KeptPages, chromium, guarded_context
from tests.integration.engines import celery_workers
from tests.servers import PostgresServer, RedisServer

expect.set_options(timeout=120_000)  # a busy machine takes its time; below the limit of pytest, so that a miss is told


@dataclass
class Site:
    """A running service; ``restart`` stops its api process and starts it again at the same address."""

    service: JobService
    settings: ApiSettings
    server: LiveServer

    @property
    def url(self) -> str:
        return self.server.url

    def key(self, owner: str, role: str = "submit") -> str:
        """A new API key."""
        return ApiKeys(self.service.store).create(owner, role)[0]  # type: ignore[arg-type]

    def stop(self) -> None:
        """Stop the api, workers go on."""
        self.server.stop()

    def start(self) -> None:
        """Start the api again where it was."""
        port = int(self.server.url.rpartition(":")[2])
        self.server = LiveServer(self.service, self.settings, port)


@contextmanager
def running(service: JobService, settings: ApiSettings) -> Iterator[Site]:
    """A site whose present server, not only its first one, is stopped at the end."""
    site = Site(service, settings, LiveServer(service, settings))
    try:
        yield site
    finally:
        site.stop()


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    with chromium() as started:
        yield started


@pytest.fixture(scope="package")
def embedded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """What `geoswarm serve` starts: SQLite, one worker process, no key."""
    folder: Path = tmp_path_factory.mktemp("embedded")
    api = ApiSettings(poll_seconds=0.05)
    with (
        open_engine(Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=1)) as engine,
        running(engine.service, api) as site,
    ):
        yield site


@pytest.fixture(scope="package")
def full(postgres_server: PostgresServer, redis_server: RedisServer) -> Iterator[Site]:
    """What an institution runs: PostgreSQL, Redis, a Celery worker, API keys."""
    postgres_server.start()
    redis_server.start()
    database = postgres_server.create_database()
    settings = Settings(database_url=database, broker_url=redis_server.create_database())
    api = ApiSettings(require_key=True, poll_seconds=0.05)
    with (
        open_engine(settings) as engine,
        celery_workers(settings, count=1, concurrency=2),
        running(engine.service, api) as site,
    ):
        yield site
    postgres_server.drop_database(database)


Opened = tuple[Page, Guard]


@pytest.fixture(scope="package")
def kept_pages(browser: Browser) -> KeptPages:
    return KeptPages(browser)


@pytest.fixture
def visit(browser: Browser, kept_pages: KeptPages) -> Iterator[Callable[..., Opened]]:
    """``page, guard = visit(site, "/", key=None, **options)``: a page without cookies and stored values.

    The first one of a test is kept for others, unless the options say more than its size and colours. What a test adds
    to the context of such a page (a clock, scripts, listeners) would stay: ``own=True`` asks for a new profile.
    A test that prepares the page before it opens what it looks at begins with "/health/live", which is short.
    """
    with ExitStack() as left:
        alone = True

        def opened(site: Site, path: str = "/", key: str | None = None, own: bool = False, **options: Any) -> Opened:
            nonlocal alone
            if alone and not own and options.keys() <= {"viewport", "color_scheme"}:
                page, guard = left.enter_context(kept_pages.page(site.url, **options))
            else:
                context, guard = left.enter_context(guarded_context(browser, site.url, **options))
                page = context.new_page()
            alone = False
            if key is not None:
                answer = page.context.request.post("/api/v1/session", data={"key": key})
                assert answer.status == 201, answer.text()
            page.goto(path)
            return page, guard

        yield opened
