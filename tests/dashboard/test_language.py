"""The pages in German: by the browser's language or by choice, with what people wrote left as it is."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.dashboard.browser import check_accessibility, guarded_context
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import textbook
from tests.dashboard.test_new_import import drop
from tests.dashboard.test_statistics import ended
from tests.variants import variants

Visit = Callable[..., Opened]

UNTRANSLATED = """async () => {
    const { untranslated } = await import(document.body.dataset.static + "/js/language.js");
    return untranslated();
}"""
OPEN = "() => { for (const one of document.querySelectorAll('main details')) one.open = true; }"
NAME = re.compile(
    r"[\w.*'′()\[\]/°,-]*[_.\d*λκμφψνσ][\w.*'′()\[\]/°,-]*( \[[^]]+\])?:?|(?:[A-Za-zΔεγστ]{1,2}′?[ ,:]*)+"
    r"|\w+′? \[[^]]+\]|geoswarm|embedded, .*|\w+, [\d.]+ m"
)
"""What no language changes: names of parameters, series, layers and workers, and symbols."""

EXAMPLES = [
    *("oedometer", "triaxial", "direct_simple_shear", "crs_oedometer", "isotropic_compression", "consolidation"),
    *("column", "slope", "combined", "formula"),
]
OWN_NAMES = {
    "crs_oedometer": {"Wissa et al."},
    "direct_simple_shear": {"normal", "over", "lambda", "kappa"},
    "slope": {"cover", "bedrock", "stable", "crack", "secondary", "survey", "gps", "rock", "soil", "strength", "clay"}
    | {"soft soil creep", "20 * K_foot", "20 * K_foot kPa/m", "2 m", "20 m"},
}
"""Names of the examples' authors."""


@pytest.fixture(scope="module")
def job(embedded: Site) -> str:
    return ended(embedded.service, textbook(name="Search_1", stopping={"max_evaluations": 240}))


@pytest.fixture(scope="module")
def german(browser: Browser, embedded: Site) -> Iterator[Page]:
    """The page of a German; one for all tests, as each new one reads Plotly and the catalogue again."""
    with guarded_context(browser, embedded.url, locale="de-DE") as (context, guard):
        guard.allow("422")  # what a draft is refused for
        yield context.new_page()


def left_in_english(page: Page, *names: str) -> list[str]:
    def own(text: str) -> bool:
        parts = re.split(r"\s*[→,;:()]\s*", text)  # a row of a legend: names, and what stands between them
        return text in names or all(not part or part in names or NAME.fullmatch(part) for part in parts)

    return [text for text in page.evaluate(UNTRANSLATED) if not (own(text) or NAME.fullmatch(text.lstrip("✓✗ ")))]


def opened(page: Page, path: str) -> None:
    page.goto(path)
    page.wait_for_load_state("networkidle")
    assert page.locator("html").get_attribute("lang") == "de"


def opened_form(page: Page, path: str) -> None:
    """The form, checked by the service, with all that can be unfolded."""
    page.goto(path)
    expect(page.locator("#verdict.good")).to_be_visible()
    page.evaluate(OPEN)


def test_pages_are_german_throughout_with_decimal_commas(german: Page, job: str) -> None:
    for path in ("", "/fit", "/search", "/statistics", "/data"):
        opened(german, f"/jobs/{job}{path}")
        expect(german.locator("h1")).to_contain_text("Search_1")  # its name, which somebody gave it
        assert left_in_english(german) == [], path
        if not path:
            values = german.locator("#parameters td.n").all_text_contents()
            assert "".join(values) != ""
            assert [value for value in values if re.search(r"\d\.\d", value)] == []
    for path in ("/?q=Search", "/workers", "/compare"):
        opened(german, path)
        assert left_in_english(german) == [], path


@pytest.mark.parametrize("example", variants(EXAMPLES, {"triaxial", "column"}))
def test_the_form_of_a_model_is_german_throughout(german: Page, example: str) -> None:
    opened_form(german, f"/new?example={example}")
    german.wait_for_load_state("networkidle")
    assert left_in_english(german, *OWN_NAMES.get(example, ())) == []


def test_an_import_and_a_refusal_are_german(german: Page) -> None:
    german.goto("/new?example=oedometer")
    drop(german, 'Zeit [min];Setzung\n1;"1,000"\n2;"2,000"\n')
    german.wait_for_load_state("networkidle")
    german.evaluate(OPEN)
    assert left_in_english(german, "Zeit [min]", "Setzung") == []
    opened_form(german, "/new?example=oedometer")
    german.locator('input[data-path$=".lower"]:visible').first.fill("x")
    expect(german.locator("#verdict.good")).to_have_count(0)
    german.wait_for_load_state("networkidle")
    assert left_in_english(german) == []


def test_dialogs_are_german(german: Page, job: str) -> None:
    opened(german, f"/jobs/{job}")
    for name in ("Weiterführen …", "Stichwörter und Notiz …", "Löschen"):
        german.locator("#actions").get_by_role("button", name=name).click()
        expect(german.locator("dialog[open]")).to_be_visible()  # some ask the service first
        german.keyboard.press("Escape")
        expect(german.locator("dialog[open]")).to_have_count(0)
    assert left_in_english(german) == []


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


def test_german_pages_are_accessible_and_fit_a_phone(german: Page, job: str) -> None:
    german.set_viewport_size({"width": 390, "height": 844})
    for path in (f"/jobs/{job}", "/", "/new?example=oedometer", f"/jobs/{job}/statistics"):
        opened(german, path)
        assert german.evaluate("document.documentElement.scrollWidth") <= 390, path
        assert german.locator("header.site").bounding_box()["height"] < 110, path  # type: ignore[index]
    check_accessibility(german)
    german.set_viewport_size({"width": 1440, "height": 900})
