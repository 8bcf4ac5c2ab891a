"""Read-only links: made and revoked on the page of a job, opened by somebody without a key."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import expect

from geoswarm.workers.access.principal import Principal
from tests.api.conftest import line_problem
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_statistics import ended

Visit = Callable[..., Opened]


def test_a_job_is_shared_and_no_longer_shared(full: Site, visit: Visit) -> None:
    alice = full.service.on_behalf_of(Principal("alice", "submit"))
    job = ended(alice, line_problem(name="for the reviewer"))
    page, _ = visit(full, f"/jobs/{job}", key=full.key("alice"))
    page.get_by_role("button", name="Share …").click()
    expect(page.get_by_role("dialog")).to_contain_text("There are no links to this job.")
    page.get_by_label("For whom").fill("Dr. Reviewer")
    page.get_by_role("button", name="Make a link").click()
    made = page.get_by_role("dialog", name="New link")
    link = made.locator("code").inner_text()
    check_accessibility(page)
    made.get_by_role("button", name="Close").click()
    expect(page.get_by_role("row", name="Dr. Reviewer")).to_contain_text("active")

    guest, guard = visit(full, link.removeprefix(full.url))
    guest.wait_for_url(f"{full.url}/jobs/{job}")
    expect(guest.locator("#answer")).to_contain_text("the fit leaves")
    assert guest.locator("#actions button").count() == 0
    expect(guest.get_by_role("navigation", name="Main")).to_have_count(0)
    guest.get_by_role("link", name="Fit", exact=True).click()
    expect(guest.locator("h1")).to_contain_text("for the reviewer")
    guest.goto("/")
    guest.wait_for_url(f"{full.url}/jobs/{job}")

    page.get_by_role("button", name="Revoke").click()
    page.get_by_role("button", name="Revoke").last.click()
    expect(page.get_by_role("row", name="Dr. Reviewer")).to_contain_text("revoked")
    guard.allow("401")
    guest.goto(link)
    expect(guest.get_by_role("alert").first).to_contain_text("has expired or was revoked")
    assert "gsw_" not in guest.url


def test_a_link_leaves_the_session_of_who_sees_the_job_already(full: Site, visit: Visit) -> None:
    alice = full.service.on_behalf_of(Principal("alice", "submit"))
    job = ended(alice, line_problem(name="mine"))
    key, _ = alice.links.create(job, valid_seconds=600.0)
    page, _ = visit(full, f"/sign-in?next=/jobs/{job}#{key}", key=full.key("alice"))
    page.wait_for_url(f"{full.url}/jobs/{job}")
    expect(page.get_by_role("button", name="Share …")).to_be_visible()
