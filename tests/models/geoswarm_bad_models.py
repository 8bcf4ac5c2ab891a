"""Ways in which a forward model can behave badly; installed for tests through its entry point.

``y = slope * x``. A run with ``slope`` above 0 misbehaves in the way that ``behaviour`` names, before it answers. What
a worker has to make of it is in :data:`REASONS`: None where the answer is as good as any.
"""

from __future__ import annotations

import ctypes
import faulthandler
import gc
import io
import multiprocessing
import os
import resource
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Literal

import numpy as np

from geoswarm import DivergedError, FloatArray, ForwardModelSpec, ForwardRun, ParameterInfo, SeriesInfo
from geoswarm.solver.runner.shared_state import SharedState
from geoswarm.solver.runner.traces import Traces

__all__ = ["REASONS", "BadSpec"]

Answer = dict[str, Any]
SLEEP = [sys.executable, "-c", "import time; time.sleep(600)"]
WRITE = [sys.executable, "-c", "import os\nwhile True: os.write(1, b'x' * 65536)"]


class OwnError(BaseException):
    """No Exception."""


class SilentError(Exception):
    """An error that cannot be printed."""

    def __str__(self) -> str:
        raise RuntimeError("no")


class Endless:
    """A value whose conversion never ends."""

    def __array__(self, *_: object, **__: object) -> FloatArray:
        time.sleep(600.0)
        return np.zeros(3)


def _sockets() -> list[int]:
    """Descriptors of this process that are sockets."""
    found = []
    for name in os.listdir("/proc/self/fd"):  # noqa: PTH208  names
        with suppress(OSError):
            if stat.S_ISSOCK(os.fstat(int(name)).st_mode):
                found.append(int(name))
    return found


def _write_to_sockets(data: bytes) -> None:
    for descriptor in _sockets():
        with suppress(OSError):
            os.write(descriptor, data)


def _fork(then: Callable[[], None]) -> None:
    if os.fork() == 0:
        then()


def _daemon(then: Callable[[], object]) -> None:
    """A process in a session of its own whose parent has left."""
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            then()
        os._exit(0)


def _raise(error: BaseException) -> None:
    raise error


def _native_fork() -> None:
    if ctypes.CDLL(None).fork() == 0:
        time.sleep(600.0)


def _allocate(mebibytes: int) -> FloatArray:
    return np.ones(mebibytes * 2**17)


def _thread(target: Callable[[], object]) -> None:
    threading.Thread(target=target, daemon=True).start()


def _for_ever(what: Callable[[], object]) -> None:
    while True:
        what()


def _close(descriptor: int) -> None:
    with suppress(OSError):
        os.close(descriptor)


def _deep(level: int = 0) -> int:
    return _deep(level + 1) + 1


kept: list[Any] = []
calls = [0]


def _leak_descriptors() -> None:
    kept.extend(os.open(os.devnull, os.O_RDONLY) for _ in range(40))


def _exhaust_descriptors() -> None:
    with suppress(OSError):
        while True:
            kept.append(os.open(os.devnull, os.O_RDONLY))


def _change_directory() -> None:
    os.chdir("/")
    os.environ.clear()


def _break_modules() -> None:
    time.monotonic = lambda: 0.0
    np.array = lambda *_, **__: None  # type: ignore[assignment]


def _once(action: Callable[[], object]) -> None:
    calls[0] += 1
    if calls[0] == 1:
        action()


BEHAVIOURS: dict[str, tuple[str | None, Callable[[], object]]] = {
    # copies of the process, and what it starts
    "fork and return": (None, lambda: _fork(lambda: None)),
    "fork and raise": (None, lambda: _fork(lambda: _raise(ValueError("in the child")))),
    "fork and leave": (None, lambda: _fork(lambda: os._exit(3))),
    "fork and hang": (None, lambda: _fork(lambda: time.sleep(600.0))),
    "fork and exit": (None, lambda: _fork(lambda: sys.exit(3))),
    "fork in C": (None, _native_fork),
    "fork, and the parent leaves": ("worker_lost", lambda: os.fork() and os._exit(0)),
    "fork in C, and the parent dies": ("worker_lost", lambda: (_native_fork(), os._exit(1))),
    "leave a program": (None, lambda: subprocess.Popen(SLEEP)),
    "leave a program with open descriptors": (None, lambda: subprocess.Popen(SLEEP, close_fds=False)),
    "leave a program that writes": (None, lambda: subprocess.Popen(WRITE)),
    "leave a daemon": (None, lambda: _daemon(lambda: time.sleep(600.0))),
    "leave a daemon that writes": (None, lambda: _daemon(lambda: _for_ever(lambda: os.write(1, b"x" * 65536)))),
    "leave a zombie": (None, lambda: subprocess.Popen([sys.executable, "-c", ""])),
    "leave a process pool": (None, lambda: kept.append(multiprocessing.get_context("fork").Pool(2))),
    # threads
    "leave a thread": (None, lambda: _thread(lambda: time.sleep(600.0))),
    "leave a thread that writes": (None, lambda: _thread(lambda: _for_ever(lambda: os.write(1, b"x" * 4096)))),
    "leave a thread that computes": (None, lambda: _thread(lambda: _for_ever(lambda: sum(range(1000))))),
    "a thread that raises": (None, lambda: threading.Thread(target=lambda: 1 / 0).start()),
    # the connection to the worker
    "write to the connection": ("worker_lost", lambda: _write_to_sockets(b"\0" * 32)),
    "write JSON to the connection": ("worker_lost", lambda: _write_to_sockets(b'{"results": []}' * 4)),
    "write a frame's beginning": ("worker_lost", lambda: _write_to_sockets(b"geoswarm" + b"\xff" * 40)),
    "write a foreign frame": (
        "worker_lost",
        lambda: _write_to_sockets(b"geoswarm" + bytes(8) + bytes(8) + bytes(8) + b"\0\0\0\2" + bytes(4) + b"{}"),
    ),
    "close the connection": ("worker_lost", lambda: [os.close(descriptor) for descriptor in _sockets()]),
    "close every descriptor": ("worker_lost", lambda: os.closerange(3, 4096)),
    "close the standard streams": (None, lambda: [_close(number) for number in (0, 1, 2)]),
    "close Python's streams": (None, lambda: (sys.stdout.close(), sys.stderr.close())),
    "redirect the output": (None, lambda: os.dup2(os.open(os.devnull, os.O_WRONLY), 1)),
    # ends
    "leave at once": ("worker_lost", lambda: os._exit(0)),
    "crash": ("worker_lost", lambda: os.kill(os.getpid(), signal.SIGSEGV)),
    "abort": ("worker_lost", os.abort),
    "kill itself": ("worker_lost", lambda: os.kill(os.getpid(), signal.SIGKILL)),
    "terminate itself": ("worker_lost", lambda: os.kill(os.getpid(), signal.SIGTERM)),
    "kill its group": ("worker_lost", lambda: os.killpg(0, signal.SIGKILL)),
    "read a wrong address": ("worker_lost", lambda: ctypes.string_at(8)),
    "exit": ("bad_output", lambda: sys.exit("enough")),
    "raise KeyboardInterrupt": ("bad_output", lambda: _raise(KeyboardInterrupt())),
    "raise an error of its own": ("bad_output", lambda: _raise(OwnError("own"))),
    "raise what cannot be printed": ("bad_output", lambda: _raise(SilentError())),
    "raise with a long message": ("bad_output", lambda: _raise(ValueError("x" * 10**7))),
    "raise with odd characters": ("bad_output", lambda: _raise(ValueError("\0\x1b[31m\udcff"))),
    "recurse without end": ("bad_output", _deep),
    "diverge": ("diverged", lambda: _raise(DivergedError("no equilibrium"))),
    "run out of memory": ("killed_memory", lambda: _raise(MemoryError())),
    # stops and time
    "stop itself": (None, lambda: os.kill(os.getpid(), signal.SIGSTOP)),
    "stop the fork server": (None, lambda: os.kill(os.getppid(), signal.SIGSTOP)),
    "kill the fork server": ("worker_lost", lambda: (os.kill(os.getppid(), signal.SIGKILL), time.sleep(600.0))),
    "hang": ("timeout", lambda: time.sleep(600.0)),
    "hang in C with every signal blocked": (
        "timeout",
        lambda: (signal.pthread_sigmask(signal.SIG_BLOCK, range(1, 32)), ctypes.CDLL(None).sleep(600)),
    ),
    "write without end": ("timeout", lambda: _for_ever(lambda: os.write(1, b"x" * 65536))),
    "eat memory": ("killed_memory", lambda: _for_ever(lambda: (kept.append(_allocate(8)), time.sleep(0.002)))),
    "eat memory in a child": (
        "killed_memory",
        lambda: (
            _fork(lambda: _for_ever(lambda: (kept.append(_allocate(8)), time.sleep(0.002)))),
            time.sleep(600.0),
        ),
    ),
    # what stays in the process
    "leak memory": (None, lambda: kept.append(_allocate(60))),
    "leak descriptors": (None, _leak_descriptors),
    "use up the descriptors": (None, lambda: _once(_exhaust_descriptors)),
    "lower a limit": (None, lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (16, 16))),
    "lower a limit to nothing": (None, lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (3, 3))),
    "end behind its answer": ("worker_lost", lambda: setattr(Traces, "of_many", lambda _: os._exit(7))),
    "note a place beyond the last, and leave": (
        "worker_lost",
        lambda: [(state.begin(10**6), os._exit(0)) for state in gc.get_objects() if isinstance(state, SharedState)],
    ),
    "change directory and environment": (None, _change_directory),
    "be nice": (None, lambda: os.nice(5)),
    "change the locale of errors": (None, lambda: (warnings.simplefilter("error"), np.seterr(all="raise"))),
    "ignore its children": (None, lambda: signal.signal(signal.SIGCHLD, signal.SIG_IGN)),
    "catch every signal": (
        None,
        lambda: [signal.signal(number, signal.SIG_IGN) for number in (1, 2, 3, 13, 15)],
    ),
    "switch the collector off": (None, lambda: (gc.disable(), gc.freeze())),
    "replace the streams": (None, lambda: setattr(sys, "stdout", io.StringIO())),
    "set an alarm": (None, lambda: (signal.signal(signal.SIGALRM, signal.SIG_IGN), signal.alarm(1))),
    "listen on a port": (None, lambda: kept.append(socket.create_server(("127.0.0.1", 0)))),
    "hold a fault handler": (None, lambda: faulthandler.enable(file=kept.append(open(os.devnull, "w")) or kept[-1])),  # noqa: PTH123, SIM115
}
ANSWERS: dict[str, tuple[str | None, Callable[[Answer], Any]]] = {
    "answer with nothing": ("bad_output", lambda _: None),
    "answer with a complex number": ("bad_output", lambda answer: {k: v + 1j for k, v in answer.items()}),
    "answer with too few values": ("bad_output", lambda answer: {k: v[1:] for k, v in answer.items()}),
    "answer with too many values": ("bad_output", lambda answer: {k: np.ones(10**6) for k in answer}),
    "answer with NaN": ("not_finite", lambda answer: {k: v * np.nan for k, v in answer.items()}),
    "answer with another series": ("bad_output", lambda answer: {"z": answer["y"]}),
    "answer with one series more": (None, lambda answer: answer | {"z": object()}),
    "answer with texts": ("bad_output", lambda answer: {k: ["a"] * len(v) for k, v in answer.items()}),
    "answer with lists": (None, lambda answer: {k: v.tolist() for k, v in answer.items()}),
    "answer with half precision": (None, lambda answer: {k: v.astype(np.float16) for k, v in answer.items()}),
    "answer with what never ends": ("timeout", lambda answer: dict.fromkeys(answer, Endless())),
    "answer in the same array": (None, lambda answer: {k: _overwritten(v) for k, v in answer.items()}),
}
REASONS: dict[str, str | None] = {name: reason for name, (reason, _) in {**BEHAVIOURS, **ANSWERS}.items()}
"""Behaviour -> reason of the failed evaluation, None: it does not fail."""

buffer = np.zeros(3)


def _overwritten(values: FloatArray) -> FloatArray:
    buffer[:] = values
    return buffer


class BadSpec(ForwardModelSpec):
    """Misbehaves on request.

    Parameters
    ----------
    builds
        What happens while it is built, every time: ``crash``, ``hang``, ``raise``, ``eat``, ``end workers``.
    """

    kind: Literal["bad"] = "bad"
    behaviour: str = "good"
    builds: str = ""

    def build(self) -> BadModel:
        """Build it."""
        match self.builds:
            case "crash":
                os.kill(os.getpid(), signal.SIGSEGV)
            case "end workers":
                if "geoswarm.workers.hosts.embedded_worker" in sys.modules:
                    os._exit(7)
            case "hang":
                time.sleep(600.0)
            case "raise":
                raise SilentError
            case "eat":
                _for_ever(lambda: (kept.append(_allocate(8)), time.sleep(0.002)))
        return BadModel(self.behaviour)


class BadModel:
    """y = slope * x, with some misbehaviour."""

    open_parameters = False
    parameters = (ParameterInfo("slope", "slope", "", "slope"),)
    series = (SeriesInfo("y", "a line", "x", "dimensionless", "y", "dimensionless"),)

    def __init__(self, behaviour: str) -> None:
        self._behaviour = behaviour

    def grid(self, series: str) -> FloatArray:  # noqa: ARG002
        return np.arange(3.0)

    def check(self, parameters: Mapping[str, float]) -> str | None:  # noqa: ARG002
        return None

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        def run(values: Mapping[str, float]) -> Any:
            slope = values["slope"]
            answer = {name: slope * x for name, x in points.items()}
            if slope <= 0.0 or self._behaviour == "good":
                return answer
            if self._behaviour in ANSWERS:
                return ANSWERS[self._behaviour][1](answer)
            BEHAVIOURS[self._behaviour][1]()
            return answer

        return run
