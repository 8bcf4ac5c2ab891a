"""Jobs side by side."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from geoswarm.solver.problem import parse_problem
from tests.api.conftest import line_problem, wait_for_end
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import LONG, SOON, textbook
from tests.dashboard.test_statistics import ended, two_lines

Visit = Callable[..., Opened]


@pytest.fixture(scope="module")
def ids(embedded: Site) -> list[str]:
    """Three finished jobs, one with a fixed parameter."""
    parameters = {"a": {"value": 0.5}, "b": {"lower": 0, "upper": 4}}
    made = [
        embedded.service.submit(parse_problem(textbook(name=name, **changes)))[0].id
        for name, changes in (("free", {}), ("other-seed", {"seed": 8}), ("fixed-a", {"parameters": parameters}))
    ]
    for job_id in made:
        wait_for_end(embedded.service, job_id)
    return made


@pytest.mark.slow
def test_parameters_convergence_and_fits_stand_side_by_side(embedded: Site, visit: Visit, ids: list[str]) -> None:
    page, _ = visit(embedded, "/compare?" + "&".join(f"job={job_id}" for job_id in ids))
    parameters = page.locator("#parameters tr")
    expect(parameters).to_have_count(3)
    expect(parameters.nth(1).locator("td.n").nth(2)).to_have_text("0.5 fixed")
    best = min((embedded.service.get(job_id).objective or 0.0, i) for i, job_id in enumerate(ids))
    expect(page.locator("#facts tr", has_text="Best objective").locator("td.n").nth(best[1])).to_contain_text(
        "(lowest)"
    )
    expect(page.locator("#facts tr").nth(1)).to_contain_text("Root mean square")
    for name in ("Lowest objective over evaluations of 3 jobs", "y: measured points and the best evaluation of 3 jobs"):
        figure = page.get_by_role("figure", name=re.compile(name))
        expect(figure.locator(".main-svg").first).to_be_visible()
    expect(page.get_by_role("figure", name=re.compile("y: measured")).locator(".legendtext")).to_have_text(
        ["measured", "free", "other-seed", "fixed-a"]
    )
    check_accessibility(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_values_stand_with_intervals_verdicts_and_bounds(embedded: Site, visit: Visit) -> None:
    points = {"x": [0, 1, 2, 3, 4, 5], "y": [1.02, 2.97, 5.01, 7.03, 8.98, 10.99]}  # a of the least squares is 1
    common = {"observations": [{"series": "y", "points": points}], "answer": {"max_evaluations": 60}}
    ranges = {"a": {"lower": -5, "upper": 0.5}, "b": {"lower": 0, "upper": 4}}
    made = [
        embedded.service.submit(parse_problem(line_problem(name=name, **common, **changes)))[0].id
        for name, changes in (("free", {}), ("narrow", {"parameters": ranges}))
    ]
    for job_id in made:
        wait_for_end(embedded.service, job_id)
    page, _ = visit(embedded, "/compare?" + "&".join(f"job={job_id}" for job_id in made))
    expect(page.locator(".chosen .badge")).to_have_count(2)
    cells = page.locator("#parameters tbody tr").first.locator("td.n")
    expect(cells.nth(0)).to_contain_text(" … ")
    expect(cells.nth(0)).to_contain_text("identified within one basin")
    expect(cells.nth(1)).to_contain_text("at its upper bound")
    assert embedded.service.get(made[1]).at_bounds == {"a": "upper"}
    check_accessibility(page)
    page.emulate_media(media="print")
    expect(page.locator(".remove").first).to_be_hidden()
    assert (
        not page.get_by_text(re.compile(" ago$"))
        .filter(visible=True)
        .evaluate_all(  # the moment on paper
            "ages => ages.some((age) => getComputedStyle(age).fontSize !== '0px')"
        )
    )


# test_jobs.py chooses jobs in the list; the other tests here open the pages of several
@pytest.mark.slow
def test_jobs_are_added_and_removed(embedded: Site, visit: Visit, ids: list[str]) -> None:
    page, _ = visit(embedded, f"/compare?job={ids[0]}")
    expect(page.locator(".empty")).to_contain_text("Choose two to six jobs")
    page.get_by_label("Add a job").select_option(ids[1])
    page.get_by_role("button", name="Add").click()
    expect(page.locator(".chosen li")).to_have_count(2)
    expect(page.locator("#parameters tr")).to_have_count(3)
    page.get_by_role("link", name="Remove free").click()
    expect(page.locator(".chosen li")).to_have_count(1)
    assert page.locator("#parameters").count() == 0


@pytest.mark.slow
def test_a_running_job_is_followed(embedded: Site, visit: Visit, ids: list[str]) -> None:
    view, _ = embedded.service.submit(parse_problem(textbook(name="running", **LONG)))
    try:
        page, _ = visit(embedded, f"/compare?job={ids[0]}&job={view.id}")
        state = page.locator(".chosen .state").nth(1)
        expect(state).to_have_text("running", timeout=SOON)
        embedded.service.cancel(view.id)
        expect(state).to_have_text("cancelled", timeout=SOON)
        assert page.locator(".chosen .state").first.inner_text() == "finished"
    finally:
        if embedded.service.get(view.id).state != "cancelled":
            embedded.service.cancel(view.id)


def test_other_weights_are_compared_under_those_of_the_first_job(embedded: Site, visit: Visit) -> None:
    first = ended(embedded.service, two_lines(name="half weight"))
    observations = two_lines()["observations"]
    observations[1] = observations[1] | {"weight": 40.0}
    second = ended(embedded.service, two_lines(name="heavy weight", observations=observations, seed=9))
    anew = embedded.service.statistics.reweighted(second, weights={"y": 1.0, "z": 0.5})["best"]["objective"]
    page, _ = visit(embedded, f"/compare?job={first}&job={second}")
    expect(page.locator("#ranking")).to_contain_text("all are compared under those of half weight")
    cells = page.locator("#facts tr", has_text="under the weights of half weight").locator("td.n")
    expect(cells.nth(1)).to_contain_text(f"{anew:.3g}"[:4])
    own = embedded.service.get(first).objective
    assert own is not None
    expect(cells.nth(0 if own <= anew else 1)).to_contain_text("(lowest)")
    expect(page.locator("#facts tr", has_text="under its own weights")).not_to_contain_text("lowest")


def test_different_readings_are_not_ranked(embedded: Site, visit: Visit, ids: list[str]) -> None:
    other = ended(embedded.service, two_lines(name="other readings"))
    page, _ = visit(embedded, f"/compare?job={ids[0]}&job={other}")
    expect(page.locator("#ranking")).to_contain_text("fitted to different readings")
    expect(page.locator("#facts")).not_to_contain_text("lowest")
