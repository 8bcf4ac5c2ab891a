"""Tests in an AGS 4 file make the problem of a new job: listed, chosen, shown with what is replaced, then confirmed."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.layout import check_layout
from tests.solver.ags.synthetic import compression, content, group, groups, keyed

Visit = Callable[..., Opened]

PHONE: dict[str, Any] = {"viewport": {"width": 390, "height": 844}, "color_scheme": "dark"}
FIRST, DRAINED = "BH1/3/1/4.60", "BH1/3/2/4.70"


def give(page: Page, data: bytes, name: str = "synthetic.ags") -> None:
    """Choose a file."""
    expect(page.locator("#verdict")).not_to_be_empty()
    page.locator("#file").set_input_files({"name": name, "mimeType": "", "buffer": data})


def listed(page: Page, data: bytes | None = None, name: str = "synthetic.ags") -> Locator:
    """The form that chooses among the tests of a file."""
    give(page, content() if data is None else data, name)
    form = page.locator(".ags")
    expect(form).to_be_visible()
    return form


def yaml(page: Page) -> Locator:
    return page.get_by_label("The problem as YAML")


def test_a_specimen_replaces_the_problem_by_confirmation_and_undo_brings_it_back(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=triaxial")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    before = yaml(page).input_value()
    form = listed(page)
    expect(form.get_by_role("checkbox")).to_have_count(4)
    expect(form).to_contain_text("4 specimens with tests that make a problem")
    expect(form.locator(".choice").first).to_contain_text("oedometer (CONG/CONS), BH1, 4.60 m")
    expect(form.locator(".choice").first).to_contain_text("9 increments of 12 to 800 kPa, e0 1.2, 2 of them unload")
    expect(page.locator("#ags-take")).to_be_disabled()
    form.get_by_text("Not usable (2)").click()
    expect(form).to_contain_text("UU, total stresses: the effective stress before shearing is not known.")
    expect(form).to_contain_text("CONG_TYPE is SWELL, which is not a compression test in a ring.")
    check_accessibility(page, ".ags")
    form.get_by_role("checkbox", name=FIRST).check()
    expect(form.get_by_role("status")).to_have_text("It makes a problem (oedometer) of 9 readings.")
    expect(form).to_contain_text("It replaces3 × triaxial, 199 readings, 5 parameters")
    expect(form).to_contain_text("1.2 kPa is assumed, a tenth of that of the first increment")
    expect(yaml(page)).to_have_value(before)  # nothing is taken yet
    check_accessibility(page, ".ags")
    form.get_by_role("button", name="Replace the problem by 1 test", exact=True).click()
    expect(page.locator(".undo")).to_contain_text(f"{FIRST} of synthetic.ags has replaced what was here.")
    expect(page.locator(".observation")).to_contain_text("9 readings")
    expect(page.locator(".observation")).to_contain_text("synthetic.ags: CONG/CONS of BH1/3/1/4.60")
    expect(page.locator(".made-of")).to_contain_text("c and phi are fixed (c 0 kPa")
    expect(page.locator("#verdict")).to_contain_text("Complete")
    for place in (".undo", ".made-of"):
        check_accessibility(page, place)
    page.get_by_role("button", name="Undo", exact=True).click()
    expect(yaml(page)).to_have_value(before)
    expect(page.locator(".made-of")).to_have_count(0)


@pytest.mark.slow
def test_several_specimens_become_one_problem(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    form = listed(page)
    for name in (FIRST, DRAINED):
        form.get_by_role("checkbox", name=name).check()
    expect(form.get_by_role("status")).to_have_text("It makes a problem (oedometer, 3 × triaxial) of 12 readings.")
    expect(form).not_to_contain_text("It replaces")  # the form was empty
    form.get_by_role("button", name="Take 2 tests", exact=True).click()
    expect(page.locator(".observation")).to_have_count(4)
    expect(yaml(page)).to_have_value(re.compile("kind: combined"))
    expect(page.locator("#verdict")).to_contain_text("Complete")
    expect(page.locator("#file")).to_be_focused()
    check_accessibility(page, ".observation")


@pytest.mark.slow
def test_all_of_it_by_keyboard(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer")
    form = listed(page)
    expect(form.get_by_role("checkbox").first).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Space")
    expect(form.get_by_role("checkbox", name="BH2/5/1/6.10")).to_be_checked()
    expect(page.locator("#ags-take")).to_be_enabled()
    for _ in range(20):
        if page.locator("#ags-take").evaluate("(node) => node === document.activeElement"):
            break
        page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.locator(".undo")).to_contain_text("BH2/5/1/6.10 of synthetic.ags has replaced what was here.")
    expect(page.locator("#file")).to_be_focused()
    undo = page.get_by_role("button", name="Undo", exact=True)
    undo.focus()
    page.keyboard.press("Enter")
    expect(page.locator(".observation")).to_contain_text("226 readings")


@pytest.mark.slow
def test_what_the_file_does_not_say_can_be_given(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/new")
    guard.allow("422")
    form = listed(page)
    form.get_by_role("checkbox", name=FIRST).check()
    form.get_by_text("What the file does not say").click()
    form.get_by_label("Duration of an increment").fill("48")
    expect(form).to_contain_text("48 h are assumed for each (“Duration of an increment”)")
    first = form.get_by_label("Initial stress")
    first.fill("12")
    expect(form.get_by_role("alert")).to_contain_text(
        "“Initial stress” must be above 0 and below 12 kPa, the stress of the first increment"
    )
    expect(page.locator("#ags-take")).to_be_disabled()
    first.fill("much")
    expect(form.get_by_role("alert")).to_contain_text("is “much”: a number of kPa above 0 is accepted.")
    first.fill("2,5")
    form.get_by_label("Soil law").select_option(label="soft soil creep")
    check_accessibility(page, ".ags")
    form.get_by_role("button", name="Take 1 test", exact=True).click()
    expect(yaml(page)).to_have_value(re.compile(r"initial_stress: 2\.5"))
    expect(yaml(page)).to_have_value(re.compile(r"soft_soil_creep"))
    expect(yaml(page)).to_have_value(re.compile(r"duration: 2\b"))


@pytest.mark.slow
def test_readings_of_an_instrument_are_mapped_like_those_of_other_files(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=formula")
    form = listed(page)
    form.get_by_text("Readings of instruments (2)").click()
    form.get_by_role("button", name="Take readings of BH3/P1, monitoring LEV (MOND)").click()
    mapping = page.locator(".mapping")
    expect(mapping.get_by_role("cell", name="3.214")).to_be_visible()
    expect(mapping.locator("legend")).to_have_text("BH3_P1_LEV.csv")
    check_accessibility(page, ".mapping")


def test_a_file_without_a_usable_test_says_so(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    empty = dict.fromkeys(("CONG", "CONS", "TREG", "TRET", "MONG", "MOND"), "")
    form = listed(page, content(**empty))
    expect(form.get_by_role("alert")).to_contain_text("No test of this file makes a problem.")
    expect(form).to_contain_text("UU, total stresses")
    form.get_by_role("button", name="Cancel").click()
    expect(form).to_have_count(0)
    expect(page.locator("#file")).to_be_focused()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            b'"**PROJ"\r\n"*PROJ_ID"\r\n',
            "is AGS 3; AGS 4 is accepted. Ask for the data as AGS 4, or convert the file",
        ),
        (b'"GROUP","CONG"\r\n"HEADING","A"\r\n"DATA","1","2"\r\n', "line 3: group CONG: 2 cells of DATA under 1"),
        (content(CONG=""), "group CONS needs the group CONG, which is missing"),
        (b"\x89PNG\r\n\0\0", "broken.ags is not a text file; give a file in the AGS 4 format"),
    ],
)
def test_a_broken_file_is_explained(embedded: Site, visit: Visit, data: bytes, message: str) -> None:
    page, guard = visit(embedded, "/new?example=oedometer")
    guard.allow("422")
    expect(page.locator(".observation")).to_contain_text("226 readings")
    give(page, data, "broken.ags")
    alert = page.locator("#measurements-body").get_by_role("alert")
    expect(alert).to_contain_text(message)
    expect(page.locator(".observation")).to_contain_text("226 readings")
    check_accessibility(page, "#measurements-body")


def test_a_file_is_known_by_its_first_line(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    expect(listed(page, content(), "laboratory.txt").get_by_role("checkbox")).to_have_count(4)


@pytest.mark.slow
def test_many_tests_are_filtered(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new")
    keys = [(f"BH{n}", "4.50", "3", "U", "", "1", "4.60") for n in range(1, 31)]
    columns = keyed(CONS_INCN=("", "X"), CONS_IVR=("", "3DP"), CONS_INCF=("kPa", "0DP"), CONS_INCE=("", "3DP"))
    long = {
        "CONG": group("CONG", keyed(CONG_HIGT=("mm", "2DP")), [[*key, 20.0] for key in keys]),
        "CONS": group("CONS", columns, [row for key in keys for row in compression(key, 80.0, 1.2)]),
    }
    form = listed(page, "".join({**groups(), **long}.values()).encode())
    expect(form.get_by_role("checkbox")).to_have_count(32)
    form.get_by_role("checkbox", name="BH17/3/1/4.60").check()
    form.get_by_label("Show tests with").fill("bh2")
    expect(form.get_by_role("checkbox")).to_have_count(12)  # BH2, BH20 to BH29, and a shear test of BH2
    form.get_by_role("checkbox", name="BH21/3/1/4.60").check()
    expect(form.get_by_role("button", name="Take 2 tests", exact=True)).to_be_enabled()
    form.get_by_label("Show tests with").fill("nothing like it")
    expect(form).to_contain_text("No test has these words.")
    check_accessibility(page, ".ags")


@pytest.mark.slow
def test_the_import_fits_a_phone(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new?example=oedometer", **PHONE)
    form = listed(page)
    for name in (FIRST, DRAINED):
        form.get_by_role("checkbox", name=name).check()
    for words in ("Not usable", "Readings of instruments", "What the file does not say"):
        form.get_by_text(words).click()
    expect(form.get_by_role("button", name="Replace the problem by 2 tests", exact=True)).to_be_enabled()
    check_layout(page)
    check_accessibility(page, ".ags")
    page.locator("#ags-take").click()
    expect(page.locator(".made-of")).to_be_visible()
    check_layout(page)
    check_accessibility(page, ".made-of")
