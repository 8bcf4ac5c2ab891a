"""Report, JSON and dashboard say the same of problems whose structure is known."""

from __future__ import annotations

from collections.abc import Callable
from html import unescape

import numpy as np
import pytest
from playwright.sync_api import expect

from geoswarm.solver.identifiability import Statistics
from geoswarm.solver.words import typeset
from tests.api.conftest import wait_for_end
from tests.dashboard.conftest import Opened, Site
from tests.dashboard.test_job import SOON
from tests.dashboard.test_statistics import ended
from tests.solver.identifiability.zoo import SWARM, ZOO
from tests.variants import variants

Visit = Callable[..., Opened]


@pytest.mark.slow  # tests/geoswarm/client/test_same_statements.py compares without a page
@pytest.mark.parametrize("name", variants(["two basins", "product", "wrong model", "plain"], {"two basins"}))
def test_report_json_and_dashboard_say_the_same(embedded: Site, visit: Visit, name: str) -> None:
    animal = ZOO[name]
    service = embedded.service
    problem = animal.make(np.random.default_rng(len(name)).standard_normal(animal.points), SWARM)
    job = ended(service, problem.document())
    page, _ = visit(embedded, f"/jobs/{job}")
    headers = {"X-Requested-With": "test"}
    made = page.context.request.post(f"/api/v1/jobs/{job}/sensitivity", headers=headers, data={"polish": True})
    wait_for_end(service, made.json()["id"])
    told = page.context.request.get(f"/api/v1/jobs/{job}/statistics").json()
    report = service.statistics.report(job)
    found = report.statistics
    assert isinstance(found, Statistics)
    assert [(v.words, v.sentence) for v in found.verdicts] == [(v["words"], v["sentence"]) for v in told["verdicts"]]
    html = unescape(report.html())
    page.goto(f"/jobs/{job}/statistics")
    for verdict in told["verdicts"]:
        assert typeset(verdict["sentence"]) in html
        card = page.locator(f"#verdict-{verdict['parameter']}")
        expect(card).to_contain_text(verdict["words"], timeout=SOON)
        expect(card).to_contain_text(verdict["sentence"])
        steps = [remedy["kind"] for remedy in verdict["what_to_do"]]
        expect(card.get_by_role("button", name="Look for further basins")).to_have_count(steps.count("explore"))
    fit = told["fit"]
    assert not any(fit["sentence"] in warning for warning in told["warnings"])
    seen = page.locator("#alarm, #warnings").get_by_text(fit["sentence"])
    expect(seen).to_have_count(0 if fit["kind"] == "describes" else 1)
    page.goto(f"/jobs/{job}")
    expect(page.locator("#parameters a.verdict")).to_have_text([v["words"] for v in told["verdicts"]], timeout=SOON)
    words = "Intervals hold within the basin of the optimum; another basin like it could still hide in"
    expect(page.locator("#parameters")).to_contain_text(words)
    assert words in html
    others = [other for other in told["basins"]["others"] if other["differs"]]
    expect(page.locator("#parameters").get_by_text("as well")).to_have_count(
        len({n for o in others for n in o["differs"]})
    )
