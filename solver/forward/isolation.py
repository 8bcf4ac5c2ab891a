"""Runs that may end their process: they are made in a process of their own where there is not one already.

Evaluations of a calibration are made in evaluation processes (:mod:`geoswarm.solver.runner`), which may die of them. A
single run elsewhere (``geoswarm evaluate``, ``check``, a sensitivity, Python) is made in a copy of the process that
wants it, and so is each run of a routine that keeps state, everywhere. On systems without ``fork`` there is none.
"""

from __future__ import annotations

import faulthandler
import json
import os
import selectors
import signal
import sys
import warnings
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import DivergedError, ForwardError, in_words, message_of
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.forward.base import ForwardRun
from geoswarm.solver.system.processes import adopts_orphans, die_with_parent
from geoswarm.solver.user_laws.law import UserLaw

__all__ = ["run_isolated"]

_LINUX = sys.platform == "linux"
_MOST_LINES = 100
"""Of what the routines of one run print, the last ones, that are shown."""
_CHUNK = 65536


def run_isolated(run: ForwardRun, laws: Sequence[UserLaw]) -> ForwardRun:
    """Return the same run, with the laws' troubles in its messages, where it can harm nothing.

    Parameters
    ----------
    run
        A forward calculation.
    laws
        Those of libraries that it calls; none: it is returned as it is.
    """
    if not laws:
        return run
    stateful = any(law.section.stateful for law in laws)

    def told(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
        for law in laws:
            law.forget_troubles()
        try:
            return run(parameters)
        except DivergedError as error:
            raise DivergedError(f"{error}{''.join(law.troubles() for law in laws)}") from None

    def calculate(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
        if not _LINUX or (adopts_orphans() and not stateful):
            return told(parameters)
        return _in_a_copy(told, parameters)

    return calculate


def _in_a_copy(run: ForwardRun, parameters: Mapping[str, float]) -> dict[str, FloatArray]:
    """Make a run in a copy of this process; raises ForwardError."""
    sys.stdout.flush()
    sys.stderr.flush()
    receiving, sending = os.pipe()
    reading, printing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads: the copy calls compiled code and writes
        pid = os.fork()
    if pid == 0:
        try:
            die_with_parent()
            os.close(receiving)
            os.close(reading)
            faulthandler.disable()  # the process that waits for this copy reports a crash
            os.dup2(printing, 1)  # what a routine prints is no part of the answer of a command
            os.dup2(printing, 2)
            os.close(printing)
            _write(sending, _answer(run, parameters))
            os.close(sending)
        finally:
            os._exit(0)
    os.close(sending)
    os.close(printing)
    try:
        answer = _read(receiving, reading)
    except BaseException:  # an interrupt
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        raise
    _, status = os.waitpid(pid, 0)
    return _understood(answer, status)


def _answer(run: ForwardRun, parameters: Mapping[str, float]) -> bytes:
    """The response, or why there is none: a line of JSON, and the numbers behind it."""
    head: dict[str, object]
    try:
        found = run(parameters)
        head = {"series": {name: int(y.size) for name, y in found.items()}}
        body = b"".join(np.asarray(y, dtype="<f8").tobytes() for y in found.values())
    except ForwardError as error:
        head, body = {"reason": error.reason, "message": message_of(error)}, b""
    except MemoryError:
        head, body = {"reason": "killed_memory", "message": "the forward model ran out of memory"}, b""
    except BaseException as error:  # noqa: BLE001  a fault of ours: told as the failure of one run
        head, body = {"reason": "bad_output", "message": f"the forward model raised {in_words(error)}"}, b""
    return json.dumps(head).encode() + b"\n" + body + b"."


def _read(answering: int, printing: int) -> bytes:
    """The answer of a copy; the last lines that its routines print go to the standard error of this process."""
    answer, lines, count, rest = bytearray(), deque[bytes](maxlen=_MOST_LINES), 0, b""
    with selectors.DefaultSelector() as selector, ExitStack() as closing:
        for descriptor in (answering, printing):
            selector.register(descriptor, selectors.EVENT_READ)
            closing.callback(os.close, descriptor)
        while selector.get_map():
            for key, _ in selector.select():
                part = os.read(key.fd, _CHUNK)
                if not part:
                    selector.unregister(key.fd)
                elif key.fd == answering:
                    answer += part
                else:
                    *whole, rest = (rest + part).split(b"\n")
                    rest = rest[-_CHUNK:]
                    lines.extend(whole)
                    count += len(whole)
    printed = b"".join(line + b"\n" for line in [*lines, *([rest] if rest else [])])
    left_out = f"... {count - len(lines)} lines of the routine before these\n" if count > len(lines) else ""
    with suppress(OSError):  # a closed standard error loses what was printed, not the answer
        _write(2, left_out.encode() + printed)
    return bytes(answer)


def _write(descriptor: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


def _understood(answer: bytes, status: int) -> dict[str, FloatArray]:
    line, _, body = answer.partition(b"\n")
    if status != 0 or not body.endswith(b"."):
        code = os.waitstatus_to_exitcode(status)
        how = f"by {signal.Signals(-code).name}" if code < 0 else f"with exit status {code}"
        raise RunFailedError("worker_lost", f"the routine ended its process {how}")
    head = json.loads(line)
    if "reason" in head:
        raise RunFailedError(head["reason"], head["message"])
    numbers = np.frombuffer(body[:-1], dtype="<f8")
    found, first = {}, 0
    for name, count in head["series"].items():
        found[name] = numbers[first : first + count].astype(np.float64)
        first += count
    return found
