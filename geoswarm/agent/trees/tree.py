"""Starts a process whose whole tree can be killed: below a keeper on POSIX, in a job object on Windows, else alone."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from typing import IO, Protocol

import psutil

from geoswarm.agent.trees.job_object import JobObject, has_job_objects
from geoswarm.agent.trees.keeper import ENDING, ENDING_SECONDS
from geoswarm.solver.system.processes import child_program, memory_below, memory_of

__all__ = ["Tree", "kill_all_below", "start_tree"]

END_SECONDS = ENDING_SECONDS + 5.0
KILL_SECONDS = 3.0
KEEPER = child_program("geoswarm.agent.trees.keeper", "sys.argv[1]")


class Tree(Protocol):
    """A process, with pipes to its standard input and output, and all that it starts."""

    requests: IO[bytes]
    answers: IO[bytes]
    """Closed by the reader, at their end: it comes when all is killed."""

    def memory_mb(self) -> float:
        """Memory of the process and all that it has started [MiB]."""

    def kill(self, *, ending: bool = False) -> int | None:
        """Kill all of it; return the exit code of the process (below 0: the signal), or None if it is not known.

        ``ending``: its answers have ended, so that it is about to end by itself. Its pipes close before its exit code
        is available, so this waits for the code first, for a limited time.
        """


def start_tree(arguments: Sequence[str], environment: Mapping[str, str]) -> Tree:
    """Start a process, in the way of this system.

    Raises
    ------
    OSError
        The system has no process to spare.
    """
    if has_job_objects():
        return _Plain(arguments, environment, JobObject())
    if hasattr(os, "killpg") and hasattr(os, "setsid"):
        return _Kept(arguments, environment)
    return _Plain(arguments, environment, None)


def kill_all_below(pid: int) -> None:
    """Kill every process below one, however long new ones appear."""
    deadline = time.monotonic() + KILL_SECONDS
    while time.monotonic() < deadline:
        with contextlib.suppress(psutil.Error):
            below = psutil.Process(pid).children(recursive=True)
            alive = [one for one in below if _alive(one)]
            for one in alive:
                with contextlib.suppress(psutil.Error):
                    one.kill()
            if alive:
                time.sleep(0.01)
                continue
        return


def _alive(process: psutil.Process) -> bool:
    try:
        return bool(process.status() != psutil.STATUS_ZOMBIE)
    except psutil.Error:
        return False


class _Kept:
    """Below a keeper (POSIX)."""

    def __init__(self, arguments: Sequence[str], environment: Mapping[str, str]) -> None:
        read_requests, write_requests = os.pipe()
        read_answers, write_answers = os.pipe()
        given = {"path": sys.path, "run": list(arguments), "in": read_requests, "out": write_answers}
        try:
            self._keeper = subprocess.Popen(
                [sys.executable, "-c", KEEPER, json.dumps(given)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=dict(environment),
                pass_fds=(read_requests, write_answers),
                start_new_session=True,  # signals of a terminal or a batch system are for the agent
            )
        except OSError:
            for end in (write_requests, read_answers):
                os.close(end)
            raise
        finally:
            for end in (read_requests, write_answers):
                os.close(end)
        self.requests: IO[bytes] = os.fdopen(write_requests, "wb", buffering=0)
        self.answers: IO[bytes] = os.fdopen(read_answers, "rb")

    def memory_mb(self) -> float:
        return memory_below(self._keeper.pid)

    def kill(self, *, ending: bool = False) -> int | None:
        stdin, self._keeper.stdin = self._keeper.stdin, None
        if ending and stdin is not None:
            with contextlib.suppress(OSError, ValueError):
                stdin.write(ENDING)
        for end in (stdin, self.requests):
            if end is not None:
                with contextlib.suppress(OSError, ValueError):
                    end.close()
        told = b""
        try:
            told, _ = self._keeper.communicate(timeout=END_SECONDS)
        except (subprocess.TimeoutExpired, ValueError, OSError):  # it was stopped, or hangs
            kill_all_below(self._keeper.pid)
            self._keeper.kill()
            self._keeper.wait()
            if self._keeper.stdout is not None:
                self._keeper.stdout.close()
        try:
            code = json.loads(told)["code"]
        except (ValueError, KeyError, TypeError):
            return None
        return None if code is None else int(code)


class _Plain:
    """Alone: its tree is found by the parents of processes, and on Windows by its job object."""

    def __init__(self, arguments: Sequence[str], environment: Mapping[str, str], job: JobObject | None) -> None:
        self._job = job
        self._process = subprocess.Popen(
            list(arguments),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=dict(environment),
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        if job is not None:
            job.add(self._process.pid)
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self.requests: IO[bytes] = self._process.stdin
        self.answers: IO[bytes] = self._process.stdout

    def memory_mb(self) -> float:
        return memory_of(self._process.pid) + memory_below(self._process.pid)

    def kill(self, *, ending: bool = False) -> int | None:
        code = self._process.poll()
        if ending:
            with contextlib.suppress(subprocess.TimeoutExpired):
                code = self._process.wait(ENDING_SECONDS)
        kill_all_below(self._process.pid)
        if self._job is not None:
            self._job.close()
        with contextlib.suppress(OSError):
            self._process.kill()
        self._process.wait()
        with contextlib.suppress(OSError, ValueError):
            self.requests.close()
        return code
