"""Fingerprints of the version of a file, or of all files below a folder."""

from __future__ import annotations

import hashlib
import os
import time
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

__all__ = ["FileStamp", "files_below", "fingerprint", "settled"]

MOST_FILES = 10_000
SAMPLED = 64 * 1024 * 1024
"""Of larger files the fingerprint is of samples."""

SETTLED_SECONDS = 2.0
"""A file may change again unseen while its time of change is as coarse as that (FAT, NFS)."""

_MOST_KEPT = 65_536  # fingerprints of files, some 30 MB
_PIECE, _PIECES = 256 * 1024, 64


class FileStamp(NamedTuple):
    """What the system reports about a file; it differs when the file has changed."""

    device: int
    number: int
    size: int
    modified_ns: int
    changed_ns: int


def settled(path: Path) -> FileStamp | None:
    """Return the stamp of a file; None: it has changed so lately that it could change again under the same stamp.

    Raises
    ------
    OSError
        There is no such file.
    """
    found = path.stat()
    stamp = FileStamp(found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns)
    age = time.time_ns() - max(stamp.modified_ns, stamp.changed_ns)
    return stamp if age > SETTLED_SECONDS * 1e9 else None


def fingerprint(path: Path) -> str:
    """SHA-256 of a file, or of the names and contents of a folder.

    Of a file above 64 MB: of its size and of 65 pieces of 256 kB, its beginning and end among them; the whole of a mesh
    of gigabytes would take half a minute each time that a problem is read. A file that has not changed is not read
    again.
    """
    if not path.is_dir():
        stamp = settled(path)
        return _of_file(path) if stamp is None else _kept(str(path.absolute()), stamp)
    digest = hashlib.sha256()
    for one in files_below(path):
        digest.update(f"{one.relative_to(path).as_posix()}\0{fingerprint(one)}\n".encode())
    return digest.hexdigest()


@lru_cache(maxsize=_MOST_KEPT)
def _kept(path: str, stamp: FileStamp) -> str:
    # A file that changes in this moment gets another stamp: what is kept under this one is not asked for again.
    del stamp
    return _of_file(Path(path))


def _of_file(path: Path) -> str:
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        if size > SAMPLED:
            digest = hashlib.sha256(f"{size}\n".encode())
            for piece in range(_PIECES + 1):
                file.seek((size - _PIECE) * piece // _PIECES)
                digest.update(file.read(_PIECE))
            return digest.hexdigest()
        file.seek(0)
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_below(folder: Path) -> list[Path]:
    """All files below a folder, those of linked folders included, in the order of their names.

    Raises
    ------
    ValueError
        There are more than 10 000, or a link leads back to a folder above it.
    """
    found: list[Path] = []
    for base, folders, names in os.walk(folder, followlinks=True):
        folders[:] = [name for name in folders if name != "__pycache__"]
        found += [path for name in names if (path := Path(base) / name).is_file()]
        if len(found) > MOST_FILES:
            raise ValueError(f"{folder} has more than {MOST_FILES} files, or a link in it leads back to it")
    return sorted(found)
