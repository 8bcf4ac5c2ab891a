"""The forward model of a problem behind the UM-Bridge protocol 1.0: a small HTTP server of Python's own library."""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, ClassVar

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.external.umbridge.client import PROTOCOL
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.given import values_from
from geoswarm.solver.units import convert

__all__ = ["MODEL", "Bridge", "RequestError", "make_server"]

MODEL = "forward"
"""Name of the model."""

_LARGEST = 2**20  # bytes of a request
_SLOW_SECONDS = 60.0  # an idle connection is closed


class RequestError(Exception):
    """A request cannot be answered: HTTP status, type of the error, and why."""

    def __init__(self, status: int, kind: str, message: str) -> None:
        self.status, self.kind = status, kind
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class Output:
    """An output vector: its series, number of points, and the units in which it is given."""

    series: str
    points: int
    x_unit: str
    y_unit: str
    base: str


class Bridge:
    """Answers to the requests of the protocol.

    One input vector: the free parameters in the order of the problem. One output vector a series: its calculated values
    at the observed points, in the unit of the observation.

    Parameters
    ----------
    problem
        The problem.
    at_once
        How many evaluations run at the same time.
    """

    def __init__(self, problem: Problem, at_once: int = 1) -> None:
        self.problem = problem
        self._calibration = Calibration(problem, problem.seed or 0)
        self._room = threading.Semaphore(at_once)
        known = {info.name: info for info in problem.model.series}
        self.outputs = tuple(
            Output(
                one.series,
                len(one.x),
                one.x_unit or known[one.series].x_unit,
                one.y_unit or known[one.series].y_unit,
                known[one.series].y_unit,
            )
            for one in problem.observations
        )

    def answer(self, route: str, body: Mapping[str, Any] | None) -> dict[str, Any]:
        """Return the answer to a request; ``body`` None: a GET.

        Raises
        ------
        RequestError
        """
        if route == "/Info":
            return {"protocolVersion": PROTOCOL, "models": [MODEL]}
        routes = {
            "/ModelInfo": self._model_info,
            "/InputSizes": lambda _: {"inputSizes": [len(self.problem.free_names)]},
            "/OutputSizes": lambda _: {"outputSizes": [one.points for one in self.outputs]},
            "/Evaluate": self._evaluate,
        }
        if route in ("/Gradient", "/ApplyJacobian", "/ApplyHessian"):
            raise RequestError(400, "UnsupportedFeature", f"{route[1:]} is not supported; Evaluate is")
        if route not in routes:
            raise RequestError(404, "InvalidInput", f"there is no {route[:60]}; there are /Info, {', '.join(routes)}")
        if body is None:
            raise RequestError(405, "InvalidInput", f"{route} is asked by POST, with a JSON object")
        if body.get("name") != MODEL:
            raise RequestError(400, "ModelNotFound", f"no model '{str(body.get('name'))[:60]}'; there is {MODEL}")
        if body.get("config"):
            raise RequestError(400, "InvalidInput", "config must be empty: the problem file says everything")
        return routes[route](body)

    def _model_info(self, _: Mapping[str, Any]) -> dict[str, Any]:
        without = dict.fromkeys(("Gradient", "ApplyJacobian", "ApplyHessian"), False)
        return {"support": {"Evaluate": True, **without}}

    def _evaluate(self, body: Mapping[str, Any]) -> dict[str, Any]:
        names = self.problem.free_names
        given = body.get("input")
        accepted = f"input must be [[{', '.join(names)}]], {len(names)} finite numbers"
        if not isinstance(given, list) or len(given) != 1 or not isinstance(given[0], list):
            raise RequestError(400, "InvalidInput", f"{accepted}; got {str(given)[:100]}")
        values = given[0]
        numbers = all(isinstance(one, int | float) and not isinstance(one, bool) for one in values)
        if len(values) != len(names) or not numbers or not all(abs(one) < 1e308 for one in values):
            raise RequestError(400, "InvalidInput", f"{accepted}; got {str(given)[:100]}")
        parameters = values_from(self.problem, dict(zip(names, map(float, values), strict=True)))
        with self._room:
            evaluation = self._calibration.evaluate_values(parameters)
        if evaluation.reason is not None:
            raise RequestError(500, evaluation.reason, evaluation.message or "the calculation failed")
        return {
            "output": [
                (
                    evaluation.responses[one.series]
                    if one.y_unit == one.base
                    else convert(evaluation.responses[one.series], one.base, one.y_unit)
                ).tolist()
                for one in self.outputs
            ]
        }


def make_server(bridge: Bridge, host: str, port: int) -> ThreadingHTTPServer:
    """Bind a server; port 0 takes a free one.

    Raises
    ------
    OSError
        The address cannot be taken.
    """

    class Handler(_Handler):
        answers = bridge

    server = ThreadingHTTPServer((host, port), Handler)
    server.daemon_threads = True
    return server


class _Handler(BaseHTTPRequestHandler):
    """Requests as JSON."""

    answers: ClassVar[Bridge]
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "geoswarm", ""
    timeout = _SLOW_SECONDS

    def do_GET(self) -> None:
        """Answer ``/Info``."""
        self._reply(None)

    def do_POST(self) -> None:
        """Answer the others."""
        try:
            length = int(self.headers.get("Content-Length", ""))
        except ValueError:
            length = -1
        if not 0 <= length <= _LARGEST:
            self.close_connection = True
            self._send(413, _error("InvalidInput", f"a request has a Content-Length of at most {_LARGEST} bytes"))
            return
        try:
            body = json.loads(self.rfile.read(length))
        except (ValueError, RecursionError):
            body = None
        if not isinstance(body, dict):
            self._send(400, _error("InvalidInput", 'a request is a JSON object, such as {"name": "forward"}'))
            return
        self._reply(body)

    def _reply(self, body: dict[str, Any] | None) -> None:
        try:
            status, found = 200, self.answers.answer(self.path.partition("?")[0], body)
        except RequestError as error:
            status, found = error.status, _error(error.kind, str(error))
        self._send(status, found)

    def _send(self, status: int, found: dict[str, Any]) -> None:
        text = json.dumps(found).encode()
        try:
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(text)))
            self.end_headers()
            self.wfile.write(text)
        except OSError:  # the client has gone
            self.close_connection = True

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing of each request."""


def _error(kind: str, message: str) -> dict[str, Any]:
    return {"error": {"type": kind, "message": message}}
