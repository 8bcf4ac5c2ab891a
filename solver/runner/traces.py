"""What a run has left in its process: a process that shows any of it makes no further run."""

from __future__ import annotations

import os
import resource
import sys
import threading

__all__ = ["Traces"]

MANY_DESCRIPTORS = 100


class Traces:
    """Compares a process with what it was when this was made.

    Threads of numerical libraries, which start theirs once and keep them, are no trace.
    """

    def __init__(self) -> None:
        self._threads = threading.active_count()
        self._descriptors = _descriptors()
        self._most_descriptors = resource.getrlimit(resource.RLIMIT_NOFILE)

    def of_run(self) -> str | None:
        """Return what a run left that still acts: processes, threads or a limit; None: nothing. Costs microseconds."""
        if _has_children():
            return "processes"
        if resource.getrlimit(resource.RLIMIT_NOFILE) != self._most_descriptors:
            return "another limit of open files"
        return "threads" if threading.active_count() > self._threads else None

    def of_many(self) -> str | None:
        """Return what many runs have left between them: open files."""
        return "open files" if _descriptors() > self._descriptors + MANY_DESCRIPTORS else None


def _has_children() -> bool:
    """Whether this process has children, ended ones that were not waited for included."""
    try:
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
    except ChildProcessError:
        return False
    return True


def _descriptors() -> int:
    if sys.platform != "linux":
        return 0
    try:
        return len(os.listdir("/proc/self/fd"))  # noqa: PTH208  names, after each request
    except OSError:  # none is left to look with
        return sys.maxsize
