"""Cut off ``geoswarm run --output`` at random moments and go on; prints what came of it as JSON.

A process of its own, because it forks: a child runs the command, and is interrupted, killed, or meets a full disk.
"""

from __future__ import annotations

import csv
import json
import os
import random
import resource
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.cli import main
from geoswarm.cli.local import run
from tests.solver.problems import decay_document

CUTS = ("interrupt", "kill", "full disk")


def history(folder: Path) -> list[Any]:
    """Everything that a run wrote but its times, bit for bit."""
    with (folder / "evaluations.csv").open(encoding="utf-8", newline="") as stream:
        rows = [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(stream)]
    result = json.loads((folder / "result.json").read_text(encoding="utf-8")) | {"seconds": 0}
    with np.load(folder / "responses.npz") as stored:
        arrays = {name: stored[name].tobytes().hex() for name in sorted(stored)}
    problem = (folder / "problem.json").read_text(encoding="utf-8")
    return [rows, result, arrays, problem, (folder / "generations.csv").read_text(encoding="utf-8")]


def forked(work: Callable[[], int]) -> int:
    """Do something in a child, which ends with its exit code; return its pid."""
    pid = os.fork()
    if pid == 0:
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        os._exit(work())
    return pid


def cut_off(cut: str, arguments: list[str], chance: random.Random, seconds: float, size: int) -> int:
    """Run the command in a child that meets a fault at a random moment; return how it ended (negative: a signal)."""

    def work() -> int:
        if cut == "full disk":
            limit = chance.randrange(size)
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        return main(arguments)

    pid = forked(work)
    if cut != "full disk":
        time.sleep(chance.uniform(0.0, seconds))
        os.kill(pid, signal.SIGINT if cut == "interrupt" else signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def trials(folder: Path, document: dict[str, Any], count: int, chance: random.Random) -> dict[str, Any]:
    """Cut off ``count`` runs, each once or twice, go on with each; count which of them end at another history."""
    problem = folder / "problem.json"
    problem.write_text(json.dumps(document), encoding="utf-8")
    began = time.monotonic()
    assert os.waitstatus_to_exitcode(os.waitpid(forked(lambda: main(command(problem, folder / "whole"))), 0)[1]) == 0
    seconds = time.monotonic() - began
    expected = history(folder / "whole")
    size = 2 * sum((folder / "whole" / name).stat().st_size for name in ("evaluations.csv", "responses.npz"))
    ends: list[int] = []
    different = unfinished = 0
    for trial in range(count):
        output = folder / f"run{trial}"
        for part in range(1 + trial % 2):
            options = ["--resume"] if part else []
            ends.append(cut_off(CUTS[trial % 3], command(problem, output, *options), chance, seconds, size))
        unfinished += (output / "run.journal").exists()
        code = os.waitpid(forked(lambda path=output: main(command(problem, path, "--resume"))), 0)[1]  # type: ignore[misc]
        different += code != 0 or history(output) != expected or (output / "run.journal").exists()
    return {"different": different, "unfinished": unfinished, "ends": ends}


def command(problem: Path, output: Path, *options: str) -> list[str]:
    """The command line of one run."""
    return ["run", str(problem), "--output", str(output), "--json", *options]


if __name__ == "__main__":
    run.figures_missing = lambda _what: "figures are not wanted here"
    swarm = decay_document(stopping={"max_evaluations": 400})
    learning = decay_document(
        stopping={"max_evaluations": 48}, method={"kind": "particle_swarm", "particles": 8, "polish": True}
    )
    main(["check", str(Path(sys.argv[1]) / "none.json")])  # what it loads is loaded once for all children
    found = []
    for name in sys.argv[3:]:
        document = {"swarm": swarm, "learning": learning}[name]
        (Path(sys.argv[1]) / name).mkdir()
        found.append(trials(Path(sys.argv[1]) / name, document, int(sys.argv[2]), random.Random(20)))
    sys.stdout.write("\n" + json.dumps(found))
