"""What a first-time user stumbled over, one test each."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.layout import check_layout, leaf_through
from tests.dashboard.test_job import SOON, textbook
from tests.dashboard.test_statistics import ended

Visit = Callable[..., Opened]
FORMAT = """async (base) => {
    const { age, coefficient, precise } = await import(base + "/js/format.js");
    const ago = (seconds) => age(new Date(Date.now() - 1000 * seconds).toISOString());
    return [ago(3), ago(35), ago(75), coefficient(-0.001), precise(2.34567, 0.75)];
}"""

LONG_TITLE = """async (base) => {
    const { plot } = await import(base + "/js/plot.js");
    const title = { text: "stage, each over log time from 0.1 to 2900 min" };
    const place = document.querySelector("#fit");
    const data = [{ x: [1, 2], y: [1, 2], name: "measured" }];
    const layout = { xaxis: { title }, yaxis: { title: { text: "y" } }, height: 300 };
    const make = () => ({ data, layout, label: "a line" });
    await plot(place, make).draw();
    return [...place.querySelectorAll(".xtitle tspan")].map((line) => line.textContent);
}"""


@pytest.fixture(scope="module")
def job(embedded: Site) -> str:
    model = {"kind": "formula", "series": {"y": {"expression": "a + b * x", "y_unit": "m"}}}
    readings = {"x": [0, 1, 2, 3], "y": [1000.0, 3020.0, 4990.0, 7010.0]}
    observations = [{"series": "y", "points": readings, "y_unit": "mm"}]
    changes = {"forward_model": model, "observations": observations, "stopping": {"max_evaluations": 240}}
    return ended(embedded.service, textbook(name="small things", **changes))


def test_numbers_and_ages_are_told_as_one_says_them(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/")
    told = page.evaluate(FORMAT, page.locator("body").get_attribute("data-static"))
    assert told == ["just now", "30 s ago", "1 min ago", "0.00", "2.35"]


def test_ages_grow_while_a_page_is_open(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, "/", own=True)
    page.clock.install()
    page.goto(f"/jobs/{job}")
    page.clock.run_for(3_600_000)
    expect(page.locator("time.age").first).to_have_text(re.compile("^1 h"))


def test_a_mistake_in_a_dialog_names_its_field(embedded: Site, visit: Visit, job: str) -> None:
    page, guard = visit(embedded, f"/jobs/{job}")
    guard.allow("422")
    page.get_by_role("button", name="Continue").click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Longest running time").fill("-1")
    dialog.get_by_role("button", name="Continue").click()
    expect(dialog.get_by_role("alert")).to_contain_text("Longest running time")
    expect(dialog.get_by_role("alert")).not_to_contain_text("body.")


def test_a_lost_connection_hides_no_message(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/workers")
    # Measured at once: the page's own connection withdraws the second message as soon as it hears from the service.
    said, lost = page.evaluate(
        """async (base) => {
            const { announce, connection } = await import(base + "/js/dom.js");
            announce("Paused.", 60000);
            connection("Connection lost; trying again …");
            return ["status", "connection"].map((id) => document.getElementById(id).getBoundingClientRect().toJSON());
        }""",
        page.locator("body").get_attribute("data-static"),
    )
    assert said["height"] > 0
    assert lost["height"] > 0
    assert said["bottom"] <= lost["top"]


@pytest.mark.slow
def test_a_report_is_made_with_a_word_on_it(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}/data")
    assert page.get_by_role("link", name="Report (page)").get_attribute("target") == "_blank"
    with page.expect_download(timeout=SOON) as download:
        page.get_by_role("link", name="Report (PDF)").click()
        expect(page.locator("#status")).to_contain_text("The report is")
    assert download.value.suggested_filename == f"report-{job}.pdf"
    assert page.url.endswith(f"/jobs/{job}/data")


def test_plots_of_the_search_fit_a_phone(embedded: Site, visit: Visit, job: str) -> None:
    """Times of the workers lay upon each other."""
    page, _ = visit(embedded, f"/jobs/{job}/search", viewport={"width": 390, "height": 844})
    expect(page.locator(".main-svg").first).to_be_visible(timeout=SOON)
    leaf_through(page)
    check_layout(page)


def test_plots_of_the_fit_fit_a_phone_and_a_long_title_has_two_lines(embedded: Site, visit: Visit, job: str) -> None:
    """The title below stages ended at the edge, and the toolbar lay upon the legend."""
    page, _ = visit(embedded, f"/jobs/{job}/fit", viewport={"width": 390, "height": 844})
    expect(page.locator("#fit .main-svg").first).to_be_visible(timeout=SOON)
    expect(page.locator("#fit .modebar-btn")).to_have_count(0)
    leaf_through(page)
    check_layout(page)
    lines = page.evaluate(LONG_TITLE, page.locator("body").get_attribute("data-static"))
    assert lines == ["stage, each over log time from 0.1", "to 2900 min"]
    check_layout(page)


def test_jobs_to_choose_from_keep_their_names(embedded: Site, visit: Visit, job: str) -> None:
    """The word for “ago” stood before the name of the job."""
    page, _ = visit(embedded, "/new", own=True, locale="de-DE")
    expect(page.locator(f"#earlier option[value='{job}']")).to_have_text(re.compile(r"^small things \(fertig, "))
    page.goto("/compare")
    expect(page.locator(f"#another option[value='{job}']")).to_have_text(f"small things (fertig, {job[:6]})")


def test_verdicts_are_seen_in_a_narrow_window(embedded: Site, visit: Visit, job: str) -> None:
    """The column had to be scrolled to."""
    page, _ = visit(embedded, f"/jobs/{job}", viewport={"width": 1040, "height": 900})
    verdict = page.locator("#parameters a.verdict").first
    expect(verdict).to_be_visible(timeout=SOON)
    verdict.evaluate("(one) => { one.textContent = 'undecided'; }")
    page.locator("#parameters td.n").first.evaluate("(one) => { one.textContent = '0.001636'; }")
    for width in (1040, 390):
        page.set_viewport_size({"width": width, "height": 900})
        expect(verdict).to_be_visible()
        assert page.locator("#parameters").evaluate("(one) => one.scrollWidth - one.clientWidth") <= 1


def test_all_forward_models_are_seen_at_once(embedded: Site, visit: Visit) -> None:
    """The last row, with the chosen model of a slope, was cut off and had to be scrolled."""
    page, _ = visit(embedded, "/new")
    choices = page.locator("fieldset.choices")
    expect(choices.locator("label").last).to_be_visible(timeout=SOON)
    assert choices.evaluate("(one) => one.scrollHeight - one.clientHeight") <= 1


def test_numbers_outside_the_usual_range_are_marked(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    expect(page.locator("#verdict")).to_contain_text("Complete", timeout=SOON)
    height = page.locator("[data-path='forward_model.height']")
    warning = page.locator(".field", has=height).locator(".unusual")
    expect(warning).to_be_hidden()
    height.fill("20")
    expect(warning).to_contain_text("Outside the usual range, 0.01 to 0.05 m")
    height.fill("20 mm")
    expect(warning).to_be_hidden()
    expect(page.locator("#yaml")).to_have_value(re.compile(r"height: 0\.02\n"))
    height.blur()
    expect(height).to_have_value("0.02")
    height.fill("20 kPa")
    expect(warning).to_contain_text("20 kPa cannot be given in m")
    expect(page.locator("#verdict")).not_to_contain_text("Complete")
    expect(page.locator("#start-now")).to_be_hidden()
    height.fill("1,250 mm")  # 1.25 or 1250
    expect(warning).to_contain_text("1,250 mm cannot be given in m")
    height.fill("2 cm")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    expect(page.locator("#start-now")).to_be_visible()
    bounds = page.locator("[data-bounds=lambda_star]")
    page.locator("[data-path='parameters.lambda_star.lower']").fill("0.02")
    page.locator("[data-path='parameters.lambda_star.upper']").fill("0.1")
    expect(bounds).to_contain_text("Searched within")
    page.locator("[data-path='parameters.lambda_star.upper']").fill("50")
    expect(bounds).to_contain_text("Searched beyond the usual range")


def test_units_are_switched_and_remembered_and_print_leaves_out_controls(
    embedded: Site, visit: Visit, job: str
) -> None:
    page, _ = visit(embedded, f"/jobs/{job}")
    page.evaluate("localStorage.clear()")
    expect(page.locator("#answer")).to_contain_text(" mm (root mean square)", timeout=SOON)
    before = float(re.findall(r"leaves ([\d.]+) mm", page.locator("#answer").inner_text())[0])
    page.get_by_label("Lengths").select_option("m")
    expect(page.locator("#answer")).to_contain_text(" m (root mean square)")
    after = float(re.findall(r"leaves ([\d.]+) m ", page.locator("#answer").inner_text())[0])
    assert after == pytest.approx(before / 1000, rel=0.01)
    expect(page.locator("#fit .multiples")).to_contain_text("[m]")
    page.reload()
    expect(page.locator("#answer")).to_contain_text(" m (root mean square)", timeout=SOON)
    expect(page.get_by_label("Lengths")).to_have_value("m")
    page.emulate_media(media="print")
    for gone in (".site nav", "#actions", ".tabs", "#next"):
        expect(page.locator(gone).first).to_be_hidden()
    expect(page.locator("#answer")).to_be_visible()
    expect(page.locator("#parameters")).to_be_visible()
    for path, there in (
        (f"/jobs/{job}/data", "#problem pre"),
        ("/workers", ".workers td"),
        ("/new?example=oedometer", ".step svg"),
    ):
        page.goto(path)
        expect(page.locator(there).first).to_be_visible()
        for gone in ("main button:not(.link)", "details:not([open]):not(#readings > *)"):
            expect(page.locator(gone).filter(visible=True)).to_have_count(0)


@pytest.mark.slow
def test_the_form_shows_what_is_done_and_folds_its_yaml(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    rail = page.get_by_role("navigation", name="Sections of the form")
    expect(rail.locator("a.open")).not_to_have_count(0, timeout=SOON)
    expect(rail).to_contain_text("not complete yet")
    page.goto("/new?example=oedometer")
    expect(rail.locator("a.good")).to_have_count(5, timeout=SOON)
    page.locator("#yaml-fold > summary").click()
    expect(page.locator("#yaml")).to_be_hidden()
    page.reload()
    expect(page.locator("#verdict")).to_contain_text("Complete", timeout=SOON)
    expect(page.locator("#yaml")).to_be_hidden()
    check_accessibility(page)


def test_a_job_is_found_by_its_tags_and_its_note_is_no_markup(embedded: Site, visit: Visit, job: str) -> None:
    page, guard = visit(embedded, f"/jobs/{job}")
    page.get_by_role("button", name="Name, tags and note").click()
    dialog = page.get_by_role("dialog")
    before = dialog.get_by_label("Name", exact=True).input_value()
    dialog.get_by_label("Name", exact=True).fill("  ")
    dialog.get_by_role("button", name="Save").click()
    expect(dialog.get_by_role("alert")).to_have_text("A job needs a name.")
    dialog.get_by_label("Name", exact=True).fill(" Dam, <b>core</b> ")
    dialog.get_by_label("Tags").fill("dam, " + "x" * 50)
    dialog.get_by_label("Note").fill(
        "# Specimen B\n\nwas *disturbed* <b>here</b> [x](javascript:alert(1)) ![y](/z.png)"
    )
    guard.allow("422")
    dialog.get_by_role("button", name="Save").click()
    expect(dialog.get_by_role("alert")).to_contain_text("at most 40 characters")
    dialog.get_by_label("Tags").fill("dam, second trial,")
    dialog.get_by_role("button", name="Save").click()
    note = page.get_by_role("region", name="Note")
    expect(note).to_contain_text("# Specimen B")
    expect(page.locator("h1")).to_contain_text("Dam, <b>core</b> finished")
    expect(page).to_have_title("✓ Dam, <b>core</b> · geoswarm")
    assert note.locator("em").inner_text() == "disturbed"
    assert note.locator("b, h1, img").count() == 0
    assert note.locator("a").get_attribute("href") == "/z.png"  # no picture, and no script
    check_accessibility(page, "main")
    page.locator("#label").get_by_role("link", name="second trial").click()
    expect(page.locator(f"tr[data-job='{job}']")).to_have_count(1)
    expect(page.locator("#total")).to_have_text("1 job that matches")
    check_accessibility(page)
    page.get_by_role("link", name="Remove the filter by tag second trial").click()
    expect(page.locator("#total")).not_to_contain_text("match")
    embedded.service.label(job, tags=[], note="", name=before)


@pytest.mark.slow
def test_parts_of_a_report_are_chosen(embedded: Site, visit: Visit) -> None:
    job = ended(embedded.service, textbook())
    page, _ = visit(embedded, f"/jobs/{job}/data")
    page.get_by_text("Choose the parts of the reports").click()
    for name in ("Figures", "Classical evaluation", "Tables", "Provenance and problem", "Verdicts"):
        page.get_by_role("checkbox", name=name).click()
    expect(page.get_by_role("checkbox", name="Verdicts")).to_be_checked()
    link = page.get_by_role("link", name="Report (page)")
    assert (link.get_attribute("href") or "").endswith("/report.html?part=verdicts")
