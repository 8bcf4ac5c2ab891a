"""Stages of a test from a column of loads in a file of readings, with one click; readings that lie in rows."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_new_import import chosen, drop, yaml
from tests.solver.problem.test_blocks import SIDE
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_load_stages import ANEW
from tests.solver.problem.test_measurements import workbook
from tests.solver.problem.test_sheets import LYING

Visit = Callable[..., Opened]

HEADINGS = ("歷時(min)", "沉陷S(mm)")
SHEETS = (
    ("9 kPa", sheet_rows(HEADINGS, (0, 0), (60, 0.2), (1440, 0.3))),
    ("13 kPa", sheet_rows(HEADINGS, (0, 0.3), (60, 0.4), (1440, 0.5))),
)


@pytest.mark.slow
def test_a_column_of_loads_fills_in_the_stages_and_joins_their_readings(embedded: Site, visit: Visit) -> None:
    """Before the forward model is complete; x restarts in every stage of this file."""
    page, guard = visit(embedded, "/new")
    guard.allow("422")  # the refusal of a wrong column
    page.locator("input[name=kind][value=oedometer]").check()
    again = ANEW + "0;0,0125;0,5\n60;0,0125;0,45\n1440;0,0125;0,4\n"  # unloaded
    mapping = drop(page, again)
    mapping.get_by_text("More about these columns").click()
    loads = mapping.get_by_label("Loads of the stages")
    loads.select_option(label="Setzung [mm]")
    expect(mapping).to_contain_text("“Setzung [mm]” gives no stages: ")
    loads.select_option(label="Spannung [MPa]")
    expect(mapping).to_contain_text(
        "“Spannung [MPa]” has 3 stages: 12.5 kPa for 1 day, 25 kPa for 2 day, 12.5 kPa for 1 day."
    )
    mapping.get_by_role("button", name="Fill in these 3 stages").click()
    expect(page.locator('[data-path="forward_model.stages[1].stress"]')).to_have_value("25")
    page.locator('[data-path="forward_model.height"]').fill("0.02")
    page.locator('[data-path="forward_model.initial_stress"]').fill("5")
    expect(page.locator("#parameters-body")).to_contain_text("lambda")
    mapping = drop(page, again)
    expect(mapping).to_contain_text("These are the stages of the forward model.")
    expect(mapping.get_by_role("status")).to_contain_text("3 blocks were joined, x of each from the start of its stage")
    check_accessibility(page)
    mapping.get_by_role("button", name="Add settlement", exact=True).click()
    expect(yaml(page)).to_have_value(
        re.compile(r"x: \[0(\.0)?, 60(\.0)?, 1440(\.0)?, 1500(\.0)?, 4320(\.0)?, 4380(\.0)?, 5760(\.0)?\]")
    )


def test_times_of_a_clock_are_asked_for(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, "Uhr;Setzung [mm]\n00:00;0\n00:30;0,1\n01:00;0,2\n")
    mapping.get_by_label("Column of x", exact=True).select_option(label="Uhr")
    expect(mapping).to_contain_text("“00:00” in Uhr is a time: say how the time since the start is written")
    mapping.get_by_label("How are times written?").select_option(label="00:15: hours and minutes since the start")
    expect(mapping.get_by_role("status")).to_have_text("3 readings.")
    mapping.get_by_role("button", name=re.compile("settlement")).click()
    expect(page.locator(".observation")).to_contain_text("3 readings")


@pytest.mark.slow
def test_readings_in_rows_are_columns_and_the_nearest_row_of_times_is_x(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new?example=oedometer")
    guard.allow("422")  # loads of another test
    mapping = drop(page, workbook(("s", LYING)), "own.xlsx")
    expect(chosen(mapping, "Column of y")).to_have_text("Setzung: [mm] (B6:C6)")
    expect(chosen(mapping, "Column of x")).to_have_text("Zeit: [min] (B5:C5)")
    mapping.get_by_label("Series").select_option(label="stage_settlement")
    expect(chosen(mapping, "Column of x")).to_have_text("Spannung: [kPa]")
    expect(mapping).to_contain_text("x = 7.3 kPa (point 1) is the load of no stage of the forward model (9, 13, 25")
    mapping = drop(page, "sigma_v;Setzung [mm]\n9;0,05\n25;0,08\n")
    expect(chosen(mapping, "Series")).to_have_text("stage_settlement")
    expect(mapping.locator(".todo")).to_have_text("“sigma_v” has no unit: give the unit of x.")
    mapping.get_by_label("Unit of x").fill("kPa")
    expect(mapping.get_by_role("status")).to_contain_text(
        "X is the number of the stage with the load of column sigma_v."
    )
    mapping.get_by_role("button", name="Add stage_settlement", exact=True).click()
    expect(yaml(page)).to_have_value(re.compile(r"y_unit: mm\s[^-]*x: \[1(\.0)?, 3(\.0)?\]"))
    mapping = drop(page, workbook(("s", LYING)), "own.xlsx")
    mapping.get_by_label("Series").select_option(label="settlement: replaces 226 readings")
    mapping.get_by_label("Column of y", exact=True).select_option(label="Setzung: [mm] (B9:C9)")
    expect(chosen(mapping, "Column of x")).to_have_text("Zeit: [min] (B8:C8)")
    mapping.get_by_role("button", name=re.compile("settlement")).click()
    expect(yaml(page)).to_have_value(re.compile(r"x: \[4320(\.0)?, 5760(\.0)?\]"))


@pytest.mark.slow
def test_stages_side_by_side_are_joined(embedded: Site, visit: Visit) -> None:
    """Only the readings of one stage could be taken."""
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, SIDE)
    expect(mapping.get_by_role("status")).to_contain_text("3 readings.")
    mapping.get_by_label("Join the 2 blocks with these headings, one after the other").check()
    expect(mapping.get_by_role("status")).to_contain_text("2 blocks were joined, x of each from the start of its stage")
    mapping.get_by_role("button", name=re.compile("Replace settlement")).click()
    expect(yaml(page)).to_have_value(re.compile(r"x: \[0, 60, 1440, 2880, 2910, 3600, 4320\]"))
    check_accessibility(page)


@pytest.mark.slow
def test_stages_on_sheets_of_their_own_are_joined(embedded: Site, visit: Visit) -> None:
    """Only the readings of one sheet could be taken."""
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, workbook(("Data", sheet_rows(("h [mm]", "d [mm]"), (20, 70))), *SHEETS), "own.xlsx")
    expect(chosen(mapping, "Sheet")).to_have_text("9 kPa")
    expect(chosen(mapping, "Series")).to_have_text("settlement: replaces 226 readings")  # by the units alone
    mapping.get_by_label("Join the 2 sheets with these headings, one after the other: 9 kPa, 13 kPa").check()
    expect(mapping.get_by_role("status")).to_contain_text("2 blocks were joined, x of each from the start of its stage")
    mapping.get_by_role("button", name=re.compile("Replace settlement")).click()
    expect(yaml(page)).to_have_value(
        re.compile(r"x: \[0(\.0)?, 60(\.0)?, 1440(\.0)?, 2880(\.0)?, 2940(\.0)?, 4320(\.0)?\]")
    )
