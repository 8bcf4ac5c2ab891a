"""Meshes and fields over HTTP."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.api import ApiSettings
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import API, App, line_problem, wait_for_end
from tests.solver.forward.continuum.bodies import OEDOMETER, ground


def loaded_ground(**changes: Any) -> dict[str, Any]:
    """Ground whose depth is looked for from the settlement of its surface."""
    return {
        "name": "ground",
        "forward_model": ground(),
        "parameters": {"depth": {"lower": 2, "upper": 9}, "E_rock": {"value": 1e5}, "q": {"value": 50}},
        "observations": [{"series": "A.uy", "points": {"x": [0], "y": [-20]}, "y_unit": "mm"}],
        "method": {"kind": "monte_carlo", "samples": 3},
        "seed": 4,
    } | changes


@pytest.fixture(scope="module")
def done(engine: Engine) -> tuple[App, str]:
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=loaded_ground()).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    return app, f"{API}/jobs/{job}"


def test_the_mesh_is_that_of_the_best_evaluation(done: tuple[App, str]) -> None:
    app, path = done
    best = app.get(f"{path}/best").json()
    found = app.get(f"{path}/mesh").json()
    assert (found["generation"], found["particle"]) == (best["generation"], best["particle"])
    assert (found["parameters"], found["objective_unit"]) == (best["parameters"], "m²")
    nodes = np.array(found["nodes"])
    assert nodes.min(axis=0) == pytest.approx([0, 0])
    assert nodes.max(axis=0) == pytest.approx([8, 10])
    below = nodes[found["points"]["B"]]
    assert below == pytest.approx([4, 10 - best["parameters"]["depth"]])
    assert [(p["name"], p["end"]) for p in found["phases"]] == [("weight", 0.0), ("loading", 0.0)]
    assert (found["start"], found["end"]) == ("weight", "loading")
    (vector,) = found["vectors"]
    assert vector["measured"] == [None, pytest.approx(-0.02)]
    assert vector["calculated"] == [None, best["responses"]["A.uy"]["y"][0]]


def test_fields_are_the_displacements_of_all_nodes(done: tuple[App, str]) -> None:
    app, path = done
    mesh = app.get(f"{path}/mesh").json()
    found = app.get(f"{path}/mesh/fields").json()
    assert (found["start"], found["end"]) == ("weight", "loading")
    moved = np.array(found["displacement"])
    node = mesh["points"]["A"]
    assert moved[node, 1] == pytest.approx(mesh["vectors"][0]["calculated"][1], rel=1e-9)
    depth = mesh["parameters"]["depth"]
    assert moved[node, 1] == pytest.approx(-50 * depth / OEDOMETER - 5 * (10 - depth) / OEDOMETER, rel=1e-6)
    assert np.array(found["shear_strain"]).shape == np.array(mesh["triangles"]).shape
    whole = app.get(f"{path}/mesh/fields", params={"since_beginning": "true"}).json()
    assert whole["start"] is None
    assert whole["displacement"][node][1] < moved[node, 1]


def test_another_evaluation_has_another_mesh(done: tuple[App, str]) -> None:
    app, path = done
    meshes = [app.get(f"{path}/mesh", params={"generation": 0, "particle": p}).json() for p in range(3)]
    assert len({mesh["parameters"]["depth"] for mesh in meshes}) == 3
    assert len({str(mesh["nodes"]) for mesh in meshes}) == 3


@pytest.mark.parametrize(
    ("query", "status", "word"),
    [
        ({"generation": 7, "particle": 0}, 404, "generation 7"),
        ({"part": "slope"}, 404, "slope"),
        ({"end": "flood"}, 409, "flood"),
        ({"generation": -1}, 422, "generation"),
    ],
)
def test_what_is_not_there_is_named(done: tuple[App, str], query: dict[str, Any], status: int, word: str) -> None:
    app, path = done
    answer = app.get(f"{path}/mesh/fields", params=query)
    assert answer.status_code == status
    assert word in answer.json()["detail"]


def test_a_model_without_a_body_has_no_mesh(app: App) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    answer = app.get(f"{API}/jobs/{job}/mesh")
    assert answer.status_code == 404
    assert answer.json()["type"] == "urn:geoswarm:error:no-mesh"
    assert "formula" in answer.json()["detail"]


def test_before_the_first_evaluation_there_is_the_nominal_mesh(app: App) -> None:
    job = app.post(f"{API}/jobs", json=loaded_ground()).json()["id"]
    found = app.get(f"{API}/jobs/{job}/mesh").json()
    assert found["generation"] is None
    assert np.array(found["nodes"])[found["points"]["B"]] == pytest.approx([4, 4])
    assert app.get(f"{API}/jobs/{job}/mesh/fields").status_code == 409


def test_a_run_that_exceeds_the_limit_is_ended(engine: Engine) -> None:
    app = App(engine.service)
    layers = [{"name": "sand", "thickness": "depth", "rows": 30}, {"name": "rock", "bottom": 0, "rows": 30}]
    fine = ground(layers=layers, element_length=0.2)  # takes longer than the interval at which limits are looked after
    document = loaded_ground(forward_model=fine, limits={"seconds_per_evaluation": 1e-6})
    answer = app.post(f"{API}/jobs", json=document)
    assert answer.status_code == 201, answer.text
    job = answer.json()["id"]
    wait_for_end(engine.service, job)
    answer = app.get(f"{API}/jobs/{job}/mesh/fields", params={"generation": 0, "particle": 0})
    assert answer.status_code == 409
    assert answer.json()["type"] == "urn:geoswarm:error:no-fields"


def test_who_may_only_read_starts_no_forward_run(engine: Engine) -> None:
    # the last of this file: once a key is made, the engine that all tests share asks everybody for one
    keyed = App(engine.service, ApiSettings(require_key=True))
    ring = ApiKeys(engine.service.store)
    keyed.headers["X-API-Key"] = ring.create("zoe", "submit")[0]
    job = keyed.post(f"{API}/jobs", json=loaded_ground()).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    reader = {"X-API-Key": ring.create("zoe", "read")[0]}
    assert keyed.get(f"{API}/jobs/{job}/mesh", headers=reader).status_code == 200
    assert keyed.get(f"{API}/jobs/{job}/mesh/fields", headers=reader).status_code == 403
    other = {"X-API-Key": ring.create("yan", "submit")[0]}
    assert keyed.get(f"{API}/jobs/{job}/mesh/fields", headers=other).status_code == 404
