"""The fork server: forks evaluation processes from a warm state, and sees that nothing outlives them.

It is a process of its own between a worker and the evaluations. It is single-threaded, so that a fork is safe, and it
adopts what its descendants leave behind, so that even a forward model whose children run away (new session, double
fork) is killed as a whole. When its worker dies, in whatever way, its socket ends, and it kills everything and ends.
"""

from __future__ import annotations

import contextlib
import gc
import logging
import os
import select
import signal
import socket
import struct
import sys
from collections.abc import Mapping
from typing import Any

from geoswarm.solver.errors import SolverError
from geoswarm.solver.forward.registry import find_spec
from geoswarm.solver.runner.output import shorten
from geoswarm.solver.system.processes import (
    adopt_orphans,
    child_program,
    die_with_parent,
    kill_descendants,
    reap,
    wake_with_parent,
)
from geoswarm.solver.warm import run_sample

__all__ = ["BOOTSTRAP", "FORK", "KERNELS", "KILL", "MODEL", "STATUS", "main"]

log = logging.getLogger(__name__)

BOOTSTRAP = child_program("geoswarm.solver.runner.fork_server", "sys.argv[1]")
FORK = b"f"
KILL = b"k"
KERNELS = b"l"
MODEL = b"m"
"""Ask to load a group of kernels, or a kind of forward model; its name follows behind its length in one byte."""
STATUS = struct.Struct("=ii")
"""Its answer, a number and whether it is known.

To a fork: the number of the new process, beside its descriptor, or that of the error. To a kill: the exit code of the
evaluation process (below 0: the signal that ended it).
"""

REAP_SECONDS = 2.0
OUTPUT_SECONDS = 0.1


def main(given: Mapping[str, Any]) -> None:
    """Serve one worker over the socket whose descriptor is ``given``, until it closes."""
    # What all evaluation processes need is loaded here, and what those of a job need when the job is known.
    from geoswarm.solver.runner import child

    adopt_orphans()
    wake_with_parent()
    for number in (signal.SIGINT, signal.SIGTERM):  # its worker decides about its end
        signal.signal(number, signal.SIG_IGN)
    logging.basicConfig(level=logging.WARNING)
    for message, name in given["loaded"]:
        _load(message.encode(), name)
    control = socket.socket(fileno=given["control"])
    ended: dict[int, int] = {}
    current, output = 0, -1
    poll = select.poll()
    poll.register(control, select.POLLIN)
    while True:
        ready = poll.poll(1000.0 * (OUTPUT_SECONDS if current else REAP_SECONDS))
        ended |= reap()
        if output >= 0:
            shorten(output)
        if not ready:
            ended = {pid: status for pid, status in ended.items() if pid == current}
            continue
        try:
            message, descriptors, _, _ = socket.recv_fds(control, 1, 3)
        except ConnectionResetError:
            message, descriptors = b"", []
        passed: list[int] = []
        if message == FORK:
            connection, new_output, shared = descriptors
            try:
                gc.freeze()  # what is here stays, also in what is forked: shared, and not searched for garbage
                current = os.fork()
                if current == 0:
                    control.close()
                    _become_child(child.serve, *descriptors)
                passed = _process_descriptor(current)
                answer = STATUS.pack(current, 1)
            except OSError as error:  # no process to be had
                current = 0
                answer = STATUS.pack(error.errno or 0, 0)
            for descriptor in (connection, shared, output):  # the output stays open: it is kept short here
                if descriptor >= 0:
                    os.close(descriptor)
            output = new_output
            ended = {}
        elif message in (KERNELS, MODEL):
            _load(message, control.recv(control.recv(1)[0]).decode())
            answer = STATUS.pack(0, 0)
        else:
            ended |= kill_descendants(os.getpid())
            status = ended.get(current)
            current = 0
            code = 0 if status is None else os.waitstatus_to_exitcode(status)
            answer = STATUS.pack(code, int(status is not None))
        if not message:
            os._exit(0)
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            socket.send_fds(control, [answer], passed)
        for descriptor in passed:
            os.close(descriptor)


def _load(message: bytes, name: str) -> None:
    """Load kernels or a forward model, which all processes forked after that have."""
    if message == KERNELS:
        run_sample(name)
        return
    try:
        find_spec(name)
    except SolverError as error:  # the jobs that name it will say so
        log.warning("%s", error)


def _process_descriptor(pid: int) -> list[int]:
    """Return a descriptor that is ready when a child has ended, if the system has such."""
    if sys.platform != "linux":
        return []
    try:
        return [os.pidfd_open(pid)]
    except OSError:
        return []


def _become_child(serve: Any, connection: int, output: int, memory: int) -> None:
    """Turn this fork into an evaluation process; does not return."""
    from geoswarm.solver.runner.shared_state import SharedState

    code = 1
    try:
        die_with_parent()
        adopt_orphans()  # what its forward models leave behind is its own, and seen after the run
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_DFL)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        for standard in (1, 2):
            os.dup2(output, standard)
        os.close(output)
        shared = SharedState(memory, new=False)
        os.close(memory)
        serve(socket.socket(fileno=connection), shared)
        code = 0
    except BaseException:
        log.exception("the evaluation process ends")
    finally:
        sys.stderr.flush()
        os._exit(code)
