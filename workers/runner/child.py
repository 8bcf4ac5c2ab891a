"""The evaluation process: evaluates positions that its worker sends, one after the other."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import sys
import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.runner.evaluator import evaluate
from geoswarm.workers.runner.wire import Board, ConnectionEnded, Outcome, pack_outcomes, receive, send

__all__ = ["LOG_TAIL", "serve", "tail"]

CACHED_CALIBRATIONS = 8
SEND_EVERY_SECONDS = 0.005
LOG_TAIL = 8192  # bytes of output kept of a failed evaluation


def serve(connection: socket.socket, board: Board) -> None:
    """Answer the worker until it closes the connection.

    ``load`` makes a job known, ``run`` evaluates positions. Results go back in frames of at least 5 ms of work, so that
    cheap evaluations share them; the last frame says ``done``.
    """
    with contextlib.suppress(OSError):
        # When memory runs out, the kernel shall choose this process, not the worker that has results to hand in.
        Path("/proc/self/oom_score_adj").write_text("500")
    known: OrderedDict[str, Calibration] = OrderedDict()
    with contextlib.suppress(ConnectionEnded):
        while True:
            request, body = receive(connection)
            job: str = request["job"]
            if request["op"] == "load":
                known[job] = Calibration(parse_problem(json.loads(request["problem"])), request["seed"])
                if len(known) > CACHED_CALIBRATIONS:
                    known.popitem(last=False)
            elif job not in known:
                send(connection, {"unknown": job})
                continue
            known.move_to_end(job)
            if request["op"] == "run":
                positions = np.frombuffer(body, dtype="<f8").reshape(request["shape"])
                _run(connection, board, known[job], positions, request)


def _run(
    connection: socket.socket,
    board: Board,
    calibration: Calibration,
    positions: FloatArray,
    request: Mapping[str, Any],
) -> None:
    budget = request["budget"]
    outcomes: list[Outcome] = []
    started = sent = time.monotonic()
    for index, position in enumerate(positions):
        began = board.begin(index)
        if index > 0 and (board.stopped or (budget is not None and began - started > budget)):
            break
        outcomes.append(_evaluate(calibration, position, began, request["fields"]))
        if outcomes[-1].ended - sent > SEND_EVERY_SECONDS:
            heads, body = pack_outcomes(outcomes)
            send(connection, {"results": heads, "done": False}, body)
            outcomes, sent = [], time.monotonic()
    board.idle()
    heads, body = pack_outcomes(outcomes)
    send(connection, {"results": heads, "done": True}, body)


def _evaluate(calibration: Calibration, position: FloatArray, began: float, fields: str | None) -> Outcome:
    if os.fstat(1).st_size:
        os.ftruncate(1, 0)
    try:
        evaluation = evaluate(calibration, position, fields)
    except SystemExit as error:
        message = f"the forward model ended the program (sys.exit({error.code!r}))"
        evaluation = Evaluation(position, None, {}, {}, "bad_output", message, time.monotonic() - began)
    log = None
    if evaluation.reason is not None:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        log = tail(1)
        evaluation = replace(evaluation, message=(evaluation.message or "")[:LOG_TAIL])
    return Outcome(evaluation, log, began, time.monotonic())


def tail(descriptor: int) -> str | None:
    """Return the end of what was written to a file; None when that is nothing."""
    size = os.fstat(descriptor).st_size
    data = os.pread(descriptor, LOG_TAIL, max(size - LOG_TAIL, 0))
    return data.decode("utf-8", "replace").replace("\x00", "") or None
