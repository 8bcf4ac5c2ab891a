"""The process that makes runs for an agent: reads requests from standard input, line by line, and answers.

What the forward models print goes to a file; the pipe is out of their reach. On POSIX a keeper stands above it, on
Windows a job object around it.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Mapping
from typing import IO, Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import in_words
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.formula import FormulaModel
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.objective import ObservedSeries
from geoswarm.solver.objective.outcome import Calculation, ForwardOutcome
from geoswarm.solver.system.activity import listen
from geoswarm.solver.system.processes import adopt_orphans, child_program, die_with_parent, go_first_without_memory
from geoswarm.solver.warm import compile_for

__all__ = ["BOOTSTRAP", "main"]

BOOTSTRAP = child_program("geoswarm.agent.run_main", "sys.argv[1]")
LOG_TAIL = 8192  # bytes


def main(given: Mapping[str, Any]) -> None:
    """Answer until standard input ends.

    Parameters
    ----------
    given
        ``log``: the file for what forward models print.
    """
    die_with_parent()
    adopt_orphans()  # what a run leaves behind is seen after it
    go_first_without_memory()
    requests = os.fdopen(os.dup(0), "rb")
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    log = os.open(given["log"], os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for standard in (1, 2):
        os.dup2(log, standard)
    runner = _Runner(answers, log)
    listen(runner)
    for line in requests:
        request = json.loads(line)
        match request["op"]:
            case "load":
                runner.load(request["shared"])
            case "run":
                runner.run(request["runs"])
    os._exit(0)  # threads of a forward model must not keep it


class _Runner:
    """Makes runs, and reports its activity: a listener of :mod:`geoswarm.solver.system.activity`."""

    def __init__(self, answers: IO[bytes], log: int) -> None:
        self._answers, self._log = answers, log
        self._lock = threading.Lock()
        self._spec: ForwardModelSpec | None = None
        self._calculation: Calculation | None = None
        self._why = "no forward model was loaded"
        self._threads = threading.active_count()

    def load(self, shared: Mapping[str, Any]) -> None:
        """Build the forward model of a job, and have its kernels compiled: no run's limit counts that."""
        self._calculation = None
        try:
            spec = parse_spec(shared["forward_model"])
            if spec.runs_programs:
                raise ValueError("it starts a program that is not registered here")
            self._spec = spec = spec.with_files(None, "forward_model")
            points = {name: np.array(x, dtype=np.float64) for name, x in shared["points"].items()}
            model = built(spec)
            inputs = {name: (points[name], _arrays(given)) for name, given in shared["inputs"].items()}
            if inputs and isinstance(model, FormulaModel):
                model = model.with_inputs(inputs)
            # What is observed is not known here: only how many numbers a series must have.
            blank = [ObservedSeries(name, x, np.zeros(x.shape), np.ones(x.shape), 1.0) for name, x in points.items()]
            compile_for(spec)
            run = model.prepare(points)
            make_ready = getattr(run, "make_ready", None)
            if make_ready is not None:
                make_ready()
            # A service of an earlier version does not say whether parts are kept.
            self._calculation = Calculation(run, blank, keeps_parts=bool(shared.get("keeps_parts")))
        except BaseException as error:  # noqa: BLE001  anybody's code
            self._why = f"the problem cannot be built here: it raised {in_words(error)}"[:LOG_TAIL]
        self._threads = threading.active_count()  # what a built model keeps stays
        self._tell({"loaded": self._calculation is not None})

    def run(self, runs: list[tuple[int, dict[str, float]]]) -> None:
        """Make runs in order; the last answer says whether the next ones should have a process of their own."""
        left = False
        for index, values in runs:
            os.ftruncate(self._log, 0)
            self._tell({"begins": index})
            outcome = self._outcome(values)
            left = _has_children() or threading.active_count() > self._threads
            self._tell({"done": index, **self._shown(outcome), "renew": left})
            if left:
                break
        self._tell({"over": True, "renew": left})

    def _outcome(self, values: Mapping[str, float]) -> ForwardOutcome:
        if self._calculation is None:
            return ForwardOutcome({}, "bad_output", self._why, 0.0)
        try:
            return self._calculation.outcome(values)
        except BaseException as error:  # noqa: BLE001  a forward model may raise anything; Ctrl-C does not come here
            if isinstance(error, SystemExit) and isinstance(error.code, int | str | None):
                told = f"the forward model ended the program (sys.exit({error.code!r}))"
            else:
                told = f"the forward model raised {in_words(error)}"
            return ForwardOutcome({}, "bad_output", told, 0.0)

    def _shown(self, outcome: ForwardOutcome) -> dict[str, Any]:
        log = None
        if outcome.reason is not None:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            log = self._tail()
        return {
            "responses": {name: values.tolist() for name, values in outcome.responses.items()},
            "reason": outcome.reason,
            "message": outcome.message and outcome.message[:LOG_TAIL],
            "log": log if log is None or self._spec is None else self._spec.shown(log),
            "seconds": max(outcome.seconds, 0.0),
        }

    def _tail(self) -> str | None:
        size = os.fstat(self._log).st_size
        os.lseek(self._log, max(size - LOG_TAIL, 0), os.SEEK_SET)
        return os.read(self._log, LOG_TAIL).decode("utf-8", "replace").replace("\x00", "") or None

    def wait(self) -> None:
        """Tell that the run begins to wait."""
        self._tell({"waits": True})

    def go_on(self, seconds: float) -> None:
        """Report that it has waited this long [s]."""
        self._tell({"waited": seconds})

    def do(self, what: str) -> None:
        """Tell what it does, in words."""
        self._tell({"does": what})

    def _tell(self, answer: Mapping[str, Any]) -> None:
        line = json.dumps(answer, separators=(",", ":")).encode() + b"\n"
        with self._lock:
            view = memoryview(line)
            while view:
                view = view[self._answers.write(view) :]


def _arrays(given: Mapping[str, Any]) -> dict[str, FloatArray]:
    return {name: np.array(values, dtype=np.float64) for name, values in given.items()}


def _has_children() -> bool:
    """Whether a run has left processes, as far as the system shows; elsewhere they end with the job object."""
    if not hasattr(os, "waitid"):
        return False
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True
