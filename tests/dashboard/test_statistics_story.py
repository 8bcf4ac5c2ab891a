"""From the statistics of an oedometer test to a follow-up with two parameters fixed, and to the report as PDF."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from geoswarm.solver.problem import load_problem
from geoswarm.workers.access.principal import Principal
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_statistics import ended

Visit = Callable[..., Opened]
EXAMPLE = Path(__file__).parents[2] / "examples" / "oedometer" / "problem.yaml"


def five_parameters() -> dict[str, Any]:
    document = load_problem(EXAMPLE).document()
    free = {"phi": {"lower": 10, "upper": 35}, "mu_star": {"lower": 1e-4, "upper": 1e-2, "scale": "log"}}
    document["parameters"] |= free
    return document | {"method": {"kind": "monte_carlo", "samples": 200}, "stopping": {}}


def follow(page: Page, job: str) -> str:
    """Fix phi and mu*, start, return the new job; the PDF of the first one is downloaded on the way."""
    page.goto(f"/jobs/{job}")
    page.get_by_role("link", name="Trust").first.click()
    expect(page.locator("#verdicts .card")).to_have_count(5)
    with page.expect_download(timeout=60_000) as download:
        page.get_by_role("link", name="Report (PDF)").click()
    assert download.value.suggested_filename == f"report-{job}.pdf"
    assert Path(download.value.path()).read_bytes().startswith(b"%PDF-")
    for symbol in ("φ", "μ*"):
        page.get_by_label(f"{symbol} in the follow-up").select_option("fixed")
    page.get_by_label("Value of φ").fill("20")
    page.get_by_label("Value of μ*").fill("0.00146")
    page.get_by_role("button", name="Start follow-up").click()
    page.wait_for_url(lambda url: "statistics" not in url)
    return page.url.rpartition("/")[2]


def check_follow_up(document: dict[str, Any]) -> None:
    assert document["parameters"]["phi"] == {"value": 20}
    assert document["parameters"]["mu_star"] == {"value": 0.00146}
    assert document["parameters"]["c"]["upper"] == 100
    assert document["name"].endswith("(μ* fixed, φ fixed)")


@pytest.mark.slow
def test_two_parameters_are_fixed_with_keys_and_workers(full: Site, visit: Visit) -> None:
    alice = full.service.on_behalf_of(Principal("alice", "submit"))
    job = ended(alice, five_parameters())
    page, _ = visit(full, "/", key=full.key("alice"))
    made = follow(page, job)
    assert alice.get(made).free_parameters == ["lambda_star", "kappa_star", "c"]
    check_follow_up(alice.problem(made))
    expect(page.locator("h1 .state")).to_have_text("finished")


@pytest.mark.slow
def test_two_parameters_are_fixed_on_a_laptop(embedded: Site, visit: Visit) -> None:
    job = ended(embedded.service, five_parameters())
    page, _ = visit(embedded, "/")
    made = follow(page, job)
    assert embedded.service.get(made).free_parameters == ["lambda_star", "kappa_star", "c"]
    check_follow_up(embedded.service.problem(made))
