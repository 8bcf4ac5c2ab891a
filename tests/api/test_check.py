"""Test runs of problems that are not jobs: in a process of their own, within limits."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import pytest

from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import API, App, line_problem

pytestmark = pytest.mark.usefixtures("misbehaving_models")


def misbehaving(behaviour: str, **changes: Any) -> dict[str, Any]:
    return line_problem(
        forward_model={"kind": "misbehaving", "behaviour": behaviour, "above": -2},
        parameters={"slope": {"lower": -1, "upper": 1}},
        **changes,
    )


def test_a_run_that_hangs_is_ended_and_the_next_one_is_made(app: App) -> None:
    hanging = misbehaving("for_ever", limits={"seconds_per_evaluation": 0.5})
    run = app.post(f"{API}/problems/check", json=hanging).json()["test_run"]
    assert (run["state"], run["reason"]) == ("failed", "timeout")
    assert "longer than 0.5 s" in run["message"]
    answer = app.post(f"{API}/problems/check", json=line_problem(answer={})).json()
    assert answer["test_run"]["state"] == "finished"
    assert (answer["planned_evaluations"], answer["left_to_answer"]) == (60, 15)


def test_a_run_that_crashes_ends_no_more_than_itself(app: App) -> None:
    run = app.post(f"{API}/problems/check", json=misbehaving("crash")).json()["test_run"]
    assert (run["state"], run["reason"]) == ("failed", "worker_lost")
    assert "SIGSEGV" in run["message"]
    assert app.get("/health/live").status_code == 200


def test_the_service_has_a_limit_of_its_own(settings: Settings) -> None:
    impatient = settings.model_copy(update={"check_seconds": 4.0})
    with closing(Store(impatient)) as store, closing(JobService(store, NoWaker(), impatient)) as service:
        app = App(service)
        assert app.post(f"{API}/problems/check", json=line_problem()).json()["test_run"]["state"] == "finished"
        run = app.post(f"{API}/problems/check", json=misbehaving("for_ever")).json()["test_run"]
        assert run["reason"] == "timeout"


def test_what_is_probably_not_meant_is_reported(app: App) -> None:
    soil = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.004, "phi": 25.0}
    document = line_problem(
        forward_model={
            "kind": "oedometer", "height": 20, "initial_stress": 1, "stages": [{"stress": 50, "duration": 24}]
        },
        parameters={name: {"value": value} for name, value in soil.items()} | {"c": {"lower": 1, "upper": 20}},
        observations=[{"series": "settlement", "points": {"x": [0.1, 1.0], "y": [-0.5, -0.7]}}],
    )  # fmt: skip
    told = app.post(f"{API}/problems/check", json=document).json()["warnings"]
    assert app.post(f"{API}/problems/read", json=document).json()["warnings"] == told
    assert [one.partition(" =")[0] for one in told[:2]] == [
        "forward_model.height",
        "forward_model.stages[].duration",
    ]
    assert "compression is positive; y_factor: -1 turns them" in told[2]


def test_what_the_model_assumes_is_reported(app: App) -> None:
    model = {
        "kind": "triaxial",
        "material": "elastic",
        "initial_stress": 100.0,
        "drainage": "undrained",
        "shearing": [{"kind": "monotonic", "axial_strain": 0.01}],
    }
    problem = line_problem(
        forward_model=model,
        parameters={"E": {"lower": 1.0e3, "upper": 1.0e5}, "nu": {"value": 0.3}},
        observations=[{"series": "q", "points": {"x": [0.01], "y": [40.0]}}],
    )
    (sentence,) = app.post(f"{API}/problems/check", json=problem).json()["assumptions"]
    assert sentence.startswith("The bulk modulus of water is not given, so pore water is rigid")
    assert app.post(f"{API}/problems/check", json=line_problem()).json()["assumptions"] == []
