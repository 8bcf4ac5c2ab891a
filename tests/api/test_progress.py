"""How far a generation is, and what follow-ups would take."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sqlalchemy import insert

from geoswarm.solver.problem import parse_problem
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.store.codec import pack_array
from geoswarm.workers.store.tables import evaluations
from tests.api.conftest import API, App, line_problem, wait_for_end


def enter_runs(service: JobService, job_id: str, objectives: list[float | None]) -> None:
    """Rows of the first generation: those with an objective have finished after 2 s, the others wait."""
    rows: list[dict[str, Any]] = [
        {
            "job_id": job_id,
            "generation": 0,
            "particle": particle,
            "parameters": pack_array(np.array([1.0, 2.0])),
            "state": "pending" if objective is None else "finished",
            "attempts": 0 if objective is None else 1,
            "objective": objective,
            "seconds": None if objective is None else 2.0,
        }
        for particle, objective in enumerate(objectives)
    ]
    service.store.write(lambda connection: connection.execute(insert(evaluations), rows))


def test_finished_runs_count_before_their_generation_has_ended(service: JobService) -> None:
    app = App(service)
    job = service.submit(parse_problem(line_problem(stopping={"max_evaluations": 60})))[0].id
    nothing = app.get(f"{API}/jobs/{job}/progress").json()
    assert (nothing["evaluations"], nothing["objective"], nothing["seconds_left"]) == (0, None, None)
    enter_runs(service, job, [5.0, 0.5, 3.0, 8.0, 9.0, 4.0, 7.0, 6.0, None, None])
    found = app.get(f"{API}/jobs/{job}/progress").json()
    assert {key: found[key] for key in ("generation", "pending", "running", "finished", "failed", "evaluations")} == {
        "generation": 0,
        "pending": 2,
        "running": 0,
        "finished": 8,
        "failed": 0,
        "evaluations": 8,
    }
    assert (found["objective"], found["seconds"]) == (0.5, 2.0)
    assert found["seconds_left"] == pytest.approx(52 * 2.0)  # no worker lives: as for one
    assert service.get(job).evaluations == 0


@pytest.mark.slow
def test_follow_ups_say_what_they_take(engine: Engine) -> None:
    app = App(engine.service)
    problem = line_problem(stopping={"max_evaluations": 60})
    job = app.post(f"{API}/jobs", json=problem).json()["id"]
    ended = wait_for_end(engine.service, job)
    found = app.get(f"{API}/jobs/{job}/follow-ups").json()
    costs = {one["kind"]: one for one in found["items"]}
    assert list(costs) == ["sensitivity", "profile", "explore", "again", "sobol"]
    assert costs["again"]["evaluations"] == ended.evaluations
    each, workers = found["run_seconds"], max(found["workers"], 1)
    for one in costs.values():
        assert one["seconds"] == pytest.approx(one["evaluations"] * each / workers)
    sobol = app.post(f"{API}/jobs/{job}/global-sensitivity").json()
    assert costs["sobol"] | {"seconds": None} == {
        "kind": "sobol",
        "evaluations": sobol["max_evaluations"],
        "exact": True,
        "seconds": None,
        "refused": None,
    }
    followed = app.post(f"{API}/jobs/{job}/sensitivity").json()["id"]
    runs = wait_for_end(engine.service, followed).evaluations
    assert runs / 2 <= costs["sensitivity"]["evaluations"] <= 2 * runs
    assert app.get(f"{API}/jobs/{followed}/follow-ups").json()["items"][3]["evaluations"] == ended.evaluations


def test_what_cannot_be_submitted_says_why(service: JobService) -> None:
    app = App(service)
    job = service.submit(parse_problem(line_problem()))[0].id
    refused = {one["kind"]: one["refused"] for one in app.get(f"{API}/jobs/{job}/follow-ups").json()["items"]}
    assert refused["sensitivity"] == "There is no successful evaluation yet to start from."
    assert refused["sobol"] is None
