"""What is said of an exception of a user's function: the exception, and the lines of the user's own file."""

from __future__ import annotations

import traceback
from pathlib import Path
from types import TracebackType
from typing import get_args

from geoswarm.solver.errors import FailureReason, ForwardError, in_words, message_of
from geoswarm.solver.external.errors import RunFailedError

__all__ = ["failure_of"]

_MOST_LINES = 4
_LONGEST = 2000  # characters of a message that anybody's code has made
_REASONS = frozenset(get_args(FailureReason))


def failure_of(error: BaseException, file: str, called: str, hint: str = "") -> RunFailedError:
    """Return the failed evaluation for an exception of a function.

    Parameters
    ----------
    file
        Name of the file, as in its code: only its lines are shown.
    called
        What the function is called in the message.
    """
    reason, told = "bad_output", f"{called} raised {in_words(error)}"
    if isinstance(error, ForwardError):
        told = message_of(error) or told
        given: object = getattr(error, "reason", None)
        if isinstance(given, str) and given in _REASONS:
            reason = given
        else:
            told += f" (its reason {given!r} is none of {', '.join(sorted(_REASONS))})"
    elif isinstance(error, SystemExit):
        told = f"{called} ended the program (sys.exit({error.code!r}))"
    if len(told) > _LONGEST:
        told = f"{told[:_LONGEST]} ..."
    return RunFailedError(reason, "\n".join([told, *_place_of(error.__traceback__, file), *([hint] if hint else [])]))


def _place_of(trace: TracebackType | None, file: str) -> list[str]:
    """Return the last lines of a file that a traceback goes through, the innermost last.

    Returns
    -------
    Lines such as ``  model.py, line 12, in settlement: return math.log(E)``.
    """
    frames = [frame for frame in traceback.extract_tb(trace) if frame.filename == file]
    name = Path(file).name
    lines = []
    for frame in frames[-_MOST_LINES:]:
        source = f": {frame.line.strip()}" if frame.line else ""
        inside = "" if frame.name == "<module>" else f", in {frame.name}"
        lines.append(f"  {name}, line {frame.lineno}{inside}{source}")
    return lines
