"""What can go wrong around the files of a program that we did not write.

::

    SolverError
    └── ExternalError
        ├── TemplateError   a template or an instruction file is wrong: found when it is read, before anything runs
        ├── InputError      a value cannot be written where a template wants it; depends on the parameters
        └── OutputError     what a run left behind cannot be read; ``reason`` is the word stored with the evaluation
    ForwardError
    └── RunFailedError      one run of a program or function has failed, for any reason
"""

from __future__ import annotations

from typing import Literal, TypeAlias

from geoswarm.solver.errors import ForwardError, SolverError

__all__ = ["ExternalError", "InputError", "OutputError", "OutputReason", "RunFailedError", "TemplateError", "place"]

OutputReason: TypeAlias = Literal["no_output", "bad_output", "not_finite"]
"""``no_output``: a file is missing or empty. ``bad_output``: it cannot be read as it was said to be. ``not_finite``: a
number in it is NaN or infinite."""


def place(file: str, line: int | None = None, column: int | None = None) -> str:
    """Return where something is: ``footing.inp.in: line 3, column 12``; lines and columns count from 1."""
    where = "" if line is None else f": line {line}"
    return f"{file}{where}" if line is None or column is None else f"{file}{where}, column {column}"


class ExternalError(SolverError):
    """Base of all errors around files of other programs."""


class TemplateError(ExternalError):
    """A template or an instruction file is wrong.

    Parameters
    ----------
    file, line, column
        Where: the file as it is named to the user; lines and columns count from 1.
    """

    def __init__(self, message: str, file: str, line: int | None = None, column: int | None = None) -> None:
        self.file, self.line, self.column, self.message = file, line, column, message
        super().__init__(f"{place(file, line, column)}: {message}")

    def __reduce__(self) -> tuple[type[TemplateError], tuple[str, str, int | None, int | None]]:
        return type(self), (self.message, self.file, self.line, self.column)


class InputError(ExternalError):
    """A value cannot be written where a template or a file of parameters wants it."""


class OutputError(ExternalError):
    """What a run left behind cannot be read; the message names file, line, what was found and what was expected."""

    def __init__(self, reason: OutputReason, message: str) -> None:
        self.reason: OutputReason = reason
        self.message = message
        super().__init__(message)

    def __reduce__(self) -> tuple[type[OutputError], tuple[OutputReason, str]]:
        return type(self), (self.reason, self.message)


class RunFailedError(ForwardError):
    """One run of a program or function has failed, or could not be made.

    Parameters
    ----------
    reason
        The word that is stored with the evaluation.
    message
        What happened, in words.
    """

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason

    def __reduce__(self) -> tuple[type[RunFailedError], tuple[str, str]]:
        return type(self), (self.reason, str(self))
