"""The form of a new job: index properties, and what they and the readings let expect of each parameter."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site

Visit = Callable[..., Opened]


def test_what_readings_and_index_properties_let_expect_stands_beside_the_bounds(embedded: Site, visit: Visit) -> None:
    """The example's own readings give k; a liquid limit of 65 % gives Cc = 0.009 (65 - 10) = 0.495."""
    page, _ = visit(embedded, "/new?example=consolidation")
    k = page.locator('[data-expected="k"]')
    expect(k.locator("summary")).to_contain_text("by readings")
    lambda_ = page.locator('[data-expected="lambda_star"]')
    expect(lambda_).to_be_hidden()
    page.get_by_role("button", name="Set index properties").click()
    page.get_by_label("Liquid limit").fill("65")
    expect(lambda_.locator("summary")).to_contain_text("by index properties")
    lambda_.locator("summary").click()
    expect(lambda_).to_contain_text("Cc: 0.009 (w_L - 10), Terzaghi & Peck (1967)")
    parameter = page.locator(".parameter", has=lambda_)
    expect(parameter).to_contain_text("PLAXIS Material Models Manual")  # the source of the usual range
    check_accessibility(page, ".parameter")
    page.get_by_label("Liquid limit").fill("0.65")
    expect(page.locator('[data-error="index_properties"]')).to_contain_text("in per cent this would be 65")
