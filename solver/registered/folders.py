"""Where registered models are found, and their versions."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
from collections.abc import Iterator
from pathlib import Path

from geoswarm.solver.errors import UnknownForwardModelError
from geoswarm.solver.external.runs.fingerprints import files_below, fingerprint
from geoswarm.solver.words import did_you_mean

__all__ = ["NAME", "VARIABLE", "find_folder", "registered_names", "version_of"]

VARIABLE = "GEOSWARM_MODELS"
"""Folders, with the system's separator between them; each folder in one of them with a ``model.yaml`` is a model."""

NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$"


def _folders() -> Iterator[Path]:
    for text in os.environ.get(VARIABLE, "").split(os.pathsep):
        with contextlib.suppress(OSError):  # one that cannot be read has no models
            if text and Path(text).is_dir():
                yield from sorted(one for one in Path(text).iterdir() if _is_model(one))


def _is_model(folder: Path) -> bool:
    return re.fullmatch(NAME, folder.name) is not None and (folder / "model.yaml").is_file()


def registered_names() -> tuple[str, ...]:
    """Names of the models registered on this machine; where two have one name, the first counts."""
    return tuple(dict.fromkeys(folder.name for folder in _folders()))


def find_folder(name: str) -> Path:
    """Return the folder of a model.

    Raises
    ------
    UnknownForwardModelError
        There is none here; the message lists those that there are.
    """
    for folder in _folders():
        if folder.name == name:
            return folder.resolve()
    known = registered_names()
    raise UnknownForwardModelError(
        f"no model '{name}' is registered on this machine{did_you_mean(name, known)}; "
        f"registered: {', '.join(known) or f'none ({VARIABLE} names the folders)'}"
    )


def version_of(folder: Path) -> str:
    """SHA-256 of the names and fingerprints of all files of a model, those of linked folders included.

    Raises
    ------
    OSError, ValueError
        A file cannot be read, or there are too many.
    """
    digest = hashlib.sha256()
    for path in files_below(folder):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0")
        digest.update(fingerprint(path).encode())
    return digest.hexdigest()
