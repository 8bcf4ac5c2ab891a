"""Importing readings: what a file holds is shown, what is in doubt is asked, and only then it is taken."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.layout import check_layout
from tests.solver.problem.test_doubtful_files import COVER, READINGS, UNCALCULATED
from tests.solver.problem.test_laboratory_files import SIDE_BY_SIDE, sheet_rows
from tests.solver.problem.test_measurements import workbook
from tests.variants import variants

Visit = Callable[..., Opened]

OWN = "Zeit [min];Setzung [mm]\n1;0,25\n2;0,5\n4;0,75\n"
PHONE: dict[str, Any] = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark"}


def drop(page: Page, content: str | bytes, name: str = "own.csv") -> Locator:
    """Choose a file; the form that maps it."""
    expect(page.locator("#verdict")).not_to_be_empty()
    data = content.encode() if isinstance(content, str) else content
    page.locator("#file").set_input_files({"name": name, "mimeType": "", "buffer": data})
    mapping = page.locator(".mapping")
    expect(mapping).to_be_visible()
    return mapping


def chosen(mapping: Locator, label: str) -> Locator:
    """What is chosen in a select."""
    return mapping.get_by_label(label, exact=True).locator("option:checked")


def more(mapping: Locator) -> None:
    mapping.get_by_text("More about these columns").click()


def yaml(page: Page) -> Locator:
    return page.get_by_label("The problem as YAML")


def test_an_own_file_replaces_the_readings_of_its_series(embedded: Site, visit: Visit) -> None:
    """It went to axial_strain, the next free series, beside the 226 readings of the example."""
    page, _ = visit(embedded, "/new?example=oedometer")
    expect(page.locator(".observation")).to_contain_text("226 readings")
    mapping = drop(page, OWN)
    expect(chosen(mapping, "Series")).to_have_text("settlement: replaces 226 readings")
    expect(mapping.get_by_label("Unit of y")).to_have_value("mm")
    expect(mapping.get_by_role("status")).to_have_text("3 readings.")
    expect(mapping.get_by_role("cell", name="0,25")).to_be_visible()  # as it stands in the file
    expect(mapping.get_by_role("figure")).to_have_attribute("aria-label", re.compile("^settlement.* 3 readings"))
    check_accessibility(page, ".mapping")
    mapping.get_by_role("button", name="Replace settlement (226 readings)", exact=True).click()
    expect(page.locator(".observation")).to_have_count(1)
    expect(page.locator(".observation")).to_contain_text("3 readings")
    expect(page.locator(".undo")).to_contain_text("226 readings of settlement were replaced by those of own.csv.")
    page.get_by_role("button", name="Undo", exact=True).click()
    expect(page.locator(".observation")).to_contain_text("226 readings")


@pytest.mark.slow
def test_another_series_is_added(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    expect(page.locator(".observation")).to_contain_text("226 readings")
    mapping = drop(page, "Zeit [min];bezogene Setzung [%]\n1;0,25\n2;0,5\n")
    expect(chosen(mapping, "Series")).to_have_text("axial_strain")
    mapping.get_by_role("button", name="Add axial_strain", exact=True).click()
    expect(page.locator(".observation")).to_have_count(2)
    expect(yaml(page)).to_have_value(re.compile(r"series: axial_strain\s[^-]*x_unit: min\s[^-]*y_unit: [\"']?%"))
    check_accessibility(page)


@pytest.mark.parametrize(
    ("heading", "unit"),
    variants([("settlement [kPa]", "kPa"), ("Setzung [min]", "min")], {"settlement [kPa]"}),
)
def test_a_unit_of_another_dimension_blocks(embedded: Site, visit: Visit, heading: str, unit: str) -> None:
    """Kilopascals became metres."""
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, f"time [min],{heading}\n1,2\n2,3\n")
    said = f"“{heading}” is in {unit}, but settlement needs a unit such as um, mm, cm"
    expect(mapping.get_by_role("alert")).to_contain_text(said)
    expect(mapping.get_by_label("Unit of y")).to_have_value(unit)
    expect(page.locator("#take")).to_be_disabled()
    mapping.get_by_label("Unit of y").fill("mm")  # the heading was wrong
    expect(page.locator("#take")).to_be_enabled()
    mapping.get_by_label("Unit of y").fill("MPa")
    expect(mapping.get_by_role("alert")).to_contain_text("MPa is given, but settlement needs a unit")
    expect(page.locator("#take")).to_be_disabled()
    check_accessibility(page, ".mapping")


@pytest.mark.parametrize(
    ("heading", "unit", "asked"),
    variants(
        [
            ("Setzung 1/100 mm", "0.01 mm", None),
            ("Setzung in Millimeter", "mm", None),
            ("Setzung", "", "“Setzung” has no unit: give the unit of y."),
            ("Setzung [div]", "", "“Setzung [div]” names 'div', which is not a known unit: give the unit of y."),
            ("Setzung [mm] [µm]", "", "“Setzung [mm] [µm]” names several units, mm and um: give the unit of y."),
        ],
        {"Setzung"},
    ),
)
def test_a_unit_is_found_or_asked_for(embedded: Site, visit: Visit, heading: str, unit: str, asked: str | None) -> None:
    """Settlements in hundredths of a millimetre became metres."""
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, f"Zeit [min];{heading}\n1;25\n2;50\n4;75\n")
    expect(chosen(mapping, "Series")).to_have_text("settlement: replaces 226 readings")
    expect(mapping.get_by_label("Unit of y")).to_have_value(unit)
    take = page.locator("#take")
    if asked is not None:
        expect(mapping.locator(".todo")).to_have_text(asked)
        expect(take).to_be_disabled()
        check_accessibility(page, ".mapping")
        mapping.get_by_label("Unit of y").fill("0.01 mm")
    take.click()
    expect(yaml(page)).to_have_value(re.compile(f'y_unit: "?{unit or "0.01 mm"}'))


@pytest.mark.slow
def test_the_unit_of_chosen_cells_is_found(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(
        page, workbook(("s", sheet_rows(("Zeit [min]", "Kanal [mm]", "Kanal"), (1, 0.25, 7), (2, 0.5, 8)))), "own.xlsx"
    )
    mapping.get_by_label("Series").select_option(label="settlement: replaces 226 readings")
    mapping.get_by_label("Column of y", exact=True).select_option(label="by cells or name …")
    mapping.get_by_label("Cells of y").fill("B2:B3")
    expect(mapping.get_by_label("Unit of y")).to_have_value("mm")
    expect(page.locator("#take")).to_be_enabled()
    mapping.get_by_label("Cells of y").fill("C2:C3")
    expect(mapping.locator(".todo")).to_have_text("The column of y has no unit: give the unit of y.")
    expect(page.locator("#take")).to_be_disabled()


@pytest.mark.slow
def test_readings_larger_than_the_specimen_are_stopped_before_the_start(embedded: Site, visit: Visit) -> None:
    """The form said "Complete and sound", and the search ran to its bounds."""
    page, _ = visit(embedded, "/new?example=oedometer")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    page.get_by_label("Unit of settlement").fill("m")
    verdict = page.locator("#verdict")
    expect(verdict).not_to_contain_text("Complete")
    told = page.locator(".observation")
    expect(told).to_contain_text("in mm it would be 0.18 of it: “Unit of settlement” mm; “The readings of")
    expect(told).not_to_contain_text("y_unit")
    page.get_by_role("button", name="Start the job", exact=True).click()
    expect(page.get_by_role("alert").filter(has_text="One thing is missing or wrong")).to_be_visible()
    for place in (".observation", "#check-body"):
        check_accessibility(page, place)
    check_layout(page)
    meant = page.get_by_label("The readings of settlement are meant as they are")
    meant.check()
    expect(verdict).to_contain_text("Complete")
    expect(yaml(page)).to_have_value(re.compile(r"accept: \[settlement\]"))
    meant.uncheck()
    expect(verdict).not_to_contain_text("Complete")
    expect(yaml(page)).not_to_have_value(re.compile("accept"))
    page.get_by_label("Unit of settlement").fill("mm")
    expect(verdict).to_contain_text("Complete")
    expect(meant).to_have_count(0)


@pytest.mark.parametrize(
    ("answer", "y"),
    variants([("a point before decimals", "1000, 2000"), ("a comma before", "1, 2")], {"a point before decimals"}),
)
def test_thousands_are_asked_for(embedded: Site, visit: Visit, answer: str, y: str) -> None:
    """Quoted "1,000" and "2,000" became 1 and 2."""
    page, _ = visit(embedded, "/new?example=formula")
    mapping = drop(page, 'time [day],settlement [mm]\n1,"1,000"\n2,"2,000"\n')
    expect(mapping.get_by_text("“1,000” in settlement [mm] can be one thousand or one: say how")).to_be_visible()
    expect(page.locator("#take")).to_be_disabled()
    check_accessibility(page, ".mapping")
    signs = mapping.get_by_label("How are numbers written?")
    signs.select_option(index=1 if "point" in answer else 2)
    expect(signs.locator("option:checked")).to_contain_text(answer)
    mapping.get_by_role("button", name=re.compile("^Replace settlement")).click()
    expect(yaml(page)).to_have_value(re.compile(rf"y: \[{y}\]"))


@pytest.mark.slow
def test_the_cover_of_a_workbook_is_passed_over_and_all_sheets_are_offered(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, workbook(("Cover", COVER), ("Readings", READINGS)), "clay.xlsx")
    expect(chosen(mapping, "Sheet")).to_have_text("Readings")
    expect(chosen(mapping, "Series")).to_have_text("settlement: replaces 226 readings")
    mapping.get_by_label("Sheet").select_option("Cover")
    expect(page.locator(".mapping").get_by_role("alert")).to_contain_text("Sheet “Cover” has no column of numbers")
    expect(page.locator("#take")).to_be_disabled()
    page.locator(".mapping").get_by_label("Sheet").select_option("Readings")
    expect(page.locator("#take")).to_be_enabled()
    check_accessibility(page, ".mapping")


@pytest.mark.slow
def test_formulas_without_values_are_named(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new?example=formula")
    guard.allow("422")
    mapping = drop(page, workbook(("s", UNCALCULATED)), "clay.xlsx")
    expect(mapping.get_by_role("alert").first).to_contain_text(
        "without a stored value, which cannot be read: B3 (=B2*2), B4"
    )
    expect(page.locator("#take")).to_be_disabled()
    check_accessibility(page)


@pytest.mark.slow
def test_headings_that_say_nothing_are_not_guessed(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, "Kanal 1;Kanal 2\n1;0,5\n2;0,7\n")
    expect(chosen(mapping, "Series")).to_have_text("choose …")
    expect(page.locator("#take")).to_be_disabled()
    expect(mapping.locator(".todo")).to_contain_text("Choose the series that these readings belong to.")
    mapping.get_by_label("Series").select_option(label="settlement: replaces 226 readings")
    mapping.get_by_label("Column of y", exact=True).select_option(label="Kanal 2")
    mapping.get_by_label("Column of x", exact=True).select_option(label="Kanal 1")
    replace = mapping.get_by_role("button", name="Replace settlement (226 readings)", exact=True)
    expect(mapping.locator(".todo")).to_have_text(
        "“Kanal 2” has no unit: give the unit of y.“Kanal 1” has no unit: give the unit of x."
    )
    expect(mapping.get_by_label("Unit of y")).to_have_value("")
    expect(mapping.get_by_role("status")).to_have_text("2 readings.")
    expect(replace).to_be_disabled()
    mapping.get_by_label("Unit of y").fill("mm")
    expect(replace).to_be_disabled()
    mapping.get_by_label("Unit of x").fill("min")
    expect(replace).to_be_enabled()
    check_accessibility(page, ".mapping")


SPECIMENS = (
    "Probe;Datum;Uhrzeit;links [mm];rechts [mm];Bemerkung\n"
    "S1;01.03.2024;08:00;5;1;\n;01.03.2024;20:00;6;1;\n"
    "S2;01.03.2024;08:00;7;2;\n;01.03.2024;20:00;90;2;gestoßen\n;02.03.2024;08:00;9;2,5;\n"
)


@pytest.mark.slow
def test_specimens_two_gauges_times_and_gross_errors(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=formula")
    mapping = drop(page, SPECIMENS)
    mapping.get_by_label("Column of y", exact=True).select_option(label="links [mm]")
    mapping.get_by_label("Column of x", exact=True).select_option(label="Datum")
    expect(mapping.locator(".todo")).to_contain_text("Choose the specimen.")
    mapping.get_by_label("Which Probe?").select_option(label="S2 (3 rows)")
    more(mapping)
    mapping.get_by_label("Subtract from y").select_option(label="rechts [mm]")
    mapping.get_by_label("Time of day").select_option(label="Uhrzeit")
    mapping.get_by_label("Gross errors").select_option(label="Bemerkung")
    mapping.get_by_label("x = 0 is at").fill("2024-02-29 08:00")
    mapping.get_by_label("Where the readings come from").fill("laboratory journal 7")
    said = mapping.get_by_role("status")
    expect(said).to_contain_text("3 readings. 1 of them are gross errors.")
    expect(said).to_contain_text("Y is the difference of two columns: links [mm] less rechts [mm].")
    check_accessibility(page, ".mapping")
    check_layout(page)
    page.locator("#take").click()
    area = yaml(page)
    expect(area).to_have_value(re.compile(r"x: \[1, 1\.5, 2\]\s+y: \[5, 88, 6\.5\]"))
    expect(area).to_have_value(re.compile(r"gross_errors: \[2\]"))
    expect(area).to_have_value(re.compile("laboratory journal 7"))
    expect(area).to_have_value(re.compile("rows of own.csv with Probe = S2"))
    expect(page.locator("#verdict")).to_contain_text("Complete")


@pytest.mark.slow
def test_dates_that_can_be_read_in_two_ways_are_asked_for(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=formula")
    mapping = drop(page, "date,settlement [mm]\n03/04/2024,1\n05/04/2024,2\n")
    expect(mapping.locator(".todo")).to_contain_text("“03/04/2024” in date can be read in two ways")
    mapping.get_by_label("How are dates written?").select_option(label="31/12/2024: the day first")
    expect(mapping.get_by_role("status")).to_have_text("2 readings. X counts from 2024-04-03 00:00:00.")
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile(r"x: \[0, 2\]\s+y: \[1, 2\]"))
    check_accessibility(page)


@pytest.mark.slow
def test_blocks_side_by_side_are_told_by_cells(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new?example=formula")
    guard.allow("422")
    mapping = drop(page, workbook(("s", sheet_rows(*SIDE_BY_SIDE))), "clay.xlsx")
    mapping.get_by_label("Column of y", exact=True).select_option(label="s (E)")
    mapping.get_by_label("Column of x", exact=True).select_option(label="t (D)")
    expect(mapping.get_by_role("status")).to_have_text("2 readings.")
    mapping.get_by_label("Column of y", exact=True).select_option(label="by cells or name …")
    mapping.get_by_label("Cells of y").fill("B3:B5")
    mapping.get_by_label("Column of x", exact=True).select_option(label="by cells or name …")
    mapping.get_by_label("Cells of x").fill("A3:A9")
    expect(mapping.get_by_role("alert")).to_contain_text("reach beyond the sheet")
    mapping.get_by_label("Cells of x").fill("A3:A5")
    expect(mapping.get_by_role("status")).to_have_text("3 readings.")
    mapping.get_by_label("Unit of y").fill("mm")
    mapping.get_by_label("Unit of x").fill("day")
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile(r"x: \[0\.5, 1\.5, 2\.5\]\s+y: \[1, 2, 3\]"))
    check_accessibility(page)


@pytest.mark.slow
def test_further_quantities_of_a_formula(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=formula")
    mapping = drop(page, "time [day],settlement [mm],temperature\n1,5,20\n2,6,21\n")
    more(mapping)
    mapping.get_by_role("button", name="Add a further quantity").click()
    mapping.get_by_label("Name of quantity 1").fill("T")
    mapping.locator("#map-input-0-column").select_option(label="temperature")
    expect(mapping.get_by_role("status")).to_have_text("2 readings.")
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile(r"inputs:\s+T: \[20, 21\]"))
    check_accessibility(page)


@pytest.mark.slow
@pytest.mark.parametrize("content", [OWN, SPECIMENS])
def test_the_import_fits_a_phone(embedded: Site, visit: Visit, content: str) -> None:
    page, _ = visit(embedded, "/new?example=oedometer", **PHONE)
    mapping = drop(page, content)
    more(mapping)
    check_layout(page)
    check_accessibility(page)


@pytest.mark.slow
def test_readings_are_prepared_in_every_way_of_the_problem_file(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=formula")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    page.get_by_text("Prepare the readings").click()
    page.get_by_label("Zero reading", exact=True).select_option(label="the reading at an x")
    page.get_by_label("Zero reading at").fill("14")
    expect(yaml(page)).to_have_value(re.compile(r"y_zero: \{x: 14\}"))
    page.get_by_label("Zero reading", exact=True).select_option(label="a known value")
    page.get_by_label("Value of the zero reading").fill("3.2")
    expect(yaml(page)).to_have_value(re.compile(r"y_zero: \{y: 3\.2\}"))
    page.get_by_label("Put them in the order of x").check()
    page.get_by_label("Readings at equal x").select_option(label="become their mean")
    page.get_by_label("Means of this many consecutive readings").fill("2")
    expect(yaml(page)).to_have_value(re.compile("sort: true.*repeated_x: average.*every: 2", re.DOTALL))
    expect(page.locator("#verdict")).to_contain_text("Complete")
    page.get_by_label("Zero reading", exact=True).select_option(label="none")
    expect(yaml(page)).not_to_have_value(re.compile("y_zero"))
    expect(page.locator("#verdict")).to_contain_text("Complete")
    check_accessibility(page, ".observation")


@pytest.mark.slow
def test_gross_errors_are_crosses_beside_the_test_run(embedded: Site, visit: Visit) -> None:
    """The calculated curve was put at the x of the first readings, gross errors or not."""
    page, _ = visit(embedded, "/new?example=formula")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    page.get_by_text("Leave readings out").click()
    page.get_by_label("Gross errors").fill("1, 3")
    expect(yaml(page)).to_have_value(re.compile(r"gross_errors: \[1, 3\]"))
    page.get_by_role("button", name="Check", exact=True).click()
    figure = page.locator("#check-body").get_by_role("figure")
    expect(figure).to_have_attribute(
        "aria-label", re.compile("14 readings and the test run, 2 marked as gross errors"), timeout=90_000
    )
    expect(figure.locator(".main-svg").first).to_be_visible()
    traces = figure.evaluate("(plot) => plot.data.map(({name, x}) => [name, x])")
    found = dict(traces)
    assert found["gross error"] == [7, 21]
    assert found["calculated"] == pytest.approx(found["measured"], rel=1e-9)
    assert found["measured"][:3] == [14, 30, 45]


@pytest.mark.slow
def test_what_is_replaced_can_be_brought_back(embedded: Site, visit: Visit) -> None:
    """Sixteen stages were gone with another forward model, everything with an example or an empty form."""
    page, _ = visit(embedded, "/new?example=oedometer")
    stage = page.locator('[data-path="forward_model.stages[15].stress"]')
    expect(stage).to_have_value("800")
    page.locator("input[name=kind][value=formula]").check()
    expect(page.locator(".undo")).to_contain_text("formula instead of oedometer: ")
    expect(page.locator(".undo")).to_contain_text("stages")
    expect(stage).to_have_count(0)
    page.get_by_role("button", name="Undo", exact=True).click()
    expect(stage).to_have_value("800")
    page.locator("input[name=kind][value=consolidation]").check()
    expect(page.locator('[data-path="forward_model.stages[15].stress"]')).to_have_value("800")  # what fits is kept
    expect(page.locator('[data-path="forward_model.height"]')).to_have_value("0.02021")
    page.locator("input[name=kind][value=formula]").check()
    page.locator("input[name=kind][value=oedometer]").check()  # back by hand: the section is still there
    expect(stage).to_have_value("800")
    page.get_by_label("Start from an example").select_option("formula")
    expect(page.locator(".undo")).to_contain_text("has replaced what was here.")
    expect(page.locator('[data-path="name"]')).to_have_value("hyperbolic-settlement")
    page.get_by_role("button", name="Undo", exact=True).click()
    expect(stage).to_have_value("800")
    page.get_by_role("button", name="Start over").click()
    expect(page.locator(".undo")).to_contain_text("The form was cleared.")
    check_accessibility(page)
    page.get_by_role("button", name="Undo", exact=True).click()
    expect(stage).to_have_value("800")
    expect(page.locator(".undo")).to_contain_text("Restored.")
    page.get_by_role("button", name="Undo", exact=True).click()  # and forth
    expect(stage).to_have_count(0)


@pytest.mark.slow
def test_removed_readings_come_back(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    expect(page.locator(".observation")).to_contain_text("226 readings")
    page.get_by_role("button", name="Remove settlement").click()
    expect(page.locator(".observation")).to_have_count(0)
    page.get_by_role("button", name="Undo", exact=True).click()
    expect(page.locator(".observation")).to_contain_text("226 readings")
    check_accessibility(page, ".observation")
