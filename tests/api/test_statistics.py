"""Statistics, reports, figures and other weights of stored evaluations."""

from __future__ import annotations

import csv
import io
from typing import Any

import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, analyse, reweight
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.report.jsonable import jsonable
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.words import typeset
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, line_problem, wait_for_end


def sampled() -> dict[str, Any]:
    """Two lines of which the second needs only one of the parameters; sampled."""
    return line_problem(
        forward_model={"kind": "formula", "series": {"y": "a + b * x", "z": "b * x"}},
        observations=[
            {"series": "y", "points": {"x": [0, 1, 2, 3], "y": [1.0, 3.1, 4.9, 7.0]}},
            {"series": "z", "points": {"x": [1, 2, 3, 4], "y": [3.0, 6.1, 8.9, 12.0]}, "weight": 0.5},
        ],
        method={"kind": "monte_carlo", "samples": 400},
        stopping={},
    )


@pytest.fixture(scope="module")
def done(engine: Engine) -> tuple[App, str]:
    """A finished sampling, and the application that shows it."""
    app = App(engine.service)
    job = app.post(f"{API}/jobs", json=sampled()).json()["id"]
    assert wait_for_end(engine.service, job).state == "finished"
    return app, f"{API}/jobs/{job}"


def test_statistics_equal_those_of_the_run_in_this_process(done: tuple[App, str]) -> None:
    app, path = done
    problem = parse_problem(sampled())
    samples = Samples.from_result(problem, calibrate(problem))
    local = analyse(Calibration(problem, 7), samples, threshold=3.0)
    answer = app.get(f"{path}/statistics", params={"threshold": 3.0})
    assert answer.status_code == 200
    assert answer.json() == jsonable(local.to_json())
    assert answer.json()["threshold"]["origin"] == "given"


def test_threshold_is_proposed_and_a_wrong_one_refused(done: tuple[App, str]) -> None:
    app, path = done
    answer = app.get(f"{path}/statistics").json()
    assert answer["threshold"]["origin"] in ("statistics", "samples")
    assert [v["parameter"] for v in answer["verdicts"]] == ["a", "b"]
    refused = app.get(f"{path}/statistics", params={"threshold": 0})
    assert refused.status_code == 422
    assert refused.json()["issues"][0]["path"] == "query.threshold"


def test_a_verdict_has_its_reason_in_one_line_and_warnings_leave_the_fit_out(done: tuple[App, str]) -> None:
    app, path = done
    answer = app.get(f"{path}/statistics").json()
    for verdict in answer["verdicts"]:
        assert verdict["sentence"].startswith(verdict["parameter"])
        assert verdict["reason"] in verdict["sentence"]
    assert answer["fit"]["words"]
    assert not any(answer["fit"]["sentence"] in warning for warning in answer["warnings"])


def test_report_is_a_page_with_a_policy_of_its_own(done: tuple[App, str]) -> None:
    app, path = done
    answer = app.get(f"{path}/report.html")
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    policy = answer.headers["content-security-policy"]
    assert "script-src" not in policy
    assert policy.startswith("default-src 'none'; style-src 'unsafe-inline'; img-src data:")
    verdict = app.get(f"{path}/statistics").json()["verdicts"][0]["sentence"]
    assert typeset(verdict) in answer.text
    assert "400" in answer.text


def test_a_report_shows_another_set_of_parameters_beside_the_result(done: tuple[App, str]) -> None:
    app, path = done
    other = app.get(f"{path}/report.html", params={"compare": "name: a book\na: 1000\nb: 1"})
    assert other.status_code == 200, other.text
    assert "Compared with a book" in other.text
    assert "Compared with" not in app.get(f"{path}/report.html").text
    missing = app.get(f"{path}/report.html", params={"compare": '{"a": 2, "c": 1}'})
    assert missing.status_code == 422
    assert [issue["path"] for issue in missing.json()["issues"]] == ["query.compare.c", "query.compare"]
    assert app.get(f"{path}/figures/fit.csv", params={"compare": "a: ["}).status_code == 422


def test_pdf_and_figures_in_every_form(done: tuple[App, str]) -> None:
    app, path = done
    pdf = app.get(f"{path}/report.pdf")
    assert (pdf.status_code, pdf.headers["content-type"]) == (200, "application/pdf")
    assert pdf.content.startswith(b"%PDF-")
    names = app.get(f"{path}/figures").json()["items"]
    assert names == ["matrix", "intervals", "fit", "convergence", "traces"]
    for name in names:
        assert b"<svg" in app.get(f"{path}/figures/{name}.svg").content
        assert app.get(f"{path}/figures/{name}.png").content.startswith(b"\x89PNG")
    rows = list(csv.DictReader(io.StringIO(app.get(f"{path}/figures/fit.csv").text)))
    assert [row["series"] for row in rows] == ["y"] * 4 + ["z"] * 4
    assert [float(row["measured"]) for row in rows[:4]] == [1.0, 3.1, 4.9, 7.0]


@pytest.mark.parametrize(("name", "status"), [("pie.svg", 404), ("fit.gif", 422)])
def test_unknown_figures_and_forms(done: tuple[App, str], name: str, status: int) -> None:
    app, path = done
    answer = app.get(f"{path}/figures/{name}")
    assert answer.status_code == status
    if status == 404:
        assert "there are: matrix, intervals, fit, convergence, traces" in answer.json()["detail"]


def test_other_weights_equal_a_fresh_evaluation(done: tuple[App, str]) -> None:
    app, path = done
    answer = app.post(f"{path}/reweight", json={"weights": {"z": 4.0}})
    assert answer.status_code == 200
    found = answer.json()
    changed = parse_problem(found["problem"])
    assert [o.weight for o in changed.observations] == [1.0, 4.0]
    best = found["best"]
    fresh = Calibration(changed, 0).evaluate_values(best["parameters"])
    assert fresh.objective == pytest.approx(best["objective"], rel=1e-12)
    assert sum(w["share"] for w in found["weights"]) == pytest.approx(1.0, rel=1e-12)
    problem = parse_problem(sampled())
    local = reweight(problem, Samples.from_result(problem, calibrate(problem)), weights={"z": 4.0})
    assert best["objective"] == local.samples.objectives[local.best_after]
    assert found["moved"] == (local.best_before != local.best_after)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({"weights": {"q": 1.0}}, "unknown series q"),
        ({"weighting": "by_error"}, "needs the standard deviation"),
        ({"weights": {"y": 1.0}, "weighting": "by_count"}, "not both"),
        ({"weights": {"y": -1.0}}, "weight"),
    ],
)
def test_wrong_weights_are_refused(done: tuple[App, str], body: dict[str, Any], words: str) -> None:
    app, path = done
    answer = app.post(f"{path}/reweight", json=body)
    assert answer.status_code == 422
    assert words in answer.json()["detail"]


def test_a_job_without_evaluations_has_a_report_but_no_statistics(app: App) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    refused = app.get(f"{API}/jobs/{job}/statistics")
    assert (refused.status_code, refused.json()["type"]) == (409, "urn:geoswarm:error:no-evaluations")
    assert app.post(f"{API}/jobs/{job}/reweight", json={"weighting": "by_count"}).status_code == 409
    page = app.get(f"{API}/jobs/{job}/report.html")
    assert page.status_code == 200
    assert "nothing to judge" in page.text
    assert app.get(f"{API}/jobs/{job}/figures").json() == {"items": []}


@pytest.mark.parametrize("path", ["statistics", "report.html", "report.pdf", "figures", "figures/fit.svg"])
def test_unknown_jobs_are_not_found(app: App, path: str) -> None:
    assert app.get(f"{API}/jobs/0123456789abcdef/{path}").status_code == 404


def test_a_report_is_made_once_for_each_state(done: tuple[App, str], engine: Engine) -> None:
    _, path = done
    job = path.rpartition("/")[2]
    statistics = engine.service.statistics
    assert statistics.report(job) is statistics.report(job)
    assert statistics.report(job, threshold=3.0) is not statistics.report(job)
    made: list[int] = []
    for _ in range(2):
        assert statistics.rendered(job, "once", lambda _report: made.append(1) or b"done") == b"done"  # type: ignore[func-returns-value]
    assert made == [1]


def test_a_swarm_is_examined_from_its_stored_evaluations(engine: Engine) -> None:
    service: JobService = engine.service
    problem = parse_problem(line_problem(stopping={"max_evaluations": 600}))
    job, _ = service.submit(problem)
    assert wait_for_end(service, job.id).state == "finished"
    report = service.statistics.report(job.id)
    assert report.statistics is not None
    assert report.statistics.samples.source == "particle_swarm"
    assert report.record.best is not None
    assert report.record.best.parameters["b"] == pytest.approx(2.0, abs=0.05)


def test_a_report_shows_the_parts_that_are_wanted_and_says_so(done: tuple[App, str]) -> None:
    app, path = done[0], f"{done[1]}/report"
    whole = app.get(f"{path}.html").text
    some = app.get(f"{path}.html", params={"part": ["tables", "verdicts"]}).text
    sections = [f'<section id="{name}">' for name in ("verdicts", "figures", "tables", "provenance")]
    assert [section in whole for section in sections] == [True] * 4
    assert [section in some for section in sections] == [True, False, True, False]
    assert "<dd>verdicts, tables</dd>" in some
    assert '<p class="summary">' in some
    pages = [len(app.get(f"{path}.pdf", params={"part": part}).content) for part in (["verdicts"], [])]
    assert 0 < pages[0] < 0.5 * pages[1]
    refused = app.get(f"{path}.html", params={"part": "sales"})
    assert refused.status_code == 422
    assert "'verdicts'" in refused.text
