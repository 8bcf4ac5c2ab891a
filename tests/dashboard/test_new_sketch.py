"""The sketch of a laboratory test beside the form: it follows what is typed, on a wide page and a phone."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from geoswarm.solver.forward.registry import find_spec
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.layout import check_layout
from tests.dashboard.test_new import fill
from tests.variants import variants

Visit = Callable[..., Opened]

CASES = {
    "oedometer": ("h = 20 mm", "height", "0.025", "h = 25 mm"),
    "isotropic_compression": ("d = 50 mm", "diameter", "0.04", "d = 40 mm"),
    "triaxial": ("σ′a = σ′r + q", "back_pressure", "300", "300 kPa"),
    "direct_simple_shear": ("τ, γ", "shearing[0].shear_strain", "0.3", "0.3"),
    "crs_oedometer": ("h = 20 mm", "back_pressure", "200", "200 kPa"),
    "consolidation": ("h = 20 mm", "stages[1].stress", "160", "160"),
    "column": ("clay, 6 m", "layers[1].thickness", "8", "clay, 8 m"),
    "section": ("y [m]", "layers[1].bottom", "-8", "rock, down to −8 m: rock (elastic)"),
}
"""What is written in the sketch of the small example, a field, another value, and what is written then."""


def drawings_of(kind: str) -> int:
    """How many there are: of a test, itself and its programme; of a section, a key and phases."""
    return 3 if kind == "section" else 2


def give(page: Page, kind: str) -> None:
    """The small example of a kind, by its YAML."""
    model = find_spec(kind).example()
    page.locator("#yaml").wait_for()
    page.locator("#yaml").evaluate(
        """(place, model) => {
            place.value = `name: sketch\\nforward_model: ${JSON.stringify(model)}\\n`;
            place.dispatchEvent(new Event("input", {bubbles: true}));
        }""",
        model,
    )


@pytest.mark.parametrize("kind", variants(CASES, {"triaxial"}))
def test_each_test_is_drawn_and_follows_what_is_typed(embedded: Site, visit: Visit, kind: str) -> None:
    first, field, value, then = CASES[kind]
    page, _ = visit(embedded, "/new")
    give(page, kind)
    sketch = page.locator("#yaml-panel #sketch")
    expect(sketch.locator("svg")).to_have_count(drawings_of(kind))
    expect(sketch.locator("svg text", has_text=re.compile(f"^{re.escape(first)}$")).first).to_be_visible()
    label = sketch.locator("svg").first.get_attribute("aria-label")
    assert label
    expect(sketch.locator("figcaption").first).to_have_text(label)
    page.locator(".step details").evaluate_all("(folds) => folds.forEach((fold) => { fold.open = true; })")
    fill(page, **{f"forward_model.{field}": value})
    expect(sketch.locator("svg text", has_text=re.compile(f"^{re.escape(then)}$")).first).to_be_visible()
    check_accessibility(page, "#sketch")
    check_layout(page)


def test_the_last_good_sketch_stays_dimmed_while_something_is_wrong_and_goes_with_its_kind(
    embedded: Site, visit: Visit
) -> None:
    page, _ = visit(embedded, "/new")
    give(page, "consolidation")
    drawings = page.locator("#sketch .sketches")
    expect(drawings.locator("svg")).to_have_count(2)
    fill(page, **{"forward_model.height": "-1"})
    expect(drawings).to_have_class(re.compile(r"\bold\b"))
    expect(drawings.get_by_text("h = 20 mm", exact=True)).to_be_visible()
    fill(page, **{"forward_model.height": "0.03"})
    expect(drawings).not_to_have_class(re.compile(r"\bold\b"))
    expect(drawings.get_by_text("h = 30 mm", exact=True)).to_be_visible()
    assert drawings.get_by_text("h = 20 mm", exact=True).count() == 0
    expect(page.locator(".choice strong").get_by_text("CRS oedometer", exact=True)).to_be_visible()
    page.locator("input[name=kind][value=formula]").check()
    expect(page.locator("#sketch")).to_be_hidden()
    assert page.locator("#sketch svg").count() == 0


def test_several_tests_are_drawn_with_their_names(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    give(page, "combined")
    expect(page.locator("#sketch svg")).to_have_count(4)
    headings = ["Oedometer test (oedometer)", "Loading programme (oedometer)"]
    assert page.locator("#sketch h3").all_inner_texts()[:2] == headings


@pytest.mark.parametrize("kind", variants(CASES, {"column"}))
def test_the_sketch_can_be_read_on_a_phone(embedded: Site, visit: Visit, kind: str) -> None:
    page, _ = visit(embedded, "/new", viewport={"width": 390, "height": 844}, color_scheme="dark")
    give(page, kind)
    sketch = page.locator(".step #sketch")  # in the form: the YAML lies far below
    expect(sketch.locator("svg")).to_have_count(drawings_of(kind))
    letters = sketch.locator("svg").evaluate_all(
        """(drawings) => drawings.flatMap((one) => [...one.querySelectorAll("text")].map((text) =>
            parseFloat(getComputedStyle(text).fontSize) * one.getScreenCTM().a))"""
    )
    assert min(letters) >= 10.0
    check_layout(page)
    check_accessibility(page)


def test_a_slope_stays_in_sight_beside_its_long_form(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=slope", viewport={"width": 1440, "height": 1000})
    section = page.locator("#yaml-panel #sketch svg.wide")
    expect(section.get_by_text("shear_zone", exact=True)).to_be_visible()
    expect(page.locator("#sketch h3")).to_have_text(["Section", "Legend", "Phases"])
    page.evaluate("scrollTo(0, document.querySelector('.step').scrollHeight / 2)")
    expect(section).to_be_in_viewport(ratio=1)
    form, picture = page.locator(".step").first.bounding_box(), section.bounding_box()
    assert form is not None
    assert picture is not None
    assert picture["x"] > form["x"] + form["width"]
    check_layout(page)
    check_accessibility(page, "#sketch")


def test_a_slope_can_be_read_on_a_phone(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=slope", viewport={"width": 390, "height": 844}, color_scheme="dark")
    expect(page.locator(".step #sketch svg.wide").get_by_text("shear_zone", exact=True)).to_be_visible()
    letters = page.locator("#sketch svg").evaluate_all(
        """(drawings) => drawings.flatMap((one) => [...one.querySelectorAll("text")].map((text) =>
            parseFloat(getComputedStyle(text).fontSize) * one.getScreenCTM().a))"""
    )
    assert min(letters) >= 10.0
    check_accessibility(page, "#sketch")
