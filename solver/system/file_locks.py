"""Locks of files that processes hold while they write, where the system has them."""

from __future__ import annotations

from typing import IO, Any

__all__ = ["try_lock"]


def try_lock(file: IO[Any]) -> bool:
    """Keep other processes from locking an open file until it is closed; False where another process holds it.

    True also where nothing can be locked: on file systems without locks.
    """
    try:
        import fcntl
    except ImportError:
        return _try_windows_lock(file)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


def _try_windows_lock(file: IO[Any]) -> bool:
    """Lock the first byte, which need not be there; the system frees it with the process."""
    try:
        import msvcrt
    except ImportError:
        return True
    file.seek(0)
    try:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined, unused-ignore]  # Windows only
    except OSError:
        return False
    return True
