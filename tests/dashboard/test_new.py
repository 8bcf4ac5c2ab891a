"""The form of a new job: from a CSV to a running job, both ways between form and YAML, mistakes where they are."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, Route, expect

from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import load_problem, parse_problem
from tests.api.conftest import line_problem
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.solver.problem.test_measurements import ROWS, STRINGS, workbook

Visit = Callable[..., Opened]

CALM = 180_000
"""Longest wait for a calculation [ms]; the first test run starts a process."""

STAGES = [9, 13, 25, 50, 100, 200, 400, 800, 400, 200, 100, 50, 100, 200, 400, 800]
DURATIONS = [2, *[1] * 14, 1.7916666666666667]


@pytest.fixture(scope="module")
def readings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The readings of the published oedometer test as a laboratory would hand them over."""
    with example_file("oedometer") as path:
        points = load_problem(path).observations[0].points
    file = tmp_path_factory.mktemp("readings") / "clay.csv"
    rows = (f"{x};{y}".replace(".", ",") for x, y in zip(points.x, points.y, strict=True))
    file.write_text("Zeit [min];Setzung [mm]\n" + "\n".join(rows) + "\n", encoding="latin-1")
    return file


def paste(page: Page, selector: str, text: str) -> None:
    """Paste rows of a spreadsheet into a cell."""
    page.locator(selector).focus()
    page.evaluate(
        """([selector, text]) => {
            const data = new DataTransfer();
            data.setData("text", text);
            const pasting = new ClipboardEvent("paste", {clipboardData: data, bubbles: true, cancelable: true});
            document.querySelector(selector).dispatchEvent(pasting);
        }""",
        [selector, text],
    )


def fill(page: Page, **values: str) -> None:
    """Fill fields by their path in the problem, written with __ for the dot."""
    for path, value in values.items():
        page.locator(f'[data-path="{path.replace("__", ".")}"]').fill(value)


def parameter(page: Page, name: str, mode: str, **values: str) -> None:
    page.get_by_label(f"Mode of {name}", exact=True).select_option(mode)
    for key, value in values.items():
        page.locator(f'[data-path="parameters.{name}.{key}"]').fill(value)


def build_oedometer(page: Page, readings: Path) -> None:
    """What a new user does: the whole published job, by hand."""
    fill(page, name="clay of San Cassiano")
    page.locator('input[name="kind"][value="oedometer"]').check()
    fill(page, forward_model__height="0,02021", forward_model__initial_stress="0.2")
    page.get_by_role("button", name="Add a row").click()
    paste(
        page,
        '[data-path="forward_model.stages[0].stress"]',
        "\n".join(f"{stress}\t{duration}" for stress, duration in zip(STAGES, DURATIONS, strict=True)),
    )
    expect(page.locator('[data-path="forward_model.stages[15].duration"]')).to_have_value("1.7916666666666667")
    expect(page.get_by_label("Mode of lambda_star")).to_be_visible()  # the forward model is known now

    page.locator("#file").set_input_files(readings)
    mapping = page.locator(".mapping")
    expect(mapping.locator("#map-series option:checked")).to_have_text("settlement")
    expect(mapping.get_by_label("Unit of x")).to_have_value("min")
    expect(mapping.get_by_label("Unit of y")).to_have_value("mm")
    expect(mapping.get_by_role("status")).to_have_text("226 readings.")
    expect(mapping.locator(".main-svg").first).to_be_visible()
    drawn = mapping.locator(".js-plotly-plot")
    assert drawn.evaluate("({ _fullLayout: { yaxis } }) => yaxis.range[0] > yaxis.range[1]")  # settlements downwards
    mapping.get_by_role("button", name="Add settlement", exact=True).click()
    expect(page.locator(".observation")).to_contain_text("226 readings")

    parameter(page, "lambda_star", "free", lower="0.002", upper="1.0")
    expect(page.locator('[data-path="parameters.lambda_star.scale"]')).to_be_checked()  # its usual range: 0.01 to 0.3
    parameter(page, "kappa_star", "free", lower="0.001", upper="0.5")
    parameter(page, "c", "free", lower="0.001", upper="100")
    parameter(page, "mu_star", "fixed", value="1.46e-3")
    parameter(page, "phi", "fixed", value="20")
    page.get_by_text("Further parameters").click()
    parameter(page, "psi", "fixed", value="0")
    page.get_by_role("button", name="Add lambda_star > kappa_star").click()
    page.get_by_label("Particles").fill("10")
    fill(page, stopping__max_evaluations="60", stopping__stagnation_generations="", stopping__target_objective="5e-9")
    page.get_by_text("More: seed").click()
    fill(page, seed="2008")
    expect(page.locator("#verdict")).to_have_text("Complete and valid: ready to start.")
    expect(page.locator(".observation")).to_contain_text("100.0 %")


def check_and_start(page: Page) -> str:
    page.get_by_role("button", name="Check", exact=True).click()
    result = page.locator("#check-body")
    expect(result).to_contain_text("The forward calculation works", timeout=CALM)
    expect(result).to_contain_text("at most 60 evaluations, about")
    expect(result).to_contain_text("the search leaves 15 of them for minimum and intervals")
    expect(result.locator(".panel .main-svg").first).to_be_visible()
    expect(result.get_by_role("figure")).to_have_attribute("aria-label", re.compile("226 readings and the test run"))
    check_accessibility(page)
    page.get_by_role("button", name="Start the job").click()
    page.wait_for_url(re.compile(r"/jobs/[0-9a-f]{16}$"))
    return page.url.rpartition("/")[2]


def published() -> dict[str, object]:
    """The published problem but for the name and the shorter search that are given in the form."""
    with example_file("oedometer") as path:
        document = load_problem(path).document()
    stopping = {"max_evaluations": 60, "target_objective": 5e-9}
    return document | {"name": "clay of San Cassiano", "stopping": stopping}


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_new_user_builds_the_published_job_from_a_csv(embedded: Site, visit: Visit, readings: Path) -> None:
    page, _ = visit(embedded, "/new")
    build_oedometer(page, readings)
    job = check_and_start(page)
    assert embedded.service.problem(job) == published()
    expect(page.locator("h1")).to_contain_text("clay of San Cassiano")
    expect(page.locator("h1 .state")).to_have_text("finished", timeout=CALM)
    page.goto("/new")
    expect(page.locator('[data-path="name"]')).to_have_value("calibration")  # what was submitted is not kept


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_same_with_keys_and_workers(full: Site, visit: Visit, readings: Path) -> None:
    page, _ = visit(full, "/new", key=full.key("alice"))
    build_oedometer(page, readings)
    job = check_and_start(page)
    assert full.service.problem(job) == published()
    expect(page.locator("h1 .state")).to_have_text("finished", timeout=CALM)


@pytest.mark.slow
def test_a_sheet_of_a_workbook_is_mapped(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new?example=formula")
    guard.allow("422")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    notes = '<row r="1"><c r="A1" t="inlineStr"><is><t>day</t></is></c></row><row r="2"><c r="A2"><v>3</v></c></row>'
    content = workbook(("Notes", notes), ("Readings", ROWS), strings=STRINGS)
    page.locator("#file").set_input_files({"name": "clay.xlsx", "mimeType": "", "buffer": content})
    mapping = page.locator(".mapping")
    mapping.get_by_label("Sheet").select_option("Readings")
    expect(mapping.get_by_label("Unit of y")).to_have_value("mm")
    expect(mapping.get_by_role("alert")).to_contain_text(
        "line 5, column settlement (mm): '#N/A' is not a finite number"
    )
    expect(page.locator("#take")).to_be_disabled()
    mapping.get_by_label("Leave out rows without a number").check()
    said = mapping.get_by_role("status")
    expect(said).to_have_text("2 readings. 1 row of clay.xlsx without a number in every column was left out.")
    mapping.get_by_text("More about these columns").click()
    mapping.get_by_label("Reverse the sign of y").check()
    mapping.get_by_role("button", name=re.compile(r"^Replace settlement \(\d+ readings\)$")).click()
    area = page.get_by_label("The problem as YAML")
    expect(area).to_have_value(re.compile(r"x: \[1\.5, 45\]"))
    assert "y: [0.25, 0.5]" in area.input_value()
    assert "y_factor: -1" in area.input_value()
    assert "without a number in every column was left out" in area.input_value()


def test_form_and_yaml_follow_each_other_and_the_download_is_a_problem_file(
    embedded: Site, visit: Visit, tmp_path: Path
) -> None:
    page, _ = visit(embedded, "/new?example=formula")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    with page.expect_download() as started:
        page.get_by_role("button", name="Download", exact=True).click()
    started.value.save_as(tmp_path / "problem.yaml")
    with example_file("formula") as path:
        assert load_problem(tmp_path / "problem.yaml") == load_problem(path)
    area = page.get_by_label("The problem as YAML")
    lower = page.locator('[data-path="parameters.s_end.lower"]')
    expect(lower).to_have_value("0.05")
    lower.fill("0.1")
    expect(area).to_have_value(re.compile(r"s_end: \{lower: 0\.1,"))
    area.fill(area.input_value().replace("t_half: {lower: 5, upper: 2000, scale: log}", "t_half: {value: 140}"))
    expect(page.get_by_label("Mode of t_half")).to_have_value("fixed")
    expect(page.locator('[data-path="parameters.t_half.value"]')).to_have_value("140")
    area.fill("name: [half\n")
    expect(page.locator("#issues")).to_contain_text("YAML syntax error")
    expect(page.locator('[data-path="parameters.t_half.value"]')).to_have_value("140")  # the form keeps what it had
    with page.expect_download() as started:
        page.get_by_role("button", name="Download", exact=True).click()
    assert started.value.suggested_filename == "hyperbolic-settlement.yaml"


def test_mistakes_appear_where_they_are_while_one_types(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    constraint = page.get_by_label("Constraint 1", exact=True)
    expect(constraint).to_have_value("lambda_star > kappa_star")
    constraint.press("End")
    page.keyboard.type(" + gamma")
    expect(page.locator('[data-error="constraints[0]"]')).to_contain_text("unknown gamma")
    expect(constraint).to_have_attribute("aria-invalid", "true")
    constraint.fill("lambda_star > kappa_star")
    expect(page.locator('[data-error="constraints[0]"]')).to_be_empty()
    stress = page.locator('[data-path="forward_model.stages[2].stress"]')
    stress.fill("2.5 mm")
    expect(page.locator('[data-error="forward_model.stages[2].stress"]')).to_contain_text("must be a number")
    expect(page.get_by_label("Unit of settlement")).to_have_value("mm")  # what is known of the test stays
    stress.fill("25")
    page.locator('[data-path="parameters.c.upper"]').fill("0.0001")
    expect(page.locator('[data-error="parameters.c.lower"]')).to_contain_text("must be below upper")
    page.get_by_role("button", name="line 28").click()
    expect(page.locator('[data-path="parameters.c.lower"]')).to_be_focused()
    check_accessibility(page)
    page.get_by_role("button", name="Start the job").click()
    expect(page.locator("#check-body [role=alert]")).to_contain_text("One thing is missing or wrong")
    yaml = page.locator("#yaml")
    swarm = "method: {kind: particle_swarm, form: constriction, social_coefficient: 1}\n"
    yaml.fill(re.sub(r"^method:.*\n", swarm, yaml.input_value(), flags=re.MULTILINE))
    expect(page.locator('[data-error="method"]')).to_contain_text("“Cognitive coefficient” + “Social coefficient”")
    assert page.url.endswith("/new?example=oedometer")


@pytest.mark.slow
def test_it_begins_with_an_earlier_job(embedded: Site, visit: Visit) -> None:
    with example_file("isotropic_compression") as path:
        view, _ = embedded.service.submit(load_problem(path))
    embedded.service.cancel(view.id)
    page, _ = visit(embedded, "/new")
    page.get_by_label("or with an earlier job").select_option(view.id)
    page.wait_for_url(f"**/new?from={view.id}")
    expect(page.locator('[data-path="name"]')).to_have_value("isotropic-san-cassiano again")
    expect(page.locator(".observation")).to_have_count(2)
    shares = page.locator("[data-share]")
    page.get_by_label("Weights of the series").select_option(label="by range: relative to the range of each series")
    words = "Share of the objective, each series missed by the same part of its range"
    expect(shares).to_have_text([f"{words}: 50.0 %", f"{words}: 50.0 %"])
    page.locator('[data-path="observations[0].weight"]').fill("3")
    expect(shares).to_have_text([f"{words}: 75.0 %", f"{words}: 25.0 %"])
    area = page.get_by_label("The problem as YAML")
    expect(area).to_have_value(re.compile("weighting: by_range"))
    assert "discretization" not in area.input_value()  # what holds anyway is left out
    assert "seed" not in area.input_value()


def answer_late(route: Route) -> None:
    time.sleep(0.5)
    route.continue_()


def test_a_draft_outlives_a_reload_and_can_be_thrown_away(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    page.route("**/examples/formula", answer_late)
    page.get_by_label("Start from an example").select_option("formula")
    page.locator('[data-path="name"]').fill("mine")  # not before the example is there, which would overwrite it
    expect(page.get_by_label("The problem as YAML")).to_have_value(re.compile("^name: mine\n"))
    page.reload()
    expect(page.locator('[data-path="name"]')).to_have_value("mine")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    page.get_by_role("button", name="Start over").click()
    expect(page.locator('[data-path="name"]')).to_have_value("calibration")
    expect(page.locator("#verdict")).to_have_text("3 still missing")
    assert page.locator(".observation").count() == 0


def test_an_example_that_comes_too_late_is_left_out(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    held: list[Route] = []
    page.route("**/examples/formula", lambda route: held.append(route))
    page.get_by_label("Start from an example").select_option("formula")
    expect(page.locator('[data-path="name"]')).to_be_disabled()
    page.get_by_role("button", name="Start over").click()
    with page.expect_response("**/examples/formula"):
        held[0].continue_()
    page.locator('[data-path="name"]').fill("mine")
    expect(page.get_by_label("The problem as YAML")).to_have_value(re.compile("^name: mine\nmethod"))


def test_a_check_that_fails_says_why(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new?example=formula")
    page.locator('[data-path="forward_model.series.settlement.expression"]').fill("s_end * x / (t_half - t_half)")
    expect(page.get_by_label("The problem as YAML")).to_have_value(re.compile("t_half - t_half"))
    page.get_by_role("button", name="Check", exact=True).click()
    alert = page.locator("#check-body [role=alert]")
    expect(alert).to_contain_text("not_finite", timeout=CALM)
    guard.allow("422")
    page.locator("#file").set_input_files({"name": "a.xls", "mimeType": "", "buffer": b"\xd0\xcf\x11\xe0"})
    expect(page.get_by_role("alert").filter(has_text="old form")).to_be_visible()
    assert page.locator(".mapping").count() == 0


@pytest.mark.slow
def test_a_check_warns_of_what_is_probably_not_meant(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    expect(page.get_by_text("do not contain primary consolidation").first).to_be_visible(timeout=CALM)
    page.locator('[data-path="forward_model.height"]').fill("20")
    expect(page.get_by_label("The problem as YAML")).to_have_value(re.compile("height: 20\n"))
    told = page.locator(".observation")
    expect(told).to_contain_text("is only 0.00018 of the height of the specimen, 20 m")  # 3.7 mm
    expect(told).to_contain_text("“Unit of settlement” m, or check “Height”")
    page.get_by_label("The readings of settlement are meant as they are").check()
    page.get_by_role("button", name="Check", exact=True).click()
    warning = page.locator("#check-body .notes[role=alert]")
    expect(warning).to_contain_text("“Height” = 20 m is far from what is usual", timeout=CALM)
    expect(warning).to_contain_text("if 20 mm is meant, give 0.02")


def test_readers_are_told_that_they_may_not_submit(full: Site, visit: Visit) -> None:
    page, _ = visit(full, "/new", key=full.key("auditor", "read"))
    expect(page.locator("main")).to_contain_text("This API key is read-only")
    assert page.locator("form, #yaml").count() == 0


def test_nobody_begins_with_a_job_of_another_owner(full: Site, visit: Visit) -> None:
    full.service.submit(parse_problem(line_problem(name="nobody's")))
    (job,) = [one.id for one in full.service.list(limit=10).items if one.name == "nobody's"]
    page, guard = visit(full, f"/new?from={job}", key=full.key("bob"))
    guard.allow("404")
    expect(page.locator("h1")).to_have_text("Job not found")
    assert "nobody's" not in page.content()


def test_readings_are_prepared_and_gross_errors_marked(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=formula")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    page.get_by_text("Prepare the readings").click()
    page.get_by_text("Leave readings out").click()
    page.get_by_label("Zero reading").select_option(label="the first reading")
    page.get_by_label("Factor of y").fill("-1")
    thinned = page.get_by_label("Means per decade of x")
    thinned.fill("3")
    page.get_by_label("Gross errors").fill("2, 3")
    area = page.get_by_label("The problem as YAML")
    expect(area).to_have_value(re.compile(r"y_zero: first\n +y_factor: -1\n"))
    expect(area).to_have_value(re.compile(r"gross_errors: \[2, 3\]"))
    expect(area).to_have_value(re.compile("per_decade: 3"))
    expect(page.locator("#verdict")).to_contain_text("Complete")
    thinned.fill("")
    expect(area).not_to_have_value(re.compile("resample"))
    expect(page.locator("#verdict")).to_contain_text("Complete")
    assert "gross_errors: [2, 3]" in area.input_value()
