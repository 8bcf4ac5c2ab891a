"""The file without a name that takes what forward models write to their standard output and error."""

from __future__ import annotations

import os
import sys
import tempfile

__all__ = ["LOG_TAIL", "OwnOutput", "anonymous_file", "shorten", "tail"]

LOG_TAIL = 8192  # bytes kept of a failed evaluation
LARGEST = 16 * 2**20  # bytes


def anonymous_file() -> int:
    """Return the descriptor of a file without a name, in memory where the system can (a full disk does not matter)."""
    if sys.platform == "linux":
        return os.memfd_create("geoswarm")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())


def tail(descriptor: int) -> str | None:
    """Return the end of what was written to a file; None when that is nothing."""
    size = os.fstat(descriptor).st_size
    data = os.pread(descriptor, LOG_TAIL, max(size - LOG_TAIL, 0))
    return data.decode("utf-8", "replace").replace("\x00", "") or None


class OwnOutput:
    """The standard output of an evaluation process, as long as its descriptor is still what it was."""

    def __init__(self, descriptor: int = 1) -> None:
        self._descriptor = descriptor
        self._identity = self._look()

    def clear(self) -> None:
        """Forget what was written."""
        if self._there() and os.fstat(self._descriptor).st_size:
            os.ftruncate(self._descriptor, 0)

    def tail(self) -> str | None:
        """Return the end of what was written; None when that is nothing, or cannot be known."""
        return tail(self._descriptor) if self._there() else None

    def _there(self) -> bool:
        """A forward model may have closed it, and opened a file of its own under its number."""
        return self._identity is not None and self._look() == self._identity

    def _look(self) -> tuple[int, int] | None:
        try:
            found = os.fstat(self._descriptor)
        except OSError:
            return None
        return found.st_dev, found.st_ino


def shorten(descriptor: int) -> None:
    """Keep only the end of a file that has become too large, while others write to it."""
    if os.fstat(descriptor).st_size > LARGEST:
        end = tail(descriptor) or ""
        os.ftruncate(descriptor, 0)
        os.write(descriptor, end.encode())
