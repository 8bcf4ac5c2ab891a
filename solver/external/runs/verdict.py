"""Whether a run has succeeded. Exit status alone is never success, and old output never counts."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from geoswarm.solver.errors import FailureReason
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.runs.program import Ended

__all__ = ["FileState", "Fail", "Success", "judge", "not_of_run", "states"]

OUTPUT = "output"
"""In rules, what the program prints."""

MOST_TEXT = 8 * 1024 * 1024
"""Last bytes of a file in which a text is looked for."""

FileState: TypeAlias = tuple[int, int, int] | None
"""Time of the last change [ns], size, and number of a file; None: there is none."""


def _pattern(text: str) -> str:
    try:
        re.compile(text)
    except re.error as error:
        raise ValueError(f"'{text}' is not a regular expression: {error}") from error
    return text


Pattern = Annotated[str, AfterValidator(_pattern), Field(max_length=1000)]
ProgramReason: TypeAlias = FailureReason | Literal["no_licence"]


class Success(BaseModel):
    """What a successful run shows; all of it is needed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    exit: tuple[int, ...] = Field((0,), description="exit statuses of success")
    files: tuple[str, ...] = Field((), max_length=100, description="files that the run must make")
    text: dict[str, Pattern] = Field(
        {}, description="by file, a regular expression that must be found in it; 'output' is what the program prints"
    )


class Fail(BaseModel):
    """Signs of why a run has failed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    exit: dict[int, ProgramReason] = Field({}, description="reason by exit status")
    text: dict[str, dict[Pattern, ProgramReason]] = Field(
        {}, description="by file, reason by regular expression; 'output' is what the program prints"
    )


def states(folder: Path, names: Iterable[str]) -> dict[str, FileState]:
    """Return the state of files of a folder, through links."""
    found: dict[str, FileState] = {}
    for name in names:
        try:
            state = os.stat(folder / name)  # noqa: PTH116  the time in whole nanoseconds
            found[name] = (state.st_mtime_ns, state.st_size, state.st_ino)
        except OSError:
            found[name] = None
    return found


def not_of_run(folder: Path, path: Path, made_at: int) -> str | None:
    """Return why a file was not made by a run, in words; None: it was, or there is none.

    Parameters
    ----------
    folder, path
        The folder of the run, and the file.
    made_at
        When the folder of the run was made [ns].
    """
    try:
        found = os.lstat(path)
    except OSError:
        return None
    if stat.S_ISLNK(found.st_mode) or (stat.S_ISREG(found.st_mode) and found.st_nlink > 1):
        return "is a link; only a file that the run itself wrote counts"
    if any(one.is_symlink() for one in path.parents if folder in one.parents):
        return "is in a linked folder; only a file that the run itself wrote counts"
    changed = found.st_mtime_ns if os.name == "nt" else min(found.st_mtime_ns, found.st_ctime_ns)
    return "is older than the run" if changed < made_at else None


def judge(
    ended: Ended,
    program: str,
    folder: Path,
    made_at: int,
    before: Mapping[str, FileState],
    needed: Iterable[str],
    success: Success,
    fail: Fail,
    output: Path,
) -> None:
    """Return when a run has succeeded.

    Parameters
    ----------
    program
        How it was called, for messages.
    made_at
        When the folder was made [ns].
    before
        State of all files that are looked at, before the run.
    needed
        Those that the run must have written.
    output
        File with what the program has printed.

    Raises
    ------
    RunFailedError
        With the reason: ``timeout``; what ``fail`` says; ``program_failed`` for another exit status, a signal or a
        missing text of success; ``no_output`` for a file that is missing, a link, or older than the run.
    """
    if ended.status is None:
        raise RunFailedError("timeout", f"{program} {ended.words} (seconds) with all that it had started")
    after = states(folder, before)

    def fault(name: str) -> str | None:
        unchanged = after.get(name) is not None and after[name] == before.get(name)
        return "is older than the run" if unchanged else not_of_run(folder, folder / name, made_at)

    def text_of(name: str) -> str | None:
        if name == OUTPUT:
            return _text(output)
        return None if fault(name) else _text(folder / name)

    for name, patterns in fail.text.items():
        text = text_of(name)
        for pattern, reason in patterns.items():
            found = None if text is None else re.search(pattern, text, re.MULTILINE)
            if found:
                raise RunFailedError(reason, f"{name}: {_line_around(found)}")
    if ended.status in fail.exit:
        raise RunFailedError(fail.exit[ended.status], f"{program} {ended.words}")
    if ended.status not in success.exit:
        raise RunFailedError("program_failed", f"{program} {ended.words}")
    for name in needed:
        if after[name] is None:
            raise RunFailedError("no_output", f"{program} {ended.words}, but has not written {name}")
        if why := fault(name):
            raise RunFailedError("no_output", f"{name} {why}: {program} {ended.words}, but has not written it")
    for name, pattern in success.text.items():
        text = text_of(name)
        if text is None or not re.search(pattern, text, re.MULTILINE):
            raise RunFailedError("program_failed", f"{program} {ended.words}, but '{pattern}' is not in {name}")


def _text(path: Path) -> str | None:
    """The end of a file; None: there is none."""
    try:
        with path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(size - MOST_TEXT, 0))
            return file.read(MOST_TEXT).decode("utf-8", errors="replace")
    except OSError:
        return None


def _line_around(found: re.Match[str]) -> str:
    """The line in which a match begins."""
    text = found.string
    first = text.rfind("\n", 0, found.start()) + 1
    last = text.find("\n", found.start())
    return text[first : len(text) if last < 0 else last].strip()[:300]
