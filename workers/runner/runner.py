"""A worker's side of its evaluation process: hands out positions, watches limits, kills what exceeds them."""

from __future__ import annotations

import contextlib
import fcntl
import json
import logging
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.workers.runner.child import LOG_TAIL, tail
from geoswarm.workers.runner.evaluator import Limits, NeverMind
from geoswarm.workers.runner.nurse import BOOTSTRAP, FORK, KILL, LOAD, STATUS
from geoswarm.workers.runner.processes import kill_session, memory_below
from geoswarm.workers.runner.wire import Board, ConnectionEnded, Outcome, anonymous_file, receive, send, unpack_outcomes
from geoswarm.workers.store.codec import pack_array

__all__ = ["Runner"]

log = logging.getLogger(__name__)

POLL_SECONDS = 0.05
PAUSES = (0.0, 0.2, 1.0)  # s, before another supervisor is started in place of one that was killed
MEMORY_SECONDS = 0.1
NURSE_SECONDS = 120.0  # it loads every kernel that is compiled
COMPILE_SECONDS = 1800.0
LARGEST_OUTPUT = 16 * 2**20  # bytes

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""Environment of a process that evaluates: one numerical thread, as there is one worker a core."""


class Runner:
    """Evaluates in a process of its own, which is killed with everything that it has started when it exceeds a limit.

    It serves one thread. The process stays for the next evaluations, so a run costs some 0.1 ms more than inline.
    """

    def __init__(self) -> None:
        self._nurse: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._connection: socket.socket | None = None
        self._board: Board | None = None
        self._output = anonymous_file()
        fcntl.fcntl(self._output, fcntl.F_SETFL, os.O_APPEND)
        self._idle_memory = 0.0
        self._memory_at = 0.0
        self.loaded: set[str] = set()

    def start(self) -> None:
        """Start the nurse, which gets ready by itself."""
        ours, theirs = socket.socketpair()
        given = json.dumps({"path": sys.path, "control": theirs.fileno()})
        with theirs:
            self._nurse = subprocess.Popen(
                [sys.executable, "-c", BOOTSTRAP, given],
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                env={**os.environ, **ONE_THREAD},
                start_new_session=True,  # signals of a terminal or a supervisor are for the worker
            )
        ours.settimeout(NURSE_SECONDS)
        self._control = ours
        self.loaded.clear()

    def load(self, group: str, unwanted: Callable[[], bool]) -> None:
        """Have the nurse load a group of kernels: all evaluation processes that she forks have it then."""
        if self._connection is not None:
            self._kill()  # what was forked before lacks them
        if self._control is None:
            self.start()
        control, nurse = self._control, self._nurse
        if control is None or nurse is None:
            raise RuntimeError("the runner was not started")
        deadline = time.monotonic() + COMPILE_SECONDS
        try:
            control.sendall(LOAD[group])
            while not select.select([control], [], [], POLL_SECONDS)[0]:
                if unwanted():
                    nurse.kill()  # her answer must not be taken for another one
                    return
                if time.monotonic() > deadline:
                    raise TimeoutError(f"kernels were not compiled within {COMPILE_SECONDS:g} s")
            self._answer()
            self.loaded.add(group)
        except OSError as error:
            log.warning("the kernels of %r could not be loaded: %s", group, error)
            self._replace_nurse()
            self.loaded.add(group)  # not again and again: an evaluation compiles, or tells what is wrong

    def run(
        self,
        job_id: str,
        calibration: Calibration,
        positions: FloatArray,
        limits: Limits,
        *,
        budget: float | None = None,
        unwanted: Callable[[], float | None] = lambda: None,
        fields: str | None = None,
    ) -> Iterator[Outcome]:
        """Evaluate positions in order; one that exceeds a limit, or ends its process, gives a failed evaluation."""
        started = time.monotonic()
        given, idle_ends = 0, 0
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
            try:
                for outcome in self._batch(
                    job_id, calibration, positions[given : min(lost, default=None)], limits, left, unwanted, fields
                ):
                    given += 1
                    yield outcome
                if not lost:
                    return
            except NeverMind as end:
                raise NeverMind(first + end.index) from None
            except _EndedError as ended:
                if ended.index < 0 and (idle_ends := idle_ends + 1) == 1:
                    continue  # killed from outside between two evaluations: no evaluation is to blame
                # What it had finished but not yet sent is calculated again, up to the one that was under way.
                culprit = max(first + ended.index, given)
                lost[culprit] = ended.outcome(positions[culprit])

    def close(self) -> None:
        """Kill the evaluation process and all that it has started, and end the nurse."""
        self._disconnect()
        if self._control is not None:
            self._control.close()
            self._control = None
        if self._nurse is not None:
            try:
                self._nurse.wait(5.0)
            except subprocess.TimeoutExpired:
                self._nurse.kill()
                self._nurse.wait()
            self._nurse = None

    def _batch(
        self,
        job_id: str,
        calibration: Calibration,
        positions: FloatArray,
        limits: Limits,
        budget: float | None,
        unwanted: Callable[[], float | None],
        fields: str | None,
    ) -> Iterator[Outcome]:
        """Give the outcomes of one request."""
        connection, board = self._connected()
        board.stopped = False
        board.idle()
        request = {"op": "run", "job": job_id, "shape": positions.shape, "budget": budget, "fields": fields}
        body = pack_array(np.ascontiguousarray(positions).ravel())
        received = 0
        try:
            send(connection, request, body)
            while True:
                self._watch(connection, board, limits, unwanted)
                answer, values = receive(connection)
                if "unknown" in answer:
                    problem = json.dumps(calibration.problem.document(), allow_nan=False)
                    load = {"op": "load", "job": job_id, "seed": calibration.seed, "problem": problem}
                    send(connection, load)
                    send(connection, request, body)
                    continue
                outcomes = unpack_outcomes(answer["results"], values, positions[received:])
                received += len(outcomes)
                yield from outcomes
                if answer["done"]:
                    return
        except ConnectionEnded:
            code = self._kill()
            raise _EndedError("worker_lost", _how_it_ended(code), board.current, tail(self._output)) from None
        except GeneratorExit:
            self._kill()  # the caller has lost interest; whatever is under way must not answer the next request
            raise

    def _watch(
        self,
        connection: socket.socket,
        board: Board,
        limits: Limits,
        unwanted: Callable[[], float | None],
    ) -> None:
        """Wait until the evaluation process has something to say.

        Raises
        ------
        _EndedError
            When it had to be killed because of a limit.
        NeverMind
            When it had to be killed because nobody wants the result.
        """
        deadline: float | None = None
        while not select.select([connection], [], [], POLL_SECONDS)[0]:
            now = time.monotonic()
            index, since = board.current
            since = since if index >= 0 else now
            if deadline is None:
                patience = unwanted()
                if patience is not None:
                    board.stopped = True
                    deadline = now + patience
            elif now > deadline:
                self._kill()
                raise NeverMind(max(index, 0))
            if limits.seconds is not None and now - since > limits.seconds:
                self._kill()
                message = f"ran for longer than {limits.seconds:g} s (limits.seconds_per_evaluation) and was killed"
                raise _EndedError("timeout", message, (index, since), tail(self._output))
            if limits.memory_mb is not None and now - self._memory_at > MEMORY_SECONDS:
                self._memory_at = now
                used = self._memory_used()
                if used > limits.memory_mb:
                    self._kill()
                    message = (
                        f"used {used:.0f} MiB, more than {limits.memory_mb:g} MiB (limits.memory_mb), and was killed"
                    )
                    raise _EndedError("killed_memory", message, (index, since), tail(self._output))
            self._shorten_output()

    def _memory_used(self) -> float:
        """Return the memory [MiB] of all below the nurse, beyond what the evaluation process had at its start."""
        return 0.0 if self._nurse is None else memory_below(self._nurse.pid) - self._idle_memory

    def _shorten_output(self) -> None:
        if os.fstat(self._output).st_size > LARGEST_OUTPUT:
            end = tail(self._output) or ""
            os.ftruncate(self._output, 0)
            os.write(self._output, end.encode()[-LOG_TAIL:])

    def _connected(self) -> tuple[socket.socket, Board]:
        """Return the connection to a live evaluation process and the memory shared with it."""
        if self._connection is None or self._board is None:
            for pause in (*PAUSES, None):
                try:
                    self._fork()
                    break
                except OSError as error:  # the nurse was killed, perhaps by what will kill the next one, too
                    if pause is None:
                        raise
                    log.warning("the supervisor of the evaluation process is gone, another one is started: %s", error)
                    time.sleep(pause)
                    self._replace_nurse()
        if self._connection is None or self._board is None:
            raise RuntimeError("there is no evaluation process")
        return self._connection, self._board

    def _fork(self) -> None:
        if self._control is None:
            self.start()
        if self._control is None:
            raise RuntimeError("the runner was not started")
        ours, theirs = socket.socketpair()
        descriptor = anonymous_file()
        try:
            with theirs:
                board = Board(descriptor, new=True)
                socket.send_fds(self._control, [FORK], [theirs.fileno(), self._output, descriptor])
                self._answer()
        except OSError:
            ours.close()
            raise
        finally:
            os.close(descriptor)
        self._connection, self._board = ours, board
        self._idle_memory = 0.0
        self._idle_memory = self._memory_used()

    def _answer(self) -> int | None:
        """Return the exit code of the evaluation process that the nurse tells, None when there is none."""
        if self._control is None:
            raise RuntimeError("the runner was not started")
        data = self._control.recv(STATUS.size, socket.MSG_WAITALL)
        if len(data) < STATUS.size:
            raise ConnectionResetError("it ended")
        code, known = STATUS.unpack(data)
        return code if known else None

    def _kill(self) -> int | None:
        """End the evaluation process with all below it; return its exit code when that is known."""
        self._disconnect()
        try:
            if self._control is None:
                return None
            self._control.sendall(KILL)
            return self._answer()
        except OSError:
            self._replace_nurse()
            return None

    def _disconnect(self) -> None:
        if self._connection is not None:
            self._connection.close()
        self._connection = None

    def _replace_nurse(self) -> None:
        """Start another nurse; what a killed one has left behind is found by its session."""
        nurse = self._nurse
        self._disconnect()
        if nurse is not None:
            with contextlib.suppress(ProcessLookupError):
                nurse.kill()
            nurse.wait()
            kill_session(nurse.pid)
        if self._control is not None:
            self._control.close()
        self.start()


class _EndedError(Exception):
    """The evaluation process has ended, by itself or not."""

    def __init__(self, reason: str, message: str, current: tuple[int, float], output: str | None) -> None:
        self.reason = reason
        self.message = message
        self.index, self.began = current
        self.output = output
        super().__init__(message)

    def outcome(self, position: FloatArray) -> Outcome:
        """Return the failed evaluation."""
        now = time.monotonic()
        began = self.began or now
        parameters = np.array(position, dtype=np.float64)
        evaluation = Evaluation(parameters, None, {}, {}, self.reason, self.message, now - began)
        return Outcome(evaluation, self.output, began, now)


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
