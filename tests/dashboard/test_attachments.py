"""Files on the page of a job: attached by a button or by dropping them, shown, deleted; by mouse and by keyboard."""

from __future__ import annotations

import base64
import struct
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, expect

from geoswarm.workers.access.principal import Principal
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import textbook
from tests.dashboard.test_statistics import ended

Visit = Callable[..., Opened]
DROP = """([name, content]) => {
    const data = new DataTransfer();
    data.items.add(new File([Uint8Array.from(atob(content), (c) => c.charCodeAt(0))], name));
    for (const kind of ["dragover", "drop"]) {
        const event = new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true });
        document.querySelector("h1").dispatchEvent(event);
    }
}"""


def picture(width: int = 320, height: int = 240) -> bytes:
    """A PNG: layers of soil in the colour of sand and clay."""
    rows = b"".join(b"\0" + bytes((190 - 40 * (y // 60 % 2), 150, 100 + y % 60)) * width for y in range(height))

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


@pytest.fixture(scope="module")
def calculated(embedded: Site) -> str:
    return ended(embedded.service, textbook(name="a job with files", stopping={"max_evaluations": 60}))


@pytest.fixture
def job(embedded: Site, calculated: str) -> Iterator[str]:
    """A job without files, also for the next test."""
    yield calculated
    for file in embedded.service.attachments.list(calculated):
        embedded.service.attachments.delete(calculated, file.sha256)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "Probe 3, Schürf 2.png").write_bytes(picture())
    (tmp_path / "laboratory.pdf").write_bytes(b"%PDF-1.7 " + b"x" * 2_100_000)
    (tmp_path / "page.html").write_text("<html>")
    return tmp_path


def attach(page: Page, *paths: Path) -> None:
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Attach files").click()
    chooser.value.set_files(paths)


def listed(page: Page) -> Locator:
    return page.get_by_role("list", name="Attached files").get_by_role("listitem")


def test_files_are_chosen_shown_and_deleted(embedded: Site, visit: Visit, job: str, folder: Path) -> None:
    page, guard = visit(embedded, f"/jobs/{job}")
    guard.allow("422")
    expect(listed(page)).to_have_count(0)
    attach(page, *(folder / name for name in ("Probe 3, Schürf 2.png", "page.html", "laboratory.pdf")))
    expect(listed(page)).to_have_count(2)
    expect(page.locator("#refused-files")).to_contain_text("'page.html' is of no type that can be attached; accepted:")
    expect(listed(page).nth(0)).to_contain_text("Probe 3, Schürf 2.png")
    expect(listed(page).nth(1)).to_contain_text("2.1 MB")
    image = listed(page).nth(0).locator("img")
    expect(image).to_have_js_property("naturalWidth", 320)
    assert image.bounding_box()["width"] == 56  # type: ignore[index]  # it is shown
    check_accessibility(page)
    with page.expect_download() as download:
        page.get_by_role("link", name="laboratory.pdf").click()
    assert download.value.suggested_filename == "laboratory.pdf"
    attach(page, folder / "laboratory.pdf")
    expect(page.locator("#refused-files")).to_be_empty()
    expect(listed(page)).to_have_count(2)
    page.get_by_role("button", name="Delete laboratory.pdf").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete the file").click()
    expect(listed(page)).to_have_count(1)
    expect(page.get_by_role("button", name="Delete Probe 3")).to_be_focused()
    assert [file.name for file in embedded.service.attachments.list(job)] == ["Probe 3, Schürf 2.png"]


# tests/api/test_attachments.py reads the policy that makes the sandbox
@pytest.mark.slow
def test_a_picture_opens_by_itself_and_runs_nothing(embedded: Site, visit: Visit, job: str, folder: Path) -> None:
    page, _ = visit(embedded, f"/jobs/{job}", own=True)
    attach(page, folder / "Probe 3, Schürf 2.png")
    with page.context.expect_page() as opened:
        page.get_by_role("link", name="Probe 3").click()
    picture = opened.value
    expect(picture.locator("img")).to_have_js_property("naturalWidth", 320)
    assert picture.evaluate("origin") == "null"  # the sandbox: not that of the service


def test_files_are_dropped_on_the_page(embedded: Site, visit: Visit, job: str) -> None:
    page, _ = visit(embedded, f"/jobs/{job}")
    page.get_by_role("button", name="Attach files").wait_for()
    page.evaluate(DROP, ["dropped.png", base64.b64encode(picture()).decode()])
    expect(listed(page)).to_contain_text(["dropped.png"])


def test_files_are_reached_by_keyboard(embedded: Site, visit: Visit, job: str, folder: Path) -> None:
    page, _ = visit(embedded, f"/jobs/{job}")
    page.on(
        "filechooser", lambda chooser: chooser.set_files(folder / "laboratory.pdf")
    )  # a key is faster than a waiter
    page.get_by_role("button", name="Attach files").focus()
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Delete laboratory.pdf").focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Escape")
    expect(listed(page)).to_have_count(1)
    page.keyboard.press("Enter")
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Enter")
    expect(listed(page)).to_have_count(0)
    expect(page.get_by_role("button", name="Attach files")).to_be_focused()


def test_who_may_only_read_sees_files_and_no_buttons(full: Site, visit: Visit, folder: Path) -> None:
    reader = full.service.on_behalf_of(Principal("alice", "submit"))
    job = ended(reader, textbook(name="read only", stopping={"max_evaluations": 60}))
    with (folder / "Probe 3, Schürf 2.png").open("rb") as file:
        full.service.attachments.add(job, "photo.png", file)
    page, _ = visit(full, f"/jobs/{job}", key=full.key("alice", "read"))
    expect(listed(page)).to_contain_text(["photo.png"])
    expect(listed(page).locator("img")).to_have_js_property("naturalWidth", 320)
    expect(page.get_by_role("button", name="Delete photo.png")).to_have_count(0)
    expect(page.get_by_role("button", name="Attach files")).to_have_count(0)


# tests/dashboard/test_base.py looks at the pages of a job on a phone, without files
@pytest.mark.slow
def test_files_fit_on_a_phone(embedded: Site, visit: Visit, job: str, folder: Path) -> None:
    page, _ = visit(embedded, f"/jobs/{job}", viewport={"width": 390, "height": 844})
    long = folder / f"{'A long name of a photo ' * 7}.png"
    long.write_bytes(picture(30, 20))
    attach(page, folder / "Probe 3, Schürf 2.png", folder / "laboratory.pdf", long)
    expect(listed(page)).to_have_count(3)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for button in page.get_by_role("button", name="Delete ").all():
        box = button.bounding_box()
        assert box is not None
        assert box["x"] + box["width"] <= 390
