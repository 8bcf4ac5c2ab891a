"""What users write about outputs: file names below the folder of a run, and regular expressions."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Field

__all__ = ["LONGEST_MATCHED", "RelativePath", "below", "compiled", "relative_path"]

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


LONGEST_MATCHED = 10_000
"""Bytes of a line in a file that is searched with a regular expression."""

LONGEST_PATTERN = 1000
"""Characters of a regular expression."""


def compiled(pattern: str) -> re.Pattern[str]:
    """Compile a regular expression.

    Raises
    ------
    ValueError
        It is too long or wrong; the message says where.
    """
    if len(pattern) > LONGEST_PATTERN:
        raise ValueError(f"regular expression has {len(pattern)} characters; at most {LONGEST_PATTERN} are accepted")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return re.compile(pattern)
    except (re.error, Warning, RecursionError, OverflowError) as error:
        raise ValueError(f"'{pattern[:80]}' is not a regular expression: {error}") from None
