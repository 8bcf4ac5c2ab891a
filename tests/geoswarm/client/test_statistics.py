"""Both clients ask for statistics, reports, figures and other weights."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from geoswarm import AsyncClient, Client
from geoswarm.client import Figure, NotFoundError
from tests.api.conftest import LiveServer, line_problem
from tests.integration.engines import PATIENCE


@pytest.fixture
def job(client: Client) -> str:
    """A finished job, the same in every test."""
    submitted = client.submit(line_problem(name="statistics"), idempotency_key="statistics")
    return client.wait(submitted.id, timeout=PATIENCE).id


def test_statistics_and_other_weights(client: Client, job: str) -> None:
    found = client.statistics(job)
    assert [verdict.parameter for verdict in found.verdicts] == ["a", "b"]
    assert found.samples.total == 60
    assert client.statistics(job, threshold=2.0).threshold.value == 2.0
    after = client.reweight(job, weights={"y": 3.0})
    assert after.weights[0].weight == 3.0
    assert after.best.objective == pytest.approx(3.0 * (client.get(job).objective or 0.0), rel=1e-12)


def test_report_and_figures_show_in_a_notebook(client: Client, job: str) -> None:
    report = client.report(job)
    assert "<h2>Verdicts</h2>" in report.html
    assert "&lt;h2&gt;Verdicts" in report._repr_html_()
    assert client.report_pdf(job).startswith(b"%PDF-")
    assert "matrix" in client.figures(job)
    figure = client.figure(job, "matrix")
    assert (figure._repr_svg_() or "").lstrip().startswith("<?xml")
    assert figure._repr_png_() is None
    png = client.figure(job, "fit", form="png")
    assert (png._repr_png_() or b"").startswith(b"\x89PNG")
    assert client.figure(job, "fit", form="csv") == Figure("fit", "csv", png_csv(client, job))
    text = client.get(job)._repr_html_()
    assert "statistics" in text
    assert ">b<" in text


def png_csv(client: Client, job: str) -> bytes:
    return client.figure(job, "fit", form="csv").content


def test_unknown_figure_names_the_known(client: Client, job: str) -> None:
    with pytest.raises(NotFoundError, match="there are: matrix"):
        client.figure(job, "pie")


def test_the_asynchronous_client_asks_the_same(server: LiveServer, client: Client, job: str) -> None:
    async def ask() -> list[Any]:
        async with AsyncClient(server.url) as opened:
            return [
                await opened.statistics(job),
                await opened.reweight(job, weighting="by_count"),
                (await opened.report(job)).html,
                await opened.report_pdf(job),
                await opened.figures(job),
                await opened.figure(job, "fit"),
            ]

    assert asyncio.run(ask()) == [
        client.statistics(job),
        client.reweight(job, weighting="by_count"),
        client.report(job).html,
        client.report_pdf(job),
        client.figures(job),
        client.figure(job, "fit"),
    ]
