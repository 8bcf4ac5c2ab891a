"""Process trees: which processes belong to one, how much memory it uses, and its end.

psutil knows that everywhere. Linux offers more (``prctl``), and lists the children of a process, which is ten times as
quick as psutil's look at all processes.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil

__all__ = [
    "adopt_orphans",
    "adopts_orphans",
    "child_program",
    "descendants",
    "die_with_parent",
    "go_first_without_memory",
    "kill_descendants",
    "kill_session",
    "memory_below",
    "memory_of",
    "reap",
    "wake_with_parent",
    "without_garbage_collection",
]

PROC = Path("/proc")
PR_SET_PDEATHSIG = 1
PR_SET_CHILD_SUBREAPER = 36
KILL_SECONDS = 1.5
MIB = 1024.0 * 1024.0
CHILDREN_ARE_LISTED = (PROC / "self" / "task" / str(os.getpid()) / "children").exists()


_adopting = 0  # process that does


def adopt_orphans() -> None:
    """Become the parent of all descendants whose parent dies, so that none is lost from sight (Linux)."""
    global _adopting
    _prctl(PR_SET_CHILD_SUBREAPER, 1)
    _adopting = os.getpid()


def adopts_orphans() -> bool:
    """Whether all that this process starts stays below it, and is there for its one purpose (Linux)."""
    return _adopting == os.getpid()


def die_with_parent() -> None:
    """Ask the kernel for SIGKILL when the parent dies (Linux)."""
    _prctl(PR_SET_PDEATHSIG, int(signal.SIGKILL))


def wake_with_parent() -> None:
    """Ask the kernel for SIGCONT when the parent dies: a stopped process then sees that it is alone (Linux)."""
    _prctl(PR_SET_PDEATHSIG, int(signal.SIGCONT))


def go_first_without_memory() -> None:
    """Ask the kernel to choose this process when memory runs out (Linux)."""
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500")


def _prctl(option: int, value: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0)


def child_program(module: str, given: str = "sys.stdin.readline()") -> str:
    """Return the text for ``python -c`` that calls ``main`` of a module with a document.

    The child takes over the import path of its parent, as geoswarm may not be installed but run from its sources. It
    looks for no garbage among what imports leave, which would take a sixth of its start.

    Parameters
    ----------
    given
        Expression for the JSON of the document, which has the import path as ``path``.
    """
    return (
        f"import gc, json, sys; gc.disable(); given = json.loads({given}); sys.path[:] = given['path'];"
        f"from {module} import main; gc.freeze(); gc.enable(); main(given)"
    )


def descendants(pid: int) -> list[int]:
    """Return the processes below one, parents before their children; zombies are left out."""
    found: list[int] = []
    if not CHILDREN_ARE_LISTED:  # a look at every process of the machine
        with contextlib.suppress(psutil.Error):
            for child in psutil.Process(pid).children(recursive=True):
                with contextlib.suppress(psutil.Error):
                    found += [child.pid] if child.status() != psutil.STATUS_ZOMBIE else []
        return found
    parents = [pid]
    while parents:
        below = [child for parent in parents for child in _children(parent)]
        found += [child for child in below if _state(child) not in ("", "Z")]
        parents = below
    return found


def _children(pid: int) -> list[int]:
    """Return the children that the kernel lists by thread: 0.1 ms, where psutil reads all processes for 1 to 2 ms."""
    found: list[int] = []
    with contextlib.suppress(OSError):
        for thread in os.listdir(PROC / str(pid) / "task"):  # noqa: PTH208  names, many times a second
            with contextlib.suppress(OSError):  # this thread has ended
                found += map(int, (PROC / str(pid) / "task" / thread / "children").read_text().split())
    return found


def _state(pid: int) -> str:
    """Return the letter of a process's state; empty when it is gone."""
    with contextlib.suppress(OSError):
        return (PROC / str(pid) / "stat").read_text(errors="replace").rpartition(")")[2].split()[0]
    return ""


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
    for pid in psutil.pids():
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if os.getsid(pid) == session:
                os.kill(pid, signal.SIGKILL)


def memory_below(pid: int) -> float:
    """Return the memory [MiB] of all processes below one; pages that several share are counted once (Linux)."""
    return sum(_proportional(child) for child in descendants(pid)) / MIB


def memory_of(pid: int) -> float:
    """Return the resident memory [MiB] of a process, shared pages included; quicker than to share them out."""
    with contextlib.suppress(psutil.Error):
        return float(psutil.Process(pid).memory_info().rss) / MIB
    return 0.0


def _proportional(pid: int) -> float:
    """Return the proportional set size of a process [byte], else its resident memory; 0 when it is gone."""
    with contextlib.suppress(psutil.Error):
        process = psutil.Process(pid)
        try:
            return float(process.memory_full_info().pss)
        except (AttributeError, psutil.AccessDenied):  # another system; a process that cannot be inspected
            return float(process.memory_info().rss)
    return 0.0


@contextmanager
def without_garbage_collection() -> Iterator[None]:
    """Look for no garbage where many small objects are made that stay: compiling takes 0.87 of the time."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
