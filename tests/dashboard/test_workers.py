"""Workers, operations and keys."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.system.versions import versions
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.agents.desk import AgentDesk
from geoswarm.workers.agents.work import Announcement
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import line_problem
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_statistics import ended
from tests.dashboard.test_statistics_story import five_parameters

Visit = Callable[..., Opened]


@pytest.mark.parametrize("theme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
def test_an_administrator_sees_workers_queue_and_failures(embedded: Site, visit: Visit, theme: str) -> None:
    ended(embedded.service, line_problem())
    process_counters.run("finished", 0.1)
    process_counters.run("timeout", 0.1)
    process_counters.flush(embedded.service.store)
    page, _ = visit(embedded, "/workers", color_scheme=theme)
    expect(page.locator("#workers tbody tr")).to_have_count(1)
    expect(page.locator("#workers")).to_contain_text("embedded")
    expect(page.locator("#operations")).to_contain_text("Evaluations waiting")
    expect(page.locator(".bars")).to_contain_text("too slow")
    check_accessibility(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


# test_slots_of_an_agent_stand_together opens the same table by default
@pytest.mark.slow
def test_a_running_job_is_shown_at_its_worker(embedded: Site, visit: Visit) -> None:
    sampling = five_parameters() | {"method": {"kind": "monte_carlo", "samples": 50_000}}
    view, _ = embedded.service.submit(parse_problem(sampling))
    page, _ = visit(embedded, "/workers")
    link = page.get_by_role("link", name=f"Job {view.id}")
    expect(link).to_be_visible(timeout=30_000)
    assert link.get_attribute("href") == f"/jobs/{view.id}"
    embedded.service.cancel(view.id)


def test_slots_of_an_agent_stand_together(embedded: Site, visit: Visit) -> None:
    desk = AgentDesk(embedded.service.store, NoWaker(), embedded.service.settings)
    of = {**versions(), "geoswarm": "0.0.1"}
    models = {"footing": "ab" * 32, "plaxis_slope": "cd" * 32}
    desk.announce("", Announcement("pc-07-4711-ab12", "pc-07", "Windows 11 AMD64", 4711, 2, versions(), [], models))
    desk.announce(
        "", Announcement("node-17", "node17.cluster.example.org", "Linux 6.1 x86_64", 7, 1, of, ["formula"], {})
    )
    page, _ = visit(embedded, "/workers", viewport={"width": 390, "height": 800})
    agent = page.locator("#workers tbody", has_text="pc-07, 2 slots")
    expect(agent.locator("tr")).to_have_count(3)
    expect(agent.locator(".agent")).to_contain_text(f"Windows 11 AMD64, geoswarm {versions()['geoswarm']}")
    expect(agent.locator(".agent")).to_contain_text("models footing (abababab), plaxis_slope (cdcdcdcd)")
    expect(agent.locator("tr", has_text="slot 2")).to_contain_text("idle")
    other = page.locator("#workers tbody", has_text="node17.cluster.example.org")
    expect(other.locator("tr")).to_have_count(1)
    expect(other.locator(".other")).to_contain_text("no built-in models")
    assert agent.locator(".other").count() == 0
    check_accessibility(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate(
        "(region => region.scrollWidth <= region.clientWidth)(document.querySelector('#workers .wide'))"
    )
    for name in ("pc-07-4711-ab12", "node-17"):
        desk.sign_off("", name)


def test_a_key_is_made_used_and_revoked(full: Site, visit: Visit) -> None:
    page, _ = visit(full, "/workers", key=full.key("root", "admin"))
    page.get_by_label("Owner").fill("erika")
    page.get_by_label("Role").select_option("read")
    page.get_by_label("Expires").select_option("30")
    page.get_by_label("Label").fill("phone")
    page.get_by_role("button", name="Make a key").click()
    key = page.locator(".new-key code").inner_text()
    check_accessibility(page)
    assert key.startswith("gsw_")
    page.keyboard.press("Escape")
    row = page.locator("#keys tr", has_text="erika")
    expect(row).to_contain_text("active")
    assert ApiKeys(full.service.store).principal(key) is not None

    other, _ = visit(full, "/workers", key=key)
    expect(other.locator("#workers")).not_to_contain_text("Reading")
    assert other.locator("#keys, #operations").count() == 0

    row.get_by_role("button", name=re.compile("Revoke")).click()
    page.get_by_role("button", name="Revoke", exact=True).click()
    expect(row).to_contain_text("revoked")
    assert ApiKeys(full.service.store).principal(key) is None


def test_a_wrong_owner_is_refused_where_it_is_typed(full: Site, visit: Visit) -> None:
    page, _ = visit(full, "/workers", key=full.key("root", "admin"))
    page.get_by_label("Owner").fill("two words")
    page.get_by_role("button", name="Make a key").click()
    assert page.get_by_label("Owner").evaluate("(field) => !field.validity.valid")
    expect(page.locator("dialog")).to_have_count(0)
