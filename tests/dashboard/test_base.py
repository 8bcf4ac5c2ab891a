"""What all pages share: they load, can be used by everybody, keep a theme, sign in and out, and plot."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from geoswarm.solver.problem import parse_problem
from tests.api.conftest import line_problem
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site

Visit = Callable[..., Opened]


@pytest.fixture(scope="module")
def job(embedded: Site) -> str:
    view, _ = embedded.service.submit(parse_problem(line_problem()))
    return view.id


@pytest.mark.parametrize("theme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_every_page_is_sound_and_usable_by_everybody(embedded: Site, visit: Visit, job: str, theme: str) -> None:
    page, _ = visit(embedded, "/", color_scheme=theme)
    for path in (
        "/",
        "/new",
        "/compare",
        "/workers",
        "/sign-in",
        "/help/statistics",
        *(f"/jobs/{job}{p}" for p in ("", "/statistics", "/mesh")),
    ):
        page.goto(path)
        expect(page.locator("h1")).to_be_visible()
        check_accessibility(page)


def test_a_phone_needs_no_scrolling_aside(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, "/", viewport={"width": 390, "height": 844})
    for path in ("/", "/new", "/workers", "/help/http-api", f"/jobs/{job}", f"/jobs/{job}/fit", f"/jobs/{job}/data"):
        page.goto(path)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), path


def test_a_theme_is_kept_and_the_first_stop_of_the_keyboard_skips_to_the_content(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/", color_scheme="light")
    page.keyboard.press("Tab")
    expect(page.locator(".skip")).to_be_focused()
    button = page.locator("#theme")
    button.click()
    button.click()
    expect(button).to_have_text("Theme: dark")
    page.reload()
    expect(button).to_have_text("Theme: dark")
    assert page.evaluate("getComputedStyle(document.body).colorScheme") == "dark"


@pytest.mark.slow
def test_a_job_is_seen_to_the_end_without_a_reload(embedded: Site, visit: Visit) -> None:
    view, _ = embedded.service.submit(parse_problem(line_problem(stopping={"max_evaluations": 600})))
    page, _ = visit(embedded, f"/jobs/{view.id}")
    expect(page.locator("h1 .state")).to_have_text("finished")
    assert embedded.service.get(view.id).state == "finished"


def test_a_page_that_is_not_there_says_so(embedded: Site, visit: Visit) -> None:
    page, guard = visit(embedded, "/jobs/nobody")
    guard.allow("404")
    expect(page.locator("h1")).to_have_text("Job not found")
    check_accessibility(page)


def test_signing_in_and_out_with_a_key(full: Site, visit: Visit) -> None:
    page, guard = visit(full, "/workers")
    guard.allow("401")  # the wrong key below
    expect(page.locator("h1")).to_have_text("Sign in")
    check_accessibility(page)
    page.get_by_label("API key").fill("wrong")
    page.keyboard.press("Enter")
    expect(page.locator("#key-error")).to_contain_text("not valid")
    page.get_by_label("API key").fill(full.key("alice"))
    page.keyboard.press("Enter")
    expect(page.locator("h1")).to_have_text("Workers")
    assert page.url == f"{full.url}/workers"
    assert "geoswarm_session" not in page.evaluate("document.cookie")
    page.get_by_role("button", name="Sign out").click()
    expect(page.locator("h1")).to_have_text("Sign in")
    page.goto("/")
    expect(page.locator("h1")).to_have_text("Sign in")


@pytest.mark.slow
def test_owners_see_their_own_jobs_only(full: Site, visit: Visit) -> None:
    page, _ = visit(full, "/", key=full.key("alice"))
    made = page.evaluate(
        """async ([base, problem]) => (await import(base + "/js/http.js")).post("/jobs", problem)""",
        [page.locator("body").get_attribute("data-static"), line_problem(name="confidential")],
    )
    page.goto(f"/jobs/{made['id']}")
    expect(page.locator("h1 .state")).to_have_text("finished")
    other, guard = visit(full, f"/jobs/{made['id']}", key=full.key("bob"))
    guard.allow("404")
    expect(other.locator("h1")).to_have_text("Job not found")
    assert "confidential" not in other.content()


def test_a_plot_is_drawn_in_the_colours_of_the_theme(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, "/new", color_scheme="light")
    draw = """async (base) => {
        const { plot, palette } = await import(base + "/js/plot.js");
        const make = () => ({
            data: [{ x: [1, 2, 3], y: [1, 4, 9], name: "square", line: { color: palette()[0] } }],
            layout: { xaxis: { title: { text: "x [m]" } }, yaxis: { title: { text: "y [m2]" }, type: "log" } },
            label: "Squares", columns: { x: [1, 2, 3], y: [1, 4, 9] },
        });
        const place = document.createElement("div");
        document.querySelector("main").append(place);
        await plot(place, make).draw();
    }"""
    page.evaluate(draw, page.locator("body").get_attribute("data-static"))
    frame = page.get_by_role("figure", name="Squares")
    expect(frame.locator(".main-svg").first).to_be_visible()
    expect(frame.locator(".scatterlayer .js-line")).to_have_css("stroke", "rgb(0, 114, 178)")
    page.locator("#theme").click()
    page.locator("#theme").click()
    expect(frame.locator(".scatterlayer .js-line")).to_have_css("stroke", "rgb(86, 180, 233)")
    page.get_by_text("Numbers of this plot").click()
    expect(page.locator(".plot-table td")).to_have_text(["1", "1", "2", "4", "3", "9"])
    check_accessibility(page, ".plot-table")
