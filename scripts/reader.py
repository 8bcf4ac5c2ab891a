"""Do what the blocks of a page say, as somebody would who follows it in an empty folder."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import psutil

from scripts.blocks import Block

ROOT = Path(__file__).resolve().parents[1]
LONGEST = 280.0
"""Seconds that a block may take."""


PROGRAMS = ".programs"
"""Folder in the reader's with the programs that come first on the path."""


class ReaderError(Exception):
    """A page does not do what it says: names the page and the line of the block."""


def environment(folder: Path, *, installed: bool = False) -> dict[str, str]:
    """Return the environment of a reader: this geoswarm first on the path, settings of the service's own unset.

    ``installed``: not the sources beside this script, but what is installed for this Python.
    """
    programs = folder / PROGRAMS
    programs.mkdir()
    command = programs / "geoswarm"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m geoswarm "$@"\n')
    command.chmod(0o755)
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("GEOSWARM_", "PYTHON"))}
    sources = {} if installed else {"PYTHONPATH": str(ROOT)}
    path = os.pathsep.join([str(programs), str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return kept | sources | {"PATH": path, "MPLBACKEND": "agg", "COLUMNS": "110", "NO_COLOR": "1"}


def left_over(folder: Path) -> list[psutil.Process]:
    """Return the processes that were started with the environment of a folder and still run."""
    found = []
    for process in psutil.process_iter():
        try:
            path = process.environ().get("PATH", "")
        except psutil.Error:  # it has ended, or belongs to another user
            continue
        if path.startswith(str(folder / PROGRAMS)):
            found.append(process)
    return found


def end_left_over(folder: Path) -> None:
    """End what a page has started and not ended."""
    for process in left_over(folder):
        with contextlib.suppress(psutil.NoSuchProcess):
            process.terminate()
    until = time.monotonic() + 20.0
    while (running := left_over(folder)) and time.monotonic() < until:
        psutil.wait_procs(running, timeout=1.0)
    for process in running:
        with contextlib.suppress(psutil.NoSuchProcess):
            process.kill()


SESSION = """
import contextlib, io, json, sys, traceback
names = {"__name__": "__main__"}
for line in sys.stdin:
    printed, failed = io.StringIO(), False
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        try:
            exec(compile(json.loads(line), "<page>", "exec"), names)
        except BaseException:
            failed = True
            traceback.print_exc()
    print(json.dumps([failed, printed.getvalue()]), flush=True)
"""


class Reader:
    """Somebody who follows a page in an empty folder.

    Parameters
    ----------
    folder
        Where the reader works.
    variables
        Environment variables that the page takes for granted.
    installed
        Whether the reader uses what is installed for this Python, not the sources beside this script.
    """

    def __init__(self, folder: Path, variables: Mapping[str, str] | None = None, *, installed: bool = False) -> None:
        self.folder = folder
        self.variables = environment(folder, installed=installed) | dict(variables or {})
        self._session: subprocess.Popen[str] | None = None

    def __enter__(self) -> Reader:
        return self

    def __exit__(self, *_: object) -> None:
        if self._session is not None:
            self._session.kill()
            self._session.communicate()
        end_left_over(self.folder)

    def do(self, block: Block) -> str | None:
        """Do what a block says; return what it printed, None for a block that is not run."""
        if block.title is not None:
            path = self.folder / block.title
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
            return None
        if block.kind == "bash":
            return self.shell(block.text)
        return self.python(block.text) if block.kind == "python" else None

    def program(self, name: str, text: str) -> None:
        """Put a script in the place of a program."""
        path = self.folder / PROGRAMS / name
        path.write_text(text, encoding="utf-8")
        path.chmod(0o755)

    def shell(self, text: str) -> str:
        """Type commands into a shell; return what they printed."""
        shell = subprocess.Popen(
            ["bash", "-euo", "pipefail", "-c", text],
            cwd=self.folder,
            env=self.variables,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            printed, _ = shell.communicate(timeout=LONGEST)
        except BaseException:
            os.killpg(shell.pid, signal.SIGKILL)
            raise
        if shell.returncode != 0:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(shell.pid, signal.SIGKILL)  # what the commands have left running
            raise ReaderError(f"ended with {shell.returncode}:\n{printed}")
        return printed

    def python(self, text: str) -> str:
        """Type statements into the session of Python; return what they printed."""
        if self._session is None:
            self._session = subprocess.Popen(
                [sys.executable, "-c", SESSION],
                cwd=self.folder,
                env=self.variables,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        assert self._session.stdin is not None
        assert self._session.stdout is not None
        self._session.stdin.write(json.dumps(text) + "\n")
        self._session.stdin.flush()
        failed, printed = json.loads(self._session.stdout.readline())
        if failed:
            raise ReaderError(printed)
        return str(printed)
