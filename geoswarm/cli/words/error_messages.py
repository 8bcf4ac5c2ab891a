"""Every error becomes one clear message on stderr and an exit code.

::

    click.ClickException
    └── CommandError
        ├── FailedRunError      exit code 1: the input was fine, the run was not
        └── BadInputError       exit code 2: the user can mend it
"""

from __future__ import annotations

import errno
import os
import secrets
import sys
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import click

from geoswarm.cli.words.output import note
from geoswarm.solver.errors import Issue
from geoswarm.solver.sentences import Key, plain
from geoswarm.solver.words import visible

if TYPE_CHECKING:
    from geoswarm.solver.external.trial import TrialRun
    from geoswarm.solver.problem import Problem

__all__ = [
    "BAD_INPUT",
    "BadInputError",
    "CommandContext",
    "CommandError",
    "FAILED_RUN",
    "FailedRunError",
    "INTERRUPTED",
    "facts_of_run",
    "report",
    "warn_of_many_points",
]

FAILED_RUN, BAD_INPUT, INTERRUPTED = 1, 2, 130


_FILES = 10


@dataclass(slots=True)
class CommandContext:
    """What one call of the command line carries from command to error handler."""

    debug: bool = False
    command: str | None = None


class CommandError(click.ClickException):
    """An error that a command raises on purpose; the message is all that the user sees."""


class FailedRunError(CommandError):
    """A calculation or a job failed although the input was accepted."""

    exit_code = FAILED_RUN


class BadInputError(CommandError):
    """The user's input, or a service that it names, is at fault."""

    exit_code = BAD_INPUT


def report(error: BaseException, session: CommandContext) -> int:
    """Write the message of an error to stderr and return the exit code."""
    if isinstance(error, BrokenPipeError):
        return _leave_quietly()
    if isinstance(error, (KeyboardInterrupt, click.Abort)):
        click.echo("\nInterrupted.", err=True)
        return INTERRUPTED
    if isinstance(error, click.UsageError):
        error.show()
        return BAD_INPUT
    if session.debug:
        import traceback

        click.echo("".join(traceback.format_exception(error)), err=True, nl=False)
    if isinstance(error, click.ClickException):
        click.echo(f"Error: {visible(error.format_message(), lines=True)}", err=True)
        return error.exit_code if isinstance(error, CommandError) else BAD_INPUT
    explained = explain(error, session.command)
    if explained is not None:
        message, code = explained
        click.echo(f"Error: {visible(message, lines=True)}", err=True)
        return code
    identifier = secrets.token_hex(4)
    click.echo(
        f"Error {identifier}: unexpected {type(error).__name__}: {error}\n"
        "This is a fault of geoswarm. 'geoswarm --debug ...' shows where it happened; please report it.",
        err=True,
    )
    return FAILED_RUN


def _mistake(issue: Issue) -> str:
    """A mistake with its path; what is to be accepted as an option, too."""
    parts = [
        replace(part, text=f"{part.text} or --accept {part.value}")
        if isinstance(part, Key) and part.path == "accept"
        else part
        for part in issue.parts
    ]
    return str(replace(issue, message=plain(parts))) if parts else str(issue)


def explain(error: BaseException, command: str | None = None) -> tuple[str, int] | None:
    """Return message and exit code of an error that geoswarm raises on purpose; None for any other."""
    from geoswarm.solver.errors import ForwardError, ProblemError, SolverError, WorkerLostError

    if isinstance(error, ProblemError):
        count = len(error.issues)
        title = "the problem has a mistake" if count == 1 else f"the problem has {count} mistakes"
        return "\n  ".join([f"{title}:", *map(_mistake, error.issues)]), BAD_INPUT
    if isinstance(error, (ForwardError, WorkerLostError)):
        return str(error), FAILED_RUN
    if isinstance(error, SolverError):
        return str(error), BAD_INPUT
    if isinstance(error, ModuleNotFoundError) and error.name is not None:
        return _explain_missing(error.name, command)
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}", BAD_INPUT
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO):
        return f"the output cannot be written: {error.strerror}", FAILED_RUN
    return _explain_service(error)


def _explain_missing(module: str, command: str | None) -> tuple[str, int] | None:
    """Name the extra that brings a module; None when no extra does."""
    from geoswarm.solver.system.extras import extra_of, needs_extra

    if extra_of(module) is None:
        return None
    return needs_extra(f"geoswarm {command}" if command else "geoswarm", module), BAD_INPUT


def _explain_service(error: BaseException) -> tuple[str, int] | None:
    """Judge errors of modules that are loaded only where a command needs them."""
    bases = (
        ("geoswarm.client.errors", "JobFailedError", FAILED_RUN),
        ("geoswarm.client.errors", "GeoswarmError", BAD_INPUT),
        ("geoswarm.workers.errors", "WorkersError", BAD_INPUT),
        ("geoswarm.api.errors", "ApiError", BAD_INPUT),
    )
    for module, base, code in bases:
        loaded = sys.modules.get(module)
        if loaded is not None and isinstance(error, getattr(loaded, base)):
            return str(error), code
    return None


def _leave_quietly() -> int:
    """The reader of our output has gone (``geoswarm list | head``): say nothing, also not at interpreter exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return FAILED_RUN


def warn_of_many_points(problem: Problem) -> None:
    """Warn of series with so many points that they only cost time."""
    from geoswarm.solver.problem.readings.preparation import many_points_warning

    for observation in problem.observations:
        message = many_points_warning(observation.series, len(observation.x))
        if message is not None:
            note(f"Warning: {message}")


def facts_of_run(run: TrialRun) -> dict[str, str]:
    """What happened, in a few lines."""
    return {
        "call": " ".join(run.call),
        "run folder": str(run.folder),
        "written": _listed(run.written),
        "made by it": _listed(run.made),
        "ended": run.ended or "was not started",
    }


def _listed(names: tuple[str, ...]) -> str:
    """Names of files, the first ones of many."""
    more = f" and {len(names) - _FILES} more" if len(names) > _FILES else ""
    return (", ".join(names[:_FILES]) or "nothing") + more
