"""What a run of a program costs beyond starting it: folder, templates, limits, reading; and what 10 000 runs leave.

Run with ``python benchmarks/programs.py``; medians of the runs in a table, one process. The program is ``cp``.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import psutil

from geoswarm.solver.external.runs.folder import private_folder
from geoswarm.solver.problem import load_problem

RUNS = 300
LIMIT = 8.0e-3  # s
LEFT_RUNS = 10_000
HUGE = 2 * 1024**3

PROBLEM = """\
forward_model:
  kind: command
  run: [cp, input.csv, out.csv]
  templates: {input.csv: input.in}
  link: [mesh.bin]
  series: {y: {file: out.csv, x: x, y: y}}
parameters: {a: {lower: 0, upper: 1}, b: {lower: 0, upper: 1}}
observations: [{series: y, points: {x: [0, 1, 2, 3], y: [0, 1, 2, 3]}}]
stopping: {max_evaluations: 10}
"""


def seconds_of(call: Callable[[], object], runs: int) -> float:
    """Return the median wall time [s] of calling something."""
    taken = []
    for _ in range(runs):
        began = time.perf_counter()
        call()
        taken.append(time.perf_counter() - began)
    return statistics.median(taken)


def main() -> int:
    """Print the table; 1 when the limit is exceeded or something is left."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tempfile.tempdir = name  # run folders of nobody else are counted
        (folder / "input.in").write_text("x,y\n" + "".join(f"{x},{{{{a}}}}\n" for x in range(4)) + "# {{b}}\n")
        with (folder / "mesh.bin").open("wb") as file:
            file.truncate(HUGE)  # a hole: linked, it is never read in a run
        (folder / "problem.yaml").write_text(PROBLEM)
        began = time.perf_counter()
        problem = load_problem(folder / "problem.yaml")
        loaded = time.perf_counter() - began
        run = problem.model.prepare({o.series: o.x for o in problem.observations})
        values = {"a": 0.5, "b": 0.25}
        run(values)
        bare = seconds_of(lambda: subprocess.run(["cp", "input.in", "copy"], check=True, cwd=folder), RUNS)
        ours = seconds_of(lambda: run(values), RUNS)
        before = len(list(private_folder("runs").iterdir())), psutil.Process().num_fds()
        many = LEFT_RUNS if "--many" in sys.argv else 500
        for _ in range(many):
            run(values)
        after = len(list(private_folder("runs").iterdir())), psutil.Process().num_fds()
    print(f"read the problem, with the fingerprint of a linked file of 2 GB: {loaded:.2f} s")
    print(f"the program itself {1e3 * bare:.2f} ms, a run {1e3 * ours:.2f} ms: {1e3 * (ours - bare):.2f} ms beyond it")
    print(f"{many} further runs: {after[0] - before[0]} folders and {after[1] - before[1]} open files more")
    print(f"children: {len(psutil.Process().children(recursive=True))}")
    return int(ours - bare > LIMIT or after != before)


if __name__ == "__main__":
    sys.exit(main())
