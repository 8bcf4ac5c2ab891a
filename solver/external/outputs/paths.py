"""Names of files below the folder of a run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Field

__all__ = ["RelativePath", "below", "relative_path"]

_DRIVE = re.compile(r"[A-Za-z]:")


def relative_path(name: str) -> str:
    """Return a name of a file below a folder, with ``/`` between folders.

    Raises
    ------
    ValueError
        It is empty or absolute, leaves the folder by ``..``, or holds a backslash or a control character.
    """
    if not name.strip() or name.endswith("/"):
        raise ValueError(f"'{name[:60]}' names no file; write for example results.csv")
    if any(ord(sign) < 32 for sign in name):
        raise ValueError("the name of a file must not hold control characters")
    if "\\" in name:
        raise ValueError(f"'{name[:60]}': write / between folders, not a backslash")
    if name.startswith(("/", "~")) or _DRIVE.match(name):
        raise ValueError(f"'{name[:60]}' must be relative to the folder of the run, such as results.csv")
    if ".." in name.split("/"):
        raise ValueError(f"'{name[:60]}' must stay in the folder of the run; .. is not accepted")
    return name


def below(folder: Path, name: str) -> Path:
    """Return the path of a relative name in a folder."""
    return folder / relative_path(name)


RelativePath: TypeAlias = Annotated[str, Field(max_length=1000), AfterValidator(relative_path)]
"""A file below the folder of the run, in a section."""
