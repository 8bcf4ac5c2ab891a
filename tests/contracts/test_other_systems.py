"""What runs without a service needs no module that only POSIX systems have: macOS and Windows cannot be tried here."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT

WITHOUT_POSIX = """
import builtins, sys
POSIX = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"}
usual = builtins.__import__

def refuse(name, globals=None, locals=None, fromlist=(), level=0):
    # what geoswarm itself asks for: on those systems the libraries have other parts for the same
    if name.partition(".")[0] in POSIX and (globals or {}).get("__name__", "").startswith("geoswarm"):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return usual(name, globals, locals, fromlist, level)

builtins.__import__ = refuse
if __name__ == "__main__":
    import runpy
    import geoswarm.solver.runs.evaluators
    geoswarm.solver.runs.evaluators.WATCHED = False
    runpy.run_path(sys.argv[1], run_name="__main__")
"""


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_runs_and_the_client_need_no_module_of_posix(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(WITHOUT_POSIX)
    done = subprocess.run(
        [sys.executable, script, ROOT / "scripts" / "try_installed.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
