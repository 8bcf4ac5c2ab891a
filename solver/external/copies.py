"""Files on their way into the folder of a problem, where nothing is overwritten."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from geoswarm.solver.external.errors import ExternalError

__all__ = ["Copies", "FileInTheWayError"]


class FileInTheWayError(ExternalError):
    """A file would be overwritten."""


@dataclass(slots=True)
class Copies:
    """Files to be written into the folder of a problem, contents and modes by name; nothing there is overwritten."""

    folder: Path
    contents: dict[str, tuple[bytes, int]] = field(default_factory=dict)

    def add(self, name: str, content: bytes, mode: int = 0o644) -> str:
        """Take a file in under its name, or under a new one where that is taken by another; return the name."""
        start, dot, ending = name.rpartition(".")
        free, number = name, 1
        while self._taken(free, content):
            number += 1
            free = f"{start}_{number}.{ending}" if dot else f"{name}_{number}"
        self.contents[free] = content, mode
        return free

    def add_as(self, name: str, content: bytes, mode: int) -> None:
        """Take a file in whose name is needed.

        Raises
        ------
        FileInTheWayError
            Another one of that name is there.
        """
        if self._taken(name, content):
            raise FileInTheWayError(f"{self.folder / name} exists with other contents and is never overwritten")
        self.contents[name] = content, mode

    def _taken(self, name: str, content: bytes) -> bool:
        if name in self.contents:
            return self.contents[name][0] != content
        path = self.folder / name
        return path.is_dir() or (path.is_file() and path.read_bytes() != content)

    def write(self) -> None:
        """Write them; those that are there as they should be are left alone."""
        for name, (content, mode) in self.contents.items():
            path = self.folder / name
            if not path.exists():
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
                path.chmod(mode)
