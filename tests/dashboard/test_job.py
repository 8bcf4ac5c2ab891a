"""The page of a job: seen to its end live, steered, and asked why it failed; embedded and with everything."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, Route, expect

from geoswarm.solver.problem import parse_problem
from geoswarm.workers.access.principal import LOCAL, Principal
from geoswarm.workers.queries.job_list import JobFilters
from tests.api.conftest import BROKEN, line_problem, wait_for_end
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site

Visit = Callable[..., Opened]
TEXTBOOK = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
LONG = {"stopping": {"max_evaluations": 4_000_000}}
SOON = 240_000


def textbook(**changes: Any) -> dict[str, Any]:
    """The line, by a search that costs next to nothing."""
    return line_problem(**({"method": TEXTBOOK} | changes))


@pytest.fixture(params=[pytest.param("embedded", marks=pytest.mark.slow), "full"])
def site(request: pytest.FixtureRequest) -> Site:
    chosen: Site = request.getfixturevalue(request.param)
    return chosen


@pytest.fixture
def submit(site: Site) -> Iterator[Callable[..., str]]:
    """``job_id = submit(**changes)``: a job of alice; ended when the test ends."""
    alice = site.service.on_behalf_of(Principal("alice", "submit") if site.settings.require_key else LOCAL)
    made: list[str] = []

    def submitted(**changes: Any) -> str:
        made.append(alice.submit(parse_problem(textbook(**changes)))[0].id)
        return made[-1]

    yield submitted
    left = {view.id for view in alice.list(JobFilters(states=("queued", "running", "paused"))).items}
    for job_id in left.intersection(made):
        alice.cancel(job_id)


def opened(site: Site, visit: Visit, path: str, **options: object) -> Opened:
    return visit(site, path, key=site.key("alice") if site.settings.require_key else None, **options)


def state(page: Page) -> Any:
    return expect(page.locator("h1 .state"))


def counted(page: Page) -> int:
    return int(re.sub(r"\D", "", page.locator("[data-field=evaluations]").inner_text().split("/")[0]))


def look_until(page: Page, place: str, wanted: Locator) -> None:
    """Keep a place on the screen, as parts above may grow and push it away, until something is seen there."""
    for _ in range(150):
        page.locator(place).scroll_into_view_if_needed()
        page.wait_for_timeout(200)
        if wanted.is_visible():
            return
    expect(wanted).to_be_visible()


def test_a_job_is_watched_to_its_end(site: Site, visit: Visit, submit: Callable[..., str]) -> None:
    job_id = submit(name="watched", stopping={"max_evaluations": 240})
    page, _ = opened(site, visit, f"/jobs/{job_id}")
    state(page).to_have_text("finished", timeout=SOON)
    best = site.service.get(job_id).parameters or {}
    expect(page.locator("#parameters a.verdict")).to_have_count(2, timeout=SOON)
    assert float(page.locator("#parameters td.n").first.inner_text()) == pytest.approx(best["a"], rel=0.1)
    expect(page.get_by_role("img", name=re.compile("y: 3 measured points and the best"))).to_be_visible()
    expect(page.locator("#connection")).to_be_hidden()
    tabs = page.get_by_role("navigation", name="Job").get_by_role("link")
    assert tabs.all_inner_texts() == ["Result", "Fit", "Trust", "Search", "Data"]
    check_accessibility(page)
    page.get_by_role("link", name="Fit", exact=True).click()
    expect(page.get_by_role("figure", name=re.compile("y: 3 measured points with first"))).to_be_visible()
    expect(page.locator("#shares meter")).to_have_count(1)
    check_accessibility(page)
    page.get_by_role("link", name="Search").click()
    expect(page.locator("[data-field=evaluations]")).to_have_text("240 / 240")
    expect(page.locator("[data-field=stopped]")).to_have_text("max evaluations")
    for plot in ("Objective over evaluations", "Generation 39: 6 particles"):
        figure = page.get_by_role("figure", name=re.compile(plot))
        figure.scroll_into_view_if_needed()
        expect(figure.locator(".main-svg").first).to_be_visible()
    check_accessibility(page)
    report = page.context.request.get(f"/api/v1/jobs/{job_id}/report.pdf", timeout=SOON)
    assert report.body().startswith(b"%PDF")


@pytest.mark.slow  # test_keyboard.py steers a job by default
def test_a_job_is_paused_resumed_cancelled_and_goes_on(site: Site, visit: Visit, submit: Callable[..., str]) -> None:
    job_id = submit(name="steered", **LONG)
    page, guard = opened(site, visit, f"/jobs/{job_id}")
    guard.allow("409")
    guard.allow("404")  # statistics that are still on their way when the job is deleted
    state(page).to_have_text("running", timeout=SOON)
    page.get_by_role("button", name="Pause").click()
    state(page).to_have_text("paused", timeout=SOON)
    page.get_by_role("button", name="Resume").click()
    state(page).to_have_text("running", timeout=SOON)
    expect(page.locator("#now")).to_contain_text(re.compile(r"generation (?!1:)\d+:"), timeout=SOON)
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("dialog").get_by_role("button", name="No").click()
    state(page).to_have_text("running")
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel the job").click()
    state(page).to_have_text("cancelled", timeout=SOON)
    there = site.service.get(job_id).evaluations
    page.get_by_role("button", name="Continue").click()
    dialog = page.get_by_role("dialog")
    check_accessibility(page, "dialog")
    dialog.get_by_label("Largest number of evaluations").fill("6")
    dialog.get_by_role("button", name="Continue").click()
    expect(dialog.get_by_role("alert")).to_contain_text("would end immediately by max_evaluations")
    dialog.get_by_label("Largest number of evaluations").fill(str(there + 600))
    dialog.get_by_role("button", name="Continue").click()
    state(page).to_have_text("finished", timeout=SOON)
    assert there < site.service.get(job_id).evaluations <= there + 600
    page.get_by_role("button", name="Delete").click()
    page.get_by_role("button", name="Delete the job").click()
    expect(page.locator("h1")).to_have_text("Jobs")


def test_why_a_job_failed_is_one_step_away(site: Site, visit: Visit, submit: Callable[..., str]) -> None:
    job_id = submit(name="failing", forward_model=BROKEN, stopping={"max_evaluations": 12})
    page, guard = opened(site, visit, f"/jobs/{job_id}")
    state(page).to_have_text("failed", timeout=SOON)
    expect(page.locator("#outcome")).to_contain_text("all 12 evaluations failed")
    page.get_by_role("button", name="Show the first failed evaluation").click()
    dialog = page.get_by_role("dialog", name="Generation 0, particle 0")
    expect(dialog).to_contain_text("Why it failed: not finite")
    expect(dialog.get_by_role("region", name="Attempts")).to_contain_text("not finite (counts)")
    check_accessibility(page, "dialog")
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    part = re.compile("/evaluations.*limit=1000")  # of a long history
    page.route(part, lambda route: route.continue_(url=route.request.url.replace("limit=1000", "limit=7")))
    page.get_by_role("link", name="Search").click()
    timeline = page.locator("#timeline")
    timeline.scroll_into_view_if_needed()
    said = (
        "^7 runs on .*, 7 of them failed",
        r"runs a minute; workers calculated for \d+ % of the time",
        "runs 1 to 7 of 12",
    )
    expect(timeline).to_contain_text(re.compile(".*".join(said)))
    expect(timeline.locator("rect.failed")).to_have_count(7)
    timeline.get_by_role("button", name="Later").click()
    expect(timeline).to_contain_text("These are runs 8 to 12 of 12")
    expect(timeline.get_by_role("button", name="Later")).to_be_disabled()
    page.locator("#evaluations-title").scroll_into_view_if_needed()
    expect(page.locator("#evaluations td.why").first).to_contain_text("is nan at point")
    assert guard.faults == []


@pytest.mark.slow
def test_a_column_that_has_no_place_in_the_dialog_is_a_fact(
    site: Site, visit: Visit, submit: Callable[..., str]
) -> None:
    job_id = submit(name="columns", stopping={"max_evaluations": 12})
    page, guard = opened(site, visit, f"/jobs/{job_id}")

    def with_more(route: Route) -> None:
        answer = route.fetch(max_retries=2)
        route.fulfill(response=answer, json=answer.json() | {"memory_mb": 12.5, "seen_at": None})

    page.route(re.compile(r"/evaluations/0/0$"), with_more)
    state(page).to_have_text("finished", timeout=SOON)
    page.get_by_role("link", name="Search").click()
    page.locator("#evaluations-title").scroll_into_view_if_needed()
    page.get_by_role("button", name="Open evaluation of particle 0 in generation 0").click()
    facts = page.get_by_role("dialog").locator("dl")
    expect(facts.locator("div", has_text="Memory mb")).to_contain_text("12.5")
    expect(facts.locator("div", has_text="Seen at")).to_contain_text("–")
    assert guard.faults == []


@pytest.mark.slow
def test_evaluations_are_filtered_and_opened_by_keyboard(embedded: Site, visit: Visit) -> None:
    model = {"kind": "formula", "series": {"y": {"expression": "a + b * x + 0 * sqrt(b - 1)"}}}
    view, _ = embedded.service.submit(parse_problem(textbook(name="partly", forward_model=model)))
    wait_for_end(embedded.service, view.id)
    failed = embedded.service.get(view.id).failed_evaluations
    page, _ = visit(embedded, f"/jobs/{view.id}")
    assert 0 < failed < 60
    expect(page.locator("#outcome")).to_contain_text(f"{failed} of 60 evaluations failed")
    page.get_by_role("link", name="Search").click()
    table = page.locator("#evaluations tbody tr")
    page.locator("#evaluations-title").scroll_into_view_if_needed()
    expect(table).to_have_count(25)
    page.get_by_role("button", name="Next").click()
    expect(table.first).to_contain_text("4 · 1")
    page.get_by_role("button", name="Objective").press("Enter")
    best = embedded.service.best(view.id)
    assert best is not None
    expect(table.first).to_contain_text(f"{best.generation} · {best.particle}")
    expect(page.locator("#evaluations th[aria-sort=ascending]")).to_have_text("Objective ▲")
    expect(page.get_by_role("button", name="Objective")).to_be_focused()
    page.get_by_label("State").select_option("failed")
    expect(table).to_have_count(min(failed, 25))
    page.get_by_label("Generation", exact=True).last.fill("0")
    first = embedded.service.evaluations(view.id, generation=0, state="failed").items
    expect(table).to_have_count(len(first))
    button = page.get_by_role("button", name=re.compile("Open evaluation")).first
    button.focus()
    page.keyboard.press("Enter")
    expect(page.get_by_role("dialog")).to_contain_text("Why it failed")
    page.locator("#evaluations table").evaluate(
        "(table) => table.replaceWith(table.cloneNode(true))"
    )  # drawn anew meanwhile
    page.keyboard.press("Escape")
    expect(button).to_be_focused()
    with page.expect_download() as download:
        page.get_by_role("link", name="Download as CSV").click()
    assert download.value.path().read_text().count("\n") == len(first) + 1


@pytest.mark.slow
def test_particles_are_leafed_through(embedded: Site, visit: Visit) -> None:
    view, _ = embedded.service.submit(parse_problem(textbook(name="particles")))
    wait_for_end(embedded.service, view.id)
    page, _ = visit(embedded, f"/jobs/{view.id}/search")
    place = page.locator("#particles")
    place.scroll_into_view_if_needed()
    expect(place.get_by_role("figure")).to_have_attribute("aria-label", "Generation 9: 6 particles, b over a")
    place.get_by_role("slider").fill("3")
    expect(place.get_by_role("figure")).to_have_attribute("aria-label", re.compile("Generation 3: "))
    place.locator("select").first.select_option("parallel")
    expect(place.get_by_role("figure")).to_have_attribute("aria-label", re.compile("3: 6 particles in parallel"))
    place.get_by_role("button", name="Play").click()
    expect(place.locator("output")).to_have_text("9 of 9")
    expect(place.get_by_role("button", name="Play")).to_be_visible()
    place.get_by_text("Numbers of this plot").click()
    rows = place.locator(".plot-table tbody tr")
    expect(rows).to_have_count(6)
    assert rows.count() == 6


@pytest.mark.slow
def test_the_jobs_of_others_are_kept_out_of_reach(full: Site, visit: Visit) -> None:
    alice = full.service.on_behalf_of(Principal("alice", "submit"))
    job_id = alice.submit(parse_problem(textbook(name="confidential-slope", **LONG)))[0].id
    try:
        page, guard = visit(full, f"/jobs/{job_id}", key=full.key("bob"))
        guard.allow("404")
        expect(page.locator("h1")).to_have_text("Job not found")
        page.goto(f"/compare?job={job_id}")
        expect(page.locator("h1")).to_have_text("Job not found")
        page.goto("/")
        expect(page.locator("#list")).not_to_contain_text("confidential-slope")
        for method, path in (("POST", "/cancel"), ("PATCH", ""), ("DELETE", ""), ("GET", "/fit"), ("GET", "/events")):
            answer = page.context.request.fetch(
                f"/api/v1/jobs/{job_id}{path}",
                method=method,
                headers={"X-Requested-With": "test"},
                data={"stopping": {"max_evaluations": 9}} if method == "PATCH" else None,
            )
            assert answer.status == 404, (method, path)
        reader, _ = visit(full, f"/jobs/{job_id}", key=full.key("alice", "read"))
        expect(reader.locator("#now")).to_contain_text("lowest objective", timeout=SOON)
        expect(reader.locator("#actions button")).to_have_count(0)
        assert alice.get(job_id).state == "running"
    finally:
        alice.cancel(job_id)
