"""The list of jobs: kept up to date, searched, sorted, leafed through, chosen from."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from geoswarm.solver.problem import parse_problem
from geoswarm.workers.service.findings import submit_sensitivity
from tests.api.conftest import wait_for_end
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import LONG, textbook

Visit = Callable[..., Opened]


@pytest.fixture(scope="module")
def ids(embedded: Site) -> list[str]:
    """Three finished jobs."""
    made = []
    for name, most in (("gravel-wall", 30), ("clay-test", 60), ("silt-test", 90)):
        problem = parse_problem(textbook(name=name, stopping={"max_evaluations": most}, seed=most))
        made.append(embedded.service.submit(problem)[0].id)
    for job_id in made:
        wait_for_end(embedded.service, job_id)
    return made


@pytest.mark.slow
def test_a_newcomer_calibrates_the_example_by_one_click(full: Site, visit: Visit) -> None:
    page, _ = visit(full, "/", key=full.key("newly-here"))
    expect(page.get_by_role("heading", name="No jobs yet")).to_be_visible()
    page.get_by_role("button", name="Try the oedometer example").click()
    page.wait_for_url(re.compile("/jobs/[0-9a-f]{16}$"))
    expect(page.locator("h1")).to_contain_text("oedometer-san-cassiano")
    full.service.cancel(page.url.rpartition("/")[2])


@pytest.mark.slow
def test_jobs_are_searched_and_sorted_without_a_reload(embedded: Site, visit: Visit, ids: list[str]) -> None:
    page, _ = visit(embedded, "/")
    rows = page.locator("tr[data-job]")
    for job_id in ids:
        expect(page.locator(f"tr[data-job='{job_id}'] svg.spark")).to_be_visible()
    page.get_by_role("searchbox", name="Search").fill("-TEST")
    expect(rows).to_have_count(2)
    assert "q=-TEST" in page.url
    page.get_by_label("Order").select_option("evaluations")
    expect(rows.first).to_contain_text("silt-test")
    page.get_by_label("Order").select_option("name")
    expect(rows.first).to_contain_text("clay-test")
    page.get_by_label("State").select_option("failed")
    expect(page.locator(".empty")).to_contain_text("No job matches")
    page.get_by_label("State").select_option("ended")
    expect(rows).to_have_count(2)
    page.reload()
    expect(page.get_by_role("searchbox", name="Search")).to_have_value("-TEST")
    expect(rows).to_have_count(2)
    check_accessibility(page)


def test_the_list_shows_values_with_intervals_and_how_far_to_trust_them(embedded: Site, visit: Visit) -> None:
    readings = {"x": [0, 1, 2, 3, 4, 5], "y": [1.02, 2.95, 5.03, 6.99, 9.04, 10.97]}
    document = textbook(
        name="a line with its answer", observations=[{"series": "y", "points": readings}],
        stopping={"max_evaluations": 240}, answer={},
    )  # fmt: skip
    job_id = embedded.service.submit(parse_problem(document))[0].id
    wait_for_end(embedded.service, job_id)
    job = embedded.service.get(job_id)
    assert job.parameters is not None
    assert job.intervals is not None
    page, _ = visit(embedded, "/?q=with+its+answer")
    values = page.locator(f"tr[data-job='{job_id}'] .values > span")
    expect(values).to_have_count(2)
    for place, name in enumerate(("a", "b")):
        shown = [float(one) for one in re.findall(r"-?\d+\.?\d*", values.nth(place).inner_text())]
        assert shown == pytest.approx([job.parameters[name], *(job.intervals[name] or ())], abs=0.006)
    fit = page.locator(f"tr[data-job='{job_id}'] .fit")
    expect(fit.locator(".badge")).to_have_text("describes")
    assert float(fit.locator("small").inner_text()) == pytest.approx((job.objective or 0.0) ** 0.5, rel=0.01)
    check_accessibility(page)


def test_a_new_job_appears_and_ends_by_itself_while_the_choice_stays(
    embedded: Site, visit: Visit, ids: list[str]
) -> None:
    page, _ = visit(embedded, "/")
    box = page.locator(f"tr[data-job='{ids[0]}'] input")
    box.focus()
    page.keyboard.press("Space")
    view, _ = embedded.service.submit(parse_problem(textbook(name="just-now")))
    row = page.locator(f"tr[data-job='{view.id}']")
    expect(row.locator(".state")).to_have_text("finished")
    expect(box).to_be_checked()
    expect(box).to_be_focused()
    assert page.locator("#chosen").inner_text() == "1 job chosen; choose at least one more to compare."


@pytest.mark.slow
def test_pages_are_leafed_through(embedded: Site, visit: Visit) -> None:
    for number in range(52):
        view, _ = embedded.service.submit(parse_problem(textbook(name=f"leaf-{number:02}", **LONG)))
        embedded.service.cancel(view.id)
    page, _ = visit(embedded, "/?q=leaf&state=cancelled&sort=name")
    rows = page.locator("tr[data-job]")
    expect(rows).to_have_count(50)
    page.get_by_role("link", name="More jobs").click()
    expect(rows).to_have_count(2)
    expect(rows.first).to_contain_text("leaf-50")
    page.get_by_role("link", name="First page").click()
    expect(rows).to_have_count(50)
    assert "q=leaf" in page.url


def test_two_jobs_are_chosen_and_compared(embedded: Site, visit: Visit, ids: list[str]) -> None:
    page, _ = visit(embedded, "/?state=finished")
    button = page.get_by_role("button", name="Compare")
    expect(button).to_be_disabled()
    for job_id in ids[:2]:
        page.locator(f"tr[data-job='{job_id}'] input").check()
    button.click()
    expect(page.locator("h1")).to_have_text("Compare jobs")
    expect(page).to_have_url(re.compile(f"job={ids[0]}&job={ids[1]}"))
    assert page.locator(".chosen li").count() == 2


def test_columns_sort_jobs_are_counted_and_many_are_deleted_at_once(embedded: Site, visit: Visit) -> None:
    made = []
    for name, most in (("bulk-b", 60), ("bulk-a", 30), ("bulk-c", 90)):
        problem = parse_problem(textbook(name=name, stopping={"max_evaluations": most}))
        made.append(embedded.service.submit(problem)[0].id)
    for job_id in made:
        wait_for_end(embedded.service, job_id)
    running = embedded.service.submit(parse_problem(textbook(name="bulk-running", **LONG)))[0].id
    page, guard = visit(embedded, "/?q=bulk-")
    guard.allow("409")
    rows = page.locator("tr[data-job]")
    expect(page.locator("#total")).to_have_text("4 jobs that match")
    page.get_by_role("link", name="Job", exact=True).click()
    expect(rows).to_have_text([re.compile(name) for name in ("bulk-a", "bulk-b", "bulk-c", "bulk-running")])
    page.locator("th[aria-sort=ascending]").get_by_role("link").click()
    expect(rows.first).to_contain_text("bulk-running")
    expect(page.locator("th[aria-sort=descending]")).to_contain_text("Job")
    check_accessibility(page)
    for box in page.get_by_role("checkbox").all():
        box.check()
    embedded.service.label(made[0], tags=["earlier"])
    page.get_by_role("button", name="Tag …").click()
    page.get_by_label("Tags to add").fill("dam, third trial")
    page.keyboard.press("Enter")
    expect(page.locator("#status")).to_have_text("4 jobs tagged.")
    expect(rows.first).to_contain_text("third trial")
    assert embedded.service.get(made[0]).tags == ["dam", "earlier", "third trial"]
    for box in page.get_by_role("checkbox").all():
        box.check()
    page.get_by_role("button", name="Delete", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    expect(page.locator("#status")).to_contain_text("3 jobs deleted; 1 not")
    expect(rows).to_have_count(1)
    page.get_by_role("button", name="Cancel", exact=True).click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel them").click()
    expect(page.locator(f"tr[data-job='{running}'] .state")).to_have_text("cancelled")
    expect(page.locator("#total")).to_have_text("1 job that matches")


def test_a_view_of_the_list_is_kept_and_removed(embedded: Site, visit: Visit) -> None:
    embedded.service.submit(parse_problem(textbook(name="kept view")))
    page, _ = visit(embedded, "/")
    views = page.get_by_role("group", name="Kept views")
    expect(views).to_be_hidden()
    page.get_by_role("searchbox", name="Search").fill("kept view")
    page.get_by_role("button", name="Keep this view").click()
    page.get_by_label("Name of the view").fill("dam")
    page.keyboard.press("Enter")
    link = views.get_by_role("link", name="dam")
    expect(link).to_have_attribute("aria-current", "true")
    expect(page.get_by_role("button", name="Keep this view")).to_have_count(0)
    check_accessibility(page, "#views")
    page.goto("/")
    expect(link).not_to_have_attribute("aria-current", "true")
    link.click()
    expect(page).to_have_url(re.compile(r"/\?q=kept\+view$"))
    expect(page.locator("tr[data-job]")).to_have_count(1)
    page.get_by_role("button", name="Remove the view dam").click()
    expect(link).to_have_count(0)
    expect(page.get_by_role("button", name="Keep this view")).to_be_visible()


def test_follow_ups_stand_below_their_job_and_parameters_are_columns(
    embedded: Site, visit: Visit, ids: list[str]
) -> None:
    view, _ = submit_sensitivity(embedded.service, ids[0])
    wait_for_end(embedded.service, view.id)
    page, _ = visit(embedded, "/")
    below = page.locator(f"tr[data-job='{view.id}']")
    expect(page.locator(f"tr[data-job='{ids[0]}']")).to_be_visible()
    expect(below).to_be_hidden()
    fold = page.locator(f"[data-below='{ids[0]}']")
    expect(fold).to_have_text("1 follow-up")
    expect(fold).to_have_attribute("aria-expanded", "false")
    fold.press("Enter")
    expect(below).to_be_visible()
    expect(fold).to_have_attribute("aria-expanded", "true")
    with page.expect_response(lambda answer: answer.url.rstrip("/") == embedded.url):
        pass  # the list is renewed
    expect(fold).to_be_focused()
    expect(below).to_be_visible()
    check_accessibility(page)
    page.get_by_role("searchbox", name="Search").fill("gravel-wall")
    expect(below.get_by_role("link", name="follow-up", exact=True)).to_have_attribute("href", f"/jobs/{ids[0]}")

    page.get_by_role("button", name="Columns …").click()
    page.get_by_role("dialog").get_by_label("b", exact=True).check()
    page.get_by_role("dialog").get_by_role("button", name="Show").click()
    page.wait_for_url("**columns=b**")
    assert "q=gravel-wall" in page.url
    job = embedded.service.get(ids[0])
    assert job.parameters is not None
    cell = page.locator(f"tr[data-job='{ids[0]}'] td[data-label='b']")
    assert float(cell.locator("span").first.inner_text().split()[0]) == pytest.approx(job.parameters["b"], rel=1e-3)
    expect(page.get_by_role("columnheader", name="b", exact=True)).to_be_visible()
    page.get_by_role("searchbox", name="Search").fill("")
    expect(page.locator(f"tr[data-job='{ids[1]}'] td[data-label='b']")).to_be_visible()
    assert "columns=b" in page.url
