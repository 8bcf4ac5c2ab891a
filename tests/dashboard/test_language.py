"""The pages in German: by the browser's language or by choice, with what people wrote left as it is."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import textbook
from tests.dashboard.test_statistics import ended

Visit = Callable[..., Opened]

UNTRANSLATED = """async () => {
    const { untranslated } = await import(document.body.dataset.static + "/js/language.js");
    return untranslated();
}"""
NAME = re.compile(
    r"[\w.*'′()\[\]/°,-]*[_.\d*λκμφψνσ][\w.*'′()\[\]/°,-]*( \[[^]]+\])?|[A-Za-z]{1,2}"
    r"|\w+ \[[^]]+\]|.*\bSearch\b.*|embedded, .*|geoswarm"
    r"|.* \((?:queued|running|paused|finished|failed|cancelled), .*\)"
)
"""Names, which no language changes: of parameters, series and workers, and of jobs, also those of other tests."""


@pytest.fixture(scope="module")
def job(embedded: Site) -> str:
    return ended(embedded.service, textbook(name="Search", stopping={"max_evaluations": 240}))


def german(visit: Visit, site: Site, path: str, **options: Any) -> Page:
    page, _ = visit(site, path, own=True, locale="de-DE", **options)
    page.wait_for_load_state("networkidle")
    return page


def left_in_english(page: Page) -> list[str]:
    return [text for text in page.evaluate(UNTRANSLATED) if not NAME.fullmatch(text)]


@pytest.mark.parametrize("path", ["", "/fit", "/search", "/statistics", "/data"])
def test_the_pages_of_a_job_are_german_throughout(embedded: Site, visit: Visit, job: str, path: str) -> None:
    page = german(visit, embedded, f"/jobs/{job}{path}")
    assert page.locator("html").get_attribute("lang") == "de"
    expect(page.locator("h1")).to_contain_text("Search")  # its name, which somebody gave it
    assert left_in_english(page) == []


@pytest.mark.usefixtures("job")
@pytest.mark.parametrize("path", ["/?q=Search", "/new?example=oedometer", "/workers", "/compare"])
def test_the_other_pages_are_german_throughout(embedded: Site, visit: Visit, path: str) -> None:
    page = german(visit, embedded, path)
    assert left_in_english(page) == []


def test_numbers_have_a_decimal_comma(embedded: Site, visit: Visit, job: str) -> None:
    page = german(visit, embedded, f"/jobs/{job}")
    values = page.locator("#parameters td.n").all_text_contents()
    assert "".join(values) != ""
    assert [value for value in values if re.search(r"\d\.\d", value)] == []


def test_a_language_is_chosen_and_kept(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/")
    expect(page.get_by_role("heading", name="Jobs")).to_be_visible()
    page.get_by_label("Language").select_option("de")
    expect(page.get_by_label("Sprache")).to_have_value("de")
    page.goto("/workers")
    expect(page.get_by_label("Sprache")).to_have_value("de")
    page.get_by_label("Sprache").select_option("en")
    expect(page.get_by_label("Language")).to_have_value("en")


def test_a_page_without_its_catalogue_is_english(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/blank", own=True, locale="de-DE")
    guard.allow("404", "net::ERR")
    page.route("**/languages/de.json", lambda route: route.abort())
    page.goto("/")
    expect(page.get_by_role("heading", name="Jobs")).to_be_visible()
    expect(page.get_by_label("Language")).to_have_value("en")


def test_german_pages_are_accessible_and_fit_a_phone(embedded: Site, visit: Visit, job: str) -> None:
    page = german(visit, embedded, f"/jobs/{job}", viewport={"width": 390, "height": 844})
    check_accessibility(page)
    for path in (f"/jobs/{job}", "/", "/new?example=oedometer", f"/jobs/{job}/statistics"):
        page.goto(path)
        page.wait_for_load_state("networkidle")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, path
