"""The files that a run is given: read once, so that nobody can change them while a calibration goes on."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.runs.folder import RunFolder
from geoswarm.solver.external.runs.verdict import FileState, states

__all__ = ["Sources", "files_below", "fingerprint"]

LARGEST = 16 * 1024 * 1024
"""Larger files are copied from where they lie."""

MOST_FILES = 10_000
SAMPLED = 64 * 1024 * 1024
_PIECE, _PIECES = 256 * 1024, 64


class Sources:
    """Files and folders beside a problem that each run gets.

    Parameters
    ----------
    base
        Where they lie.
    copied, linked
        Names of files and folders.
    versions
        Fingerprint by name that they must have.

    Raises
    ------
    ValueError
        One is missing, or was changed since its fingerprint was taken.
    """

    def __init__(self, base: Path, copied: Iterable[str], linked: Iterable[str], versions: Mapping[str, str]) -> None:
        self._base = base
        self._copied, self._linked = tuple(copied), tuple(linked)
        self._contents: dict[str, tuple[bytes, int]] = {}
        self._kept = tuple(name for name in (*self._copied, *self._linked) if (base / name).is_file())
        self._states: Mapping[str, FileState] = states(base, self._kept)
        for name in (*self._copied, *self._linked):
            path = base / name
            if not (path.is_file() or path.is_dir()):
                raise ValueError(f"{name} is not in {base}")
            if name in self._copied and path.is_file() and path.stat().st_size <= LARGEST:
                self._contents[name] = path.read_bytes(), path.stat().st_mode & 0o777
            if versions.get(name, now := fingerprint(path)) != now:
                raise ValueError(f"{name} in {base} has changed since the problem was read; start anew, or put it back")

    def place(self, folder: RunFolder) -> None:
        """Copy and link them into the folder of a run.

        Raises
        ------
        RunFailedError
            A linked or large file has changed since this was made.
        """
        for name, (content, mode) in self._contents.items():
            folder.write_bytes(name, content, mode)
        others = [name for name in (*self._copied, *self._linked) if name not in self._contents]
        now = states(self._base, others)
        for name in others:
            if name in self._kept and now[name] != self._states[name]:
                raise RunFailedError("not_started", f"{name} in {self._base} has changed since the calibration began")
            folder.place(self._base / name, name, link=name in self._linked)


def fingerprint(path: Path) -> str:
    """SHA-256 of a file, or of the names and contents of a folder.

    Of a file above 64 MB: of its size and of 65 pieces of 256 kB, its beginning and end among them; the whole of a mesh
    of gigabytes would take half a minute each time that a problem is read.
    """
    if not path.is_dir():
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
    digest = hashlib.sha256()
    for one in files_below(path):
        digest.update(f"{one.relative_to(path).as_posix()}\0{fingerprint(one)}\n".encode())
    return digest.hexdigest()


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
