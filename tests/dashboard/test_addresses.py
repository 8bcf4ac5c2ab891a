"""What is looked at has an address; problems are copied, plots are saved."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import SOON
from tests.dashboard.test_statistics import chosen, ended, two_lines

Visit = Callable[..., Opened]


@pytest.fixture(scope="module")
def job(embedded: Site) -> str:
    return ended(embedded.service, two_lines())


@pytest.mark.slow
def test_a_threshold_and_ranges_are_in_the_address(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}/statistics")
    expect(page.locator("#verdicts .card")).to_have_count(3)
    with page.expect_response(re.compile(r"/statistics\?threshold=")):
        page.get_by_label("Threshold as a number").fill("20")
        page.keyboard.press("Enter")
    page.get_by_text("Ranges of the parameters").click()
    field = page.get_by_label("b, at most")
    field.fill("2")
    field.press("Enter")
    kept = chosen(page)
    assert "threshold=20" in page.url
    assert "range.b=0.1..2" in page.url
    other, _ = visit(embedded, page.url.removeprefix(embedded.url))
    expect(other.locator("#verdicts .card")).to_have_count(3)
    expect(other.locator("#threshold-why")).to_contain_text("the threshold that you chose")
    assert chosen(other) == kept
    other.get_by_role("button", name="Remove all ranges").click()
    other.get_by_role("button", name="Proposed threshold").click()
    expect(other).to_have_url(re.compile("/statistics$"))


def test_ranges_without_a_good_fit_say_so_and_how_to_go_on(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}/statistics?range.a=4.5..5&range.b=0.1..0.2")
    advice = page.locator("#advice")
    expect(advice).to_contain_text("No good fit lies inside these ranges")
    advice.get_by_role("button", name="Remove the ranges").click()
    expect(advice).to_be_hidden()
    assert chosen(page) > 0


def test_an_evaluation_has_an_address(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}/search?evaluation=0-3")
    expect(page.get_by_role("dialog", name="Generation 0, particle 3")).to_be_visible(timeout=SOON)
    page.keyboard.press("Escape")
    expect(page).to_have_url(re.compile("/search$"))


@pytest.mark.slow
def test_a_problem_is_copied_and_a_plot_is_saved(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}/data", permissions=["clipboard-read", "clipboard-write"])
    # before it is there, what stands below it moves, and a button may be elsewhere when the pointer is let go
    expect(page.locator("#figures").get_by_role("link", name="convergence as PNG")).to_be_visible(timeout=SOON)
    expect(page.locator("#problem pre")).to_contain_text("expression: a + b * x + 0 * d")
    page.get_by_text("y: 4 readings, weight 1").click()
    expect(page.get_by_role("region", name="Readings of y").locator("tbody tr")).to_have_count(4)
    check_accessibility(page)
    texts = {}
    for name in ("YAML", "Python", "Command line", "curl"):
        page.get_by_role("button", name=name, exact=True).click()
        expect(page.locator("#status")).to_have_text(f"Copied as {name}.")
        texts[name] = page.evaluate("navigator.clipboard.readText()")
    assert "expression: a + b * x + 0 * d" in texts["YAML"]
    assert f'client.problem("{job}")' in texts["Python"]
    compile(texts["Python"], "copied", "exec")
    assert "geoswarm submit problem.json" in texts["Command line"]
    assert f"{embedded.url}/api/v1/jobs" in texts["curl"]
    page.goto(f"/jobs/{job}")
    forms = {"YAML values": "a: ", "CSV values": "parameter,unit,value", "PLAXIS table": "Parameter\tValue\tUnit\n"}
    for name, start in forms.items():
        page.get_by_role("button", name=name, exact=True).click()
        expect(page.locator("#status")).to_have_text(f"Copied as {name}.")
        assert page.evaluate("navigator.clipboard.readText()").startswith(start)
    page.goto(f"/jobs/{job}/fit")
    expect(page.locator("#fit .main-svg").first).to_be_visible(timeout=SOON)
    starts = {"SVG": b"<svg", "PNG": b"\x89PNG", "CSV": b'"x'}
    for form, start in starts.items():
        with page.expect_download() as download:
            page.locator("#fit").get_by_role("button", name=f"This plot as {form}").first.click()
        assert Path(download.value.path()).read_bytes().startswith(start), form
        assert download.value.suggested_filename.endswith(form.lower())
    rows = Path(download.value.path()).read_text().splitlines()
    assert len(rows) == 5
    assert json.loads(rows[1].split(",")[1]) == 1.0
    check_accessibility(page)
