"""Models behind UM-Bridge: requests, units, every failure with its reason, and who may have them."""

from __future__ import annotations

import http.client
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ForwardError, ProblemError
from geoswarm.solver.forward.base import ForwardRun
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.problem import parse_problem
from tests.servers import free_port
from tests.solver.forward.programs.umbridge_servers import CUT_OFF, HANG, HANG_UP, Scripted, scripted

POINTS = {"travel": np.array([1.0, 1.5, 3.0])}


def section(url: str = "http://127.0.0.1:4242", **changes: Any) -> dict[str, Any]:
    return {
        "kind": "umbridge",
        "url": url,
        "inputs": [["E"], ["nu"]],
        "pause": 0.01,
        "series": {"travel": {"output": 1, "x": [1, 2, 3], "x_unit": "day", "y_unit": "mm"}},
    } | changes


def run_of(server: Scripted, **changes: Any) -> ForwardRun:
    return parse_spec(section(server.url, **changes)).build().prepare(POINTS)


def problem(url: str = "http://127.0.0.1:4242", **changes: Any) -> dict[str, Any]:
    return {
        "forward_model": section(url, **changes),
        "parameters": {"E": {"lower": 1, "upper": 10}, "nu": {"value": 0.3}},
        "observations": [{"series": "travel", "points": {"x": [1.0, 1.5], "y": [1.0, 1.6]}, "y_unit": "m"}],
        "stopping": {"max_evaluations": 10},
    }


def test_vectors_go_in_order_and_come_back_in_base_units() -> None:
    with scripted() as server:
        run = run_of(server, config={"level": 2})
        assert server.asked == []
        found = run({"nu": 0.25, "E": 2e4})
        np.testing.assert_allclose(found["travel"], [1.0, 1.5, 4.0], rtol=1e-15)
        run({"nu": 0.5, "E": 1.0})
    about = {"name": "forward", "config": {"level": 2}}
    assert server.asked == [
        ("/Info", None),
        ("/ModelInfo", {"name": "forward"}),
        ("/InputSizes", about),
        ("/OutputSizes", about),
        ("/Evaluate", {**about, "input": [[2e4], [0.25]]}),
        ("/Evaluate", {**about, "input": [[1.0], [0.5]]}),
    ]


def test_the_model_tells_parameters_series_and_its_points() -> None:
    model = parse_spec(section(inputs=["E", "nu"])).build()
    assert [info.name for info in model.parameters] == ["E", "nu"]
    assert not model.open_parameters
    assert [(info.name, info.x_unit, info.y_unit) for info in model.series] == [("travel", "day", "m")]
    assert model.grid("travel").tolist() == [1.0, 2.0, 3.0]


LARGE = "1" + "0" * 400
FAILURES: list[tuple[dict[str, Any], str, str]] = [
    ({"Evaluate": {"output": [[7, 8], [1.0, 2.0]]}}, "bad_output", "output vectors of 2, 2 numbers, not 2, 3"),
    ({"Evaluate": {"output": [[7, 8]]}}, "bad_output", "output vectors of 2 numbers, not 2, 3"),
    ({"Evaluate": {"output": [[7, 8], [1.0, "2", 3.0]]}}, "bad_output", "output 1 contains what is not a number"),
    ({"Evaluate": {"output": [[7, 8], [1.0, True, 3.0]]}}, "bad_output", "output 1 contains what is not a number"),
    ({"Evaluate": {"result": 1}}, "bad_output", "answered with an output that is not a list of lists"),
    ({"Evaluate": [1, 2]}, "bad_output", "answered with an output that is not a list of lists"),
    ({"Evaluate": "{oops"}, "bad_output", "did not answer with JSON: '{oops'"),
    ({"Evaluate": '{"output": [[7, 8], [1.0, nan, 3.0]]}'}, "not_finite", "output 1 is nan at number 2"),
    ({"Evaluate": '{"output": [[7, 8], [-inf, 1, 3.0]]}'}, "not_finite", "output 1 is -inf at number 1"),
    ({"Evaluate": '{"output": [[7, 8], [1, null, 3.0]]}'}, "not_finite", "output 1 is nan at number 2"),
    ({"Evaluate": f'{{"output": [[7, {LARGE}], [1, 2, 3.0]]}}'}, "not_finite", "output 0 is inf at number 2"),
    ({"Evaluate": (500, "500 Internal\nServer Error")}, "program_failed", "HTTP 500: 500 Internal Server Error"),
    ({"Evaluate": (400, {"error": {"type": "InvalidInput", "message": "no"}})}, "program_failed", "InvalidInput: no"),
    ({"Evaluate": (500, {"error": {"type": "diverged", "message": "step 3"}})}, "diverged", "diverged: step 3"),
    ({"Evaluate": (500, {"error": {"type": "timeout", "message": "60 s"}})}, "timeout", "HTTP 500: timeout: 60 s"),
    ({"Evaluate": (302, "")}, "program_failed", "HTTP 302: no word why"),
    ({"Evaluate": HANG_UP}, "program_failed", "closed the connection"),
    ({"Evaluate": CUT_OFF}, "program_failed", "closed the connection: IncompleteRead: .*5 more expected"),
    ({"Evaluate": HANG}, "timeout", "has not answered in 0.3 s"),
    ({"Info": {"protocolVersion": 0.9, "models": ["forward"]}}, "bad_output", "speaks version 0.9"),
    ({"Info": '{"protocolVersion": NaN, "models": ["forward"]}'}, "bad_output", "is not an UM-Bridge server"),
    ({"Info": {"protocolVersion": 1.0, "models": ["forwards"]}}, "bad_output", "did you mean forwards"),
    ({"Info": "<html>"}, "bad_output", "did not answer with JSON"),
    ({"Info": {"name": "geoswarm"}}, "bad_output", "is not an UM-Bridge server"),
    ({"Info": (404, "Not found")}, "program_failed", "/Info answered with HTTP 404: Not found"),
    ({"ModelInfo": {"support": {"Evaluate": False}}}, "bad_output", "does not support Evaluate"),
    ({"ModelInfo": (200, [])}, "bad_output", "answered no ModelInfo"),
    (
        {"InputSizes": {"inputSizes": [2]}},
        "bad_output",
        r"takes input vectors of \[2\] numbers, but inputs has \[1, 1\]",
    ),
    ({"InputSizes": {"inputSizes": ["1"]}}, "bad_output", "answered without inputSizes"),
    (
        {"OutputSizes": {"outputSizes": [2]}},
        "bad_output",
        "series.travel.output is 1, but the model has outputs 0 to 0",
    ),
    ({"OutputSizes": {"outputSizes": [2, 4]}}, "bad_output", "output 1 has 4 numbers, but series.travel.x has 3"),
]


@pytest.mark.parametrize(("answers", "reason", "message"), FAILURES)
def test_each_failure_has_its_reason(answers: dict[str, Any], reason: str, message: str) -> None:
    with scripted(**answers) as server, pytest.raises(ForwardError, match=message) as caught:
        run_of(server, seconds=0.3 if HANG in answers.values() else 20)({"E": 1.0, "nu": 0.3})
    assert caught.value.reason == reason


def test_a_server_that_is_not_there_is_tried_again() -> None:
    run = parse_spec(section(f"http://127.0.0.1:{free_port()}", pause=0.1)).build().prepare(POINTS)
    began = time.monotonic()
    with pytest.raises(ForwardError, match=r"cannot be reached: .*\(3 tries\); is the server running") as caught:
        run({"E": 1.0, "nu": 0.3})
    assert caught.value.reason == "not_started"
    assert time.monotonic() - began >= 0.2  # two pauses


def test_a_server_that_takes_no_connection_is_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """As behind a firewall that drops packets."""
    tried: list[object] = []

    def dropped(connection: http.client.HTTPConnection) -> None:
        tried.append(connection)
        raise TimeoutError

    monkeypatch.setattr(http.client.HTTPConnection, "connect", dropped)
    run = parse_spec(section(seconds=5.0, tries=3)).build().prepare(POINTS)
    with pytest.raises(ForwardError, match=r"cannot be reached: no answer in 5 s \(3 tries\)") as caught:
        run({"E": 1.0, "nu": 0.3})
    assert caught.value.reason == "not_started"
    assert len(tried) == 3


def test_a_connection_that_the_system_gives_up_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def given_up(_: http.client.HTTPConnection) -> None:
        raise TimeoutError(110, "Connection timed out")

    monkeypatch.setattr(http.client.HTTPConnection, "getresponse", given_up)
    with (
        scripted() as server,
        pytest.raises(ForwardError, match=r"closed the connection: .*the connection has timed out") as caught,
    ):
        run_of(server)({"E": 1.0, "nu": 0.3})
    assert caught.value.reason == "program_failed"


def test_a_busy_server_and_one_that_hangs_up_are_asked_again() -> None:
    good = {"output": [[7, 8], [1.0, 2.0, 3.0]]}
    with scripted(Evaluate=[(503, "busy"), HANG_UP, good]) as server:
        found = run_of(server)({"E": 1.0, "nu": 0.3})
    assert found["travel"].tolist() == [0.001, 0.0015, 0.003]
    with scripted(Evaluate=(503, "busy")) as server, pytest.raises(ForwardError, match="HTTP 503: busy"):
        run_of(server)({"E": 1.0, "nu": 0.3})
    assert [route for route, _ in server.asked].count("/Evaluate") == 3


def test_points_beyond_those_of_the_server_are_refused() -> None:
    with scripted() as server, pytest.raises(ForwardError, match="observed from 0 to 2") as caught:
        parse_spec(section(server.url)).build().prepare({"travel": np.array([0.0, 2.0])})({"E": 1.0, "nu": 0.3})
    assert caught.value.reason == "bad_output"


@pytest.mark.parametrize(
    ("changes", "path", "message"),
    [
        ({"url": "localhost:4242"}, "url", "write for example http://localhost:4242"),
        ({"url": "ftp://localhost"}, "url", "not the address of a server"),
        ({"url": "http://user:word@localhost"}, "url", "no user, password"),
        ({"url": "http://localhost:99999"}, "url", "is not an address: "),
        ({"inputs": [["E"], ["E"]]}, "inputs", "E is given twice"),
        ({"inputs": [[]]}, "inputs", "no parameter is named"),
        ({"inputs": [["a b"]]}, "inputs", "must match"),
        ({"series": {"travel": {"x": [1, 2, 1]}}}, "series.travel.x", "1 is given twice"),
        ({"series": {"travel": {"x": []}}}, "series.travel.x", "must not be empty"),
        ({"series": {"travel": {"x": [1], "y_unit": "quux"}}}, "series.travel.y_unit", "quux"),
        ({"config": {"a": [float("inf")]}}, "config", "finite"),
        ({"tries": 0}, "tries", "1"),
    ],
)
def test_mistakes_are_told_with_their_place(changes: dict[str, Any], path: str, message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        parse_problem(problem(**changes), programs=True)
    assert any(issue.path.startswith(f"forward_model.{path}") for issue in caught.value.issues), str(caught.value)
    assert message in str(caught.value)


def test_no_problem_of_the_network_may_call_a_server() -> None:
    with pytest.raises(ProblemError, match="accepted from problem files and Python only"):
        parse_problem(problem())
    assert parse_problem(problem(), programs=True).forward_model.runs_programs


def test_a_registered_model_may(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_MODELS", str(tmp_path))
    (tmp_path / "bridge").mkdir()
    with scripted() as server:
        declared = {
            "forward_model": section(server.url, inputs=[["E"], ["level"]]),
            "parameters": {"E": {"unit": "kPa", "lower": 1, "upper": 100}},
            "settings": {"level": {"type": "integer", "default": 4}},
        }
        (tmp_path / "bridge" / "model.yaml").write_text(json.dumps(declared))
        document = problem() | {"forward_model": {"kind": "registered", "model": "bridge"}}
        document["parameters"] = {"E": {"lower": 1, "upper": 10}}
        found = parse_problem(document).model.prepare(POINTS)({"E": 5.0})
    assert found["travel"].tolist() == [1.0, 1.5, 4.0]
    assert server.asked[-1] == ("/Evaluate", {"name": "forward", "config": {}, "input": [[5.0], [4.0]]})
