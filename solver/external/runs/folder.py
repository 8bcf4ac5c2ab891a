"""The folder of a run: new and empty for each, then filled; and which folders are kept.

A folder's name says what became of it: ``running-``, ``failed-`` or ``run-``, then the process that made it. What a
killed process has left as ``running-`` becomes ``failed-`` when the next one starts.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import platform
import shutil
import tempfile
import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal, TypeAlias

import psutil

__all__ = ["Keep", "RunFolder", "private_folder", "tidy"]

Keep: TypeAlias = Literal["failed", "all", "none"]

MOST_FAILED = 20
"""Folders of failed runs that are kept; the oldest go."""

_DELETE_TRIES, _DELETE_SECONDS = 5, 0.1
_numbers = itertools.count()


def private_folder(*parts: str) -> Path:
    """Return a folder below the system's temporary one that only this user can read."""
    user = str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME", "user")
    base = Path(tempfile.gettempdir()) / f"geoswarm-{user}"
    base.mkdir(mode=0o700, exist_ok=True)
    found = base.lstat()
    if hasattr(os, "getuid") and (found.st_uid != os.getuid() or base.is_symlink()):
        raise OSError(f"{base} belongs to somebody else; set TMPDIR to another folder")
    folder = base.joinpath(*parts)
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder


class RunFolder:
    """A new, empty folder.

    Parameters
    ----------
    parent
        Where it is made.
    """

    def __init__(self, parent: Path) -> None:
        self._name = f"{_here()}-{os.getpid()}-{_started(os.getpid())}-{next(_numbers)}"
        self.path = parent / f"running-{self._name}"
        self.path.mkdir(mode=0o700)
        self.made_at = self.path.stat().st_mtime_ns
        """By the clock of the file system, which may be that of another machine [ns]."""

    def place(self, source: Path, name: str, *, link: bool) -> None:
        """Copy a file or folder into this one, or link it, as ``name``."""
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if link:
            target.symlink_to(source, target_is_directory=source.is_dir())
        elif source.is_dir():
            shutil.copytree(source, target, symlinks=True, dirs_exist_ok=True)
        else:
            shutil.copy2(source, target)

    def write_bytes(self, name: str, content: bytes, mode: int) -> None:
        """Write a copy of a file, with the rights that it has."""
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        target.chmod(mode)

    def write(self, name: str, text: str) -> None:
        """Write a text as UTF-8, with the line ends that it has."""
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8", newline="")

    def kept_as(self, *, failed: bool) -> Path:
        """Where it lies after the run, if it is kept."""
        return self.path.with_name(f"{'failed' if failed else 'run'}-{self._name}")

    def finish(self, keep: Keep, *, failed: bool) -> Path | None:
        """Keep or delete it; return where it is kept, None if it was deleted. Never raises."""
        if keep == "all" or (failed and keep == "failed"):
            kept = self.kept_as(failed=failed)
            with contextlib.suppress(OSError):
                self.path.rename(kept)
                if failed:
                    _prune(kept.parent)
                return kept
            return self.path
        _delete(self.path)
        return None


def tidy(parent: Path) -> None:
    """Mark folders of runs whose process has ended as failed, and delete those too many."""
    for folder in _folders(parent, "running-"):
        parts = folder.name.split("-")
        if len(parts) == 5 and parts[1] == _here() and _started(int(parts[2])) != parts[3]:
            with contextlib.suppress(OSError):
                folder.rename(folder.with_name(folder.name.replace("running-", "failed-", 1)))
    _prune(parent)


@cache
def _here() -> str:
    """What distinguishes the processes that this one can see from those of other machines and containers."""
    try:
        space = str(Path("/proc/self/ns/pid").readlink()) + Path("/proc/sys/kernel/random/boot_id").read_text()
    except OSError:
        space = ""
    return hashlib.sha256(f"{platform.node()} {space}".encode()).hexdigest()[:8]


def _started(pid: int) -> str:
    """When a process has begun, in the system's own ticks where it has them; empty: there is no such process."""
    with contextlib.suppress(OSError, IndexError):
        return Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()[19]
    with contextlib.suppress(psutil.Error):
        return str(int(psutil.Process(pid).create_time()))
    return ""


def _prune(parent: Path) -> None:
    for folder in _folders(parent, "failed-")[:-MOST_FAILED]:
        _delete(folder)


def _folders(parent: Path, beginning: str) -> Sequence[Path]:
    """Folders whose names begin so, the oldest first."""
    found: list[tuple[float, Path]] = []
    with contextlib.suppress(OSError), os.scandir(parent) as entries:
        for entry in entries:
            if entry.name.startswith(beginning):
                with contextlib.suppress(OSError):
                    found.append((entry.stat(follow_symlinks=False).st_mtime, Path(entry.path)))
    return [path for _, path in sorted(found)]


def _delete(folder: Path) -> None:
    """Delete a folder, not what its links lead to; a file that is still held is tried again, then left."""
    for attempt in range(_DELETE_TRIES):
        try:
            shutil.rmtree(folder)
        except FileNotFoundError:
            return
        except OSError:
            time.sleep(_DELETE_SECONDS * (attempt + 1))
        else:
            return
