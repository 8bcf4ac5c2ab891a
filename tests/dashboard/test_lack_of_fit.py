"""A model that does not describe the data: said first on the pages of the job, with what to do."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.api.conftest import line_problem
from tests.dashboard.browser import check_accessibility
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_statistics import ended

Visit = Callable[..., Opened]
SOON = 240_000


@pytest.fixture(scope="module")
def bent(embedded: Site) -> str:
    x = np.linspace(0.0, 3.0, 40)
    y = 1.0 + 2.0 * x + 0.8 * (x - 1.5) ** 2 + np.random.default_rng(2).normal(0.0, 0.05, x.size)
    document = line_problem(
        name="a line through a bend",
        observations=[{"series": "y", "points": {"x": x.tolist(), "y": y.tolist()}}],
        stopping={"max_evaluations": 240},
    )
    return ended(embedded.service, document)


@pytest.mark.parametrize("path", ["", "/statistics"])
def test_the_pages_begin_with_what_is_wrong(embedded: Site, visit: Visit, bent: str, path: str) -> None:
    page, _ = visit(embedded, f"/jobs/{bent}{path}")
    alarm = page.locator("#alarm")
    expect(alarm).to_contain_text("The model does not describe the data", timeout=SOON)
    expect(alarm).to_contain_text("What to do")
    expect(alarm).to_contain_text("leave out what the model does not contain (“From”, “To”, “Stages to leave out”)")
    expect(alarm).not_to_contain_text("x_from")
    offered = 1 if path else 0  # on the page of the job the next step is this
    expect(alarm.get_by_role("link", name="Change the problem")).to_have_count(offered)
    sentence = page.context.request.get(f"/api/v1/jobs/{bent}/statistics").json()["fit"]["sentence"]
    expect(page.get_by_text(sentence)).to_have_count(1)
    expect(page.locator(".card.identified")).to_have_count(0)
    check_accessibility(page)
    if folder := os.environ.get("PICTURES_TEMP"):
        page.screenshot(path=f"{folder}/page{path.replace('/', '_')}.png", full_page=False)
