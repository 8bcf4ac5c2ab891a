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
