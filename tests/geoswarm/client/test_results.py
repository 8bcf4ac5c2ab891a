"""Both clients read evaluations, fit, points and bodies as arrays."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import httpx
import numpy as np
import pytest

from geoswarm import AsyncClient, Client, ConflictError, GeoswarmError, NotFoundError
from tests.api.conftest import LiveServer, line_problem
from tests.api.test_mesh import loaded_ground
from tests.api.test_statistics import sampled
from tests.integration.engines import PATIENCE


@pytest.fixture
def job(client: Client) -> str:
    """Two lines sampled 400 times, the same in every test."""
    return client.wait(client.submit(sampled(), idempotency_key="sampled").id, timeout=PATIENCE).id


@pytest.fixture
def body(client: Client) -> str:
    """A calibration of loaded ground, the same in every test."""
    return client.wait(client.submit(loaded_ground(), idempotency_key="ground").id, timeout=120.0).id


def test_points_are_the_evaluations(client: Client, job: str) -> None:
    rows = list(client.iterate_evaluations(job, responses=True))
    points = client.points(job, responses=True)
    assert (points.count, points.failed, points.left_out, points.source) == (len(rows), 0, 0, "monte_carlo")
    assert [p.name for p in points.parameters] == list(points.values) == ["a", "b"]
    assert points.generation.tolist() == [row.generation for row in rows]
    assert points.particle.tolist() == [row.particle for row in rows]
    assert points.objective == pytest.approx([row.objective for row in rows], rel=1e-6)
    assert points.values["b"] == pytest.approx([row.parameters["b"] for row in rows], rel=1e-6)
    assert points.misfits["z"] == pytest.approx([row.misfits["z"] for row in rows], rel=1e-6)
    curve = (rows[7].responses or {})["z"]
    assert points.responses["z"][7] == pytest.approx(curve.y, rel=1e-6)
    series = {s.name: s for s in points.series}
    assert points.responses["z"].shape == (400, len(series["z"].x))
    assert series["z"].x == pytest.approx(curve.x)
    assert client.points(job).responses == {}
    for array in (points.generation, points.objective, points.values["a"], series["y"].y):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def answering(content: bytes) -> Client:
    """A client whose service answers everything with these bytes."""
    return Client("http://localhost", transport=httpx.MockTransport(lambda _: httpx.Response(200, content=content)))


def block(**changes: Any) -> bytes:
    own = [{"kind": "own", "name": name, "width": 1} for name in ("generation", "particle", "objective")]
    head = {"count": 1, "failed": 0, "left_out": 0, "source": None, "parameters": [], "series": [], "columns": own}
    text = json.dumps(head | changes).encode()
    return len(text).to_bytes(4, "little") + text + np.array([3, 1, 0.5], "<f4").tobytes()


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "is not one of a geoswarm service"),
        (b"\x04\x00\x00\x00null", "is not one of a geoswarm service"),
        (block()[:-1], r"bytes were announced, \d+ came"),
        (block(columns=[{"kind": "own", "name": "objective", "width": 3}]), "no column 'generation'"),
    ],
)
def test_a_block_that_is_none_is_reported(content: bytes, why: str) -> None:
    with answering(content) as client, pytest.raises(GeoswarmError, match=why):
        client.points("x")


def test_columns_of_a_newer_service_are_passed_over() -> None:
    own = [{"kind": "own", "name": name, "width": 1} for name in ("generation", "particle", "objective")]
    wide = {"kind": "gradient", "name": "a", "width": 2}
    content = block(columns=[*own, wide]) + np.zeros(2, "<f4").tobytes()
    with answering(content) as client:
        points = client.points("x")
    assert (points.generation.tolist(), points.particle.tolist(), points.objective.tolist()) == ([3], [1], [0.5])


def test_the_fit_in_the_units_of_the_problem(client: Client, job: str) -> None:
    fit = client.fit(job, generation=0, particle=3)
    assert [curve.role for curve in fit.curves] == ["initial", "best", "chosen"]
    assert [(p.name, p.form) for p in fit.parameters] == [("a", "free"), ("b", "free")]
    chosen = client.evaluation(job, 0, 3)
    assert fit.curves[2].objective == chosen.objective
    assert fit.curves[2].values["y"] == pytest.approx((chosen.responses or {})["y"].y)
    assert sum(share.share for share in fit.curves[1].shares) == pytest.approx(1.0)
    assert fit.series[0].measured.shape == fit.series[0].x.shape
    with pytest.raises(NotFoundError, match="99999"):
        client.evaluation(job, 0, 99999)


def test_generations_evenly_spaced(client: Client) -> None:
    job = client.wait(client.submit(line_problem()).id, timeout=PATIENCE).id
    assert [generation.number for generation in client.generations(job, points=4)] == [0, 3, 6, 9]


def test_mesh_and_fields_agree_with_the_calculated_vector(client: Client, body: str, job: str) -> None:
    mesh = client.mesh(body)
    assert mesh.nodes.shape[1] == 2
    assert mesh.triangles.shape == (len(mesh.regions), 6)
    assert mesh.interfaces.shape == (0, 6)
    assert mesh.triangles.max() == len(mesh.nodes) - 1
    (vector,) = mesh.vectors
    assert np.isnan(vector.measured[0])
    assert vector.measured[1] == pytest.approx(-0.02)
    fields = client.mesh_fields(body)
    assert (fields.start, fields.end) == (mesh.start, mesh.end) == ("weight", "loading")
    assert fields.displacement.shape == mesh.nodes.shape
    assert fields.shear_strain.shape == mesh.triangles.shape
    assert fields.displacement[mesh.points["A"], 1] == pytest.approx(vector.calculated[1], rel=1e-9)
    assert client.mesh_fields(body, since_beginning=True).start is None
    other = client.mesh(body, generation=0, particle=0)
    assert (other.generation, other.particle) == (0, 0)
    with pytest.raises(ConflictError, match="flood"):
        client.mesh_fields(body, end="flood")
    with pytest.raises(NotFoundError, match="formula"):
        client.mesh(job)


def test_the_asynchronous_client_reads_the_same(server: LiveServer, client: Client, body: str, job: str) -> None:
    async def ask() -> list[Any]:
        async with AsyncClient(server.url) as opened:
            points = await opened.points(job)
            fit = await opened.fit(job)
            mesh = await opened.mesh(body)
            fields = await opened.mesh_fields(body, start="weight", end="loading")
            return [
                await opened.evaluation(job, 0, 3),
                points.objective.tolist(),
                fit.curves[1].values["y"].tolist(),
                mesh.nodes.tolist(),
                fields.displacement.tolist(),
            ]

    assert asyncio.run(ask()) == [
        client.evaluation(job, 0, 3),
        client.points(job).objective.tolist(),
        client.fit(job).curves[1].values["y"].tolist(),
        client.mesh(body).nodes.tolist(),
        client.mesh_fields(body).displacement.tolist(),
    ]
