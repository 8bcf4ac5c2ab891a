"""The command line ``geoswarm``.

=============  ===========================================================================
``commands``   the table of commands; each is imported only when it is called
``start``      commands to begin with: starters, examples, the demonstration
``local``      commands that calculate here
``model``      commands for programs as forward models
``service``    commands for the jobs of a service
``words``      tables, notes and errors: every error is one clear message and an exit code
``options``    options and arguments that several commands share
``databases``  the database of a service, where a command needs one
``serve``      ``geoswarm serve``, ``worker`` and ``sweep``: the processes of a service
=============  ===========================================================================

Exit codes: 0 ok, 1 a run failed, 2 bad input (also: a service, database or broker that cannot be reached, a port in
use), 130 interrupted.
"""

from __future__ import annotations

import atexit
import gc
import io
import os
import sys
from collections.abc import Sequence

from geoswarm.cli.commands import cli
from geoswarm.cli.words.error_messages import CommandContext, report
from geoswarm.solver.system.environment import same_bits

__all__ = ["cli", "main"]

OBJECTS_BETWEEN_COLLECTIONS, OBJECTS_OF_A_START = 50_000, 250_000
"""Instead of Python's 700: looking for garbage among what imports leave would take a tenth of a short command, and
once more when it ends."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code; never raises for what a user can cause.

    Parameters
    ----------
    arguments
        Without the program's name; ``sys.argv[1:]`` when None.
    """
    _collect_little()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a symbol that the terminal lacks must not end the command
    session = CommandContext()
    try:
        os.environ.update(same_bits())  # NumPy is not loaded yet
        code = cli.main(
            args=None if arguments is None else list(arguments),
            prog_name="geoswarm",
            standalone_mode=False,
            obj=session,
        )
        sys.stdout.flush()
    except (Exception, KeyboardInterrupt) as error:  # noqa: BLE001  the last handler: no traceback reaches a user
        return report(error, session)
    except SystemExit as done:  # click ends like this when the reader of our output has gone
        return done.code if isinstance(done.code, int) else 0
    return code if isinstance(code, int) else 0


def _collect_little() -> None:
    """Have Python look for garbage only where a command goes on: not at its start, nor at the end of the process."""

    def go_on(_phase: str, _info: dict[str, int]) -> None:
        gc.callbacks.remove(go_on)
        gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)

    gc.callbacks.append(go_on)
    gc.set_threshold(OBJECTS_OF_A_START)
    atexit.register(gc.freeze)
