"""The command line of a control file, split without a shell."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

__all__ = ["CommandLine", "command_line"]

SCRIPT = "run.sh"
"""What a user writes where a shell is needed."""

_SHELL = re.compile(r"[|&;<>$`*?\n]|%\w+%")
_BUILT_IN = {"cd", "set", "export", "call", "source", ".", "rem", "copy", "del", "echo", "move", "type"}


@dataclass(frozen=True, slots=True)
class CommandLine:
    """Arguments for ``run``, and what the user has to do or know about them."""

    arguments: tuple[str, ...]
    script: str | None = None
    """Text of the script that the user has to write; None: no shell is needed."""
    notes: tuple[str, ...] = ()


def command_line(commands: tuple[str, ...], folder: Path) -> CommandLine:
    """Split the command line.

    Parameters
    ----------
    commands
        Lines of ``* model command line``.
    folder
        Of the control file, in which PEST starts them.

    Examples
    --------
    >>> command_line(("python model.py  'a b'",), Path()).arguments
    ('python', 'model.py', 'a b')
    >>> command_line(("model < in.txt",), Path()).arguments
    ('sh', 'run.sh')
    """
    why = _why_shell(commands)
    if why is not None:
        script = "#!/bin/sh\nset -e\n" + "".join(f"{command}\n" for command in commands)
        return CommandLine(
            ("sh", SCRIPT),
            script,
            (
                f"the command line needs a shell ({why}), and programs are never started by one: write {SCRIPT} beside "
                "problem.yaml with the lines that stand there in a comment",
            ),
        )
    first, *rest = shlex.split(commands[0].replace("\\", "/"))
    notes = []
    if first.lower().endswith((".bat", ".cmd")):
        notes.append(f"{first} is a batch file, which runs on Windows only; name another program in run elsewhere")
    if "/" not in first and (folder / first).is_file():
        first = f"./{first}"
    return CommandLine((first, *rest), None, tuple(notes))


def _why_shell(commands: tuple[str, ...]) -> str | None:
    if len(commands) > 1:
        return f"there are {len(commands)} commands"
    command = commands[0]
    try:
        words = shlex.split(command.replace("\\", "/"))
    except ValueError as error:
        return str(error).lower()
    plain = re.sub(r"'[^']*'", "", command)
    if found := _SHELL.search(plain):
        return f"for {found[0]}"
    if not words:
        return "it is empty"
    if words[0].lower() in _BUILT_IN or re.fullmatch(r"[A-Za-z_]\w*=.*", words[0]):
        return f"for {words[0]}"
    return None
