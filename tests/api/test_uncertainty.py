"""Follow-up jobs: sensitivities, profiles, global sensitivity; the posterior sample; known noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import stats

from geoswarm.solver.identifiability.stored.findings import findings_of
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.queries.follow_ups import evaluations_in_order
from tests.api.conftest import API, App, line_problem, wait_for_end
from tests.solver.identifiability.test_leaving_out import curves, fit, scattered

X = np.linspace(0.0, 3.0, 16)
Y = 1.0 + 2.0 * X + np.random.default_rng(4).normal(0.0, 0.05, X.size)


def noisy() -> dict[str, Any]:
    return line_problem(
        observations=[{"series": "y", "points": {"x": X.tolist(), "y": Y.tolist()}}],
        method={"kind": "monte_carlo", "samples": 300},
        stopping={},
        noise={"kind": "white"},
    )


def textbook(noise: float | None = None) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Standard errors of intercept and slope by the normal equations."""
    design = np.stack([np.ones_like(X), X], axis=1)
    found = np.linalg.lstsq(design, Y, rcond=None)[0]
    variance = np.sum((Y - design @ found) ** 2) / (X.size - 2) if noise is None else noise**2
    errors: np.ndarray[Any, np.dtype[np.float64]] = np.sqrt(variance * np.diag(np.linalg.inv(design.T @ design)))
    return errors


@pytest.fixture(scope="module")
def done(engine: Engine) -> tuple[App, str]:
    """A finished sampling, and the application that shows it."""
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=noisy()).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    return app, job


@pytest.fixture(scope="module")
def examined(done: tuple[App, str], engine: Engine) -> tuple[App, str, str]:
    """The same, with its sensitivities."""
    app, job = done
    assert app.post(f"{API}/jobs/{job}/profile").status_code == 409
    submitted = app.post(f"{API}/jobs/{job}/sensitivity")
    assert submitted.status_code == 201
    assert submitted.headers["location"].endswith(submitted.json()["id"])
    assert wait_for_end(engine.service, submitted.json()["id"]).state == "finished"
    return app, job, submitted.json()["id"]


def errors_of(answer: dict[str, Any]) -> list[float]:
    return [row["standard_error"] for row in answer["linearisation"]["parameters"].values()]


def test_sensitivities_give_the_textbook_errors(examined: tuple[App, str, str]) -> None:
    app, job, follow_up = examined
    found = app.get(f"{API}/jobs/{job}/uncertainty").json()
    assert found["follow_ups"][-1] == {
        "id": follow_up,
        "kind": "sensitivity",
        "state": "finished",
        "evaluations": found["follow_ups"][-1]["evaluations"],
    }
    np.testing.assert_allclose(errors_of(found), textbook(), rtol=1e-5)
    assert found["linearisation"]["at_optimum"]
    assert errors_of(app.get(f"{API}/jobs/{follow_up}/uncertainty").json()) == errors_of(found)
    statistics = app.get(f"{API}/jobs/{job}/statistics").json()
    assert errors_of(statistics) == errors_of(found)


def test_an_exploration_counts_in_the_statistics(examined: tuple[App, str, str], engine: Engine) -> None:
    app, job, _ = examined
    before = app.get(f"{API}/jobs/{job}/statistics").json()["basins"]
    submitted = app.post(f"{API}/jobs/{job}/explore", json={"runs": 40})
    assert submitted.status_code == 201
    assert wait_for_end(engine.service, submitted.json()["id"]).state == "finished"
    found = app.get(f"{API}/jobs/{job}/uncertainty").json()
    assert 0 < found["explored"] <= 40
    assert "explore" in [one["kind"] for one in found["follow_ups"]]
    after = app.get(f"{API}/jobs/{job}/statistics").json()["basins"]
    assert after["hidden"] <= before["hidden"]
    assert after["others"] == []  # of a line
    assert app.post(f"{API}/jobs/{job}/explore", json={"runs": 0}).status_code == 422
    assert app.post(f"{API}/jobs/0123456789abcdef/explore").status_code == 404


def test_known_noise_counts_instead_of_the_residuals(examined: tuple[App, str, str]) -> None:
    app, job, _ = examined
    for noise in ("0.2", "y=0.2"):
        found = app.get(f"{API}/jobs/{job}/uncertainty", params={"noise": noise}).json()
        np.testing.assert_allclose(errors_of(found), textbook(0.2), rtol=1e-5)
        assert found["linearisation"]["noise"] == {"origin": "known", "deviations": {"y": 0.2}}
    page = app.get(f"{API}/jobs/{job}/report.html", params={"noise": "0.2"})
    assert page.status_code == 200
    for wrong in ("-1", "y", "y=", "=1", "nan"):
        refused = app.get(f"{API}/jobs/{job}/statistics", params={"noise": wrong})
        assert refused.status_code == 422, wrong
        assert refused.json()["issues"][0]["path"] == "query.noise"
    assert app.get(f"{API}/jobs/{job}/statistics", params={"noise": ["1", "y=1"]}).status_code == 422
    assert "observed series: y" in app.get(f"{API}/jobs/{job}/statistics", params={"noise": "q=1"}).json()["detail"]


def test_profiles_equal_those_of_this_process_bit_for_bit(examined: tuple[App, str, str], engine: Engine) -> None:
    app, job, _ = examined
    submitted = app.post(f"{API}/jobs/{job}/profile", json={"parameters": ["b"]}, headers={"Idempotency-Key": "p"})
    again = app.post(f"{API}/jobs/{job}/profile", json={"parameters": ["b"]}, headers={"Idempotency-Key": "p"})
    assert (submitted.status_code, again.status_code) == (201, 200)
    follow_up = submitted.json()["id"]
    assert again.json()["id"] == follow_up
    ended = wait_for_end(engine.service, follow_up)
    assert (ended.state, ended.stop_reasons) == ("finished", ["design_completed"])
    stored = engine.service.store.read(lambda connection: evaluations_in_order(connection, follow_up))
    local = calibrate(parse_problem(app.get(f"{API}/jobs/{follow_up}/problem").json())).history
    assert [e.objective for e in stored] == [r.evaluation.objective for r in local]
    np.testing.assert_array_equal([e.parameters for e in stored], [r.evaluation.parameters for r in local])
    (profile,) = app.get(f"{API}/jobs/{job}/uncertainty").json()["profiles"]
    linear = app.get(f"{API}/jobs/{job}/uncertainty").json()["linearisation"]["parameters"]["b"]["interval"]
    np.testing.assert_allclose([profile["lower"], profile["upper"]], linear, rtol=1e-4)
    assert app.post(f"{API}/jobs/{job}/profile", json={"parameters": ["q"]}).status_code == 422


def test_tests_are_left_out_as_in_this_process_bit_for_bit(done: tuple[App, str], engine: Engine) -> None:
    app, single = done
    refused = app.post(f"{API}/jobs/{single}/jackknife")
    assert refused.status_code == 422
    assert "at least 3 tests with readings, got a single one" in refused.json()["detail"]
    sampling = {"seed": 1, "method": {"kind": "monte_carlo", "samples": 60}, "stopping": {}}
    readings = curves(*scattered(1, 4)).document() | sampling
    job = app.post(f"{API}/jobs", json=readings).json()["id"]
    wait_for_end(engine.service, job)
    assert app.post(f"{API}/jobs/{job}/jackknife").status_code == 409
    wait_for_end(engine.service, app.post(f"{API}/jobs/{job}/sensitivity").json()["id"])
    costs = {one["kind"]: one for one in app.get(f"{API}/jobs/{job}/follow-ups").json()["items"]}
    assert costs["jackknife"]["evaluations"] == 37
    submitted = app.post(f"{API}/jobs/{job}/jackknife", json={"by": "test"}).json()
    assert submitted["max_evaluations"] == 37
    assert wait_for_end(engine.service, submitted["id"]).stop_reasons == ["design_completed"]
    stored = engine.service.store.read(lambda connection: evaluations_in_order(connection, submitted["id"]))
    local = calibrate(parse_problem(app.get(f"{API}/jobs/{submitted['id']}/problem").json()), workers=2).history
    assert [e.objective for e in stored] == [r.evaluation.objective for r in local]
    found = app.get(f"{API}/jobs/{job}/uncertainty").json()
    assert found["jackknife"] == found["linearisation"]["without_tests"]
    values = [one["values"]["test_2"] for one in found["jackknife"]["parameters"].values()]
    np.testing.assert_allclose(values, fit(curves(*scattered(1, 4)), 1), rtol=2e-3)
    assert "jackknife" not in {one["kind"] for one in app.get(f"{API}/jobs/{single}/follow-ups").json()["items"]}


# tests/solver/identifiability/test_follow_ups.py has the same follow-up without a service
@pytest.mark.slow
def test_global_sensitivity_and_the_report_of_everything(examined: tuple[App, str, str], engine: Engine) -> None:
    app, job, _ = examined
    submitted = app.post(f"{API}/jobs/{job}/global-sensitivity", json={"kind": "morris", "samples": 12})
    assert submitted.status_code == 201
    assert submitted.json()["max_evaluations"] == 36
    assert wait_for_end(engine.service, submitted.json()["id"]).state == "finished"
    found = app.get(f"{API}/jobs/{job}/uncertainty").json()["global_sensitivities"]
    assert [(one["kind"], one["output"], one["blocks"]) for one in found] == [
        ("morris", "objective", 12),
        ("morris", "y", 12),
    ]
    names = app.get(f"{API}/jobs/{job}/figures", params={"posterior": True}).json()["items"]
    assert {"posterior", "global_sensitivity"} <= set(names)
    for name in ("posterior", "global_sensitivity"):
        for form, start in (("svg", b"<?xml"), ("png", b"\x89PNG"), ("csv", name[0:0].encode())):
            answer = app.get(f"{API}/jobs/{job}/figures/{name}.{form}", params={"posterior": True})
            assert answer.status_code == 200
            assert answer.content.startswith(start)
    page = app.get(f"{API}/jobs/{job}/report.html", params={"posterior": True})
    assert "Posterior sample" in page.text
    assert "Elementary effects of Morris" in page.text
    own = app.get(f"{API}/jobs/{submitted.json()['id']}/report.html")
    assert "Influence on the objective, the largest first" in own.text
    assert app.get(f"{API}/jobs/{submitted.json()['id']}/statistics").json()["samples"]["source"] == "follow_up"
    refused = app.post(f"{API}/jobs/{job}/global-sensitivity", json={"samples": 100})
    assert refused.status_code == 422
    assert refused.json()["issues"] == [{"path": "method.samples", "message": "must be a power of two, got 100"}]


def test_posterior_agrees_with_the_linear_interval(examined: tuple[App, str, str]) -> None:
    app, job, _ = examined
    found = app.get(f"{API}/jobs/{job}/posterior", params={"noise": 0.05}).json()
    linear = app.get(f"{API}/jobs/{job}/uncertainty", params={"noise": 0.05}).json()["linearisation"]["parameters"]
    assert found["trusted"]
    for name, row in linear.items():
        half = (row["interval"][1] - row["interval"][0]) / 2.0
        assert found["medians"][name] == pytest.approx(row["value"], abs=0.1 * half)
        assert np.diff(found["intervals"][name])[0] / 2.0 == pytest.approx(half, rel=0.1)


def test_a_follow_up_of_another_question_is_not_taken(examined: tuple[App, str, str], engine: Engine) -> None:
    app, job, follow_up = examined
    other = app.get(f"{API}/jobs/{follow_up}/problem").json()
    other["observations"][0]["points"]["y"] = [y + 1.0 for y in other["observations"][0]["points"]["y"]]
    foreign = app.post(f"{API}/jobs", json=other).json()["id"]
    assert wait_for_end(engine.service, foreign).state == "finished"
    listed = app.get(f"{API}/jobs/{job}/uncertainty").json()["follow_ups"]
    assert foreign not in [f["id"] for f in listed]


def test_what_cannot_be_followed_up(app: App) -> None:
    queued = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    refused = app.post(f"{API}/jobs/{queued}/sensitivity")
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:geoswarm:error:no-optimum")
    at = app.post(f"{API}/jobs/{queued}/sensitivity", json={"at": {"a": 1.0, "b": 2.0}, "polish": False})
    assert at.status_code == 201
    assert at.json()["max_evaluations"] is None  # steps are found: how many runs it takes is not known before
    fixed = {"at": {"a": 1.0, "b": 2.0}, "polish": False, "step": 5e-3}
    assert app.post(f"{API}/jobs/{queued}/sensitivity", json=fixed).json()["max_evaluations"] == 9
    missing = app.post(f"{API}/jobs/{queued}/sensitivity", json={"at": {"a": 1.0}})
    assert "at: b is missing; free: a, b" in missing.json()["detail"]
    assert app.get(f"{API}/jobs/{queued}/posterior").status_code == 422
    few_runs = app.get(f"{API}/jobs/{queued}/surface")
    assert few_runs.status_code == 422
    assert "a response surface needs 30 different evaluations, there are 0" in few_runs.json()["detail"]
    for path in ("sensitivity", "profile", "global-sensitivity"):
        assert app.post(f"{API}/jobs/0123456789abcdef/{path}").status_code == 404
    single = line_problem(observations=[{"series": "y", "points": {"x": [1], "y": [3]}}])
    one = app.post(f"{API}/jobs", json=single).json()["id"]
    few = app.post(f"{API}/jobs/{one}/sensitivity", json={"at": {"a": 1.0, "b": 2.0}})
    assert few.status_code == 422
    assert "1 measured point cannot determine 2 free parameters" in few.json()["detail"]


def test_answers_are_described(app: App) -> None:
    paths = app.get("/openapi.json").json()["paths"]
    for path, method in (
        ("statistics", "get"),
        ("reweight", "post"),
        ("uncertainty", "get"),
        ("posterior", "get"),
        ("surface", "get"),
    ):
        operation = paths[f"{API}/jobs/{{job_id}}/{path}"][method]
        schema = operation["responses"]["200"]["content"]["application/json"]["schema"]
        assert schema["$ref"].endswith("Answer")


LATER: dict[str, Any] = {
    "name": "later",
    "forward_model": {"kind": "formula", "series": {"y": "a + b * x"}},
    "observations": [{"series": "y", "points": {"x": [3.0, 6.0]}}],
}


def test_a_prediction_has_the_textbook_band(examined: tuple[App, str, str], engine: Engine) -> None:
    app, job, _ = examined
    submitted = app.post(f"{API}/jobs/{job}/predict", json={"problem": LATER, "runs": 400})
    assert submitted.status_code == 201, submitted.text
    follow_up = submitted.json()["id"]
    assert wait_for_end(engine.service, follow_up).state == "finished"
    found = app.get(f"{API}/jobs/{job}/uncertainty").json()
    (prediction,) = found["predictions"]
    assert prediction == app.get(f"{API}/jobs/{follow_up}/uncertainty").json()["predictions"][0]
    (series,) = prediction["series"]
    design = np.stack([np.ones_like(X), X], axis=1)
    best = np.linalg.lstsq(design, Y, rcond=None)[0]
    at = np.array([[1.0, 3.0], [1.0, 6.0]])
    variance = np.sum((Y - design @ best) ** 2) / (X.size - 2)
    error = np.sqrt(variance * np.einsum("ij,jk,ik->i", at, np.linalg.inv(design.T @ design), at))
    np.testing.assert_allclose(series["median"], at @ best, atol=0.05 * error.max())
    np.testing.assert_allclose(
        np.array(series["upper"]) - series["lower"], 2 * stats.t.ppf(0.95, X.size - 2) * error, rtol=0.07
    )
    assert {f["kind"] for f in found["follow_ups"]} >= {"predict"}
    question = parse_problem(app.get(f"{API}/jobs/{follow_up}/problem").json())
    history = [record.evaluation for record in calibrate(question).history]
    assert findings_of(question, 0, history).predictions[0].to_json() == prediction  # to the last bit
    figures = app.get(f"{API}/jobs/{job}/figures").json()["items"]
    assert "prediction.later" in figures
    assert app.get(f"{API}/jobs/{follow_up}/figures").json()["items"] == ["prediction.later"]
    table = app.get(f"{API}/jobs/{job}/figures/prediction.later.csv").text.splitlines()
    assert table[0].startswith("series,x,x_unit,median,lower,upper")
    page = app.get(f"{API}/jobs/{follow_up}/report.html").text
    assert "Prediction: later" in page


def two_tests(fragile: str) -> dict[str, Any]:
    series = {"sound": "a + b * x", "fragile": fragile}
    return {
        "name": "two tests",
        "forward_model": {
            "kind": "combined",
            "parts": {name: {"kind": "formula", "series": {"y": formula}} for name, formula in series.items()},
        },
        "observations": [{"series": f"{name}.y", "points": {"x": [3.0]}} for name in series],
    }


def test_a_test_that_fails_in_every_draw_leaves_the_band_of_the_other(
    examined: tuple[App, str, str], engine: Engine
) -> None:
    """The job had failed; `geoswarm predict` gave the band."""
    app, job, _ = examined
    other = two_tests("ln(-1 - a**2)")
    follow_up = app.post(f"{API}/jobs/{job}/predict", json={"problem": other, "runs": 60}).json()["id"]
    ended = wait_for_end(engine.service, follow_up)
    assert (ended.state, ended.error, ended.objective) == ("finished", None, None)
    (found,) = app.get(f"{API}/jobs/{follow_up}/uncertainty").json()["predictions"]
    assert [one["series"] for one in found["series"]] == ["sound.y"]
    assert "Fragile.y: no band, which needs 10 successful runs." in found["remarks"]
    question = parse_problem(app.get(f"{API}/jobs/{follow_up}/problem").json())
    result = calibrate(question)
    assert (result.state, result.error) == ("finished", None)
    history = [record.evaluation for record in result.history]
    assert findings_of(question, 0, history).predictions[0].to_json() == found
    page = app.get(f"{API}/jobs/{follow_up}/report.html")
    assert "Prediction: two tests" in page.text
    lost = two_tests("ln(-1 - a**2)") | {"observations": [{"series": "fragile.y", "points": {"x": [3.0]}}]}
    follow_up = app.post(f"{API}/jobs/{job}/predict", json={"problem": lost, "runs": 20}).json()["id"]
    assert wait_for_end(engine.service, follow_up).state == "failed"


def test_a_draw_whose_one_test_fails_keeps_the_others(examined: tuple[App, str, str], engine: Engine) -> None:
    app, job, _ = examined
    middle = np.linalg.lstsq(np.stack([np.ones_like(X), X], axis=1), Y, rcond=None)[0][0]
    other = two_tests(f"ln(a - {middle - 1e-3})")
    follow_up = app.post(f"{API}/jobs/{job}/predict", json={"problem": other, "runs": 60}).json()["id"]
    assert wait_for_end(engine.service, follow_up).state == "finished"
    (found,) = app.get(f"{API}/jobs/{follow_up}/uncertainty").json()["predictions"]
    assert [one["series"] for one in found["series"]] == ["sound.y", "fragile.y"]
    assert any(f"left out are {found['failed']} runs of fragile." in remark for remark in found["remarks"])
    question = parse_problem(app.get(f"{API}/jobs/{follow_up}/problem").json())
    history = [record.evaluation for record in calibrate(question).history]
    assert findings_of(question, 0, history).predictions[0].to_json() == found  # as in one process
    page = app.get(f"{API}/jobs/{follow_up}/evaluations", params={"state": "failed", "responses": True}).json()
    assert {name for one in page["items"] for name in one["responses"]} == {"sound.y"}


def test_mistakes_of_a_prediction_have_their_path(examined: tuple[App, str, str]) -> None:
    app, job, _ = examined
    other = LATER | {"forward_model": {"kind": "formula", "series": {"y": "a + c * x"}}}
    refused = app.post(f"{API}/jobs/{job}/predict", json={"problem": other})
    assert refused.status_code == 422
    assert "parameters.c" in refused.text
    assert app.post(f"{API}/jobs/{job}/predict").status_code == 422


def test_a_design_puts_the_candidate_that_tells_most_first(examined: tuple[App, str, str], engine: Engine) -> None:
    app, job, _ = examined
    text = """
    candidates:
      - {name: inside, observations: [{series: y, points: {x: [1.5]}}]}
      - {name: outside, observations: [{series: y, points: {x: [9.0]}}]}
    """
    submitted = app.post(f"{API}/jobs/{job}/design", json={"candidates": text, "predict": LATER, "draws": 2})
    assert submitted.status_code == 201, submitted.text
    follow_up = submitted.json()["id"]
    assert wait_for_end(engine.service, follow_up).state == "finished"
    (found,) = app.get(f"{API}/jobs/{job}/uncertainty").json()["designs"]
    assert [one["name"] for one in found["candidates"]] == ["outside", "inside"]
    assert found["predicted"] == "later"
    rows = np.stack([np.ones_like(X), X], axis=1)
    before, after = np.linalg.inv(rows.T @ rows), np.linalg.inv(rows.T @ rows + np.outer([1.0, 9.0], [1.0, 9.0]))
    expected = 1.0 - np.sqrt(np.diag(after) / np.diag(before))
    np.testing.assert_allclose(list(found["candidates"][0]["parameters"].values()), expected, atol=2e-3)
    assert "design" in app.get(f"{API}/jobs/{follow_up}/figures").json()["items"]
    wrong = {"candidates": [{"name": "x", "observations": [{"series": "z", "points": {"x": [1]}}]}]}
    refused = app.post(f"{API}/jobs/{job}/design", json={"candidates": wrong})
    assert refused.status_code == 422
    assert "candidates[0].observations[0].series" in refused.text


def test_a_job_shows_intervals_and_verdicts_as_soon_as_it_has_ended(engine: Engine) -> None:
    app = App(engine.service)
    readings = [{"series": "y", "points": {"x": X.tolist(), "y": Y.tolist()}}]
    problem = line_problem(observations=readings, answer={"max_evaluations": 40}, noise={"kind": "white"})
    job = app.post(f"{API}/jobs", json=problem).json()
    assert job["intervals"] is job["verdicts"] is job["search_best"] is job["at_bounds"] is None
    assert wait_for_end(engine.service, job["id"]).state == "finished"
    shown = app.get(f"{API}/jobs/{job['id']}").json()
    statistics = app.get(f"{API}/jobs/{job['id']}/statistics").json()
    assert shown["verdicts"] == {one["parameter"]: one["kind"] for one in statistics["verdicts"]}
    assert shown["verdict_words"] == {one["parameter"]: one["words"] for one in statistics["verdicts"]}
    rows = statistics["linearisation"]["parameters"]
    assert shown["intervals"] == {name: row["interval"] for name, row in rows.items()}
    assert shown["parameters"] == {name: row["value"] for name, row in rows.items()}
    (listed,) = [one for one in app.get(f"{API}/jobs").json()["items"] if one["id"] == job["id"]]
    assert (listed["intervals"], listed["verdicts"]) == (shown["intervals"], shown["verdicts"])
    assert job["search_evaluations"] is job["answer_evaluations"] is None
    assert shown["answer_evaluations"] == 60 - shown["search_evaluations"] > 8
    searched = app.get(f"{API}/jobs/{job['id']}/evaluations?limit={shown['search_evaluations']}").json()["items"]
    best = min(searched, key=lambda one: one["objective"])
    assert shown["search_best"] == {"objective": best["objective"], "parameters": best["parameters"]}
    # by the normal equations and Student's t
    errors = textbook()
    design = np.stack([np.ones_like(X), X], axis=1)
    estimates = np.linalg.lstsq(design, Y, rcond=None)[0]
    half = stats.t.ppf(0.975, X.size - 2) * errors
    for name, estimate, width in zip("ab", estimates, half, strict=True):
        assert shown["intervals"][name] == pytest.approx([estimate - width, estimate + width], abs=0.05 * width)


def test_a_job_that_goes_on_shows_no_intervals_until_it_ends_again(engine: Engine) -> None:
    app = App(engine.service)
    readings = [{"series": "y", "points": {"x": X.tolist(), "y": Y.tolist()}}]
    job = app.post(f"{API}/jobs", json=line_problem(observations=readings, answer={"max_evaluations": 40})).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    first = app.get(f"{API}/jobs/{job}").json()
    assert app("PATCH", f"{API}/jobs/{job}", json={"stopping": {"max_evaluations": 90}}).status_code == 200
    assert wait_for_end(engine.service, job).state == "finished"
    again = app.get(f"{API}/jobs/{job}").json()
    assert again["evaluations"] > first["evaluations"]
    for name, interval in first["intervals"].items():
        assert again["intervals"][name] == pytest.approx(interval, rel=1e-3)
    # a search alone has none
    alone = app.post(f"{API}/jobs", json=line_problem(observations=readings)).json()["id"]
    assert wait_for_end(engine.service, alone).state == "finished"
    assert app.get(f"{API}/jobs/{alone}").json()["intervals"] is None
