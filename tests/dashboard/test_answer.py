"""The page of a job begins with its answer: in words, with verdicts of the statistics, and one next step."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, Route, expect

from geoswarm.solver.problem import parse_problem
from tests.api.conftest import line_problem, wait_for_end
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import LONG, SOON, state, textbook
from tests.dashboard.test_statistics import ended, two_lines

Visit = Callable[..., Opened]

FINISHED = {"stopping": {"max_evaluations": 240}}


@pytest.fixture(scope="module")
def line(embedded: Site) -> str:
    """A calibrated line whose readings have an error, so that its intervals have a width."""
    readings = {"x": [0, 1, 2, 3, 4, 5], "y": [1.02, 2.95, 5.03, 6.99, 9.04, 10.97]}
    return ended(
        embedded.service, textbook(name="a line", observations=[{"series": "y", "points": readings}], **FINISHED)
    )


def verdicts_of_table(page: Page) -> list[str]:
    expect(page.locator("#parameters a.verdict").first).to_be_visible(timeout=SOON)
    return page.locator("#parameters a.verdict").all_inner_texts()


def test_the_answer_in_words_agrees_with_the_statistics(embedded: Site, visit: Visit, line: str) -> None:
    page, _ = visit(embedded, f"/jobs/{line}")
    found = embedded.service.statistics.report(line).statistics
    assert found is not None
    document = found.to_json()
    answer = page.locator("#answer")
    expect(answer).to_contain_text("root mean square", timeout=SOON)
    expect(answer).to_contain_text("the fit leaves")
    for words in {verdict["words"] for verdict in document["verdicts"]}:
        expect(answer).to_contain_text(words, ignore_case=True)
    expect(answer).to_contain_text(document["fit"]["words"])
    assert verdicts_of_table(page) == [verdict["words"] for verdict in document["verdicts"]]
    expect(page.locator("#progress")).to_be_hidden()
    expect(page.locator("#live")).to_be_hidden()
    expect(page.get_by_role("link", name="Slope and mesh")).to_have_count(0)
    # the answer, the parameters, the fit and the next step are seen without scrolling
    for place in ("#answer", "#parameters", "#next", "#fit .multiples svg"):
        page.locator(place).first.wait_for()
        box = page.locator(place).first.bounding_box()
        assert box is not None
        assert box["y"] + box["height"] <= 900, place
    check_accessibility(page)


def test_a_touched_bound_is_flagged_and_digits_follow_the_interval(embedded: Site, visit: Visit, line: str) -> None:
    page, _ = visit(embedded, "/health/live")

    def at_bound(route: Route) -> None:
        answer = route.fetch(max_retries=2)
        fit = answer.json()
        fit["parameters"][0]["upper"] = embedded.service.get(line).parameters["a"]  # type: ignore[index]
        route.fulfill(response=answer, json=fit)

    page.route(re.compile("/fit$"), at_bound)
    page.goto(f"/jobs/{line}")
    rows = page.locator("#parameters tbody tr")
    expect(rows.first.locator(".touched")).to_contain_text("at its upper bound", timeout=SOON)
    expect(rows.nth(1).locator(".touched")).to_have_count(0)
    verdicts_of_table(page)
    assert len(re.sub(r"\D", "", rows.first.locator("td.n").inner_text()).lstrip("0")) <= 4


def test_the_next_step_is_taken_where_it_is_proposed(embedded: Site, visit: Visit) -> None:
    job = ended(embedded.service, two_lines(name="sampled lines"))
    page, _ = visit(embedded, f"/jobs/{job}")
    step = page.get_by_role("button", name="Find out what the data can tell")
    expect(step).to_contain_text(re.compile(r"about \d+ runs"), timeout=SOON)
    step.click()
    expect(page.locator("#next")).to_contain_text("Sensitivities at the optimum", timeout=SOON)
    expect(page.locator("#next").get_by_role("button", name="Find out")).to_have_count(0, timeout=SOON)
    expect(page.locator("#parameters thead")).to_contain_text("95 % interval", timeout=SOON)


def test_a_touched_bound_is_widened_where_it_is_proposed(embedded: Site, visit: Visit) -> None:
    points = {"x": [0, 1, 2, 3, 4, 5], "y": [1.02, 2.97, 5.01, 7.03, 8.98, 10.99]}  # a of the least squares is 1
    observations = [{"series": "y", "points": points}]
    parameters = {"a": {"lower": -5, "upper": 0.5}, "b": {"lower": 0, "upper": 4}}
    answer = {"max_evaluations": 60}
    problem = line_problem(name="narrow", observations=observations, parameters=parameters, answer=answer)
    job = ended(embedded.service, problem)
    page, _ = visit(embedded, f"/jobs/{job}")
    page.get_by_role("button", name="Widen the upper bound of a and recalculate").click(timeout=SOON)
    page.wait_for_url(re.compile(rf"/jobs/(?!{job})"), timeout=SOON)
    wider = embedded.service.problem(page.url.rpartition("/")[2])
    assert wider["name"] == "narrow (widen the upper bound of a)"
    assert (wider["parameters"]["a"]["lower"], wider["parameters"]["a"]["upper"]) == (-5, pytest.approx(3.25))
    assert wider["parameters"]["b"] == embedded.service.problem(job)["parameters"]["b"]


# tests/api/test_owners.py reads the link to the job on the page of a follow-up
@pytest.mark.slow
def test_a_follow_up_leads_to_its_parent_and_draws_no_convergence(embedded: Site, visit: Visit, line: str) -> None:
    page, _ = visit(embedded, f"/jobs/{line}")
    made = page.context.request.post(f"/api/v1/jobs/{line}/sensitivity", headers={"X-Requested-With": "test"}, data={})
    follow_up = made.json()["id"]
    wait_for_end(embedded.service, follow_up)
    page.goto(f"/jobs/{follow_up}")
    expect(page.locator("#answer")).to_contain_text("page of the job that it follows")
    page.get_by_role("link", name="Search").click()
    expect(page.locator("#convergence")).to_have_count(0)
    expect(page.get_by_text("there is no search to show")).to_be_visible()
    page.get_by_role("link", name="a line", exact=True).click()
    expect(page.locator("h1")).to_contain_text("a line")
    assert page.url.endswith(f"/jobs/{line}")


def test_the_runs_of_a_sampling_are_not_joined(embedded: Site, visit: Visit) -> None:
    job = ended(embedded.service, two_lines(name="unrelated", method={"kind": "monte_carlo", "samples": 40}))
    page, _ = visit(embedded, f"/jobs/{job}/search")
    figure = page.locator("#particles [role=figure]")
    expect(figure.locator(".main-svg").first).to_be_visible(timeout=SOON)
    assert figure.evaluate("(frame) => frame.data.find(({ name }) => name === 'move').x.length") == 0


# tests/api/test_progress.py has the numbers that the page shows
@pytest.mark.slow
def test_each_run_counts_at_once_and_the_tab_tells_how_far_it_is(embedded: Site, visit: Visit) -> None:
    view, _ = embedded.service.submit(parse_problem(textbook(name="under way", **LONG)))
    try:
        page, _ = visit(embedded, "/health/live")
        found = {
            "generation": 0, "pending": 2, "running": 2, "finished": 8, "failed": 0, "objective": 0.5,
            "evaluations": 8, "search_evaluations": None, "answer_evaluations": None, "seconds": 2.0, "workers": 1,
            "seconds_left": 104.0,
        }  # fmt: skip
        page.route(re.compile("/progress$"), lambda route: route.fulfill(json=found))
        page.goto(f"/jobs/{view.id}")
        state(page).to_have_text("running", timeout=SOON)
        now = page.locator("#now")
        expect(now).to_contain_text("8 of 4\u202f000\u202f000 runs have ended", timeout=SOON)
        expect(now).to_contain_text("generation 1: 8 of 12, 2 running")
        expect(now).to_contain_text("lowest objective 0.5")
        expect(now).to_contain_text("at most 1 min 44 s left")
        expect(page).to_have_title(re.compile("^0 % under way"))
        expect(page.locator("#crew")).to_contain_text("free")
        found |= {"evaluations": 52, "search_evaluations": 40, "answer_evaluations": 47}
        expect(now).to_contain_text("search ended after 40 runs, intervals: 12 of at most 47", timeout=SOON)
        expect(page).to_have_title(re.compile("^59 % under way"))
        check_accessibility(page)
    finally:
        embedded.service.cancel(view.id)
    expect(page).to_have_title(re.compile("^■ under way"))
    expect(page.locator("#live")).to_be_hidden()


@pytest.mark.slow
def test_another_set_of_parameters_is_drawn_beside_the_result(embedded: Site, visit: Visit, line: str) -> None:
    page, _ = visit(embedded, f"/jobs/{line}/fit")
    page.get_by_text("Compare with another set of parameters").click(timeout=SOON)
    area = page.locator("#other-set textarea")
    expect(area).to_have_value(re.compile(r"^name: other set\na: .*\nb: "))
    area.fill("name: a book\na: 1.5\nb: 2")
    page.get_by_role("button", name="Compare", exact=True).click()
    picture = page.locator("#other-set img")
    expect(picture).to_be_visible(timeout=SOON)
    page.wait_for_function("() => document.querySelector('#other-set img').naturalWidth > 100")
    link = page.get_by_role("link", name="Report with both").get_attribute("href")
    assert link is not None
    assert "Compared with a book" in page.request.get(link).text()
    check_accessibility(page)
