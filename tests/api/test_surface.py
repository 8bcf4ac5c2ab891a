"""Slices and contours of the response surface over HTTP."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import API, App, wait_for_end
from tests.api.test_uncertainty import X, Y, done, examined, noisy

__all__ = ["done", "examined"]  # fixtures


def fit_of_a_line() -> dict[str, Any]:
    """The same readings, searched, with an answer."""
    return noisy() | {"method": {"kind": "particle_swarm"}, "stopping": {"max_evaluations": 60}, "answer": {}}


def test_slices_and_contours_of_the_response_surface(examined: tuple[App, str, str]) -> None:
    app, job, _ = examined
    found = app.get(f"{API}/jobs/{job}/surface", params={"noise": 0.05}).json()
    assert found["trusted"]
    assert found["error"] < 0.05
    assert found["objective"] < found["limit"]
    design = np.stack([np.ones_like(X), X], axis=1)
    for one, column in zip(found["slices"], design.T, strict=True):
        best = found["best"][one["parameter"]]
        rest = Y - design @ [found["best"]["a"], found["best"]["b"]]
        for value, objective in zip(one["values"], one["objectives"], strict=True):
            exact = float(np.mean((rest - (value - best) * column) ** 2))
            assert objective == pytest.approx(exact, rel=0.02)
    contours = found["contours"]
    assert (contours["x"], contours["y"]) == ("a", "b")
    assert np.shape(contours["objectives"]) == (len(contours["y_values"]), len(contours["x_values"]))
    assert len(found["runs"]["objectives"]) == found["evaluations"]
    turned = app.get(f"{API}/jobs/{job}/surface", params={"x": "b"}).json()["contours"]
    assert (turned["x"], turned["y"]) == ("b", "a")
    refused = app.get(f"{API}/jobs/{job}/surface", params={"x": "c"})
    assert refused.status_code == 422
    assert "'c' is no free parameter; there are a, b" in refused.json()["detail"]


def test_the_surface_of_an_answered_search_has_the_runs_of_its_answer(engine: Engine) -> None:
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=fit_of_a_line()).json()["id"]
    ended = wait_for_end(engine.service, job)
    found = app.get(f"{API}/jobs/{job}/surface").json()
    assert ended.search_evaluations is not None
    assert ended.evaluations > ended.search_evaluations
    assert found["evaluations"] > ended.search_evaluations
    assert found["best"] == pytest.approx(ended.parameters)


def test_each_failed_run_of_search_and_answer_is_shown_once(engine: Engine) -> None:
    app = App(engine.service)
    problem = fit_of_a_line()
    problem["forward_model"]["series"]["y"]["expression"] += " + 0 * ln(0.52 - b)"
    job = app.post(f"{API}/jobs", json=problem).json()["id"]
    ended = wait_for_end(engine.service, job)
    runs = list(engine.service.iterate_evaluations(job))
    failed = [number for number, run in enumerate(runs) if run.state == "failed"]
    assert ended.search_evaluations is not None
    assert failed[0] < ended.search_evaluations <= failed[-1]
    shown = app.get(f"{API}/jobs/{job}/surface").json()["runs"]["objectives"]
    assert shown.count(None) == len(failed)
