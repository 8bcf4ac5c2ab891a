"""Evaluations as one block of float32."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import API, App, wait_for_end
from tests.api.test_statistics import sampled


@pytest.fixture(scope="module")
def done(engine: Engine) -> tuple[App, str]:
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=sampled()).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    return app, f"{API}/jobs/{job}"


def test_the_block_holds_what_the_rows_hold(done: tuple[App, str]) -> None:
    app, path = done
    answer = app.get(f"{path}/points", params={"responses": "true"})
    assert answer.headers["content-type"] == "application/vnd.geoswarm.points"
    body = answer.content
    size = int.from_bytes(body[:4], "little")
    head = json.loads(body[4 : 4 + size])
    values = np.frombuffer(body, "<f4", offset=4 + size)
    rows = app.get(f"{path}/evaluations", params={"limit": 1000, "responses": "true"}).json()["items"]
    assert head["count"] == len(rows) == 400
    assert [p["name"] for p in head["parameters"]] == ["a", "b"]
    assert head["series"][1]["weight"] == 0.5
    place, columns = 0, {}
    for column in head["columns"]:
        length = head["count"] * column["width"]
        columns[column["kind"], column["name"]] = values[place : place + length].reshape(head["count"], -1)
        place += length
    assert place == len(values)
    assert columns["own", "particle"][:, 0].tolist() == [row["particle"] for row in rows]
    assert columns["own", "objective"][:, 0] == pytest.approx([row["objective"] for row in rows], rel=1e-6)
    assert columns["parameter", "b"][:, 0] == pytest.approx([row["parameters"]["b"] for row in rows], rel=1e-6)
    assert columns["misfit", "z"][:, 0] == pytest.approx([row["misfits"]["z"] for row in rows], rel=1e-6)
    assert columns["response", "z"][7] == pytest.approx(rows[7]["responses"]["z"]["y"], rel=1e-6)


def test_the_block_is_compressed_for_who_takes_it(done: tuple[App, str]) -> None:
    app, path = done
    plain = app.get(f"{path}/points", headers={"Accept-Encoding": "identity"})
    packed = app.get(f"{path}/points", headers={"Accept-Encoding": "gzip"})
    assert "content-encoding" not in plain.headers
    assert packed.headers["content-encoding"] == "gzip"
    assert packed.headers["vary"] == "Accept-Encoding"
    assert packed.content == plain.content


def test_a_job_without_evaluations_has_an_empty_block(app: App) -> None:
    job = app.post(f"{API}/jobs", json=sampled()).json()["id"]
    body = app.get(f"{API}/jobs/{job}/points").content
    size = int.from_bytes(body[:4], "little")
    head = json.loads(body[4 : 4 + size])
    assert (head["count"], head["source"], len(body)) == (0, None, 4 + size)
