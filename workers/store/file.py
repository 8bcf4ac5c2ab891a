"""The file of an SQLite database: readable by its owner only, and the same as long as it is open."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path
from typing import TypeAlias

from sqlalchemy.engine import make_url

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.settings import Settings

__all__ = ["DatabaseFile", "FileIdentity", "database_path", "missing_database"]

FileIdentity: TypeAlias = tuple[int, int]
"""Device and inode: what a path leads to."""


def database_path(settings: Settings) -> Path | None:
    """Return the file of an SQLite database, absolute; None for other databases."""
    url = make_url(settings.database_url)
    if url.get_backend_name() != "sqlite" or not url.database:
        return None
    return Path(url.database).expanduser().absolute()


def missing_database(settings: Settings) -> Path | None:
    """Return the missing file of an SQLite database, or None."""
    path = database_path(settings)
    return None if path is None or path.is_file() else path


class DatabaseFile:
    """An SQLite file that is open.

    Parameters
    ----------
    identity
        What it must be; None: what it is at :meth:`remember`.
    """

    def __init__(self, path: Path, identity: FileIdentity | None = None) -> None:
        self.path = path
        self.identity = identity

    def make(self) -> None:
        """Make the file for this user only, where there is none; SQLite gives its journals the same mode."""
        with contextlib.suppress(OSError):  # it is there, or SQLite reports why it cannot be made
            os.close(os.open(self.path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))

    def remember(self) -> None:
        """Remember the present file as the right one, unless one is known already."""
        if self.identity is None:
            self.identity = _identity(self.path)

    def check(self) -> None:
        """Check that the path still leads to the same file; costs a microsecond or two.

        Raises
        ------
        StoreUnavailableError
        """
        if self.identity is None:
            return
        now = _identity(self.path)
        if now != self.identity:
            what = "removed" if now is None else "replaced"
            raise StoreUnavailableError(
                f"database file {self.path} was {what} while it was in use; nothing more is read or written."
                " Stop the service, put the right file in its place, and start again"
            )

    def free_bytes(self) -> int:
        """Return the free space on the disk [bytes]."""
        return shutil.disk_usage(self.path.parent).free

    def size_bytes(self) -> int:
        """Return the size of the file and its journal [bytes]."""
        return _size(self.path) + self.journal_bytes()

    def journal_bytes(self) -> int:
        """Return the size of the write-ahead log [bytes]; 0 where there is none."""
        return _size(self.path.with_name(f"{self.path.name}-wal"))


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _identity(path: Path) -> FileIdentity | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino
