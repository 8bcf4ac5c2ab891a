"""How long a user waits: ``geoswarm --help``, and a fresh worker process up to its first evaluation.

Run with ``python benchmarks/start_up.py``; medians of several runs, kernels compiled and cached before.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROBLEM = ROOT / "examples" / "oedometer" / "problem.yaml"
RUNS = 9
HELP_LIMIT, WORKER_LIMIT = 0.4, 1.5

# What an embedded worker process does: everything it imports, the problem from its document, one evaluation.
WORKER = """
import json, sys
import geoswarm.workers.hosts.embedded_worker
from geoswarm.solver.warm import import_models
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.problem import parse_problem
import_models()
calibration = Calibration(parse_problem(json.loads(sys.stdin.read())), 2008)
evaluation = calibration.evaluate(calibration.start().positions[0])
assert evaluation.reason is None, evaluation.message
"""


def median_seconds(command: list[str], text: str = "") -> float:
    """Return the median wall time [s] of a command; the first run, which fills caches, does not count."""
    seconds = []
    for _ in range(RUNS + 1):
        began = time.perf_counter()
        subprocess.run(command, input=text, text=True, check=True, capture_output=True, cwd=ROOT)
        seconds.append(time.perf_counter() - began)
    return statistics.median(seconds[1:])


def main() -> int:
    """Print the medians beside their limits; 1 when one is exceeded."""
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
    measured = {
        "geoswarm --help": (median_seconds([sys.executable, "-m", "geoswarm", "--help"]), HELP_LIMIT),
        "a worker's first evaluation after start": (
            median_seconds([sys.executable, "-c", WORKER], document),
            WORKER_LIMIT,
        ),
    }
    for name, (seconds, limit) in measured.items():
        print(f"{name:<42} {seconds:6.3f} s   limit {limit:.1f} s   {'ok' if seconds <= limit else 'TOO SLOW'}")
    return 0 if all(seconds <= limit for seconds, limit in measured.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
