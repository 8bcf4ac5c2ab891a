"""The forward model of a problem behind the UM-Bridge protocol 1.0: a small HTTP server of Python's own library."""

from __future__ import annotations

import json
import math
import socket
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import WorkerLostError, in_words
from geoswarm.solver.external.umbridge import PROTOCOL
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.running import Limits
from geoswarm.solver.runner.evaluator import EvaluationCancelled
from geoswarm.solver.runs.evaluators import WATCHED
from geoswarm.solver.units import convert

if TYPE_CHECKING:
    from geoswarm.solver.runner.team import Team

__all__ = ["MODEL", "Bridge", "RequestError", "make_server"]

MODEL = "forward"
"""Name of the model."""

_LARGEST = 2**20  # bytes of a request
_SLOW_SECONDS = 60.0  # an idle connection is closed
_END_SECONDS = 5.0  # for a run to be killed
_MOST_WAITING = 128  # connections that are not taken up yet


class RequestError(Exception):
    """A request cannot be answered: HTTP status, type of the error, and why."""

    def __init__(self, status: int, kind: str, message: str) -> None:
        self.status, self.kind = status, kind
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class Output:
    """An output vector: its series, number of points, the unit in which it is given, and that of the calculation."""

    series: str
    points: int
    y_unit: str
    base: str


class Bridge:
    """Answers to the requests of the protocol.

    One input vector: the free parameters in the order of the problem. One output vector a series: its calculated values
    at the observed points, in the unit of the observation.

    Programs, functions and whatever the problem limits run in watched processes, where limits hold. A context manager:
    at its end these processes end, with all that they have started.

    Parameters
    ----------
    problem
        The problem.
    at_once
        How many evaluations run at the same time.
    """

    def __init__(self, problem: Problem, at_once: int = 1) -> None:
        self.problem = problem
        self._at_once = at_once
        self._calibration = Calibration(problem, problem.seed or 0)
        self._room = threading.Semaphore(at_once)
        self._watched = WATCHED and (problem.limits != Limits() or problem.forward_model.runs_outside)
        self._team: Team | None = None
        known = {info.name: info for info in problem.model.series}
        self.outputs = tuple(
            Output(one.series, len(one.x), one.y_unit or known[one.series].y_unit, known[one.series].y_unit)
            for one in problem.observations
        )

    def __enter__(self) -> Bridge:
        if self._watched:
            from geoswarm.solver.runner.team import Team

            self._team = Team(self._calibration, self._at_once).__enter__()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._team is not None:
            self._team.abandon()
            for _ in range(self._at_once):
                self._room.acquire(timeout=_END_SECONDS)
            self._team.__exit__(kind, error, at)

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
        evaluation = self._evaluated(self._position(body.get("input")))
        if evaluation.reason is not None:
            raise RequestError(500, evaluation.reason, evaluation.message or "the calculation failed")
        responses = evaluation.responses
        return {"output": [convert(responses[one.series], one.base, one.y_unit).tolist() for one in self.outputs]}

    def _position(self, given: Any) -> FloatArray:
        """The free parameters, shape (d,)."""
        names = self.problem.free_names
        values = given[0] if isinstance(given, list) and len(given) == 1 and isinstance(given[0], list) else None
        if values is None or len(values) != len(names) or not all(_is_number(one) for one in values):
            accepted = f"input must be [[{', '.join(names)}]], {len(names)} finite numbers"
            raise RequestError(400, "InvalidInput", f"{accepted}; got {str(given)[:100]}")
        return np.array(values, dtype=np.float64)

    def _evaluated(self, position: FloatArray) -> Evaluation:
        with self._room:
            if self._team is None:
                return self._calibration.evaluate(position)
            try:
                (evaluation,) = self._team.evaluate(position[np.newaxis])
            except EvaluationCancelled:
                raise RequestError(503, "Ending", "the server is ending") from None
            except WorkerLostError as error:
                raise RequestError(503, "Busy", str(error)) from None
            return evaluation


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def make_server(bridge: Bridge, host: str, port: int) -> ThreadingHTTPServer:
    """Bind a server; port 0 takes a free one.

    Raises
    ------
    OSError
        The address cannot be taken.
    """

    class Handler(_Handler):
        answers = bridge

    class Server(ThreadingHTTPServer):
        address_family = socket.AF_INET6 if ":" in host else socket.AF_INET
        daemon_threads = True
        request_queue_size = _MOST_WAITING

    return Server((host, port), Handler)


class _Handler(BaseHTTPRequestHandler):
    """Requests as JSON."""

    answers: ClassVar[Bridge]
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "geoswarm", ""
    timeout = _SLOW_SECONDS

    def do_GET(self) -> None:
        """Answer ``/Info``."""
        if self.headers.get("Content-Length", "0") != "0" or "Transfer-Encoding" in self.headers:
            self.close_connection = True  # what is not read would be taken for the next request
        self._reply(None)

    def do_POST(self) -> None:
        """Answer the others."""
        length = _length(self.headers.get("Content-Length"))
        if length is None or length > _LARGEST:
            self.close_connection = True
            status, found = (411, "must have a") if length is None else (413, "is too large:")
            self._send(status, _error("InvalidInput", f"a request {found} Content-Length of at most {_LARGEST} bytes"))
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
            if "Origin" in self.headers:  # a page of any site can send requests from the browser of this machine
                raise RequestError(403, "InvalidInput", "web pages are not answered")
            status, found = 200, self.answers.answer(self.path.partition("?")[0], body)
        except RequestError as error:
            status, found = error.status, _error(error.kind, str(error))
        except Exception as error:  # noqa: BLE001  a client must learn that it is the server's fault
            self.server.handle_error(self.connection, self.client_address)
            status, found = 500, _error("InternalError", in_words(error)[:1000])
        self._send(status, found)

    def _send(self, status: int, found: dict[str, Any]) -> None:
        text = json.dumps(found, allow_nan=False).encode()
        try:
            self.send_response(status)
            self.send_header("Content-Type", "application/json")
            self.send_header("Content-Length", str(len(text)))
            if self.close_connection:
                self.send_header("Connection", "close")
            self.end_headers()
            self.wfile.write(text)
        except OSError:  # the client has gone
            self.close_connection = True

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing of each request."""


def _length(header: str | None) -> int | None:
    """Length of a body; None: it is not told as a number."""
    return int(header) if header is not None and header.isascii() and header.isdigit() and len(header) < 20 else None


def _error(kind: str, message: str) -> dict[str, Any]:
    return {"error": {"type": kind, "message": message}}
