"""Both clients submit follow-ups and read what they found."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from geoswarm import AsyncClient, Client
from geoswarm.client import ConflictError
from tests.api.conftest import LiveServer
from tests.api.test_uncertainty import noisy
from tests.integration.engines import PATIENCE


@pytest.fixture
def job(client: Client) -> str:
    """A finished job, the same in every test."""
    return client.wait(client.submit(noisy(), idempotency_key="noisy").id, timeout=PATIENCE).id


@pytest.mark.slow
def test_follow_ups_one_after_the_other(client: Client, job: str) -> None:
    with pytest.raises(ConflictError, match="need the sensitivities"):
        client.profile(job)
    client.wait(client.sensitivity(job).id, timeout=PATIENCE)
    client.wait(client.profile(job, noise={"y": 0.05}).id, timeout=PATIENCE)
    client.wait(client.global_sensitivity(job, kind="morris", samples=8).id, timeout=PATIENCE)
    found = client.uncertainty(job, noise=0.05)
    assert [profile.parameter for profile in found.profiles] == ["a", "b"]
    assert [follow_up.kind for follow_up in found.follow_ups] == ["morris", "profile", "sensitivity"]
    assert client.figure(job, "profiles", form="csv").content.startswith(b"parameter,value,objective")
    linearisation = client.statistics(job, noise=0.05).linearisation
    assert linearisation is not None
    assert linearisation.noise is not None
    assert linearisation.noise.origin == "known"
    assert client.posterior(job, noise={"y": 0.05}).trusted
    assert "posterior" in client.figures(job, posterior=True)
    assert client.report_pdf(job, posterior=True).startswith(b"%PDF-")


def test_the_asynchronous_client_does_the_same(server: LiveServer, job: str) -> None:
    async def ask() -> list[Any]:
        async with AsyncClient(server.url) as opened:
            follow_up = await opened.sensitivity(job, polish=False, at={"a": 1.0, "b": 2.0})
            ended = await opened.wait(follow_up.id, timeout=PATIENCE)
            return [ended.evaluations, await opened.uncertainty(follow_up.id)]

    evaluations, found = asyncio.run(ask())
    assert evaluations == 9 + 4  # the optimum and four places a parameter, and the ends of both intervals
    assert found.linearisation.parameters["b"].value == 2.0
