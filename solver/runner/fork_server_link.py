"""A worker's side of the fork server: starts it, has it fork, load and kill, and replaces it when it is lost."""

from __future__ import annotations

import contextlib
import errno
import json
import logging
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Collection

from geoswarm.solver.runner.evaluator import NoProcessError
from geoswarm.solver.runner.fork_server import BOOTSTRAP, FORK, KERNELS, KILL, MODEL, STATUS
from geoswarm.solver.runner.output import anonymous_file
from geoswarm.solver.runner.process import EvaluationProcess
from geoswarm.solver.runner.shared_state import SharedState
from geoswarm.solver.runner.wire import readable
from geoswarm.solver.system.environment import clean_environment, numerics
from geoswarm.solver.system.processes import kill_session, memory_below

__all__ = ["ForkServerLink"]

log = logging.getLogger(__name__)

POLL_SECONDS = 0.05
PAUSES = (0.0, 0.2, 1.0)  # s, before another fork server is started instead of one that was killed
READY_SECONDS = 120.0  # to import what evaluations need, and to load again what the one before it had
ANSWER_SECONDS = 15.0  # to fork or to kill, when it is ready
WAKE_SECONDS = 1.0
COMPILE_SECONDS = 1800.0


class ForkServerLink:
    """The fork server of one worker.

    Parameters
    ----------
    output
        Descriptor of the file that takes what forward models write to their standard output and error.
    passed
        Names of environment variables that forward models get beside the usual ones.
    """

    def __init__(self, output: int, passed: tuple[str, ...] = ()) -> None:
        self._output = output
        self._passed = passed
        self._process: subprocess.Popen[bytes] | None = None
        self._control: socket.socket | None = None
        self._ready = False
        self.loaded: set[str] = set()
        """Groups of kernels that need not be asked for any more."""
        self._asked: set[str] = set()  # kinds of forward models
        self._again: list[tuple[str, str]] = []  # what one that takes the place of this one loads, too

    @property
    def pid(self) -> int | None:
        """Its process number."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start it; it gets ready by itself.

        Raises
        ------
        OSError
            When the system has no process or descriptor to spare.
        """
        ours, theirs = socket.socketpair()
        given = json.dumps({"path": sys.path, "control": theirs.fileno(), "loaded": self._again})
        try:
            with theirs:
                self._process = subprocess.Popen(
                    [sys.executable, "-c", BOOTSTRAP, given],
                    stdin=subprocess.DEVNULL,
                    pass_fds=[theirs.fileno()],
                    env={**clean_environment(os.environ, self._passed), **numerics()},
                    start_new_session=True,  # signals of a terminal or a supervisor are for the worker
                )
        except OSError:
            ours.close()
            raise
        self._control = ours
        self._ready = False

    def load(self, group: str, unwanted: Callable[[], bool]) -> None:
        """Have it load a group of kernels: all evaluation processes that it forks have it then."""
        if self._load(KERNELS, group, unwanted):
            self.loaded.add(group)

    def import_models(self, kinds: Collection[str], unwanted: Callable[[], bool]) -> None:
        """Have it import forward models that it lacks: all evaluation processes that it forks have them then."""
        for kind in self.lacking(kinds):
            if self._load(MODEL, kind, unwanted):
                self._asked.add(kind)

    def lacking(self, kinds: Collection[str]) -> list[str]:
        """Return those of some kinds of forward models that it was not asked for yet."""
        return sorted(set(kinds) - self._asked)

    def _load(self, message: bytes, name: str, unwanted: Callable[[], bool]) -> bool:
        """Have it load something; False: that became unwanted. It is not asked again for what has failed."""
        try:
            control, process = self._started()
            text = name.encode()
            control.sendall(message + bytes([len(text)]) + text)
            deadline = time.monotonic() + COMPILE_SECONDS
            while not readable(control, POLL_SECONDS):
                if unwanted():
                    process.kill()  # its answer must not be taken for another one
                    return False
                if time.monotonic() > deadline:
                    raise TimeoutError(f"this took longer than {COMPILE_SECONDS:g} s")
            self._answer()
            self._again.append((message.decode(), name))
        except OSError as error:  # an evaluation compiles or imports, or reports what is wrong
            what = "the kernels of" if message == KERNELS else "forward model"
            log.warning("%s %r could not be loaded: %s", what, name, error)
            self._lose()
        return True

    def fork(self) -> EvaluationProcess:
        """Return a new evaluation process.

        Raises
        ------
        NoProcessError
            When none is to be had, however often the fork server was replaced.
        """
        for pause in (*PAUSES, None):
            try:
                return self._fork()
            except OSError as error:  # it was killed, perhaps by what will kill the next one, too
                self._lose()
                if pause is None:
                    raise NoProcessError(f"no evaluation process could be started: {error}") from error
                log.warning("the fork server of the evaluation process has ended; another one is started: %s", error)
                time.sleep(pause)
        raise AssertionError

    def kill(self) -> int | None:
        """End everything that it has forked, with all that it has started; return its exit code if that is known."""
        if self._control is None:
            return None
        try:
            self._control.sendall(KILL)
            code, known, _ = self._answer()
        except OSError:
            self._lose()
            return None
        return code if known else None

    def memory(self) -> float:
        """Return the memory [MiB] of all that it has forked."""
        return 0.0 if self.pid is None else memory_below(self.pid)

    def close(self) -> None:
        """End it; it kills all that it has forked."""
        if self._control is not None:
            self._control.close()
            self._control = None
        if self._process is not None:
            self._wake()
            try:
                self._process.wait(5.0)
            except subprocess.TimeoutExpired:
                self._lose()
            self._process = None

    def _started(self) -> tuple[socket.socket, subprocess.Popen[bytes]]:
        if self._control is None or self._process is None:
            self.start()
        if self._control is None or self._process is None:
            raise RuntimeError("the fork server was not started")
        return self._control, self._process

    def _fork(self) -> EvaluationProcess:
        control, _ = self._started()
        ours, theirs = socket.socketpair()
        memory = -1
        try:
            with theirs:
                memory = anonymous_file()
                shared = SharedState(memory, new=True)
                socket.send_fds(control, [FORK], [theirs.fileno(), self._output, memory])
                pid, known, pidfd = self._answer()
        except OSError:
            ours.close()
            raise
        finally:
            if memory >= 0:
                os.close(memory)
        if not known:
            ours.close()
            raise OSError(pid, os.strerror(pid))
        return EvaluationProcess(ours, shared, pid, pidfd)

    def _answer(self) -> tuple[int, bool, int | None]:
        """Return the number of its answer, whether it is known, and the descriptor that came with it."""
        control, _ = self._started()
        deadline = time.monotonic() + (ANSWER_SECONDS if self._ready else READY_SECONDS)
        while not readable(control, WAKE_SECONDS):
            self._wake()
            if time.monotonic() > deadline:
                raise TimeoutError(errno.ETIMEDOUT, "the fork server does not answer")
        data, descriptors, _, _ = socket.recv_fds(control, STATUS.size, 1)
        if len(data) < STATUS.size:
            for descriptor in descriptors:
                os.close(descriptor)
            raise ConnectionResetError(errno.ECONNRESET, "the fork server has ended")
        self._ready = True
        number, known = STATUS.unpack(data)
        return number, bool(known), descriptors[0] if descriptors else None

    def _wake(self) -> None:
        """Have it go on if a forward model has stopped it."""
        if self._process is not None:
            with contextlib.suppress(OSError):
                self._process.send_signal(signal.SIGCONT)

    def _lose(self) -> None:
        """Kill it and what it leaves behind, which is found by its session."""
        if self._process is not None:
            with contextlib.suppress(OSError):
                self._process.kill()
            self._process.wait()
            kill_session(self._process.pid)
            self._process = None
        if self._control is not None:
            self._control.close()
            self._control = None
