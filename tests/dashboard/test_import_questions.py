"""What the import of readings asks for, it asks for at once, and no answer is lost."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from tests.dashboard.conftest import Site
from tests.dashboard.test_new_import import Visit, chosen, drop, more, yaml


def test_columns_and_units_of_a_table_without_headings_are_one_question(embedded: Site, visit: Visit) -> None:
    """Columns were asked for, then their units; a unit that was given first was lost."""
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, "0;0;A\n1;25;A\n2;50;A\n4;75;A\n")
    mapping.get_by_label("Series", exact=True).select_option(label="settlement: replaces 226 readings")
    both = [f"Choose the column of {axis}, and give its unit where its heading names none." for axis in "yx"]
    expect(mapping.locator(".todo li")).to_have_text(both)
    mapping.get_by_label("Unit of y").fill("0.01 mm")
    mapping.get_by_label("Unit of x").fill("min")
    mapping.get_by_label("Column of y").select_option(label="column 2")
    mapping.get_by_label("Column of x").select_option(label="column 1")
    expect(mapping.locator(".todo")).to_have_count(0)
    expect(mapping.get_by_role("status")).to_have_text("4 readings.")
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile(r"y_unit: \"?0.01 mm"))
    expect(yaml(page)).to_have_value(re.compile("x_unit: min"))


def test_what_a_file_says_is_in_no_other_language(embedded: Site, visit: Visit) -> None:
    """In German “1.600” was shown as “1,600”, and both answers to the question had the same example."""
    page, _ = visit(embedded, "/new?example=oedometer", own=True, locale="de-DE")
    mapping = drop(page, "time [min];settlement [um]\n1;800\n2;1.600\n4;3.200\n")
    expect(mapping.locator(".first-rows th").nth(1)).to_contain_text("settlement [um]")
    expect(mapping.locator(".first-rows td").nth(3)).to_have_text("1.600")
    expect(chosen(mapping, "Spalte von y")).to_have_text("settlement [um]")
    expect(mapping.locator(".todo")).to_contain_text("„1.600“ in settlement [um] kann tausend")
    signs = mapping.get_by_label("Wie sind Zahlen geschrieben?")
    expect(signs.locator("option")).to_have_text(
        [re.compile("^auswählen"), re.compile(r"^1\.5 und 1,000: Punkt"), re.compile(r"^1,5 und 1\.000: K")]
    )
    signs.select_option(index=2)
    page.locator("#take").click()
    expect(page.locator("#yaml")).to_have_value(re.compile(r"y: \[800, 1600, 3200\]"))


@pytest.mark.slow
def test_a_strain_is_made_of_a_stroke(embedded: Site, visit: Visit) -> None:
    """Files of presses, which have strokes and forces, could not be taken."""
    page, _ = visit(embedded, "/new?example=triaxial")
    mapping = drop(page, "Stauchung [mm];Kraft [kN]\n0,1;0,01\n0,2;0,03\n")
    series = mapping.get_by_label("Series", exact=True)
    series.select_option(series.locator("option", has_text=re.compile(r"^cell_50\.q:")).get_attribute("value"))
    mapping.get_by_label("Column of y").select_option(label="Kraft [kN]")
    mapping.get_by_label("Column of x").select_option(label="Stauchung [mm]")
    expect(mapping.get_by_role("alert").first).to_contain_text(
        "needs the unit “dimensionless”, and “Multiply x by” below"
    )
    mapping.get_by_label("Unit of x").fill("dimensionless")
    mapping.get_by_label("Unit of y").fill("kPa")
    more(mapping)
    mapping.get_by_label("Multiply x by").fill("0,001/0,02")
    mapping.get_by_label("Multiply y by").fill("1/0.004")
    expect(mapping.get_by_role("status")).to_contain_text("X was multiplied by 0.05. Y was multiplied by 250.")
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile(r"x: \[0\.005"))


def test_a_time_of_a_formula_is_no_number_of_a_row(embedded: Site, visit: Visit) -> None:
    """The first column was proposed."""
    page, _ = visit(embedded, "/new?example=formula")
    mapping = drop(page, "No;Zeit;Setzung [mm]\n1;0,5;1\n2;1,5;2\n")
    expect(chosen(mapping, "Column of x")).to_have_text("Zeit")


@pytest.mark.slow
def test_noise_before_a_test_is_asked_for(embedded: Site, visit: Visit) -> None:
    """The problem was refused after the readings were taken."""
    page, _ = visit(embedded, "/new?example=triaxial")
    mapping = drop(page, "eps [%];q [kPa]\n-0,01;1\n0;2\n0,5;9\n")
    series = mapping.get_by_label("Series", exact=True)
    series.select_option(series.locator("option", has_text=re.compile(r"^cell_50\.q:")).get_attribute("value"))
    mapping.get_by_label("Leave out readings before axial strain 0 (1)").check()
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile("x_from: 0\n"))


@pytest.mark.slow
def test_the_state_before_the_first_stage_is_left_out(embedded: Site, visit: Visit) -> None:
    """Its load, 0 as a rule, was refused, and cells had to be given; as stage 0 it was refused after it was taken."""
    page, guard = visit(embedded, "/new?example=oedometer")
    guard.allow("422")  # the load of no stage
    mapping = drop(page, "Last [kPa];Setzung [mm]\n0;0\n9;0,05\n25;0,08\n")
    expect(chosen(mapping, "Series")).to_have_text("stage_settlement")
    expect(mapping.get_by_role("alert")).to_contain_text("leave out what is before them: “Leave out readings before")
    mapping.get_by_label("Leave out readings before stage 1").check()
    expect(mapping.get_by_role("status")).to_contain_text("3 readings.")
    expect(mapping.get_by_label("Leave out readings before stage 1 (1)")).to_be_checked()
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile(r"x_from: 1\n"))
    expect(page.locator("#verdict")).to_contain_text("Complete")


@pytest.mark.slow
def test_the_stage_of_a_file_of_several_is_asked_for(embedded: Site, visit: Visit) -> None:
    """Rows of all stages were offered for sorting: strains of consolidation among those of shearing."""
    page, _ = visit(embedded, "/new?example=triaxial")
    rows = "1;0;0\n1;0,5;2\n2;0;2\n2;1;30\n2;2;50\n"
    mapping = drop(page, f"Stage Number;Axial Strain;Deviator Stress\n{rows}")
    expect(mapping.locator(".todo li")).to_have_text(
        [
            "Choose the stage.",
            "“Deviator Stress” has no unit: give the unit of y.",
            "“Axial Strain” has no unit: give the unit of x.",
        ]
    )
    mapping.get_by_label("Unit of y").fill("kPa")
    mapping.get_by_label("Unit of x").fill("%")
    mapping.get_by_label("Which Stage Number?").select_option(label="2 (3 rows)")
    expect(mapping.get_by_role("status")).to_contain_text("3 readings.")
    expect(mapping.locator(".todo")).to_have_count(0)
    page.locator("#take").click()
    expect(yaml(page)).to_have_value(re.compile(r"x: \[0, 1, 2\]"))


@pytest.mark.slow
def test_the_time_of_day_is_no_part_of_a_strain(embedded: Site, visit: Visit) -> None:
    """The first series that was proposed took it; with another one, strains were no dates."""
    page, _ = visit(embedded, "/new?example=triaxial")
    rows = "2019-02-11;06:30:24;0,1;10\n2019-02-11;06:31:26;0,2;20\n"
    mapping = drop(page, f"Datum;Uhrzeit;Stauchung [%];p [kPa]\n{rows}")
    mapping.get_by_label("Column of x", exact=True).select_option(label="Datum")
    expect(mapping.get_by_role("status")).to_contain_text("X counts from 2019-02-11 06:30:24.")
    mapping.get_by_label("Column of x", exact=True).select_option(label="Stauchung [%]")
    expect(mapping.get_by_role("status")).to_have_text("2 readings.")
