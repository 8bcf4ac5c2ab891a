"""Every view at the width of a desk and of a phone, light and dark: sound to look at, and usable by everybody.

A picture of each lies in the folder ``gallery`` below pytest's ``--basetemp`` afterwards.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.workers.operations.counters import process_counters
from tests.api.conftest import BROKEN
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.layout import check_layout, leaf_through
from tests.dashboard.test_job import LONG, SOON, state, textbook
from tests.dashboard.test_statistics import ended
from tests.dashboard.test_statistics_story import five_parameters

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

Visit = Callable[..., Opened]

DESK, PHONE = {"width": 1440, "height": 900}, {"width": 390, "height": 844}
LOOKS = {
    f"{name}-{theme}": {"viewport": size, "color_scheme": theme}
    for name, size in (("desk", DESK), ("phone", PHONE))
    for theme in ("light", "dark")
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("gallery", numbered=False)


@pytest.fixture(params=LOOKS)
def look(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def check_view(folder: Path, look: str) -> Callable[..., None]:
    """``check_view(page, name)``: take a picture of a view, and find nothing wrong with it."""

    def seen(page: Page, name: str, *, whole: bool = True) -> None:
        if whole:
            leaf_through(page)
        try:
            check_layout(page)
            check_accessibility(page)
        finally:
            page.screenshot(path=folder / f"{name}-{look}.png", full_page=whole)

    return seen


CheckView = Callable[..., None]


def oedometer(**changes: Any) -> dict[str, Any]:
    """The published test, by a search that costs little."""
    with example_file("oedometer") as path:
        document = load_problem(path).document()
    method = {"kind": "particle_swarm", "particles": 10, "acceleration": "none"}
    return document | {"method": method, "stopping": {"max_evaluations": 300}} | changes


@pytest.fixture(scope="module")
def calibrated(embedded: Site) -> list[str]:
    """Three calibrations of the published test."""
    return [ended(embedded.service, oedometer(name=f"oedometer, seed {seed}", seed=seed)) for seed in (1, 2, 3)]


@pytest.fixture
def running(embedded: Site) -> Iterator[str]:
    """A job that goes on for long."""
    view, _ = embedded.service.submit(parse_problem(textbook(name="a line that is calibrated for very long", **LONG)))
    yield view.id
    embedded.service.cancel(view.id)


def test_lists(
    embedded: Site, full: Site, visit: Visit, look: str, check_view: CheckView, calibrated: list[str], running: str
) -> None:
    ended(embedded.service, textbook(name="failing", forward_model=BROKEN, stopping={"max_evaluations": 12}))
    page, _ = visit(embedded, "/", **LOOKS[look])
    expect(page.locator(f"tr[data-job='{running}'] .state")).to_have_text("running", timeout=SOON)
    check_view(page, "jobs")
    page.locator(f"tr[data-job='{calibrated[0]}'] input").check()
    page.goto("/?q=nothing-is-called-so")
    expect(page.locator(".empty")).to_be_visible()
    check_view(page, "jobs-none-matches")
    page.goto("/compare?" + "&".join(f"job={job}" for job in calibrated))
    expect(page.locator("#parameters tr")).to_have_count(7)
    expect(page.get_by_role("figure", name=re.compile("every stage over the logarithm"))).to_be_visible()
    check_view(page, "compare")
    page.goto("/compare")
    check_view(page, "compare-none")
    newcomer, _ = visit(full, "/", key=full.key("newcomer"), **LOOKS[look])
    expect(newcomer.get_by_role("heading", name="No jobs yet")).to_be_visible()
    check_view(newcomer, "jobs-empty")


def test_jobs(
    embedded: Site, visit: Visit, look: str, check_view: CheckView, calibrated: list[str], running: str
) -> None:
    page, _ = visit(embedded, f"/jobs/{calibrated[0]}", **LOOKS[look])
    expect(page.locator("#fit .multiples svg").nth(1)).to_be_visible()
    expect(page.locator("#answer")).to_contain_text("root mean square", timeout=SOON)
    check_view(page, "job-finished")
    page.goto(f"/jobs/{calibrated[0]}/fit")
    expect(page.locator("#fit .main-svg").first).to_be_visible()
    expect(page.locator("#diagrams h3")).to_have_text("Compression curve")
    check_view(page, "job-fit")
    page.goto(f"/jobs/{calibrated[0]}/data")
    expect(page.locator("#figures a").first).to_be_visible()
    check_view(page, "job-data")
    page.goto(f"/jobs/{calibrated[0]}/search")
    expect(page.locator("#convergence .main-svg").first).to_be_visible()
    check_view(page, "job-search")
    page.locator("#particles select").first.select_option("parallel")
    page.locator("#particles").scroll_into_view_if_needed()
    expect(page.locator("#particles [role=figure]")).to_have_attribute("aria-label", re.compile("in parallel"))
    check_view(page, "job-parallel-coordinates")
    page.get_by_role("button", name="Open evaluation").first.click()
    expect(page.get_by_role("dialog")).to_be_visible()
    check_view(page, "job-evaluation", whole=False)
    page.goto(f"/jobs/{calibrated[0]}")
    page.get_by_role("button", name="Continue").click()
    check_view(page, "job-go-on", whole=False)
    page.goto(f"/jobs/{running}")
    state(page).to_have_text("running", timeout=SOON)
    check_view(page, "job-running")


def test_failed_jobs(embedded: Site, visit: Visit, look: str, check_view: CheckView) -> None:
    job = ended(embedded.service, textbook(name="failing", forward_model=BROKEN, stopping={"max_evaluations": 12}))
    page, guard = visit(embedded, f"/jobs/{job}", **LOOKS[look])
    state(page).to_have_text("failed")
    check_view(page, "job-failed")
    page.get_by_role("button", name="Show the first failed evaluation").click()
    expect(page.get_by_role("dialog")).to_contain_text("Why it failed")
    check_view(page, "job-failed-evaluation", whole=False)
    guard.allow("409", "404", "statistics")
    page.goto(f"/jobs/{job}/statistics")
    expect(page.locator("#nothing")).not_to_contain_text("Reading")
    check_view(page, "statistics-none")
    page.goto(f"/jobs/{job}/mesh")
    check_view(page, "mesh-none")
    page.goto("/jobs/nobody")
    expect(page.locator("h1")).to_have_text("Job not found")
    check_view(page, "not-found")


def test_new(embedded: Site, visit: Visit, look: str, check_view: CheckView) -> None:
    page, _ = visit(embedded, "/new", **LOOKS[look])
    expect(page.locator("#verdict")).to_contain_text("still missing")
    check_view(page, "new-empty")
    page.goto("/new?example=oedometer")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    page.get_by_role("button", name="Check", exact=True).click()
    expect(page.locator("#check-body")).to_contain_text("The forward calculation works", timeout=180_000)
    check_view(page, "new-oedometer-checked")
    page.goto("/new?example=slope")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    check_view(page, "new-slope")


def test_statistics_and_mesh(embedded: Site, visit: Visit, look: str, check_view: CheckView) -> None:
    job = ended(embedded.service, five_parameters() | {"method": {"kind": "monte_carlo", "samples": 1000}})
    page, _ = visit(embedded, f"/jobs/{job}/statistics", **LOOKS[look])
    expect(page.locator("#verdicts .card")).to_have_count(5)
    for summary in page.locator("main summary").all():
        summary.click()
    check_view(page, "statistics")
    with example_file("slope") as path:
        slope = load_problem(path).document() | {"method": {"kind": "monte_carlo", "samples": 2}, "stopping": {}}
    page.goto(f"/jobs/{ended(embedded.service, slope)}/mesh")
    expect(page.locator("#told")).to_contain_text("Largest displacement", timeout=SOON)
    check_view(page, "mesh")
    page.get_by_label("Show", exact=True).select_option("shear")
    check_view(page, "mesh-shear")


def test_administration(full: Site, visit: Visit, look: str, check_view: CheckView) -> None:
    process_counters.run("finished", 0.1)
    process_counters.run("timeout", 0.1)
    process_counters.flush(full.service.store)
    page, _ = visit(full, "/workers", **LOOKS[look])
    expect(page.locator("h1")).to_have_text("Sign in")
    check_view(page, "sign-in")
    admin, _ = visit(full, "/workers", key=full.key("root", "admin"), **LOOKS[look])
    expect(admin.locator("#keys tbody tr").first).to_be_visible()
    check_view(admin, "workers-keys")
    admin.get_by_label("Owner").fill("erika")
    admin.get_by_role("button", name="Make a key").click()
    expect(admin.get_by_role("dialog")).to_be_visible()
    check_view(admin, "workers-new-key", whole=False)
