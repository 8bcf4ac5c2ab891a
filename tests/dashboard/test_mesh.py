"""The body of a job: mesh, deformation, contours, vectors."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.api.conftest import line_problem
from tests.api.test_mesh import loaded_ground
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_statistics import ended

Visit = Callable[..., Opened]

PAINTED = """(canvas) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
    const colours = new Set();
    for (let i = 0; i < data.length; i += 4) {
        if (data[i + 3] === 255) colours.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
    }
    return [...colours];
}"""


TICKS = """(canvas) => {
    const context = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    const marks = ([x, y, width, height]) => {
        const { data } = context.getImageData(x, y, width, height);
        let count = 0, before = 0;
        for (let i = 3; i < data.length; i += 4) {
            if (data[i] > 60 && before <= 60) count += 1;
            before = data[i];
        }
        return count;
    };
    return [marks([0, canvas.height - 2, canvas.width, 1]), marks([1, 0, 1, canvas.height])];
}"""
"""How many ticks are along the lower edge and the left one."""


@pytest.fixture(scope="module")
def job(embedded: Site) -> str:
    return ended(embedded.service, loaded_ground())


def opened(visit: Visit, site: Site, job: str, **options: Any) -> Page:
    page, _ = visit(site, f"/jobs/{job}/mesh", **options)
    expect(page.locator("#told")).to_contain_text("Largest displacement")
    return page


def test_contours_deformation_and_vectors_are_shown(embedded: Site, visit: Visit, job: str) -> None:
    page = opened(visit, embedded, job)
    canvas = page.locator(".body canvas")
    expect(page.locator(".scale")).to_contain_text("sand")
    check_accessibility(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    before = canvas.evaluate(PAINTED)
    page.get_by_label("Show", exact=True).select_option("shear")
    expect(page.locator(".scale")).to_contain_text("shear strain [%]")
    expect(canvas).to_have_attribute("aria-label", re.compile("Contours of shear strain.*deformed"))
    after = canvas.evaluate(PAINTED)
    assert 0x46327E in after  # the lowest band
    assert 0xA2DA37 in after  # the highest
    assert 0x46327E not in before
    page.get_by_label("Deformation scale as a number").fill("1e9")
    page.keyboard.press("Enter")
    expect(page.locator("#controls")).to_contain_text("beyond, triangles turn inside out")
    assert 0 < float(page.get_by_label("Deformation scale as a number").input_value()) < 1e9
    page.get_by_label("Deformation scale as a number").fill("0")
    page.keyboard.press("Enter")
    expect(canvas).not_to_have_attribute("aria-label", re.compile("deformed"))
    row = page.locator("#vectors tbody tr")
    expect(row).to_have_count(1)
    expect(row).to_contain_text("-20")
    about = page.locator("#about").inner_text()
    assert about.count("Triangles of") == 3
    points = re.findall(r"Point (\w+)\s+x = [\d.]+ m, y = [\d.]+ m", about)
    assert points == sorted(loaded_ground()["forward_model"]["points"]), about
    assert min(canvas.evaluate(TICKS)) > 1
    page.emulate_media(media="print")
    expect(page.locator("#controls")).to_be_hidden()


def test_another_period_and_another_evaluation_can_be_chosen(embedded: Site, visit: Visit, job: str) -> None:
    page = opened(visit, embedded, job)
    told = page.locator("#told")
    first = told.inner_text()
    page.get_by_label("Displacements from").select_option("")
    expect(told).not_to_have_text(first)
    best = page.locator("#about").inner_text()
    particle = page.get_by_label("Particle")
    particle.fill(str((int(particle.input_value()) + 1) % 3))
    page.get_by_role("button", name="Show this evaluation").click()
    expect(page.locator("#about")).not_to_have_text(best)
    page.get_by_role("button", name="Best").click()
    expect(told).to_have_text(first)
    assert page.locator("#about").inner_text() == best


def test_the_keyboard_moves_and_resizes_the_body(embedded: Site, visit: Visit, job: str) -> None:
    page = opened(visit, embedded, job)
    canvas = page.locator(".body canvas")
    whole = canvas.evaluate("(canvas) => canvas.toDataURL()")
    page.locator(".body").focus()
    page.keyboard.press("+")
    page.keyboard.press("ArrowRight")
    assert canvas.evaluate("(canvas) => canvas.toDataURL()") != whole
    page.keyboard.press("0")
    assert canvas.evaluate("(canvas) => canvas.toDataURL()") == whole


def test_the_body_can_be_used_by_everybody_on_a_dark_phone(embedded: Site, visit: Visit, job: str) -> None:
    page = opened(visit, embedded, job, color_scheme="dark", viewport={"width": 390, "height": 844})
    check_accessibility(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_job_without_a_mesh_says_so(embedded: Site, visit: Visit) -> None:
    page, _ = visit(embedded, f"/jobs/{ended(embedded.service, line_problem())}/mesh")
    expect(page.locator(".empty")).to_contain_text("formula, has no mesh")
    assert page.locator("canvas").count() == 0
