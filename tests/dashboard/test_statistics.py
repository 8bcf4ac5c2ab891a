"""The statistics of a job: what is chosen by threshold and brush, verdicts, follow-ups, other weights."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable
from typing import Any
from xml.etree import ElementTree

import pytest
from playwright.sync_api import Locator, Page, Route, expect

from geoswarm.solver.problem import parse_problem
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import line_problem, wait_for_end
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site

Visit = Callable[..., Opened]

READ_POINTS = """async (base) => {
    const { fetchPoints } = await import(base + "/js/statistics/points.js");
    const found = await fetchPoints(document.querySelector("main").dataset.job);
    return [found.count, [...found.values[1]], [...found.objective], [...found.misfits.z]];
}"""
PLACE_OF_PLAN = "document.getElementById('plan').getBoundingClientRect().top + scrollY"
MOVE = "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input')); }"


def two_lines(**changes: Any) -> dict[str, Any]:
    """Two series, of which one needs one of the parameters only; sampled. A third parameter has no influence."""
    return (
        line_problem(
            name="two lines",
            forward_model={"kind": "formula", "series": {"y": "a + b * x + 0 * d", "z": "b * x"}},
            parameters={
                "a": {"lower": -5, "upper": 5},
                "b": {"lower": 0.1, "upper": 4, "scale": "log"},
                "d": {"lower": 0, "upper": 1},
            },
            observations=[
                {"series": "y", "points": {"x": [0, 1, 2, 3], "y": [1.0, 3.1, 4.9, 7.0]}},
                {"series": "z", "points": {"x": [1, 2, 3, 4], "y": [3.0, 6.1, 8.9, 12.0]}, "weight": 0.5},
            ],
            method={"kind": "monte_carlo", "samples": 400},
            stopping={},
        )
        | changes
    )


def ended(service: JobService, document: dict[str, Any]) -> str:
    view, _ = service.submit(parse_problem(document))
    return wait_for_end(service, view.id).id


@pytest.fixture(scope="module")
def job(embedded: Site) -> str:
    return ended(embedded.service, two_lines())


@pytest.fixture
def page(embedded: Site, visit: Visit, job: str) -> Page:
    opened, _ = visit(embedded, f"/jobs/{job}/statistics")
    expect(opened.locator("#verdicts .card")).to_have_count(3)
    return opened


def chosen(page: Page) -> int:
    text = page.locator("#filter output").inner_text()
    found = re.search(r"(\d+) inside", text) or re.match(r"(\d+) of", text)
    assert found is not None, text
    return int(found[1])


def slide(page: Page, value: int) -> None:
    page.locator("#threshold").evaluate(MOVE, value)


def test_points_are_those_of_the_service_and_sentences_name_buttons(embedded: Site, page: Page, job: str) -> None:
    base = page.locator("body").get_attribute("data-static")
    count, b, objectives, misfits = page.evaluate(READ_POINTS, base)
    stored = embedded.service.evaluations(job, limit=1000).items
    assert count == 400
    assert b == pytest.approx([item.parameters["b"] for item in stored], rel=1e-6)
    assert objectives == pytest.approx([item.objective for item in stored], rel=1e-6)
    assert misfits == pytest.approx([item.misfits["z"] for item in stored], rel=1e-6)
    # the page as it opens: sentences name buttons, no commands; everybody can use it
    expect(page.locator("#warnings")).to_contain_text("“Sensitivities at the optimum” refines the optimum")
    expect(page.get_by_role("button", name=re.compile("^Sensitivities at the optimum"))).to_be_visible()
    expect(page.locator("main")).not_to_contain_text("'geoswarm ")
    check_accessibility(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_the_slider_keeps_its_width_counts_as_the_service_does_and_verdicts_follow(
    embedded: Site, page: Page, job: str
) -> None:
    widths = []
    for value in (100, 500, 1000):  # what stands beside the slider grows with the number of good fits
        slide(page, value)
        box = page.locator("#threshold").bounding_box()
        assert box is not None
        widths.append(box["width"])
    assert widths == pytest.approx([widths[0]] * 3, abs=0.5)
    slide(page, 700)
    exact = float(page.get_by_label("Threshold as a number").input_value())
    with page.expect_response(re.compile("/statistics")):
        page.get_by_label("Threshold as a number").fill(str(exact))
        page.keyboard.press("Enter")
    expect(page.locator("#threshold-why")).to_contain_text("the threshold that you chose")
    samples = embedded.service.statistics.report(job, threshold=exact).statistics
    assert samples is not None
    assert chosen(page) == samples.filtered.kept
    page.locator("#correlations summary").click()
    r = samples.pearson.get("a", "b").coefficient
    assert r is not None
    expect(page.locator("#correlations td").first).to_contain_text(f"{r:.2f}")
    expect(page.locator(".marks .r").first).to_contain_text(f"{r:.2f}".replace("-", "−"))
    expect(page.locator("#fit")).to_contain_text(f"{chosen(page)} chosen")


def check_files(place: Locator, name: str, good: int) -> None:
    """A plot is saved as it is shown, and the numbers of all evaluations, the best first."""
    files = {}
    for form in ("SVG", "PNG", "CSV"):
        with place.page.expect_download() as download:
            place.get_by_role("button", name=f"This plot as {form}").click()
        assert download.value.suggested_filename == f"{name}.{form.lower()}"
        files[form] = download.value.path().read_bytes()
    drawing = ElementTree.fromstring(files["SVG"])  # noqa: S314: made by this page
    assert len(drawing.findall("{*}image")) == 2
    assert {"a", "b", "d"} <= {text.text for text in drawing.findall("{*}text")}
    assert b"var(" not in files["SVG"]
    assert files["PNG"].startswith(b"\x89PNG")
    head, *rows = csv.reader(io.StringIO(files["CSV"].decode()))
    assert head == ["f", "a", "b", "d", "chosen"]
    objectives = [float(row[0]) for row in rows]
    assert (len(rows), objectives) == (400, sorted(objectives))
    assert sum(int(row[-1]) for row in rows) == good


def test_a_range_on_a_parallel_axis_limits_all_plots(page: Page) -> None:
    slide(page, 900)
    before = chosen(page)
    expect(page.locator("#judged")).not_to_have_attribute("aria-busy", "true")
    place = page.locator("#parallel .marks")
    place.scroll_into_view_if_needed()
    axis = place.locator(".cell").nth(2).bounding_box()  # of b: the first is that of the objective
    assert axis is not None
    page.mouse.move(axis["x"], axis["y"] + 0.1 * axis["height"])
    page.mouse.down()
    page.mouse.move(axis["x"], axis["y"] + 0.5 * axis["height"], steps=5)
    page.mouse.up()
    expect(place.locator(".brush")).to_have_count(1)
    assert 0 < chosen(page) < before
    assert "range.b=" in page.url
    expect(page.locator("#matrix .brush").first).to_be_visible()
    expect(place).to_have_attribute("aria-label", re.compile(f"{chosen(page)} of 400 evaluations are chosen"))
    for where, name in (("#parallel", "parallel-coordinates"), ("#matrix", "matrix-plot")):
        check_files(page.locator(where), name, chosen(page))
    expect(page.locator("#judged")).not_to_have_attribute("aria-busy", "true")  # verdicts stand above and may grow
    place.scroll_into_view_if_needed()
    axis = place.locator(".cell").nth(2).bounding_box()  # the buttons may have scrolled the page
    assert axis is not None
    page.mouse.click(axis["x"], axis["y"] + 0.3 * axis["height"])
    expect(place.locator(".brush")).to_have_count(0)
    assert chosen(page) == before


def test_a_rectangle_in_one_cell_limits_all_cells_and_the_fit_and_ranges_can_be_typed(page: Page) -> None:
    slide(page, 900)
    before = chosen(page)
    expect(page.locator("#judged")).not_to_have_attribute("aria-busy", "true")  # verdicts stand above and may grow
    page.locator(".marks .cell").nth(3).scroll_into_view_if_needed()
    cell = page.locator(".marks .cell").nth(3).bounding_box()  # row b, column a
    assert cell is not None
    x, y, side = cell["x"], cell["y"], cell["width"]
    page.mouse.move(x + 0.5 * side, y + 0.1 * side)
    page.mouse.down()
    page.mouse.move(x + 0.9 * side, y + 0.9 * side, steps=4)
    page.mouse.up()
    inside = chosen(page)
    assert 0 < inside < before
    expect(page.locator("#matrix .brush")).to_have_count(5)  # every cell with a or b
    expect(page.locator("#fit")).to_contain_text(f"{inside} chosen")
    page.get_by_text("Ranges of the parameters").click()
    low = float(page.get_by_label("a, at least").input_value())
    assert low == pytest.approx(0.0, abs=0.15)  # the middle of -5 to 5, to a pixel
    page.get_by_role("button", name="Remove all ranges").click()
    assert chosen(page) == before
    slide(page, 1000)  # a range that is typed
    whole = chosen(page)
    field = page.get_by_label("b, at most")
    field.fill("1")
    field.press("Enter")
    assert 0 < chosen(page) < whole
    page.get_by_role("button", name="Any b").click()
    assert chosen(page) == whole


# tests/api/test_statistics.py has the numbers of other weights
@pytest.mark.slow
def test_other_weights_move_the_optimum_as_the_service_says(embedded: Site, page: Page, job: str) -> None:
    before = page.locator("#weights > p").nth(2).inner_text()
    with page.expect_response(re.compile("/reweight")):
        page.get_by_label("Weight of z").fill("0")
        page.keyboard.press("Enter")
    after = embedded.service.statistics.reweighted(job, weights={"y": 1.0, "z": 0.0})
    best = after["best"]["parameters"]
    told = page.locator("#weights > p").nth(2)
    expect(told).to_contain_text(f"a = {best['a']:.4g}")
    assert told.inner_text() != before
    expect(page.locator("#verdicts-note")).to_be_visible()
    expect(page.locator("#threshold-why")).to_contain_text("keep the number of good fits")
    page.get_by_role("button", name="Weights of the job").click()
    expect(page.locator("#threshold-why")).not_to_contain_text("as many")
    expect(told).to_have_text(before)


# test_a_follow_up_is_offered_the_values_of_the_job plans one by default
@pytest.mark.slow
def test_a_proposal_becomes_a_job_with_the_parameter_fixed(embedded: Site, page: Page) -> None:
    card = page.locator(".card[data-parameter=d]")
    expect(card).to_contain_text("not identified")
    card.get_by_role("button", name="Fix d in the follow-up").click()
    expect(page.locator("#plan")).to_contain_text("d fixed; 2 free")
    page.get_by_label("a in the follow-up").select_option("widened")
    page.get_by_label("Upper bound of a").fill("9")
    page.get_by_role("button", name="Check first").click()
    expect(page.locator("#plan")).to_contain_text("It works")
    page.get_by_role("button", name="Start follow-up").click()
    page.wait_for_url(lambda url: "statistics" not in url)
    made = embedded.service.problem(page.url.rpartition("/")[2])
    assert made["parameters"]["a"]["upper"] == 9
    assert "value" in made["parameters"]["d"]
    assert made["name"] == "two lines (a bounds changed, d fixed)"


def test_a_follow_up_is_offered_the_values_of_the_job(embedded: Site, visit: Visit) -> None:
    readings = {"x": [0, 1, 2, 3, 4, 5], "y": [1.02, 2.95, 5.03, 6.99, 9.04, 10.97]}
    observations = [{"series": "y", "points": readings}]
    method = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
    document = line_problem(name="short", observations=observations, method=method, answer={"max_evaluations": "auto"})
    job = ended(embedded.service, document)
    found = embedded.service.get(job)
    assert found.parameters is not None
    assert found.search_best is not None
    assert found.parameters["a"] != pytest.approx(found.search_best.parameters["a"], rel=1e-4)
    page, _ = visit(embedded, f"/jobs/{job}/statistics")
    for name in ("a", "b"):
        page.get_by_label(f"{name} in the follow-up").select_option("fixed")
        offered = float(page.get_by_label(f"Value of {name}").input_value())
        assert offered == pytest.approx(found.parameters[name], rel=1e-5)


def test_a_refused_follow_up_says_why(embedded: Site, visit: Visit, job: str) -> None:
    page, guard = visit(embedded, "/health/live")
    guard.allow("422")
    scripts: list[Route] = []
    page.route(re.compile("plotly"), lambda route: scripts.append(route))
    page.goto(f"/jobs/{job}/statistics")
    expect(page.locator("#verdicts .card")).to_have_count(3)
    start = page.get_by_role("button", name="Start follow-up")
    expect(start).to_contain_text("runs")
    page.get_by_label("a in the follow-up").select_option("linked")
    page.get_by_label("Expression of a").fill("2 * nobody")
    before = page.evaluate(PLACE_OF_PLAN)
    scripts[0].continue_()
    expect(page.locator("#fit .main-svg").first).to_be_visible()
    assert page.evaluate(PLACE_OF_PLAN) == pytest.approx(before, abs=5)  # a click while it moves is lost
    start.click()
    expect(page.locator("#plan .error")).to_contain_text("nobody")
    assert page.url.endswith(f"/jobs/{job}/statistics")


def test_sensitivities_are_a_follow_up_whose_intervals_appear(page: Page) -> None:
    page.get_by_role("button", name="Sensitivities at the optimum").click()
    expect(page.locator("#uncertainty li")).to_contain_text("Sensitivities at the optimum")
    expect(page.locator("#uncertainty .state")).to_have_text("finished")
    expect(page.locator("#uncertainty table")).to_contain_text("Standard error")
    assert page.locator("#uncertainty tbody tr").count() == 3


def test_statistics_can_be_used_by_everybody_on_a_dark_phone(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}/statistics", color_scheme="dark", viewport={"width": 390, "height": 844})
    expect(page.locator("#verdicts .card")).to_have_count(3)
    check_accessibility(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_job_without_evaluations_says_so(embedded: Site, visit: Visit) -> None:
    view, _ = embedded.service.submit(parse_problem(line_problem()))
    embedded.service.cancel(view.id)
    page, guard = visit(embedded, f"/jobs/{view.id}/statistics")
    guard.allow("409", "statistics")
    expect(page.locator("#nothing")).to_contain_text(re.compile("nothing to judge|Reading"))
    assert page.locator("h1 .state").inner_text() in ("cancelled", "finished")
