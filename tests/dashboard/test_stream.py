"""One stream a job and browser: shared by tabs, handed on, and taken up again after a restart of the service."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import BrowserContext, Page, Request, expect

from geoswarm.solver.problem import parse_problem
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.settings import Settings
from tests.api.conftest import wait_for_end
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import LONG, SOON, counted, state, textbook

Visit = Callable[..., Opened]


@pytest.fixture
def job(embedded: Site) -> Iterator[str]:
    """A job that goes on for long."""
    view, _ = embedded.service.submit(parse_problem(textbook(name="long", **LONG)))
    yield view.id
    if embedded.service.get(view.id).state in ("queued", "running", "paused"):
        embedded.service.cancel(view.id)


def streams(context: BrowserContext) -> list[str]:
    """Addresses of the streams that were opened from now on."""
    found: list[str] = []

    def note(request: Request) -> None:
        if "/events" in request.url:
            found.append(request.url)

    context.on("request", note)
    return found


def goes_on(page: Page) -> None:
    before = counted(page)
    page.wait_for_function(
        "n => +document.querySelector('[data-field=evaluations]').innerText.split('/')[0].replace(/\\D/g, '') > n",
        arg=before,
        timeout=SOON,
    )


def test_compiling_is_reported(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}/search")
    goes_on(page)
    runtime = Runtime(embedded.service.store, Settings())
    runtime.tell_kernels(job, 0, 2, None)
    expect(page.locator("#connection")).to_contain_text("compiles the numerical kernels", timeout=SOON)
    runtime.tell_kernels(job, 1, 2, None)
    expect(page.locator("#connection")).to_contain_text("1 of 2 groups are compiled.", timeout=SOON)
    runtime.tell_kernels(job, 2, 2, 52.0)
    expect(page.locator("#connection")).to_be_hidden(timeout=SOON)
    assert embedded.service.get(job).state == "running"


@pytest.mark.slow
def test_tabs_share_one_stream_and_hand_it_on(embedded: Site, visit: Visit, job: str) -> None:
    first, _ = visit(embedded, "/", own=True)
    opened = streams(first.context)
    first.goto(f"/jobs/{job}/search")
    goes_on(first)
    others = [first.context.new_page() for _ in range(2)]
    for page in others:
        page.goto(f"/jobs/{job}/search")
    for page in (first, *others):
        goes_on(page)
    asked_again = len(opened)
    assert asked_again <= 5  # one stream, which begins again where a new tab is, at most twice for each
    numbers = [int(match[1]) for url in opened if (match := re.search(r"after=(\d+)", url))]
    assert len(numbers) == asked_again
    first.close()
    for page in others:
        goes_on(page)
    assert len(opened) == asked_again + 1  # one of the others reads it now
    embedded.service.cancel(job)
    for page in others:
        state(page).to_have_text("cancelled", timeout=SOON)
        expect(page.locator("#connection")).to_be_hidden()
    total = embedded.service.get(job).evaluations
    for page in others:
        expect(page.locator("[data-field=generations]")).not_to_have_text("0")
        assert counted(page) == total


@pytest.mark.slow
def test_a_reload_and_a_restart_of_the_service_lose_nothing(embedded: Site, visit: Visit, job: str) -> None:
    page, guard = visit(embedded, f"/jobs/{job}/search")
    guard.allow("ERR_CONNECTION_REFUSED", "ERR_CONNECTION_RESET", "ERR_INCOMPLETE_CHUNKED", "ERR_EMPTY_RESPONSE")
    goes_on(page)
    page.reload()
    goes_on(page)
    embedded.stop()
    expect(page.locator("#connection")).to_contain_text("Connection lost", timeout=SOON)
    embedded.start()
    expect(page.locator("#connection")).to_be_hidden(timeout=SOON)
    goes_on(page)
    embedded.service.cancel(job)
    state(page).to_have_text("cancelled", timeout=SOON)
    assert counted(page) == embedded.service.get(job).evaluations


def test_an_ended_job_that_goes_on_is_noticed(embedded: Site, visit: Visit) -> None:
    view, _ = embedded.service.submit(parse_problem(textbook(name="again", stopping={"max_evaluations": 30})))
    wait_for_end(embedded.service, view.id)
    page, _ = visit(embedded, f"/jobs/{view.id}")
    state(page).to_have_text("finished")
    page.get_by_role("button", name="Continue").click()
    page.get_by_label("Largest number of evaluations").fill("90")
    page.get_by_role("dialog").get_by_role("button", name="Continue").click()
    expect(page.get_by_role("dialog")).to_have_count(0)
    page.get_by_role("link", name="Search").click()
    expect(page.locator("[data-field=evaluations]")).to_have_text("90 / 90", timeout=SOON)
    state(page).to_have_text("finished", timeout=SOON)
    assert embedded.service.get(view.id).stop_reasons == ["max_evaluations"]
