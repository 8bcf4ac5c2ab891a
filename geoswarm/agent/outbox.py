"""Results on disk, from when a run has ended until the service has them.

Each agent has a folder of its own below that of its service. Results that a killed agent has left are taken over by the
next one that starts on the machine with the same folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import psutil

__all__ = ["Outbox", "default_folder"]

SUFFIX = ".json"


def default_folder() -> Path:
    """Return where agents of this user keep results that could not be handed in yet."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA")
        return (Path(base) if base else Path.home() / "AppData" / "Local") / "geoswarm" / "agent"
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "geoswarm" / "agent"


class Outbox:
    """The results of one agent.

    Parameters
    ----------
    folder
        Where agents of this user keep theirs.
    url
        Address of the service: leases of another one mean nothing to it.
    """

    def __init__(self, folder: Path, url: str) -> None:
        self._service = folder / hashlib.sha256(url.rstrip("/").encode()).hexdigest()[:16]
        self.folder = self._service / f"{_here()}-{os.getpid()}-{_started(os.getpid())}"
        self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def save(self, lease_id: str, brought: Mapping[str, Any]) -> None:
        """Keep the results of a lease.

        Raises
        ------
        OSError
            The disk takes nothing.
        """
        path = self.folder / f"{lease_id}{SUFFIX}"
        draft = path.with_suffix(".tmp")
        draft.write_text(json.dumps(brought, allow_nan=False), encoding="utf-8")
        draft.replace(path)

    def drop(self, lease_id: str) -> None:
        """Forget results that the service has, or does not want."""
        with contextlib.suppress(OSError):
            (self.folder / f"{lease_id}{SUFFIX}").unlink()

    def take_over(self) -> None:
        """Take over what agents of this machine have left that have ended."""
        for other in sorted(self._service.iterdir()):
            if other != self.folder and other.is_dir() and _has_ended(other.name):
                with contextlib.suppress(OSError):  # another agent is at it, too
                    for path in other.iterdir():
                        if path.suffix == SUFFIX:
                            path.replace(self.folder / path.name)
                        else:
                            path.unlink()
                    other.rmdir()

    def waiting(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Give the lease of each, and its results; what cannot be read is dropped."""
        for path in sorted(self.folder.glob(f"*{SUFFIX}")):
            try:
                yield path.stem, json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError):
                self.drop(path.stem)

    def close(self) -> None:
        """Remove the folder if it is empty."""
        with contextlib.suppress(OSError):
            self.folder.rmdir()


def _here() -> str:
    """What distinguishes this machine, and its boot where the system names it, from others that share the folder."""
    space = ""
    with contextlib.suppress(OSError):
        space = str(Path("/proc/self/ns/pid").readlink()) + Path("/proc/sys/kernel/random/boot_id").read_text()
    return hashlib.sha256(f"{platform.node()} {space}".encode()).hexdigest()[:8]


def _started(pid: int) -> str:
    with contextlib.suppress(psutil.Error):
        return str(int(psutil.Process(pid).create_time()))
    return ""


def _has_ended(name: str) -> bool:
    parts = name.split("-")
    return len(parts) == 3 and parts[0] == _here() and parts[1].isdecimal() and _started(int(parts[1])) != parts[2]
