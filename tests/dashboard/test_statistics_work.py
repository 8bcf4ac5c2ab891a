"""What the statistics ask of the service: never for what is old already, and no hours without a question."""

from __future__ import annotations

import re

from playwright.sync_api import Page, Request, Route, expect

from tests.api.conftest import line_problem
from tests.dashboard.conftest import Site
from tests.dashboard.test_statistics import Visit, ended, job, page, slide

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
    expect(page.locator("#threshold-why")).to_contain_text("given")


def test_a_follow_up_tells_its_cost_and_one_of_hours_is_asked_for(embedded: Site, visit: Visit, job: str) -> None:
    opened, _ = visit(embedded, "/")

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
    opened, _ = visit(embedded, "/")
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
    expect(rows).to_have_count(5)
    expect(rows.nth(2)).to_contain_text("without third")
    expect(rows.nth(2).locator("td").nth(1)).to_have_text("2")  # the line through the other two
    expect(rows.nth(4).locator("td").nth(1)).to_have_text("third")
