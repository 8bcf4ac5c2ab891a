"""Starts a program, waits for it within a limit, and ends everything that it has started."""

from __future__ import annotations

import contextlib
import os
import queue
import secrets
import select
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import psutil

from geoswarm.solver.system.processes import adopts_orphans, descendants, kill_session

__all__ = ["Ended", "NotStartedError", "run_program"]

TAIL = 16 * 1024
"""Last bytes of what a program prints that are kept for a message."""

MOST_OUTPUT, END = 4 * 1024 * 1024, 1024 * 1024
"""First and last bytes of what a program prints that are written to its file."""

MARK = "GEOSWARM_RUN"
"""Variable by which what a run has started is known."""

_ONCE = 64 * 1024  # what a pipe holds
_READS, _LAST_READS = 64, 4096  # before the limit of time is looked at; after the end
_KILL_SECONDS = 1.5
_LOOK_SECONDS = 0.02  # where the system does not tell that a process has ended


class NotStartedError(Exception):
    """A program cannot be started: it is missing, or may not be executed."""


@dataclass(frozen=True, slots=True)
class Ended:
    """How a program has ended.

    Parameters
    ----------
    status
        Exit status; minus the number of the signal that ended it; None: it was killed at its limit.
    tail
        The last of what it printed.
    seconds
        Wall time [s].
    """

    status: int | None
    tail: str
    seconds: float

    @property
    def words(self) -> str:
        """How it ended, in words."""
        if self.status is None:
            return f"was killed after {self.seconds:.3g} s"
        if self.status < 0:
            return f"was ended by {_signal_name(-self.status)}"
        return f"ended with exit status {self.status}"


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def run_program(
    arguments: Sequence[str],
    folder: Path,
    environment: Mapping[str, str],
    seconds: float | None,
    output: Path,
) -> Ended:
    """Run a program in a folder, without a shell and without input.

    Parameters
    ----------
    arguments
        The program and its arguments. A program without a slash is looked for on the environment's ``PATH``, one with
        a slash in the folder.
    seconds
        Wall time after which it is killed with all that it has started; None: any.
    output
        File for the first 4 MiB and the last MiB of what it prints; what lies between is read and dropped.

    Raises
    ------
    NotStartedError
        The program is missing or cannot be executed; the message says which.
    """
    program = _found(arguments[0], folder, environment)
    began, mark = time.monotonic(), secrets.token_hex(8)
    try:
        process = subprocess.Popen(
            [program, *arguments[1:]],
            cwd=folder,
            env={**environment, MARK: mark},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    except OSError as error:
        raise NotStartedError(f"{arguments[0]} cannot be started: {error.strerror or error}") from None
    except BaseException:  # an interrupt while it starts
        _kill_marked(mark)
        raise
    with output.open("wb") as file:
        printed = _Printed(file)
        try:
            ended = _watched(process, mark, began, seconds, printed)
        except BaseException:  # also an interrupt
            _kill_tree(process, mark)
            raise
        finally:
            if process.stdout is not None:
                process.stdout.close()
            tail = printed.finish()
    return Ended(process.returncode if ended else None, tail, time.monotonic() - began)


def _found(program: str, folder: Path, environment: Mapping[str, str]) -> str:
    """The path of a program."""
    if os.sep in program or (os.altsep and os.altsep in program):
        path = folder / program
        if not path.exists():
            raise NotStartedError(f"{program} is not in the run folder; list it under files to have it copied there")
        if not os.access(path, os.X_OK):
            raise NotStartedError(f"{program} is not executable; use chmod +x, or name its interpreter first")
        return str(path)
    found = shutil.which(program, path=environment.get("PATH"))
    if found is None:
        if (folder / program).exists():
            raise NotStartedError(f"{program} is in the run folder, but not on PATH; write ./{program}")
        raise NotStartedError(f"{program} was not found on PATH; install it, or give its whole path")
    return found


def _watched(
    process: subprocess.Popen[bytes], mark: str, began: float, seconds: float | None, printed: _Printed
) -> bool:
    """Take in what a program prints until it ends; False when it was killed at its limit."""
    assert process.stdout is not None
    pipe = process.stdout.fileno()
    if not hasattr(os, "set_blocking") or sys.platform == "win32":
        return _watched_by_thread(process, pipe, mark, began, seconds, printed)
    os.set_blocking(pipe, False)
    deadline = None if seconds is None else began + seconds
    with _PidDescriptor(process.pid) as ended:
        waiting = select.poll() if hasattr(select, "poll") else None
        if waiting is not None:
            waiting.register(pipe, select.POLLIN)
            if ended is not None:
                waiting.register(ended, select.POLLIN)
        is_open = True
        while True:
            left = None if deadline is None else deadline - time.monotonic()
            if left is not None and left <= 0.0:
                _kill_tree(process, mark)
                return False
            pause = left if ended is not None else min(_LOOK_SECONDS, left or _LOOK_SECONDS)
            if waiting is None:
                time.sleep(_LOOK_SECONDS)
            else:
                waiting.poll(None if pause is None else 1000.0 * pause)
            over = process.poll() is not None
            if over:
                _kill_rest(process.pid, mark)  # first: what goes on printing would never end
            for _ in range(_READS if not over else _LAST_READS):
                data = _read(pipe) if is_open else None
                if data is None:
                    break
                if not data:
                    is_open = False
                    if waiting is not None:
                        waiting.unregister(pipe)
                    break
                printed.take(data)
            if over:
                return True


def _watched_by_thread(
    process: subprocess.Popen[bytes], pipe: int, mark: str, began: float, seconds: float | None, printed: _Printed
) -> bool:
    """Do the same where a pipe cannot be asked whether there is something to read."""
    pieces: queue.Queue[bytes] = queue.Queue(_READS)

    def read() -> None:
        with contextlib.suppress(OSError):
            while data := os.read(pipe, _ONCE):
                pieces.put(data)

    reader = threading.Thread(target=read, name="output of a program", daemon=True)
    reader.start()

    def take(most: int) -> None:
        with contextlib.suppress(queue.Empty):
            for _ in range(most):
                printed.take(pieces.get_nowait())

    while True:
        take(_READS)
        over = process.poll() is not None
        if over or (seconds is not None and time.monotonic() - began > seconds):
            (_kill_rest(process.pid, mark) if over else _kill_tree(process, mark))
            last = time.monotonic() + _KILL_SECONDS
            while reader.is_alive() and time.monotonic() < last:
                take(_READS)
                reader.join(_LOOK_SECONDS)
            take(_LAST_READS)
            return over
        time.sleep(_LOOK_SECONDS)


class _Printed:
    """What a program prints: its beginning and end in a file, its last lines for messages."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._room, self._left_out = MOST_OUTPUT, 0
        self._end = bytearray()
        self._tail = bytearray()

    def take(self, data: bytes) -> None:
        """Take what was printed next."""
        self._file.write(data[: self._room])
        self._end += data[self._room :]
        self._room = max(self._room - len(data), 0)
        self._tail += data
        del self._tail[:-TAIL]
        if len(self._end) > 2 * END:
            self._left_out += len(self._end) - END
            del self._end[:-END]

    def finish(self) -> str:
        """Write the end, and return the last lines."""
        more = len(self._end) - END
        if more > 0:
            self._left_out += more
            del self._end[:-END]
        if self._left_out:
            self._file.write(f"\n[{self._left_out} bytes are left out here]\n".encode())
        self._file.write(self._end)
        return self._tail.decode("utf-8", errors="replace")


class _PidDescriptor:
    """A descriptor that is ready when a process has ended; None where the system has none."""

    def __init__(self, pid: int) -> None:
        self._descriptor: int | None = None
        if sys.platform == "linux":
            with contextlib.suppress(OSError):
                self._descriptor = os.pidfd_open(pid)

    def __enter__(self) -> int | None:
        return self._descriptor

    def __exit__(self, *_: object) -> None:
        if self._descriptor is not None:
            os.close(self._descriptor)


def _read(pipe: int) -> bytes | None:
    """What can be read now; empty at the end, None: nothing yet."""
    try:
        return os.read(pipe, _ONCE)
    except BlockingIOError:
        return None


def _kill_tree(process: subprocess.Popen[bytes], mark: str) -> None:
    """Kill a program and all that it has started, and wait for it."""
    for pid in reversed(descendants(process.pid)):
        _kill(pid)
    process.kill()
    process.wait()
    _kill_rest(process.pid, mark)


def _kill_rest(session: int, mark: str) -> None:
    """Kill what is left of a program: its session, and in an evaluation process what has left that, by its mark."""
    _kill_session(session)
    if adopts_orphans():
        _kill_marked(mark)


def _kill_marked(mark: str) -> None:
    """Kill what stands below this process and carries the mark of a run, where marks can be read."""
    if not hasattr(os, "WNOHANG"):
        return
    killed: set[int] = set()
    deadline = time.monotonic() + _KILL_SECONDS
    while True:
        left = [pid for pid in descendants(os.getpid()) if _is_marked(pid, mark)]
        for pid in left:
            _kill(pid)
        killed.update(left)
        for pid in killed:  # orphans are ours to collect, other processes are not
            with contextlib.suppress(ChildProcessError):
                os.waitpid(pid, os.WNOHANG)
        if not left or time.monotonic() > deadline:
            return
        time.sleep(0.002)


def _kill(pid: int) -> None:
    with contextlib.suppress(psutil.Error):
        psutil.Process(pid).kill()


def _kill_session(session: int) -> None:
    if not hasattr(os, "killpg"):
        return
    try:
        os.killpg(session, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        return
    kill_session(session)  # groups of their own within the session


def _is_marked(pid: int, mark: str) -> bool:
    """Whether a process was started by a run: it has inherited the mark."""
    try:
        return f"{MARK}={mark}".encode() in Path(f"/proc/{pid}/environ").read_bytes()
    except OSError:
        return False
