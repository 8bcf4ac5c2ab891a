"""The files of a run: read once, so that they cannot change during a calibration."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.runs.fingerprints import fingerprint
from geoswarm.solver.external.runs.folder import RunFolder
from geoswarm.solver.external.runs.verdict import FileState, states

__all__ = ["Sources"]

LARGEST = 16 * 1024 * 1024
"""Larger files are copied from where they lie."""


class Sources:
    """Files and folders of a problem that each run gets.

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
                raise ValueError(f"{name} in {base} has changed since the problem was read; start over, or restore it")

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
