"""How long a user waits: commands that start, answer and end, and a fresh worker process up to its first evaluation.

Run with ``python benchmarks/start_up.py``; medians of nine runs, kernels compiled and cached before, the commands in
turn. ``--against FOLDER`` takes turns with another checkout, whose kernels are compiled too, and gives the ratios. On a
machine that others use, processor time tells more than wall time.
"""

from __future__ import annotations

import argparse
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
PROBLEM = EXAMPLES / "oedometer" / "problem.yaml"
VALUES = ("--set", "lambda_star=0.064", "--set", "kappa_star=0.035", "--set", "c=27")
RUNS = 9
HELP_LIMIT, COMMAND_LIMIT, WORKER_LIMIT = 0.4, 1.0, 1.5

# What an embedded worker process does: everything it imports, the problem from its document, one evaluation. Its
# modules are named where they stand in this checkout, so it is not compared with another.
WORKER = """
import json, sys
import geoswarm.workers.hosts.embedded_worker
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.problem import parse_problem
calibration = Calibration(parse_problem(json.loads(sys.stdin.read())), 2008)
evaluation = calibration.evaluate(Course(calibration).start().positions[0])
assert evaluation.reason is None, evaluation.message
"""


class Seconds(NamedTuple):
    """Wall and processor time of a process [s]."""

    wall: float
    processor: float


def seconds_of(command: list[str], root: Path, text: str = "", code: int = 0) -> Seconds:
    """Return what a command takes with the sources below ``root``; it must end with this exit code."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPATH"] = str(root)
    began, before = time.perf_counter(), os.times()
    done = subprocess.run(
        [sys.executable, "-P", *command], input=text, text=True, capture_output=True, cwd=root, env=environment
    )
    wall, after = time.perf_counter() - began, os.times()
    processor = after.children_user + after.children_system - before.children_user - before.children_system
    if done.returncode != code:
        raise SystemExit(f"{command} ended with {done.returncode}: {done.stderr}")
    return Seconds(wall, processor)


@contextmanager
def service(root: Path) -> Iterator[str]:
    """Run a service with no job; gives its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-m", "geoswarm", "serve", "--workers", "1", "--port", str(port)]
        command += ["--database", f"sqlite:///{folder}/jobs.db"]
        nowhere = subprocess.DEVNULL
        serving = subprocess.Popen(
            command, stdout=nowhere, stderr=nowhere, cwd=root, env=os.environ | {"PYTHONPATH": str(root)}
        )
        try:
            while serving.poll() is None:
                with socket.socket() as door:
                    if door.connect_ex(("127.0.0.1", port)) == 0:
                        break
                time.sleep(0.1)
            yield f"http://127.0.0.1:{port}"
        finally:
            serving.terminate()
            serving.wait()


def commands(folder: Path, url: str) -> dict[str, tuple[list[str], int, float | None]]:
    """Return what is measured: name, arguments, exit code, and limit [s] or None."""
    wrong = folder / "wrong.yaml"
    wrong.write_text(PROBLEM.read_text().replace("particles: 10", "particles: ten"))
    for data in PROBLEM.parent.glob("*.csv"):
        (folder / data.name).write_bytes(data.read_bytes())
    asked = {
        "--help": (["--help"], 0, HELP_LIMIT),
        **{
            f"check {name}": (["check", str(EXAMPLES / name / "problem.yaml")], 0, COMMAND_LIMIT)
            for name in ("oedometer", "isotropic_compression", "combined", "formula")
        },
        "check slope (two runs of finite elements)": (["check", str(EXAMPLES / "slope" / "problem.yaml")], 0, None),
        "evaluate oedometer": (["evaluate", str(PROBLEM), *VALUES], 0, COMMAND_LIMIT),
        "list": (["list", "--url", url], 0, COMMAND_LIMIT),
        "check: no such file": (["check", str(folder / "none.yaml")], 2, COMMAND_LIMIT),
        "check: a mistake": (["check", str(wrong)], 2, COMMAND_LIMIT),
        "evaluate: a parameter unknown": (["evaluate", str(PROBLEM), "--set", "lambda=1"], 2, COMMAND_LIMIT),
        "evaluate: a parameter missing": (["evaluate", str(PROBLEM), "--set", "c=27"], 2, COMMAND_LIMIT),
        "list: no service": (["list", "--url", "http://127.0.0.1:9"], 2, COMMAND_LIMIT),
        "list: an unknown state": (["list", "--state", "gone"], 2, COMMAND_LIMIT),
    }
    return {name: (["-m", "geoswarm", *words], code, limit) for name, (words, code, limit) in asked.items()}


def median(taken: list[Seconds]) -> Seconds:
    """Return the medians of wall and of processor times."""
    return Seconds(*(statistics.median(times) for times in zip(*taken, strict=True)))


def medians(
    measured: dict[str, tuple[list[str], int, float | None]], roots: list[Path]
) -> dict[str, dict[Path, Seconds]]:
    """Return the medians; one round before them fills caches and does not count."""
    seconds: dict[str, dict[Path, list[Seconds]]] = {name: {root: [] for root in roots} for name in measured}
    for _ in range(RUNS + 1):
        for name, (command, code, _limit) in measured.items():
            for root in roots:
                seconds[name][root].append(seconds_of(command, root, code=code))
    return {name: {root: median(taken[1:]) for root, taken in by_root.items()} for name, by_root in seconds.items()}


def first_evaluation() -> Seconds:
    """Return the medians of a worker's first evaluation, in this checkout."""
    document = subprocess.run(
        [
            sys.executable,
            "-c",
            "import json, sys; from pathlib import Path; from geoswarm.solver.problem import load_problem; "
            "print(json.dumps(load_problem(Path(sys.argv[1])).document()))",
            str(PROBLEM),
        ],
        check=True,
        capture_output=True,
        text=True,
        cwd=ROOT,
    ).stdout
    return median([seconds_of(["-c", WORKER], ROOT, document) for _ in range(RUNS + 1)][1:])


def main() -> int:
    """Print the medians beside their limits and those of the other checkout; 1 when a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, metavar="FOLDER", help="another checkout, kernels compiled")
    other = parser.parse_args().against
    roots = [ROOT] if other is None else [ROOT, other.resolve()]
    with tempfile.TemporaryDirectory() as folder, service(ROOT) as url:
        measured = commands(Path(folder), url)
        found = medians(measured, roots)
    limits = {name: limit for name, (_command, _code, limit) in measured.items()}
    worker = "a worker's first evaluation after start"
    found[worker], limits[worker] = {ROOT: first_evaluation()}, WORKER_LIMIT
    least, exceeded = found["--help"][ROOT], False
    print(f"{'':<42} {'wall time':>22}   {'processor time':>22}   " + ("ratios to the other" if other else ""))
    for name, by_root in found.items():
        seconds, limit = by_root[ROOT], limits[name]
        parts = [f"{one:6.3f} s {one / of:5.1f} of --help" for one, of in zip(seconds, least, strict=True)]
        if len(by_root) > 1:
            parts.append(" ".join(f"{one / of:5.2f}" for one, of in zip(seconds, by_root[roots[1]], strict=True)))
        if limit is not None:
            exceeded |= seconds.wall > limit
            parts.append(f"limit {limit:.1f} s {'ok' if seconds.wall <= limit else 'TOO SLOW'}")
        print(f"{name:<42} {'   '.join(parts)}", flush=True)
    return int(exceeded)


if __name__ == "__main__":
    sys.exit(main())
