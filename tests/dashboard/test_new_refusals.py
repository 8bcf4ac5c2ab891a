"""What of a file cannot be taken, and why: in the words of the import, labels of its fields, not keys."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_new_import import OWN, drop

Visit = Callable[..., Opened]

TEMPERATURES = "Zeit [min];Setzung [mm];Grad\n1;0,25;20\n2;defekt;21\n4;0,75;22\n"


@pytest.mark.slow  # tests/api/test_readings_of_files.py has the questions
def test_millimetres_are_no_strain(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, OWN)
    mapping.get_by_label("Series").select_option(label="axial_strain")
    mapping.get_by_label("Column of y", exact=True).select_option(label="Setzung [mm]")
    expect(mapping.get_by_role("alert")).to_contain_text("is in mm, but axial strain of axial_strain has no unit but %")
    expect(page.locator("#take")).to_be_disabled()
    check_accessibility(page, ".mapping")
    mapping = drop(page, "t [min];eps\n1;0.05\n2;0.1\n")
    mapping.get_by_label("Series").select_option(label="axial_strain")
    expect(mapping.locator(".todo")).to_have_text("“eps” has no unit: give the unit of y.")


@pytest.mark.slow
def test_a_refusal_names_fields_and_no_keys(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new?example=oedometer")
    guard.allow("422")
    mapping = drop(page, TEMPERATURES)
    refusal = mapping.get_by_role("alert")
    expect(refusal).to_contain_text("“Leave out rows without a number in every column” passes over such rows")
    expect(refusal).not_to_contain_text("incomplete_rows")
    mapping.get_by_label("Leave out rows without a number in every column").check()
    expect(mapping.get_by_role("status")).to_contain_text("2 readings.")


@pytest.mark.slow
def test_a_force_is_no_stress(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=triaxial")
    mapping = drop(page, "Axial strain [%];Force [N]\n0.1;10\n1;40\n")
    mapping.get_by_label("Series").select_option(index=1)
    mapping.get_by_label("Column of y", exact=True).select_option(label="Force [N]")
    asked = "“Force [N]” is in N, a force; for a stress in kPa the factor is 0.001 / A with the area A in m2"
    expect(mapping.locator(".todo")).to_contain_text(asked)


@pytest.mark.slow  # tests/api/test_readings_of_files.py has the questions
def test_a_control_file_of_pest_is_named(embedded: Site, visit: Visit) -> None:
    """It was "a table without numbers"."""
    page, guard = visit(embedded, "/new?example=oedometer")
    guard.allow("422")
    expect(page.locator("#verdict")).not_to_be_empty()
    control = b"pcf\n* control data\nrestart estimation\n2 3 1 0 1\n"
    page.locator("#file").set_input_files({"name": "clay.pst", "mimeType": "", "buffer": control})
    said = "clay.pst is a control file of PEST; geoswarm import pest clay.pst --output DIR makes a problem of it"
    expect(page.get_by_text(said)).to_be_visible()


def test_a_heave_is_not_preselected_as_a_settlement(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    mapping = drop(page, "Zeit [min];Hebung [mm]\n1;0,25\n2;0,5\n4;0,75\n")
    mapping.get_by_label("Series").select_option(label="settlement: replaces 226 readings")
    expect(mapping.get_by_label("Column of y", exact=True).locator("option:checked")).to_have_text("choose …")


@pytest.mark.slow  # tests/api/test_readings_of_files.py has the questions
def test_numbers_of_stages_that_come_again_are_no_x(embedded: Site, visit: Visit) -> None:
    """An axial stress over the number of the stage was proposed where the deviator stood beside it."""
    page, _ = visit(embedded, "/new?example=triaxial")
    rows = "".join(f"9,{strain},{100 + 20 * strain},{20 * strain}\n" for strain in range(1, 5))
    mapping = drop(page, f"StageNumber,AxialStrain_pct,AxialStress_kPa,q_kPa\n{rows}")
    expect(mapping.get_by_label("Series").locator("option:checked")).to_contain_text("cell_50.q: ")
    expect(mapping.get_by_label("Column of y", exact=True).locator("option:checked")).to_have_text("q_kPa")
    expect(mapping.get_by_label("Column of x", exact=True).locator("option:checked")).to_have_text("AxialStrain_pct")


@pytest.mark.slow
def test_a_number_for_no_reading_is_asked_for(embedded: Site, visit: Visit) -> None:
    """-999 was a reading."""
    page, guard = visit(embedded, "/new?example=oedometer")
    guard.allow("422")
    mapping = drop(page, "Zeit [min];Setzung [mm]\n1;0,25\n2;-999\n4;0,75\n")
    expect(mapping.get_by_role("alert")).to_contain_text("-999 is far from the other numbers")
    expect(mapping.get_by_role("alert")).not_to_contain_text("no_reading")
    mapping.get_by_label("Numbers that stand for no reading").select_option(label="-999")
    expect(mapping.get_by_role("status")).to_contain_text("2 readings.")
    mapping.get_by_label("Numbers that stand for no reading").select_option(label="none: these are readings")
    expect(mapping.get_by_role("status")).to_contain_text("3 readings.")
    check_accessibility(page, ".mapping")
