"""Try an installed geoswarm as a newcomer would, in an empty folder: no server, no compiler, no checkout.

python scripts/try_installed.py                a first calibration: needs no extra
python scripts/try_installed.py --tutorials    every tutorial that needs no program of others: extras server and plots
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
import time
from pathlib import Path

COMMANDS = (
    ["examples", "oedometer", "example"],
    ["init", "oedometer", "--output", "own"],
    ["check", "example/problem.yaml"],
    ["evaluate", "example/problem.yaml", "--set", "lambda_star=0.06", "--set", "kappa_star=0.03", "--set", "c=27"],
    ["run", "own/problem.yaml", "--output", "out", "--workers", "2"],
    ["statistics", "out"],
)

ELSEWHERE = ("own-program",)
"""Tutorials that need a program of others: a Fortran compiler."""


def tutorials() -> int:
    """Follow the tutorials in their order with what is installed; return 1 if one does not do what it says."""
    from tutorials import PAGES, ReaderError, follow

    names = re.findall(r"\]\(([\w-]+)\.md\)", (PAGES / "README.md").read_text(encoding="utf-8"))
    failed: list[str] = []
    for name in names:
        if name in ELSEWHERE:
            continue
        began = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            try:
                follow(PAGES / f"{name}.md", Path(folder), installed=True)
            except ReaderError as error:
                print(error, file=sys.stderr)
                failed.append(name)
        state = "failed" if name in failed else "done"
        print(f"{name}: {state} after {time.monotonic() - began:.0f} s", flush=True)
    return 1 if failed else 0


def main() -> int:
    """Run the commands one after the other; return 1 where one of them ends otherwise than it should."""
    if "--tutorials" in sys.argv[1:]:
        return tutorials()
    import geoswarm.client
    from geoswarm.cli import main as geoswarm

    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for command in COMMANDS:
                print("geoswarm", *command, flush=True)
                if code := geoswarm(command):
                    print(f"ended with {code}", file=sys.stderr)
                    return 1
            if not Path("out", "result.json").is_file():
                print("geoswarm run wrote no result.json", file=sys.stderr)
                return 1
        finally:
            os.chdir(before)
    return 0


if __name__ == "__main__":
    sys.exit(main())
