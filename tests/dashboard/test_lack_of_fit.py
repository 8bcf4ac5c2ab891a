"""A model that does not describe the data: said first on the pages of the job, with what to do."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import expect

from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import load_problem
from tests.api.conftest import line_problem
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_statistics import ended
from tests.variants import variants
from tests.verification.test_primary_consolidation import measured, problem_of

Visit = Callable[..., Opened]
SOON = 240_000


@pytest.fixture(scope="module")
def bent(embedded: Site) -> str:
    x = np.linspace(0.0, 3.0, 40)
    y = 1.0 + 2.0 * x + 0.8 * (x - 1.5) ** 2 + np.random.default_rng(2).normal(0.0, 0.05, x.size)
    document = line_problem(
        name="a line through a bend",
        observations=[{"series": "y", "points": {"x": x.tolist(), "y": y.tolist()}}],
        stopping={"max_evaluations": 240},
    )
    return ended(embedded.service, document)


@pytest.mark.slow  # test_answer.py widens one by default
def test_a_bound_that_is_touched_is_widened_from_the_alarm(embedded: Site, visit: Visit, bent: str) -> None:
    """Its button was below the alarm and the parameters, off the first screen."""
    document = embedded.service.problem(bent) | {"name": "a slope that is limited"}
    document["parameters"]["b"] = {"lower": 0.0, "upper": 1.5}
    page, _ = visit(embedded, f"/jobs/{ended(embedded.service, document)}")
    step = page.locator("#alarm #next").get_by_role("button", name="Widen the upper bound of b and recalculate")
    expect(step).to_be_visible(timeout=SOON)
    box, table = step.bounding_box(), page.locator("#parameters").bounding_box()
    assert box is not None
    assert table is not None
    assert box["y"] + box["height"] < table["y"]
    check_accessibility(page)


@pytest.mark.parametrize("path", ["", "/statistics"])
def test_the_pages_begin_with_what_is_wrong(embedded: Site, visit: Visit, bent: str, path: str) -> None:
    page, _ = visit(embedded, f"/jobs/{bent}{path}")
    alarm = page.locator("#alarm")
    expect(alarm).to_contain_text("The model does not describe the data", timeout=SOON)
    expect(alarm).to_contain_text("What to do")
    expect(alarm).to_contain_text("leave out what the model does not contain (“From”, “To”, “Stages to leave out”)")
    expect(alarm).not_to_contain_text("x_from")
    offered = 1 if path else 0  # on the page of the job the next step is this
    expect(alarm.get_by_role("link", name="Change the problem")).to_have_count(offered)
    sentence = page.context.request.get(f"/api/v1/jobs/{bent}/statistics").json()["fit"]["sentence"]
    expect(page.get_by_text(sentence)).to_have_count(1)
    expect(page.locator(".card.identified")).to_have_count(0)
    if not path:  # what is wrong, the parameters, the fit and the next step are seen without scrolling
        for place in ("#alarm", "#parameters", "#next", "#fit .multiples svg"):
            page.locator(place).first.wait_for()
            box = page.locator(place).first.bounding_box()
            assert box is not None
            assert box["y"] + box["height"] <= 900, place
    check_accessibility(page)
    if folder := os.environ.get("PICTURES_TEMP"):
        page.screenshot(path=f"{folder}/page{path.replace('/', '_')}.png", full_page=False)


def outlier() -> dict[str, Any]:
    x = np.linspace(0.0, 3.0, 25)
    y = 1.0 + 2.0 * x + np.random.default_rng(3).normal(0.0, 0.05, x.size)
    y[16] += 4.0
    points = {"x": x.tolist(), "y": y.tolist()}
    return line_problem(
        name="a slip", observations=[{"series": "y", "points": points}], stopping={"max_evaluations": 90}
    )


def metres() -> dict[str, Any]:
    with example_file("oedometer") as file:
        document = load_problem(file).document()
    document["observations"][0]["y_unit"] = "m"
    return document | {
        "stopping": {"max_evaluations": 20},
        "answer": {"max_evaluations": "off"},
        "accept": ["settlement"],
    }


def consolidating() -> dict[str, Any]:
    few = {"stopping": {"max_evaluations": 300}, "answer": {"max_evaluations": "off"}}
    return problem_of(measured(primary=True)).document() | few


@pytest.mark.parametrize(
    ("wrong", "button", "changed"),
    variants(
        [
            (
                consolidating,
                "Leave out the first 4.. min of each stage of settlement",
                {"stage_x_from": pytest.approx(412, rel=0.05)},
            ),
            (outlier, "Leave out reading 17 of y and recalculate", {"gross_errors": [17]}),
            (metres, "Read settlement in mm and recalculate", {"y_unit": "mm"}),
        ],
        {outlier},
    ),
)
def test_a_remedy_is_done_by_its_button(
    embedded: Site, visit: Visit, wrong: Callable[[], dict[str, Any]], button: str, changed: dict[str, Any]
) -> None:
    job = ended(embedded.service, wrong())
    page, _ = visit(embedded, f"/jobs/{job}")
    step = page.locator("#alarm").get_by_role("button", name=re.compile(button))
    expect(step).to_be_visible(timeout=SOON)
    expect(page.locator("#next").get_by_text("Change the problem")).to_have_count(0)  # that button is the next step
    step.click()
    page.wait_for_url(re.compile(rf"/jobs/(?!{job})"), timeout=SOON)
    problem = embedded.service.problem(page.url.rpartition("/")[2])
    observation = problem["observations"][0]
    assert {key: observation[key] for key in changed} == changed
    assert not problem.get("accept")
