"""Extreme numbers, in jobs and in what is asked about them, are answered in words: never by 500."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import pytest

from geoswarm.workers.hosts.engine import Engine, open_engine
from geoswarm.workers.settings import Settings
from tests.api.conftest import API, App, line_problem, wait_for_end
from tests.variants import variants

X = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def job(scale: float, **changes: Any) -> dict[str, Any]:
    """A line whose y and parameters are of a scale."""
    y = [scale * (1.0 + 2.0 * x + 0.1 * (-1) ** int(x)) for x in X]
    return line_problem(
        parameters={"a": {"lower": 0.0, "upper": 3.0 * scale}, "b": {"lower": 0.0, "upper": 4.0 * scale}},
        observations=[{"series": "y", "points": {"x": X, "y": y}, **changes}],
        method={"kind": "monte_carlo", "samples": 60},
        stopping={},
    )


JOBS = {
    "ordinary": job(1.0),
    "large": job(1e150),
    "larger": job(1e160),
    "small": job(1e-200),
    "smaller": job(1e-310),
    "wide": line_problem(
        parameters={"a": {"lower": -1e300, "upper": 5e299}, "b": {"lower": 1e-300, "upper": 1e300, "scale": "log"}},
        method={"kind": "monte_carlo", "samples": 60},
        stopping={},
    ),
    "apart": line_problem(
        forward_model={"kind": "formula", "series": {"y": "a * 1e100 + b"}},
        parameters={"a": {"lower": 0.0, "upper": 3.0}, "b": {"lower": 0.0, "upper": 3.0}},
        stopping={"max_evaluations": 80},
    ),
}
REFUSED = {
    "observations[0].error": (job(1.0, error=1e-200), job(1.0, error=1e200)),
    "observations[0].weight": (job(1.0, weight=1e300), job(1.0, weight=1e-300)),
}
"""Jobs by the field that is beyond what can be squared."""
NUMBERS = (5e-324, 1e-300, 1e-150, 1.0, 1e150, 1e300, 1.7e308)
PAGES = ("/figures", "/fit", "/points", "/report.html")
GETS = ("", "/evaluations", "/statistics", "/uncertainty", "/posterior", "/surface", *PAGES)


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    folder = tmp_path_factory.mktemp("extreme")
    with open_engine(Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=1)) as running:
        yield running


@pytest.fixture(scope="module")
def app(engine: Engine) -> App:
    return App(engine.service)


@pytest.fixture(scope="module", params=variants(JOBS, {"larger", "smaller", "wide"}))
def path(request: pytest.FixtureRequest, app: App, engine: Engine) -> str:
    answer = app.post(f"{API}/jobs", json=JOBS[request.param])
    assert answer.status_code == 201, answer.text
    found = answer.json()["id"]
    wait_for_end(engine.service, found, 300.0)
    return f"{API}/jobs/{found}"


@pytest.mark.parametrize("what", GETS)
def test_what_is_asked_without_numbers(app: App, path: str, what: str) -> None:
    answer = app.get(f"{path}{what}")
    assert answer.status_code in (200, 404, 409, 422), answer.text


@pytest.mark.parametrize(
    ("what", "name"),
    [
        *itertools.product(("/statistics", "/uncertainty"), ("noise", "threshold")),
        ("/posterior", "threshold"),
        ("/surface", "noise"),
        pytest.param("/posterior", "noise", marks=pytest.mark.slow),  # a sample for each number
    ],
)
def test_numbers_in_queries(app: App, path: str, what: str, name: str) -> None:
    for number in NUMBERS:
        answer = app.get(f"{path}{what}", params={name: number})
        assert answer.status_code in (200, 404, 409, 422), (number, answer.text)


@pytest.mark.parametrize("name", ["weights", "noise", "point_weights", "weighting"])
def test_numbers_of_other_weights(app: App, path: str, name: str) -> None:
    for number in NUMBERS:
        given: dict[str, Any] = {
            "weights": {"weights": {"y": number}},
            "noise": {"weighting": "by_error", "noise": number},
            "point_weights": {"point_weights": {"y": [number] * 6}},
            "weighting": {"weighting": "by_spread"},
        }[name]
        answer = app.post(f"{path}/reweight", json=given)
        assert answer.status_code in (200, 404, 409, 422), (number, answer.text)


@pytest.mark.parametrize("field", REFUSED)
@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("route", ["/jobs", "/problems/check"])
def test_weights_and_errors_beyond_what_can_be_squared_are_refused(
    app: App, field: str, number: int, route: str
) -> None:
    answer = app.post(f"{API}{route}", json=REFUSED[field][number])
    assert answer.status_code == 422, answer.text
    (issue,) = answer.json()["issues"]
    assert issue["path"] == field
    assert "1e-150 to 1e+150" in issue["message"]
    assert "accepted" in issue["message"]


def test_an_error_is_judged_by_the_readings(app: App) -> None:
    answer = app.post(f"{API}/problems/check", json=job(1e100, error=1e-100))
    assert answer.status_code == 422, answer.text
    assert "1e-150 times the largest reading" in answer.text
    points = {"x": X, "y": X, "weight": [1.0, 1.0, 0.0, 1e-200, 1.0, 1.0]}
    answer = app.post(f"{API}/problems/check", json=line_problem(observations=[{"series": "y", "points": points}]))
    assert answer.status_code == 422, answer.text
    assert "weights of points" in answer.text
