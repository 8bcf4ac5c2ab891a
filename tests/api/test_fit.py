"""Measured points with what evaluations give there, in the units of the user; one evaluation by its place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import API, App, line_problem, wait_for_end

MEASURED = {"x": [120.0, 0.0, 60.0], "y": [500.0, 100.0, 300.0]}
TEXTBOOK = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
CHANGES: dict[str, Any] = {
    "method": TEXTBOOK,
    "forward_model": {
        "kind": "formula",
        "series": {"settlement": {"expression": "a + b * x", "x_unit": "day", "y_unit": "m"}},
    },
    "parameters": {"a": {"lower": -5, "upper": 5, "initial": 1}, "b": {"lower": 0, "upper": 200}, "c": {"value": 2}},
    "observations": [{"series": "settlement", "points": MEASURED, "x_unit": "min", "y_unit": "mm", "weight": 3}],
}


@pytest.fixture(scope="module")
def job(engine: Engine) -> str:
    view, _ = engine.service.submit(parse_problem(line_problem(**CHANGES)))
    wait_for_end(engine.service, view.id)
    return view.id


def test_a_fit_has_the_units_of_the_user_and_rises_in_x(engine: Engine, job: str) -> None:
    fit = App(engine.service).get(f"{API}/jobs/{job}/fit").json()
    (series,) = fit["series"]
    assert (series["x_unit"], series["y_unit"], series["weight"]) == ("min", "mm", 3)
    assert (series["x"], series["measured"]) == ([0, 60, 120], pytest.approx([100, 300, 500], rel=1e-12))
    assert fit["objective_unit"] == "m²"
    first, best = fit["curves"]
    assert [first["role"], best["role"]] == ["initial", "best"]
    assert (first["generation"], first["particle"], first["parameters"]["a"]) == (0, 0, 1.0)
    a, b = best["parameters"]["a"], best["parameters"]["b"]
    assert best["values"]["settlement"] == pytest.approx(1000 * (a + b * np.array([0, 60, 120]) / 1440), rel=1e-9)
    left = np.array(best["values"]["settlement"]) - series["measured"]
    assert best["residuals"]["settlement"] == pytest.approx(left, rel=1e-9, abs=1e-9)
    assert series["distance"] == "vertical"
    assert best["objective"] == engine.service.get(job).objective
    assert [share["share"] for share in best["shares"]] == [pytest.approx(1.0, abs=1e-12)]
    assert best["shares"][0]["root_mean_square"] >= 0.0
    assert App(engine.service).get(f"{API}/jobs/{job}/diagrams").json() == {"items": []}  # a formula has none
    forms = {parameter["name"]: parameter["form"] for parameter in fit["parameters"]}
    assert forms == {"a": "free", "b": "free", "c": "fixed"}
    assert (fit["parameters"][0]["lower"], fit["parameters"][0]["initial"], fit["parameters"][2]["value"]) == (-5, 1, 2)


def test_distances_from_the_curve_are_the_residuals_in_the_unit_of_the_user(engine: Engine) -> None:
    observed = [CHANGES["observations"][0] | {"distance": "orthogonal"}]
    view, _ = engine.service.submit(parse_problem(line_problem(**CHANGES | {"observations": observed})))
    wait_for_end(engine.service, view.id)
    fit = App(engine.service).get(f"{API}/jobs/{view.id}/fit").json()
    (series,), best = fit["series"], fit["curves"][-1]
    assert series["distance"] == "orthogonal"
    x, y, line = (np.array(values) for values in (series["x"], series["measured"], best["values"]["settlement"]))
    slope = (line[-1] - line[0]) / 120.0 * np.ptp(x) / np.ptp(y)  # of a line, in parts of the ranges
    across = np.abs(line - y) / np.sqrt(1.0 + slope**2)
    distances = np.array(best["residuals"]["settlement"])
    assert (np.sign(distances) == np.sign(line - y)).all()
    assert (np.abs(distances) >= across * (1.0 - 1e-9)).all()  # beyond the ends of the line it is farther
    assert distances[1] == pytest.approx(np.sign(line - y)[1] * across[1], rel=1e-9, abs=1e-9)


def test_gross_errors_are_told_beside_the_measured_points(engine: Engine) -> None:
    observed = [CHANGES["observations"][0] | {"gross_errors": [3]}]
    view, _ = engine.service.submit(parse_problem(line_problem(**CHANGES | {"observations": observed})))
    wait_for_end(engine.service, view.id)
    (series,) = App(engine.service).get(f"{API}/jobs/{view.id}/fit").json()["series"]
    assert series["x"] == [0, 120]
    assert (series["gross_x"], series["gross_measured"]) == ([60], pytest.approx([300], rel=1e-12))


def test_a_laboratory_test_has_its_compression_curve(engine: Engine) -> None:
    with example_file("oedometer") as path:
        document = load_problem(path).document() | {"method": {"kind": "monte_carlo", "samples": 1}, "stopping": {}}
    view, _ = engine.service.submit(parse_problem(document))
    wait_for_end(engine.service, view.id)
    app = App(engine.service)
    (curve,) = app.get(f"{API}/jobs/{view.id}/diagrams").json()["items"]
    assert (curve["name"], curve["test"], curve["log"], curve["downwards"]) == ("compression", "", True, True)
    assert (curve["x_quantity"], curve["y_unit"]) == ("vertical effective stress σ′v", "%")
    assert curve["x"][:3] == [0.2, 9, 13]
    assert len(curve["measured_x"]) == len(curve["measured_y"]) == 16
    lambda_star = app.get(f"{API}/jobs/{view.id}/fit").json()["parameters"][0]
    assert lambda_star["lower"] < lambda_star["typical_lower"] < lambda_star["typical_upper"]


def test_one_evaluation_is_shown_by_its_place(engine: Engine, job: str) -> None:
    app = App(engine.service)
    chosen = app.get(f"{API}/jobs/{job}/fit?generation=2&particle=3").json()["curves"][-1]
    one = app.get(f"{API}/jobs/{job}/evaluations/2/3").json()
    assert (chosen["role"], chosen["generation"], chosen["particle"]) == ("chosen", 2, 3)
    assert chosen["objective"] == one["objective"]
    order = np.argsort(MEASURED["x"])
    assert chosen["values"]["settlement"] == pytest.approx(
        1000 * np.array(one["responses"]["settlement"]["y"])[order], rel=1e-12
    )
    page = app.get(f"{API}/jobs/{job}/evaluations?generation=2&responses=true").json()["items"]
    assert one == page[3]
    for path in ("fit?generation=2&particle=99", "evaluations/2/99", "evaluations/999/0"):
        answer = app.get(f"{API}/jobs/{job}/{path}")
        assert (answer.status_code, answer.json()["type"]) == (404, "urn:geoswarm:error:evaluation-not-found")
    assert app.get(f"{API}/jobs/{job}/fit?generation=2").status_code == 422


def test_a_job_that_waits_shows_its_measured_points(app: App) -> None:
    job_id = app.post(f"{API}/jobs", json=line_problem(**CHANGES)).json()["id"]
    fit = app.get(f"{API}/jobs/{job_id}/fit").json()
    assert fit["curves"] == []
    assert fit["series"][0]["measured"] == pytest.approx([100, 300, 500], rel=1e-12)


def test_generations_come_evenly_spaced(engine: Engine, job: str) -> None:
    app = App(engine.service)
    numbers = [g["number"] for g in app.get(f"{API}/jobs/{job}/generations?points=4").json()["items"]]
    assert numbers == [0, 3, 6, 9]
    assert len(app.get(f"{API}/jobs/{job}/generations?points=400").json()["items"]) == 10


def test_lists_are_filtered_over_http(engine: Engine, job: str) -> None:
    app = App(engine.service)
    found = app.get(f"{API}/jobs?q=line&state=finished&state=failed&sort=objective&order=ascending&trend=5").json()
    (item,) = [item for item in found["items"] if item["id"] == job]
    assert len(item["trend"]) == 5
    assert item["trend"][-1] == item["objective"]
    assert item["last_event"] == engine.service.events(job)[-1].id
    assert app.get(f"{API}/jobs?q=%00").status_code == 422
    assert app.get(f"{API}/jobs?sort=colour").status_code == 422


def test_the_end_of_a_job_is_changed_over_http(engine: Engine) -> None:
    app = App(engine.service)
    job_id = app.post(f"{API}/jobs", json=line_problem(method=TEXTBOOK, stopping={"max_evaluations": 12})).json()["id"]
    wait_for_end(engine.service, job_id)
    path = f"{API}/jobs/{job_id}"
    assert app("PATCH", path, json={"stopping": {"max_evaluations": 12}}).status_code == 409
    assert app("PATCH", path, json={"stopping": {"max_evaluations": "many"}}).status_code == 422
    assert app("PATCH", path, json={"seed": 8}).status_code == 422
    answer = app("PATCH", path, json={"stopping": {"max_evaluations": 30, "max_seconds": None}})
    assert (answer.status_code, answer.json()["max_evaluations"]) == (200, 30)
    assert wait_for_end(engine.service, job_id).evaluations == 30
