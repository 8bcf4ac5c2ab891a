"""A table of tests with its files becomes parts of the forward model; its mistakes are told by line and column."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.api.test_drafts import OEDOMETER
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site

Visit = Callable[..., Opened]

TABLE = "test;file;type;e0\nOE-1;oe.csv;Oedometer;{e0}\nOE-2;oe.csv;Oedometer;0.9\n"


@pytest.mark.slow
def test_tests_are_added_from_a_table(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new")
    guard.allow("422")

    def choose(e0: str) -> None:
        files = {"oe.csv": OEDOMETER, "tests.csv": TABLE.format(e0=e0).encode()}
        page.locator("#tests-files").set_input_files(
            [{"name": name, "mimeType": "", "buffer": content} for name, content in files.items()]
        )
        form.get_by_label("Soil law").select_option(label="hypoplastic sand")

    form = page.locator(".mapping")
    choose("loose")
    expect(form.get_by_label("Table with a row a test").locator("option:checked")).to_have_text("tests.csv")
    expect(form.get_by_role("alert")).to_have_text(
        "tests.csv line 2, column 'e0': must be a number, got text 'loose'", timeout=30_000
    )
    choose("0.8")
    form.get_by_role("button", name="Take 2 tests", exact=True).click(timeout=30_000)
    expect(page.locator(".observation")).to_have_count(2)
    expect(page.get_by_label("The problem as YAML")).to_have_value(re.compile("OE_2:"))
    check_accessibility(page)
    choose("0.8")
    expect(form.get_by_role("alert").first).to_contain_text("which another test has")
