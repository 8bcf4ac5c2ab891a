"""How the fit changes with the parameters: contours, slices and importance from stored runs, without further ones."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from geoswarm.solver.problem import parse_problem
from tests.api.conftest import line_problem
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import LONG, textbook
from tests.dashboard.test_statistics import ended, two_lines

Visit = Callable[..., Opened]


def figure(page: Page, name: str) -> str:
    """What a plot says of itself, once it is drawn."""
    found = page.locator("#surface").get_by_role("figure", name=re.compile(name))
    expect(found.locator(".plot-container")).to_be_visible()
    return found.get_attribute("aria-label") or ""


def test_contours_and_slices_of_a_finished_job_with_its_runs(embedded: Site, visit: Visit) -> None:
    job = ended(embedded.service, two_lines(name="two lines, their surface"))
    before = embedded.service.get(job).evaluations
    page, _ = visit(embedded, f"/jobs/{job}/statistics")
    assert figure(page, "^Contours") == (
        "Contours of the objective over a and b, by the response surface, with 400 stored runs"
    )
    assert figure(page, "^Slices").endswith("along a, b, d, with 400 stored runs")
    assert re.fullmatch(r"Importance: [ab] \d\d %, [ab] \d+ %, d 0 %", figure(page, "^Importance"))
    said = page.locator("#surface .help").first
    expect(said).to_contain_text("A response surface of 400 stored runs")
    expect(said).to_contain_text(re.compile(r"it misses f by (less than )?\d[\d.]* % \(root mean square, \d+ runs\)"))
    across = page.get_by_role("combobox", name="Across")
    expect(across).to_have_value("a")
    across.select_option("b")  # the other axis then takes what this one showed
    assert "over b and a" in figure(page, "over b and a")
    page.locator("#surface").get_by_role("combobox", name="Up").select_option("d")
    assert "over b and d" in figure(page, "over b and d")
    contours = page.locator("#surface .contours")
    for form in ("SVG", "PNG"):
        expect(contours.get_by_role("button", name=f"This plot as {form}")).to_be_visible()
    with page.expect_download() as saved:
        contours.get_by_role("button", name="This plot as CSV").click()
    rows = list(csv.reader(io.StringIO(Path(saved.value.path()).read_text(encoding="utf-8"))))
    found = embedded.service.statistics.surface(job, x="b", y="d").to_json()["contours"]
    assert [name.strip('"') for name in rows[0]] == ["b", "d", "f", "f over the limit"]
    assert len(rows) - 1 == len(found["x_values"]) * len(found["y_values"])
    assert float(rows[1][0]) == found["x_values"][0]
    check_accessibility(page, "#surface")
    assert embedded.service.get(job).evaluations == before


# tests/solver/identifiability/test_slices.py and test_posterior.py have both cases without a page
@pytest.mark.slow
def test_too_few_runs_are_said_and_one_parameter_has_no_contours(embedded: Site, visit: Visit) -> None:
    sampled = {"method": {"kind": "monte_carlo", "samples": 12}, "stopping": {}}
    few = ended(embedded.service, line_problem(name="few runs", **sampled))
    page, guard = visit(embedded, f"/jobs/{few}/statistics")
    guard.allow("422")
    said = "A response surface needs 30 different evaluations, there are 12."
    expect(page.locator("#surface .empty")).to_have_text(said)
    parameters = {"a": {"value": 1.0}, "b": {"lower": 0, "upper": 5}}
    sampled["method"] = {"kind": "monte_carlo", "samples": 60}
    one = ended(embedded.service, line_problem(name="one parameter", parameters=parameters, **sampled))
    page.goto(f"/jobs/{one}/statistics")
    assert "along b, with" in figure(page, "^Slices")
    expect(page.locator("#surface .contours")).to_be_empty()


# tests/solver/identifiability/test_slices.py has such a surface without a page
@pytest.mark.slow
def test_a_surface_that_cannot_be_relied_on_is_not_drawn(embedded: Site, visit: Visit) -> None:
    rough = line_problem(
        name="a rough model",
        forward_model={"kind": "formula", "series": {"y": "sin(40 * a) * x + sin(40 * b)"}},
        parameters={"a": {"lower": 0, "upper": 10}, "b": {"lower": 0, "upper": 10}},
        observations=[{"series": "y", "points": {"x": list(range(12)), "y": [0.3 * x for x in range(12)]}}],
        method={"kind": "monte_carlo", "samples": 200},
        stopping={},
    )
    page, _ = visit(embedded, f"/jobs/{ended(embedded.service, rough)}/statistics")
    figure(page, "^Contours")
    expect(page.locator("#surface .poor")).to_contain_text("too much for a surface to be drawn")
    legend = page.locator("#surface .contours .legend")
    expect(legend).to_contain_text("run")
    expect(legend).not_to_contain_text("limit")
    expect(page.locator("#surface .slices .legend")).not_to_contain_text("response surface")
    expect(page.locator("#surface .importance")).to_be_empty()


def test_a_running_job_shows_no_surface_yet(embedded: Site, visit: Visit) -> None:
    service = embedded.service
    view, _ = service.submit(parse_problem(textbook(name="still searching", **LONG)))
    try:
        page, _ = visit(embedded, f"/jobs/{view.id}/statistics")
        expect(page.locator("#verdicts .card").first).to_be_visible()
        expect(page.locator("#surface")).to_be_hidden()
    finally:
        service.cancel(view.id)
