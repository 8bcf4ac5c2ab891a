"""A worker's side of its evaluation process: hands out positions, watches limits, kills what exceeds them."""

from __future__ import annotations

import fcntl
import json
import logging
import os
import signal
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray, pack_array
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.runner.evaluator import BuildError, EvaluationCancelled, RunLimits
from geoswarm.solver.runner.fork_server_link import POLL_SECONDS, ForkServerLink
from geoswarm.solver.runner.output import anonymous_file, tail
from geoswarm.solver.runner.process import EvaluationProcess
from geoswarm.solver.runner.shared_state import BUILDING, IDLE, Progress
from geoswarm.solver.runner.wire import ConnectionEnded, Frame, GarbledError, Outcome, unpack_outcomes
from geoswarm.solver.system.processes import memory_of

__all__ = ["Runner"]

log = logging.getLogger(__name__)

MEMORY_SECONDS = 0.1
GROWTH_SECONDS = 1.0
MOST_RUNS = 50_000  # in one process
MOST_GROWTH = 256.0  # MiB that a process may keep between runs, beyond three times what it keeps after the first ones
BUILD_SECONDS = 300.0
BUILD_TRIES = 3
GARBLED = "the evaluation process gave an answer that does not fit what was asked, and was killed"
SILENT_SECONDS = 30.0  # in the middle of an answer, or with an answer due


class Runner:
    """Evaluates in a process of its own, which is killed with everything that it has started when it exceeds a limit.

    It serves one thread. The process stays for the next evaluations of the same job, so a run costs some 0.1 ms more
    than inline. Another job, a run that leaves processes or threads behind, and many runs or much memory bring a
    fresh one.

    Parameters
    ----------
    passed
        Names of environment variables that forward models get beside the usual ones.
    """

    def __init__(self, passed: tuple[str, ...] = ()) -> None:
        self._output = anonymous_file()
        fcntl.fcntl(self._output, fcntl.F_SETFL, os.O_APPEND)
        self._fork_server = ForkServerLink(self._output, passed)
        self._process: EvaluationProcess | None = None
        self._idle_memory = 0.0  # pages shared with the fork server are shared out: what a limit is about
        self._idle_resident = 0.0  # all its pages: quick to ask for
        self._kept_memory: float | None = None  # after the first runs
        self._memory_at = 0.0

    @property
    def loaded(self) -> Collection[str]:
        """Groups of kernels that need not be loaded any more."""
        return self._fork_server.loaded

    def start(self) -> None:
        """Start the fork server, which gets ready by itself; if it cannot be started now, the first run does."""
        try:
            self._fork_server.start()
        except OSError as error:
            log.warning("the fork server of evaluation processes could not be started yet: %s", error)

    def load(self, group: str, unwanted: Callable[[], bool]) -> None:
        """Have the fork server load a group of kernels: all evaluation processes that it forks have it then."""
        self._kill()  # what was forked before lacks them
        self._fork_server.load(group, unwanted)

    def import_models(self, kinds: Collection[str], unwanted: Callable[[], bool]) -> None:
        """Have the fork server import forward models: all evaluation processes that it forks have them then."""
        if self._fork_server.lacking(kinds):
            self._kill()
            self._fork_server.import_models(kinds, unwanted)

    def build(self, job_id: str, document: Mapping[str, Any], seed: int, limits: RunLimits) -> None:
        """Have the problem of a job built in the evaluation process, which may die of it."""
        why = ""
        for _ in range(BUILD_TRIES):
            process = self._ready(job_id)
            try:
                if process.job is None:
                    self._load(process, job_id, document, seed)
                    process.ask({"op": "built"}, first=False)
                    self._watched(process, limits, lambda: None)
                return
            except ConnectionEnded:
                why = _how_it_ended(self._kill())
            except GarbledError:
                self._kill()
                why = GARBLED
            except _EndedError as ended:
                why = ended.message
        raise BuildError(f"the problem could not be built, tried {BUILD_TRIES} times: {why}")

    def run(
        self,
        job_id: str,
        calibration: Calibration,
        positions: FloatArray,
        limits: RunLimits,
        *,
        budget: float | None = None,
        unwanted: Callable[[], float | None] = lambda: None,
        fields: str | None = None,
    ) -> Iterator[Outcome]:
        """Evaluate positions in order; one that exceeds a limit, or ends its process, gives a failed evaluation."""
        started = time.monotonic()
        given, idle_ends = 0, 0
        alone = len(positions)  # has to begin in a fresh process
        singly = False
        lost: dict[int, Outcome] = {}
        while given < len(positions):
            if given in lost:
                yield lost.pop(given)
                given += 1
                continue
            left = None if budget is None else max(started + budget - time.monotonic(), 0.0)
            if given and (left == 0.0 or unwanted() is not None):
                return
            first = given
            if given == alone:
                self._kill()
                alone = len(positions)
            part = positions[given : given + 1 if singly else min((alone, *lost))]
            try:
                for outcome in self._batch(job_id, calibration, part, limits, left, unwanted, fields):
                    given += 1
                    yield outcome
                if given < first + len(part) and self._process is not None:
                    return
            except EvaluationCancelled as end:
                if given < first + len(part):  # else all had been answered
                    raise EvaluationCancelled(max(first + _noted(end.index, part), given)) from None
            except _SpoiledError as spoiled:
                alone = max(first + _noted(spoiled.index, part), given)
            except _EndedError as ended:
                index = _noted(ended.index, part)
                if given == first + len(part) or 0 <= index < given - first:
                    continue  # it ended behind an answer: no evaluation is to blame
                if index < 0 and len(part) > 1:
                    singly = True  # to find out which one is to blame
                    continue
                if index < 0 and (idle_ends := idle_ends + 1) == 1:
                    continue  # killed from outside between two evaluations: no evaluation is to blame
                # What it had finished but not yet sent is calculated again, up to the one that was under way.
                culprit = max(first + index, given)
                lost[culprit] = ended.outcome(positions[culprit])

    def close(self) -> None:
        """Kill the evaluation process and all that it has started, and end the fork server."""
        self._disconnect()
        self._fork_server.close()

    def _batch(
        self,
        job_id: str,
        calibration: Calibration,
        positions: FloatArray,
        limits: RunLimits,
        budget: float | None,
        unwanted: Callable[[], float | None],
        fields: str | None,
    ) -> Iterator[Outcome]:
        """Give the outcomes of one request; afterwards there is no process if the next run should have a fresh one."""
        process = self._ready(job_id)
        shared = process.shared
        shared.stopped = False
        shared.idle()
        request = {"op": "run", "shape": positions.shape, "budget": budget, "fields": fields}
        received = 0
        try:
            if process.job is None:
                problem = calibration.problem
                programs = problem.forward_model.runs_programs  # accepted where the problem was built
                self._load(process, job_id, problem.document(), calibration.seed, programs=programs)
                process.ask(request, _packed(positions), first=False)
            else:
                process.ask(request, _packed(positions))
            while True:
                frame = self._watched(process, limits, unwanted)
                outcomes = _outcomes(frame, positions[received:])
                received += len(outcomes)
                if frame.head["done"] and not received:
                    raise GarbledError
                process.took(len(outcomes))
                yield from outcomes
                if frame.head["done"]:
                    self._renew(process, frame.head["renew"])
                    return
        except ConnectionEnded:
            at = shared.current
            raise _EndedError("worker_lost", _how_it_ended(self._kill()), at, tail(self._output)) from None
        except GarbledError:
            at = shared.current._replace(position=IDLE)
            self._kill()
            raise _EndedError("worker_lost", GARBLED, at, tail(self._output)) from None
        except GeneratorExit:
            self._kill()  # the caller has lost interest; whatever is under way must not answer the next request
            raise

    def _load(
        self,
        process: EvaluationProcess,
        job_id: str,
        document: Mapping[str, Any],
        seed: int,
        *,
        programs: bool = False,
    ) -> None:
        process.shared.build()
        text = json.dumps(document, allow_nan=False)
        process.ask({"op": "load", "seed": seed, "problem": text, "programs": programs})
        process.job = job_id

    def _watched(self, process: EvaluationProcess, limits: RunLimits, unwanted: Callable[[], float | None]) -> Frame:
        """Wait for the next answer.

        Raises
        ------
        _EndedError
            When the process had to be killed because of a limit.
        _SpoiledError
            When it had to be killed for memory that an earlier run may have left.
        EvaluationCancelled
            When it had to be killed because the result is not wanted.
        ConnectionEnded, GarbledError
        """
        deadline: float | None = None
        asked = time.monotonic()
        while True:
            frame = process.answer(POLL_SECONDS)
            if frame is not None:
                return frame
            now = time.monotonic()
            at = process.shared.current
            if deadline is None:
                patience = unwanted()
                if patience is not None:
                    process.shared.stopped = True
                    deadline = now + patience
            elif now > deadline:
                self._kill()
                raise EvaluationCancelled(at.position)
            self._keep_time(process, limits, at, now - max(asked, process.heard))
            if limits.memory_mb is not None and now - self._memory_at > MEMORY_SECONDS:
                self._memory_at = now
                self._keep_memory(process, limits.memory_mb, at)

    def _keep_time(self, process: EvaluationProcess, limits: RunLimits, at: Progress, silent: float) -> None:
        running = time.monotonic() - at.since
        message: str | None = None
        reason = "worker_lost"
        if at.position >= 0 and limits.seconds is not None and running - at.waited > limits.seconds:
            reason, doing = "timeout", process.shared.doing
            message = f"ran for longer than {limits.seconds:g} s ({limits.of_time}) and was killed"
            message += f" while {doing}" if doing else ""
        elif at.position == BUILDING and running > BUILD_SECONDS:
            message = f"the problem was not built within {BUILD_SECONDS:g} s in the evaluation process"
        elif (process.answering or at.position == IDLE) and min(running, silent) > SILENT_SECONDS:
            message = f"the evaluation process was silent for {SILENT_SECONDS:g} s with an answer due, and was killed"
        if message is not None:
            self._kill()
            raise _EndedError(reason, message, at, tail(self._output))

    def _keep_memory(self, process: EvaluationProcess, most: float, at: Progress) -> None:
        used = self._memory_used()
        if used <= most:
            return
        # What counts is what this evaluation uses, not what those before it have left.
        spoiled = process.runs > 0 or at.position > 0
        self._kill()
        if spoiled:
            raise _SpoiledError(at.position)
        message = f"used {used:.0f} MiB, more than {most:g} MiB (limits.memory_mb), and was killed"
        raise _EndedError("killed_memory", message, at, tail(self._output))

    def _memory_used(self) -> float:
        """Return the memory [MiB] of all below the fork server, beyond what the evaluation process had at its start."""
        return self._fork_server.memory() - self._idle_memory

    def _ready(self, job_id: str) -> EvaluationProcess:
        """Return a process that is idle and has evaluated for this job at most."""
        process = self._process
        if process is not None and (process.job not in (None, job_id) or process.spoke_unasked):
            self._kill()
        if self._process is None:
            self._process = self._fork_server.fork()
            self._idle_memory = self._fork_server.memory()
            self._idle_resident = memory_of(self._process.pid)
            self._kept_memory = None
        return self._process

    def _renew(self, process: EvaluationProcess, left: str | None) -> None:
        """Kill a process that should make no further run; the next one begins in a fresh one."""
        now = time.monotonic()
        if left is None and process.runs < MOST_RUNS:
            if now - self._memory_at < GROWTH_SECONDS and self._kept_memory is not None:
                return
            self._memory_at = now
            kept = memory_of(process.pid) - self._idle_resident  # it has nothing below it now
            if self._kept_memory is None:
                self._kept_memory = kept
            if kept < 3.0 * self._kept_memory + MOST_GROWTH:
                return
            left = f"{kept:.0f} MiB of memory"
        log.debug("a fresh evaluation process after %d runs: they have left %s", process.runs, left)
        self._kill()

    def _kill(self) -> int | None:
        """End the evaluation process with all below it; return its exit code when that is known."""
        if self._process is None:
            return None
        self._disconnect()
        return self._fork_server.kill()

    def _disconnect(self) -> None:
        if self._process is not None:
            self._process.close()
        self._process = None


class _SpoiledError(Exception):
    """The process was killed for what may not be the fault of the run under way: it is begun again in a fresh one."""

    def __init__(self, index: int) -> None:
        self.index = index
        super().__init__(index)


class _EndedError(Exception):
    """The evaluation process has ended, by itself or not."""

    def __init__(self, reason: str, message: str, at: Progress, output: str | None) -> None:
        self.reason = reason
        self.message = message
        self.index, self.began = at.position, at.since
        self.output = output
        super().__init__(message)

    def outcome(self, position: FloatArray) -> Outcome:
        """Return the failed evaluation."""
        now = time.monotonic()
        began = self.began or now
        parameters = np.array(position, dtype=np.float64)
        evaluation = Evaluation(parameters, None, {}, {}, self.reason, self.message, now - began)
        return Outcome(evaluation, self.output, began, now)


def _noted(index: int, positions: FloatArray) -> int:
    """Return the place that an evaluation process noted; ``IDLE`` for one that is none: a model may have written it."""
    return index if index < len(positions) else IDLE


def _outcomes(frame: Frame, positions: FloatArray) -> list[Outcome]:
    """Return the outcomes of an answer about positions, shape (k, d), or some of the first of them."""
    try:
        if len(frame.head["results"]) > len(positions) or not isinstance(frame.head["done"], bool):
            raise GarbledError
        return unpack_outcomes(frame.head["results"], frame.body, positions)
    except (LookupError, TypeError, ValueError):
        raise GarbledError from None


def _packed(positions: FloatArray) -> bytes:
    return pack_array(np.ascontiguousarray(positions).ravel())


def _how_it_ended(code: int | None) -> str:
    if code is None:
        return "the evaluation process was lost"
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        return f"the evaluation process was ended by {name}"
    return f"the evaluation process ended by itself with exit code {code}"
