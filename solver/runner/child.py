"""The evaluation process: evaluates positions that its worker sends, one after the other, for one job."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import sys
import time
from dataclasses import replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import in_words
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runner.evaluator import evaluate
from geoswarm.solver.runner.output import LOG_TAIL, OwnOutput
from geoswarm.solver.runner.shared_state import SharedState
from geoswarm.solver.runner.traces import Traces
from geoswarm.solver.runner.wire import ConnectionEnded, Frame, FrameReader, Outcome, pack_outcomes, receive, send
from geoswarm.solver.system.activity import listen
from geoswarm.solver.system.processes import adopt_orphans, go_first_without_memory

__all__ = ["serve"]

SEND_EVERY_SECONDS = 0.005


def serve(connection: socket.socket, shared: SharedState) -> None:
    """Answer the worker until it closes the connection.

    ``load`` makes the job known, ``run`` evaluates positions. Results go back in frames of at least 5 ms of work, so
    that cheap evaluations share them; the last frame says ``done``, and ``renew`` when the runs have left traces and
    the next one should have a process of its own.
    """
    adopt_orphans()
    go_first_without_memory()  # not the worker, which has results to hand in
    listen(shared)
    _Child(connection, shared).serve()


class _Child:
    def __init__(self, connection: socket.socket, shared: SharedState) -> None:
        self._connection = connection
        self._shared = shared
        self._pid = os.getpid()
        self._socket = _identity(connection)
        self._calibration: Calibration | None = None
        self._why = "no problem was loaded"
        self._output = OwnOutput()
        self._traces = Traces()
        # What a forward model forks must not speak for this process, whatever it raises or returns.
        os.register_at_fork(after_in_child=connection.close)

    def serve(self) -> None:
        reader = FrameReader()
        with contextlib.suppress(ConnectionEnded):
            while True:
                request = receive(self._connection, reader)
                if request.pid != self._pid:
                    return
                match request.head["op"]:
                    case "load":
                        self._load(request)
                    case "built":
                        self._send(request, {})
                    case "run":
                        self._run(request)

    def _load(self, request: Frame) -> None:
        self._shared.build()
        self._calibration = None
        try:
            problem = parse_problem(json.loads(request.head["problem"]), programs=request.head["programs"])
            calibration = Calibration(problem, request.head["seed"])
            calibration.make_ready()
            self._calibration = calibration
        except BaseException as error:  # noqa: BLE001  anybody's code; the worker that builds it finds out by itself
            self._why = f"the problem cannot be built here: it raised {in_words(error)}"[:LOG_TAIL]
        self._leave_if_forked()
        self._traces = Traces()  # what a built model keeps open stays
        self._shared.idle()

    def _run(self, request: Frame) -> None:
        head, shared = request.head, self._shared
        budget = head["budget"]
        positions = np.frombuffer(request.body, dtype="<f8").reshape(head["shape"])
        outcomes: list[Outcome] = []
        first = 0  # of those that were not sent yet
        left: str | None = None
        started = sent = time.monotonic()
        for index, position in enumerate(positions):
            began = shared.begin(index)
            if index > 0 and (shared.stopped or (budget is not None and began - started > budget)):
                break
            outcomes.append(self._evaluate(position, began, head["fields"]))
            self._leave_if_forked()
            if _identity(self._connection) != self._socket:
                os._exit(0)  # while this run is known as the one under way: it has cut off this process
            left = self._traces.of_run()
            if left is not None:
                break
            if outcomes[-1].ended - sent > SEND_EVERY_SECONDS:
                self._answer(request, first, outcomes, done=False)
                first, outcomes, sent = index + 1, [], time.monotonic()
        shared.idle()
        self._answer(request, first, outcomes, done=True, renew=left or self._traces.of_many())

    def _evaluate(self, position: FloatArray, began: float, fields: str | None) -> Outcome:
        self._output.clear()
        try:
            if self._calibration is None:
                evaluation = Evaluation(position, None, {}, {}, "bad_output", self._why, 0.0)
            else:
                evaluation = evaluate(self._calibration, position, fields)
        except BaseException as error:  # noqa: BLE001  a forward model may raise anything; Ctrl-C does not come here
            seconds = time.monotonic() - began
            evaluation = Evaluation(position, None, {}, {}, "bad_output", _what_it_raised(error), seconds)
        log = None
        if evaluation.reason is not None:
            for stream in (sys.stdout, sys.stderr):
                with contextlib.suppress(Exception):
                    stream.flush()
            log = self._output.tail()
            evaluation = replace(evaluation, message=(evaluation.message or "")[:LOG_TAIL])
        return Outcome(evaluation, log, began, time.monotonic())

    def _answer(self, request: Frame, first: int, outcomes: list[Outcome], **head: Any) -> None:
        heads, body = pack_outcomes(outcomes)
        self._send(request, {"results": heads, **head}, first, body)

    def _send(self, request: Frame, head: dict[str, Any], first: int = 0, body: bytes = b"") -> None:
        send(self._connection, Frame(request.nonce, first, self._pid, head, body))

    def _leave_if_forked(self) -> None:
        """End a copy of this process that a forward model has made by forking, in whatever language."""
        if os.getpid() != self._pid:
            os._exit(0)


def _identity(connection: socket.socket) -> tuple[int, int] | None:
    """Return what distinguishes a socket from all other files; None: it is closed."""
    try:
        found = os.fstat(connection.fileno())
    except (OSError, ValueError):  # no descriptor, or -1
        return None
    return found.st_dev, found.st_ino


def _what_it_raised(error: BaseException) -> str:
    if isinstance(error, SystemExit) and isinstance(error.code, int | str | None):
        return f"the forward model ended the program (sys.exit({error.code!r}))"
    return f"the forward model raised {in_words(error)}"
