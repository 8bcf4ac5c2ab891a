"""``geoswarm umbridge`` for the package umbridge and for our own client, and a server of the package for ours."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from geoswarm.cli import main
from geoswarm.cli.model.umbridge_server import Bridge, make_server
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.problem import load_problem, parse_problem
from tests.installation import packages_in
from tests.integration.engines import PATIENCE, must_end
from tests.servers import free_port
from tests.solver.external.test_failures import sleepers

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "umbridge.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(python|yaml|sh)\n(.*?)```", PAGE, re.DOTALL)

SERVED: dict[str, Any] = {
    "name": "served",
    "forward_model": {
        "kind": "formula",
        "series": {
            "travel": {"expression": "a * x + shift", "x_unit": "day", "y_unit": "m"},
            "root": {"expression": "sqrt(b) * x", "x_unit": "1", "y_unit": "1"},
        },
    },
    "parameters": {
        "b": {"lower": -1, "upper": 4},
        "a": {"lower": 0, "upper": 4},
        "shift": {"expression": "2 * fixed * a"},
        "fixed": {"value": 0.5},
    },
    "observations": [
        {"series": "root", "points": {"x": [1, 4], "y": [1, 2]}},
        {"series": "travel", "points": {"x": [24, 48, 96], "y": [1, 2, 3]}, "x_unit": "h", "y_unit": "mm"},
    ],
    "stopping": {"max_evaluations": 10},
}


@contextmanager
def served(document: dict[str, Any] = SERVED) -> Iterator[str]:
    server = make_server(Bridge(parse_problem(document)), "127.0.0.1", 0)
    with server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()
            thread.join()


def asked(url: str, route: str, **body: Any) -> tuple[int, Any]:
    answer = httpx.post(f"{url}{route}", json={"name": "forward", **body}, trust_env=False, timeout=PATIENCE)
    return answer.status_code, answer.json()


def test_the_routes_of_the_protocol() -> None:
    with served() as url:
        assert httpx.get(f"{url}/Info", trust_env=False, timeout=PATIENCE).json() == {
            "protocolVersion": 1.0,
            "models": ["forward"],
        }
        assert asked(url, "/ModelInfo")[1]["support"] == {
            "Evaluate": True,
            "Gradient": False,
            "ApplyJacobian": False,
            "ApplyHessian": False,
        }
        assert asked(url, "/InputSizes", config={}) == (200, {"inputSizes": [2]})
        assert asked(url, "/OutputSizes") == (200, {"outputSizes": [2, 3]})
        status, found = asked(url, "/Evaluate", input=[[4.0, 1.5]])
    assert status == 200
    assert found["output"][0] == [2.0, 8.0]
    assert found["output"][1] == pytest.approx([3000.0, 4500.0, 7500.0], rel=1e-14)  # mm, at 1, 2 and 4 days


@pytest.mark.parametrize(
    ("route", "body", "status", "kind", "message"),
    [
        ("/Evaluate", {"input": [[1.0]]}, 400, "InvalidInput", "input must be [[b, a]], 2 finite numbers"),
        ("/Evaluate", {"input": [1.0, 2.0]}, 400, "InvalidInput", "got [1.0, 2.0]"),
        ("/Evaluate", {"input": [[1.0, "2"]]}, 400, "InvalidInput", "2 finite numbers"),
        ("/Evaluate", {"input": [[1.0, 10**400]]}, 400, "InvalidInput", "2 finite numbers"),
        ("/Evaluate", {}, 400, "InvalidInput", "got None"),
        ("/Evaluate", {"input": [[1, 2]], "config": {"a": 1}}, 400, "InvalidInput", "config must be empty"),
        ("/Evaluate", {"input": [[-1.0, 2.0]]}, 500, "not_finite", "series 'root' is nan"),
        ("/InputSizes", {"name": "other"}, 400, "ModelNotFound", "no model 'other'; there is forward"),
        ("/Gradient", {}, 400, "UnsupportedFeature", "Gradient is not supported"),
        ("/Nothing", {}, 404, "InvalidInput", "there is no /Nothing"),
    ],
)
def test_refusals_say_why(route: str, body: dict[str, Any], status: int, kind: str, message: str) -> None:
    with served() as url:
        got, found = asked(url, route, **body)
    assert (got, found["error"]["type"]) == (status, kind)
    assert message in found["error"]["message"]


def test_requests_that_are_none() -> None:
    with served() as url:
        assert httpx.get(f"{url}/Evaluate", trust_env=False, timeout=PATIENCE).status_code == 405
        assert httpx.post(f"{url}/Evaluate", content=b"{", trust_env=False).status_code == 400
        assert httpx.post(f"{url}/Evaluate", content=b"[1]", trust_env=False, timeout=PATIENCE).status_code == 400
        assert (
            httpx.post(f"{url}/Evaluate", content=b" " * (2**20 + 1), trust_env=False, timeout=PATIENCE).status_code
            == 413
        )
        assert asked(url, "/InputSizes")[0] == 200


def raw(url: str, request: str) -> bytes:
    """All that a server sends on one connection."""
    host, _, port = url.removeprefix("http://").rpartition(":")
    with socket.create_connection((host.strip("[]"), int(port)), timeout=PATIENCE) as connection:
        connection.sendall(request.encode())
        connection.shutdown(socket.SHUT_WR)
        return b"".join(iter(lambda: connection.recv(65536), b""))


def test_what_stands_in_a_request_is_never_taken_for_another() -> None:
    inner = "POST /InputSizes HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\n\r\n{}"
    with served() as url:
        found = raw(url, f"GET /Info HTTP/1.1\r\nHost: a\r\nContent-Length: {len(inner)}\r\n\r\n{inner}")
        chunked = raw(
            url, f"POST /Info HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{{}}\r\n0\r\n\r\n{inner}"
        )
        negative = raw(url, "POST /Info HTTP/1.1\r\nHost: a\r\nContent-Length: -1\r\n\r\n")
    assert found.count(b"HTTP/1.1 ") == chunked.count(b"HTTP/1.1 ") == negative.count(b"HTTP/1.1 ") == 1
    assert b"protocolVersion" in found
    assert b"HTTP/1.1 411 " in chunked
    assert b"HTTP/1.1 411 " in negative
    assert b"must have a Content-Length of at most 1048576 bytes" in negative


def test_web_pages_are_not_answered() -> None:
    """The browser sends what any page asks for, as plain text also to other sites."""
    body, headers = json.dumps({"name": "forward", "input": [[1, 2]]}), {"Origin": "http://elsewhere.example"}
    with served() as url:
        answer = httpx.post(f"{url}/Evaluate", content=body, headers=headers, trust_env=False, timeout=PATIENCE)
    assert (answer.status_code, answer.json()["error"]["message"]) == (403, "web pages are not answered")


def test_a_fault_of_the_server_is_reported(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def broken(*_: Any) -> None:
        raise RuntimeError("out of order")

    with served() as url:
        monkeypatch.setattr(Calibration, "evaluate", broken)
        status, found = asked(url, "/Evaluate", input=[[1.0, 2.0]])
    assert (status, found) == (500, {"error": {"type": "InternalError", "message": "RuntimeError: out of order"}})
    assert "out of order" in capsys.readouterr().err


def has_version_6() -> bool:
    try:
        with socket.socket(socket.AF_INET6) as own:
            own.bind(("::1", 0))
    except OSError:
        return False
    return True


def test_addresses_of_version_6_are_served() -> None:
    bridge = Bridge(parse_problem(SERVED))
    if not has_version_6():  # as in many containers
        with pytest.raises(OSError, match=r"Cannot assign requested address|Address family not supported"):
            make_server(bridge, "::1", 0)
        return
    with make_server(bridge, "::1", 0) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            url = f"http://[::1]:{server.server_address[1]}"
            assert httpx.get(f"{url}/Info", trust_env=False, timeout=PATIENCE).status_code == 200
        finally:
            server.shutdown()
            thread.join()


GLOBAL = """\
import time
kept = None

def curve(x, a):
    global kept
    kept = a
    time.sleep(0.1)  # so that others come meanwhile
    return kept * x
"""


def of_a_function(folder: Path, source: str, **changes: Any) -> Path:
    """A problem file with a function of one parameter."""
    (folder / "model.py").write_text(source)
    document = {
        "forward_model": {"kind": "python", "file": "model.py", "function": "curve", "series": {"y": {}}},
        "parameters": {"a": {"lower": 0, "upper": 100}},
        "observations": [{"series": "y", "points": {"x": [1, 2], "y": [1, 2]}}],
        "stopping": {"max_evaluations": 10},
    }
    path = folder / "problem.json"
    path.write_text(json.dumps(document | changes))
    return path


def test_functions_at_the_same_time_do_not_meet(tmp_path: Path) -> None:
    path = of_a_function(tmp_path, GLOBAL)
    with command(path, "--port", "0", "--workers", "3") as (url, _), ThreadPoolExecutor(6) as clients:
        found = list(clients.map(lambda a: asked(url, "/Evaluate", input=[[a]]), range(12)))
    assert found == [(200, {"output": [[float(a), 2.0 * a]]}) for a in range(12)]


def test_limits_of_the_problem_hold(tmp_path: Path) -> None:
    source = "import time\ndef curve(x, a):\n    time.sleep(600 if a > 1 else 0)\n    return a * x\n"
    path = of_a_function(tmp_path, source, limits={"seconds_per_evaluation": 4})
    with command(path, "--port", "0") as (url, _):
        status, found = asked(url, "/Evaluate", input=[[2.0]])
        assert (status, found["error"]["type"]) == (500, "timeout")
        assert "limits.seconds_per_evaluation" in found["error"]["message"]
        assert asked(url, "/Evaluate", input=[[0.5]]) == (200, {"output": [[0.5, 1.0]]})


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_its_end_is_that_of_the_programs(how: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    program = {"kind": "command", "run": ["sleep", "600"], "write": {"p.json": "json"}}
    program["series"] = {"y": {"file": "out.csv", "x": 1, "y": 2}}
    path = of_a_function(tmp_path, "", forward_model=program)
    with ThreadPoolExecutor(1) as client, command(path, "--port", "0", ending=how) as (url, said):
        answer = client.submit(asked, url, "/Evaluate", input=[[2.0]])
        waited(lambda: sleepers(tmp_path), None)
    waited(lambda: not sleepers(tmp_path), None)
    assert isinstance(answer.exception(), httpx.TransportError) or answer.result()[0] == 503
    assert "Traceback" not in said()


def test_our_own_client_finds_the_same_through_our_own_server() -> None:
    series = {
        "root": {"output": 0, "x": [1, 4]},
        "travel": {"output": 1, "x": [24, 48, 96], "x_unit": "h", "y_unit": "mm"},
    }
    parameters = {name: SERVED["parameters"][name] for name in ("b", "a")}
    values = {"b": 2.0, "a": 0.125}
    with served() as url:
        section = {"kind": "umbridge", "url": url, "inputs": ["b", "a"], "series": series}
        document = {**SERVED, "forward_model": section, "parameters": parameters}
        through = Calibration(parse_problem(document, programs=True), 1)
        found = through.evaluate_values(values)
        failed = through.evaluate_values({"b": -1.0, "a": 1.0})
    straight = Calibration(parse_problem(SERVED), 1).evaluate_values({**values, "shift": 0.125, "fixed": 0.5})
    assert found.objective == pytest.approx(straight.objective, rel=1e-12)
    assert failed.reason == "not_finite"


def test_the_command_says_what_it_serves_and_ends_when_told(tmp_path: Path) -> None:
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(SERVED))
    with command(path, "--port", "0") as (url, said):
        assert asked(url, "/OutputSizes") == (200, {"outputSizes": [2, 3]})
        assert "b, a" in said()
        assert re.search(r"output 1 +3 +travel +mm", said())


def test_a_port_in_use_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(SERVED))
    with served() as url:
        port = url.rpartition(":")[2]
        assert main(["umbridge", str(path), "--port", port]) == 2
    assert f"127.0.0.1:{port} cannot be used" in capsys.readouterr().err


@contextmanager
def command(*arguments: str | Path, ending: signal.Signals = signal.SIGTERM) -> Iterator[tuple[str, Any]]:
    """The command in a process of its own, its address, and what it has said; ended by a signal."""
    words = [sys.executable, "-P", "-m", "geoswarm", "umbridge", *map(str, arguments)]
    output = Path(arguments[0]).with_suffix(".log")
    with output.open("wb") as file:
        process = subprocess.Popen(words, cwd=ROOT, env=environment(ROOT), stdout=file, stderr=subprocess.STDOUT)
    try:
        url = waited(lambda: re.search(r"serves UM-Bridge at (http://\S+?);", output.read_text()), process)[1]
        yield url, output.read_text
    finally:
        process.send_signal(ending)
        must_end(process)


def environment(*folders: Path) -> dict[str, str]:
    path = ":".join(map(str, folders))
    kept = {name: os.environ[name] for name in ("HOME", "TMPDIR") if name in os.environ}
    return {"PYTHONPATH": path, "PATH": "/usr/bin:/bin", "NO_PROXY": "*"} | kept


def waited(look: Any, process: subprocess.Popen[bytes] | None) -> Any:
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        assert process is None or process.poll() is None
        if found := look():
            return found
        time.sleep(0.05)
    raise AssertionError(f"nothing in {PATIENCE} s")


@pytest.fixture(scope="module")
def umbridge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package umbridge with all that it wants, apart."""
    return packages_in(tmp_path_factory.mktemp("umbridge"), "umbridge==1.2.10")


def block(kind: str, number: int) -> str:
    return [text for found, text in BLOCKS if found == kind][number]


def test_the_page_has_its_blocks() -> None:
    assert [kind for kind, _ in BLOCKS] == ["python", "yaml", "sh", "sh", "python"]


@pytest.mark.slow
def test_the_example_of_the_page_runs_both_ways_with_the_package(
    umbridge: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port = free_port()
    (tmp_path / "server.py").write_text(block("python", 0))
    problem = tmp_path / "problem.yaml"
    problem.write_text(block("yaml", 0).replace("4242", str(port)))
    theirs = subprocess.Popen(
        [sys.executable, "server.py", str(port)],
        cwd=tmp_path,
        env=environment(umbridge),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        waited(lambda: reached(port), theirs)
        assert main(["check", str(problem)]) == 0
        assert "test run          finished" in capsys.readouterr().out
        assert main(["run", str(problem), "--json"]) == 0
        result = json.loads(capsys.readouterr().out)
        assert result["state"] == "finished"
        assert result["parameters"]["final"] == pytest.approx(25.0, rel=0.05)

        with command(problem, "--port", "0") as (url, _):
            script = block("python", 1).replace("http://localhost:4243", url)
            script += "print(model.get_input_sizes(), model.get_output_sizes(), umbridge.supported_models(model.url))\n"
            script += "try:\n    model([[1.0]])\nexcept Exception as error:\n    print(error)\n"
            done = subprocess.run(
                [sys.executable, "-c", script],
                env=environment(umbridge),
                capture_output=True,
                text=True,
                check=False,
                timeout=PATIENCE,
            )
            assert done.returncode == 0, done.stderr
            values, sizes, error = done.stdout.splitlines()
            expected = [20.0 * t / (10.0 + t) for t in (1.0, 5.0, 20.0, 100.0)]
            assert json.loads(values)[0] == pytest.approx(expected, rel=1e-12)
            assert sizes == "[2] [4] ['forward']"
            assert error.startswith("Model returned error of type InvalidInput: input must be [[final, half]]")
    finally:
        theirs.terminate()
        must_end(theirs)
    loaded = load_problem(problem)
    assert Calibration(loaded, 1).evaluate_values({"final": 20.0, "half": 10.0}).reason == "not_started"


def reached(port: int) -> bool:
    try:
        return httpx.get(f"http://localhost:{port}/Info", trust_env=False, timeout=PATIENCE).status_code == 200
    except httpx.TransportError:
        return False
