"""Everything that a pointer can do is within reach of the keyboard, and it is seen where the keyboard is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from geoswarm.solver.problem import parse_problem
from tests.api.test_mesh import loaded_ground
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.layout import leaf_through
from tests.dashboard.test_job import LONG, SOON, state, textbook
from tests.dashboard.test_statistics import ended, two_lines

Visit = Callable[..., Opened]

STEPS = Path(__file__).with_name("keyboard.js").read_text(encoding="utf-8")
MOST = 600
"""Presses of Tab after which a walk must be round."""


def walk(page: Page) -> None:
    """Go through a page with Tab until it begins again; nothing may be left out, and every stop must be seen."""
    reached: list[int] = []
    page.evaluate("document.activeElement.blur()")
    for _ in range(MOST):
        page.keyboard.press("Tab")
        stop = page.evaluate(f"({STEPS}).focused()")
        if stop is None and not reached:
            continue
        if stop is None or stop[0] in reached:
            break
        number, seen, what = stop
        assert seen, f"nothing shows that the keyboard is at {what}"
        reached.append(number)
    else:
        pytest.fail(f"after {MOST} steps the walk is not round")
    missed = page.evaluate(f"(reached) => ({STEPS}).missed(reached)", reached)
    assert missed == [], missed


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_every_control_of_every_view_is_reached(embedded: Site, visit: Visit) -> None:
    lines, ground = ended(embedded.service, two_lines()), ended(embedded.service, loaded_ground())
    line = ended(embedded.service, textbook(name="to be compared"))
    page, _ = visit(embedded, "/")
    for path, ready in (
        ("/", "tr[data-job]"),
        (f"/compare?job={lines}&job={line}", "#parameters tr"),
        ("/new?example=oedometer", "#verdict.good"),
        ("/workers", "#workers tbody tr"),
        (f"/jobs/{line}", "#copies button"),
        (f"/jobs/{line}/data", "#figures a"),
        (f"/jobs/{line}/search", "#evaluations tbody tr"),
        (f"/jobs/{lines}/statistics", "#verdicts .card"),
        (f"/jobs/{ground}/mesh", ".body canvas"),
    ):
        page.goto(path)
        leaf_through(page)  # what is made when it is looked at is there then
        page.locator(ready).first.wait_for(state="attached")
        walk(page)
    assert page.url.endswith("/mesh")


def test_a_job_is_steered_without_a_pointer(embedded: Site, visit: Visit) -> None:
    view, _ = embedded.service.submit(parse_problem(textbook(name="by keyboard", **LONG)))
    page, guard = visit(embedded, f"/jobs/{view.id}")
    guard.allow("409")
    state(page).to_have_text("running", timeout=SOON)
    press(page, "Pause")
    state(page).to_have_text("paused", timeout=SOON)
    press(page, "Resume")
    state(page).to_have_text("running", timeout=SOON)
    press(page, "Cancel")
    dialog = page.get_by_role("dialog")
    expect(dialog).to_be_visible()
    walk(page)
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    expect(page.get_by_role("button", name="Cancel")).to_be_focused()
    page.keyboard.press("Enter")
    press(page, "Cancel the job")
    state(page).to_have_text("cancelled", timeout=SOON)
    assert embedded.service.get(view.id).state == "cancelled"


def press(page: Page, name: str) -> None:
    """Go to a button with Tab and press Enter."""
    button = page.get_by_role("button", name=name, exact=True)
    expect(button).to_be_visible()
    for _ in range(60):
        if button.evaluate("(button) => button === document.activeElement"):
            break
        page.keyboard.press("Tab")
    expect(button).to_be_focused()
    page.keyboard.press("Enter")


@pytest.mark.slow
def test_a_table_that_renews_itself_keeps_the_keyboard(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/workers")
    page.locator("#workers tbody tr").first.wait_for()
    page.get_by_role("region", name="Workers").focus()
    page.evaluate("window.before = document.activeElement")
    page.wait_for_function("() => !window.before.isConnected")
    expect(page.get_by_role("region", name="Workers")).to_be_focused()
    assert page.evaluate("document.activeElement !== window.before")
