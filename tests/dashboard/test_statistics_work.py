"""What the statistics ask of the service: never for what is old already, and no hours without a question."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, Request, Route, expect

from geoswarm.solver.problem import parse_problem
from tests.api.conftest import line_problem, wait_for_end, wait_until
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Site
from tests.dashboard.test_job import LONG, textbook
from tests.dashboard.test_statistics import Visit, ended, job, page, slide, two_lines
from tests.variants import variants

__all__ = ["Visit", "job", "page"]  # fixtures

FOLLOW_UPS = re.compile("/follow-ups$")


def test_only_the_newest_threshold_is_judged_and_what_is_old_is_dimmed(page: Page) -> None:
    held: list[Route] = []
    broken_off: list[Request] = []
    page.route(re.compile(r"/statistics\?threshold="), lambda route: held.append(route))

    def note(request: Request) -> None:
        broken_off.append(request)

    page.on("requestfailed", note)
    judged = page.locator("#judged")
    for number, value in enumerate((300, 500, 700), 1):
        with page.expect_request(re.compile(r"/statistics\?threshold=")):
            slide(page, value)
            expect(judged).to_have_attribute("aria-busy", "true")  # at once, not when the answer is there
        expect(page.locator("#judging")).to_contain_text("What is dimmed belongs to")
        assert len(held) == number
    assert len(broken_off) == 2
    page.remove_listener("requestfailed", note)
    held[-1].continue_()
    expect(judged).not_to_have_attribute("aria-busy", "true")
    expect(page.locator("#judging")).to_be_empty()
    expect(page.locator("#threshold-why")).to_contain_text("the threshold that you chose")


def test_new_evaluations_wait_for_the_verdicts_that_are_asked_for(embedded: Site, visit: Visit) -> None:
    """A quick search beside a slow service would otherwise break off each question of the last one."""
    service = embedded.service
    view, _ = service.submit(parse_problem(textbook(name="quicker than its verdicts", **LONG)))
    cards = re.compile("/statistics$")
    held: list[Route] = []
    broken_off: list[Request] = []
    try:
        opened, _ = visit(embedded, "/health/live")
        opened.clock.install()
        opened.goto(f"/jobs/{view.id}/statistics")
        expect(opened.locator("#verdicts .card").first).to_be_visible()
        opened.on("requestfailed", lambda request: broken_off.append(request))
        with opened.expect_request(cards):
            opened.route(cards, lambda route: held.append(route))
            opened.clock.fast_forward(60_000)
        before = service.get(view.id).evaluations
        wait_until(lambda: service.get(view.id).evaluations > before + 1000)
        opened.clock.fast_forward(60_000)
        opened.wait_for_load_state()
        assert (len(held), broken_off) == (1, [])
        with opened.expect_request(cards):  # asked again for what came meanwhile
            held[0].continue_()
            opened.clock.fast_forward(60_000)
    finally:
        service.cancel(view.id)


def test_a_follow_up_tells_its_cost_and_one_of_hours_is_asked_for(embedded: Site, visit: Visit, job: str) -> None:
    opened, _ = visit(embedded, "/health/live")

    def costly(route: Route) -> None:
        answer = route.fetch(max_retries=2)  # the service may close an idle connection just then
        costs = answer.json()
        for item in costs["items"]:
            if item["kind"] == "sobol":
                item["seconds"] = 7200.0
        route.fulfill(response=answer, json=costs)

    opened.route(FOLLOW_UPS, costly)
    opened.goto(f"/jobs/{job}/statistics")
    sobol = opened.get_by_role("button", name="Global sensitivity (Sobol)")
    expect(sobol).to_contain_text(re.compile(r"\d+ runs, about 2 h"))
    sensitivities = opened.get_by_role("button", name="Sensitivities at the optimum")
    expect(sensitivities).to_contain_text(re.compile("about 40 runs, (less than|about)"))
    before = {view.id for view in embedded.service.list().items}
    sobol.click()
    dialog = opened.get_by_role("dialog")
    expect(dialog).to_contain_text("about 2 h")
    dialog.get_by_role("button", name="No").click()
    assert {view.id for view in embedded.service.list().items} == before


def test_a_follow_up_that_runs_can_be_cancelled_where_it_is_shown(embedded: Site, visit: Visit, job: str) -> None:
    opened, _ = visit(embedded, "/health/live")
    state = "running"

    def one(route: Route) -> None:
        answer = route.fetch(max_retries=2)
        follow_ups = [{"id": "f" * 16, "kind": "sobol", "state": state, "evaluations": 3}]
        route.fulfill(response=answer, json=answer.json() | {"follow_ups": follow_ups})

    def cancelled(route: Route) -> None:
        nonlocal state
        assert route.request.method == "POST"
        state = "cancelled"
        route.fulfill(json={})

    opened.route(re.compile("/uncertainty$"), one)
    opened.route(re.compile("/f{16}/cancel$"), cancelled)
    opened.goto(f"/jobs/{job}/statistics")
    opened.get_by_role("button", name="Cancel Global sensitivity").click()
    expect(opened.locator("#uncertainty .state")).to_have_text("cancelled")
    expect(opened.get_by_role("button", name="Cancel Global sensitivity")).to_have_count(0)


@pytest.mark.slow
def test_profiles_bring_the_sensitivities_that_they_start_from(embedded: Site, visit: Visit) -> None:
    job = ended(embedded.service, two_lines(name="nothing at the optimum yet"))
    page, _ = visit(embedded, f"/jobs/{job}/statistics")
    profiles = page.get_by_role("button", name="Profiles of all parameters")
    expect(profiles).to_contain_text(re.compile("with the sensitivities first: about 1.. runs"))
    profiles.click()
    begun = page.locator("#uncertainty li", has_text="finished")
    expect(begun).to_have_text([re.compile("^Profile objectives"), re.compile("^Sensitivities at the optimum")])
    expect(profiles).not_to_contain_text("first")
    expect(page.locator("#uncertainty").get_by_role("figure", name=re.compile("^Profile of"))).to_be_visible()
    page.get_by_role("button", name="Sample the posterior").click()
    sampled = page.get_by_role("region", name="Posterior")
    expect(sampled.locator("tbody tr")).to_have_count(3)
    expect(sampled.locator("tbody tr").nth(1).locator("td")).to_have_text([re.compile("^2.7"), re.compile("^2.* … 3.")])
    check_accessibility(page, "#uncertainty")


# tests/solver/identifiability/test_leaving_out.py has the values without each test
@pytest.mark.slow
def test_the_values_without_each_test_say_which_one_pulls(embedded: Site, visit: Visit) -> None:
    tests = {"first": [1.0, 3.1, 4.9, 7.0], "second": [1.1, 2.9, 5.1, 7.1], "third": [1.0, 3.5, 6.0, 8.5]}
    document = line_problem(
        forward_model={
            "kind": "combined",
            "parts": {name: {"kind": "formula", "series": {"y": "a + b * x"}} for name in tests},
        },
        observations=[{"series": f"{name}.y", "points": {"x": [0, 1, 2, 3], "y": y}} for name, y in tests.items()],
        answer={},
    )
    page, _ = visit(embedded, f"/jobs/{ended(embedded.service, document)}/statistics")
    rows = page.get_by_role("region", name="Values without each test").locator("tbody tr")
    expect(rows).to_have_count(6)
    expect(rows.nth(0)).to_contain_text("all tests")
    expect(rows.nth(0).locator("td").nth(1)).to_have_text(re.compile(r"^2\.16"))
    expect(rows.nth(3)).to_contain_text("without third")
    expect(rows.nth(3).locator("td").nth(1)).to_have_text("2")  # the line through the other two
    expect(rows.nth(5).locator("td").nth(1)).to_have_text("third")


@pytest.mark.slow
@pytest.mark.parametrize("count", variants([2, 5], {5}))
def test_a_prediction_says_test_by_test_how_close_it_comes_to_what_was_measured(
    embedded: Site, visit: Visit, count: int
) -> None:
    """Also of tests beside one that failed in every draw; the curves of many tests are drawn once asked for."""
    readings = {"x": [0, 1, 2, 3, 4, 5], "y": [1.02, 2.95, 5.03, 6.99, 9.04, 10.97]}
    document = line_problem(observations=[{"series": "y", "points": readings}], answer={})
    job = ended(embedded.service, document)
    further = {"x": [6, 7, 8, 9], "y": [13.0, 15.1, 16.9, 19.5]}
    parts = {f"T{k}": {"kind": "formula", "series": {"y": "a + b * x"}} for k in range(count)}
    asked = {
        "name": "further tests",
        "forward_model": {
            "kind": "combined",
            "parts": parts | {"never": {"kind": "formula", "series": {"y": "ln(-1 - a**2)"}}},
        },
        "observations": [{"series": f"{name}.y", "points": further} for name in (*parts, "never")],
    }
    page, _ = visit(embedded, f"/jobs/{job}/statistics")
    path = f"{embedded.url}/api/v1/jobs/{job}/predict"
    follow_up = page.request.post(path, data={"problem": asked, "runs": 40}).json()["id"]
    assert wait_for_end(embedded.service, follow_up).state == "finished"
    page, _ = visit(embedded, f"/jobs/{follow_up}/statistics")
    (found,) = page.request.get(f"{embedded.url}/api/v1/jobs/{follow_up}/uncertainty").json()["predictions"]
    outlook = page.locator("#outlook")
    expect(outlook).to_contain_text("Never.y: no band, which needs 10 successful runs.")
    expect(outlook.locator("section")).to_have_count(count)
    first, close = outlook.get_by_role("region", name="T0"), found["series"][0]["closeness"]
    expect(first.locator("li")).to_have_count(1)
    base = page.locator("body").get_attribute("data-static")
    shown = "async ([base, value]) => (await import(base + '/js/format.js')).number(value, 3)"
    largest = page.evaluate(shown, [base, close["largest"]])
    expect(first.locator("li")).to_contain_text(
        f"at most {largest}; {found['series'][0]['inside']} of 4 measured points"
    )
    if count > 3:
        expect(outlook.locator(".js-plotly-plot")).to_have_count(0)
        first.locator("summary").first.click()
    expect(first.locator(".js-plotly-plot .legendtext")).to_have_text(["measured", "median", "90 % band"])
    check_accessibility(page)
    page, _ = visit(embedded, f"/jobs/{follow_up}")
    expect(page.locator("h1")).to_contain_text("finished")
    expect(page.get_by_role("link", name="What it found")).to_be_visible()
    expect(page.locator(".result .panel:visible")).to_have_count(0)
    expect(page.get_by_text("around an optimum")).to_have_count(0)
