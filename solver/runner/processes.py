"""Process trees: who belongs to one, how much memory it uses, and its end. Linux tells all; elsewhere less is known."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
import time
from pathlib import Path

__all__ = [
    "adopt_orphans",
    "descendants",
    "die_with_parent",
    "go_first_without_memory",
    "kill_descendants",
    "kill_session",
    "memory_below",
    "memory_of",
    "reap",
    "wake_with_parent",
]

PROC = Path("/proc")
PR_SET_PDEATHSIG = 1
PR_SET_CHILD_SUBREAPER = 36
KILL_SECONDS = 1.5
MIB = 1024.0 * 1024.0
PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096


def adopt_orphans() -> None:
    """Become the parent of all descendants whose parent dies, so that none is lost from sight (Linux)."""
    _prctl(PR_SET_CHILD_SUBREAPER, 1)


def die_with_parent() -> None:
    """Ask the kernel for SIGKILL when the parent dies (Linux)."""
    _prctl(PR_SET_PDEATHSIG, int(signal.SIGKILL))


def wake_with_parent() -> None:
    """Ask the kernel for SIGCONT when the parent dies: who was stopped then sees that it is alone (Linux)."""
    _prctl(PR_SET_PDEATHSIG, int(signal.SIGCONT))


def go_first_without_memory() -> None:
    """Ask the kernel to choose this process when memory runs out (Linux)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")


def _prctl(option: int, value: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0)


def _stat(pid: str) -> list[str] | None:
    """Return the fields of /proc/PID/stat that follow the name: state, parent, group, session, ..."""
    try:
        return (PROC / pid / "stat").read_text(errors="replace").rpartition(")")[2].split()
    except (OSError, ValueError):
        return None


def descendants(pid: int) -> list[int]:
    """Return the processes below one, children before grandchildren; zombies are left out."""
    found: list[int] = []
    parents = [pid]
    while parents:
        below = [child for parent in parents for child in _children(parent)]
        found += [child for child in below if (fields := _stat(str(child))) is not None and fields[0] != "Z"]
        parents = below
    return found


def _children(pid: int) -> list[int]:
    try:
        threads = os.listdir(PROC / str(pid) / "task")  # noqa: PTH208  names, many times a second
        return [
            int(child)
            for thread in threads
            for child in (PROC / str(pid) / "task" / thread / "children").read_text().split()
        ]
    except FileNotFoundError:
        if (PROC / "self" / "task" / str(os.getpid()) / "children").exists():
            return []  # the process is gone
    except OSError:
        return []
    # A kernel without these lists: look at all processes.
    stats = ((int(name), _stat(name)) for name in _process_names())
    return [child for child, fields in stats if fields is not None and int(fields[1]) == pid]


def _process_names() -> list[str]:
    try:
        return [name for name in os.listdir(PROC) if name.isdigit()]  # noqa: PTH208  names, a hundred times a second
    except OSError:
        return []


def kill_descendants(pid: int) -> dict[int, int]:
    """Kill all processes below this one and return the wait status of those that were its own children.

    What forks while it is being killed is found in the next round; after 1.5 s the rest is left to itself (it hangs in
    the kernel, and dies when it comes back).
    """
    ended: dict[int, int] = {}
    deadline = time.monotonic() + KILL_SECONDS
    while True:
        alive = descendants(pid)
        for child in alive:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(child, signal.SIGKILL)
        ended |= reap()
        if not alive or time.monotonic() > deadline:
            return ended
        time.sleep(0.002)


def reap() -> dict[int, int]:
    """Collect the ended children of this process: wait status by pid."""
    ended: dict[int, int] = {}
    with contextlib.suppress(ChildProcessError):
        while True:
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                break
            ended[pid] = status
    return ended


def kill_session(session: int) -> None:
    """Kill all processes of a session whose leader is gone."""
    for name in _process_names():
        fields = _stat(name)
        if fields is not None and int(fields[3]) == session and fields[0] != "Z":
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(int(name), signal.SIGKILL)


def memory_below(pid: int) -> float:
    """Return the memory [MiB] of all processes below one; pages that several share are counted once."""
    return sum(_proportional(child) for child in descendants(pid)) / MIB


def memory_of(pid: int) -> float:
    """Return the resident memory [MiB] of a process, shared pages included; quicker than to share them out."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        return int((PROC / str(pid) / "statm").read_text().split()[1]) * PAGE / MIB
    return 0.0


def _proportional(pid: int) -> float:
    """Return the proportional set size of a process [byte], 0 when it is gone or nothing is known."""
    with contextlib.suppress(OSError, ValueError):
        for line in (PROC / str(pid) / "smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                return float(line.split()[1]) * 1024.0
    return 0.0
