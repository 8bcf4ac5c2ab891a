"""How long a report takes: of a 2000-run job, and the matrix plot of 20 000 points in six parameters.

Run with ``python benchmarks/reports.py``; medians of several runs in one process, matplotlib loaded before. Limits are
for processor time, which other programs on the machine do not stretch; exits with 1 when one is not kept.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, analyse
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.report.document.build import Report
from geoswarm.solver.report.figures.figure_set import FigureSet
from geoswarm.solver.report.figures.style import png_of, svg_of
from geoswarm.solver.report.record import record_of_result
from geoswarm.solver.runs.local import calibrate

ROOT = Path(__file__).resolve().parents[1]
PROBLEM = ROOT / "examples" / "oedometer" / "problem.yaml"
RUNS = 3
REPORT_LIMIT = 5.0  # s, HTML and PDF with all figures, 2000 runs
MATRIX_LIMIT = 3.0  # s, 20 000 points, six parameters
MATRIX_BYTES = 5_000_000


def median_seconds(action: Callable[[], object]) -> tuple[float, float]:
    """Return the median processor and wall time [s]; the first run, which fills caches, does not count."""
    runs = []
    for _ in range(RUNS + 1):
        began = time.process_time(), time.perf_counter()
        action()
        runs.append((time.process_time() - began[0], time.perf_counter() - began[1]))
    processor, wall = zip(*runs[1:], strict=True)
    return statistics.median(processor), statistics.median(wall)


def sampled_oedometer() -> Problem:
    """The published sampling: five free parameters, 2000 runs."""
    document = load_problem(PROBLEM).document()
    document["parameters"] |= {
        "mu_star": {"lower": 1e-5, "upper": 0.75, "scale": "log"},
        "phi": {"lower": 8, "upper": 30},
    }
    return parse_problem(document | {"method": {"kind": "monte_carlo", "samples": 2000}, "stopping": {}})


def report_seconds() -> dict[str, tuple[float, float]]:
    """Time HTML, PDF and both of a 2000-run job, statistics and all figures included."""
    problem = sampled_oedometer()
    result = calibrate(problem, seed=1)
    samples, record = Samples.from_result(problem, result), record_of_result(problem, result)

    def report() -> Report:
        return Report(problem, record, samples, threshold=1e-7)

    def both() -> None:
        made = report()
        made.html()
        made.pdf()

    return {
        "html": median_seconds(lambda: report().html()),
        "pdf": median_seconds(lambda: report().pdf()),
        "html and pdf": median_seconds(both),
    }


def large_matrix() -> tuple[Problem, Samples, Any]:
    """20 000 points of a formula in six parameters."""
    names = "abcdef"
    x = np.linspace(0.1, 3.0, 12)
    document = {
        "forward_model": {"kind": "formula", "series": {"y": "a + b * x + c * x ** 2 + d * exp(-e * x) + f"}},
        "parameters": {
            name: {"lower": 0.1, "upper": 10.0, "scale": "log" if name in "ace" else "linear"} for name in names
        },
        "observations": [{"series": "y", "points": {"x": x.tolist(), "y": (2.0 + 3.0 * x + x**2).tolist()}}],
        "method": {"kind": "monte_carlo", "samples": 20_000, "batch": 1000},
        "seed": 1,
    }
    problem = parse_problem(document)
    result = calibrate(problem)
    return problem, Samples.from_result(problem, result), record_of_result(problem, result)


def main() -> int:
    """Print times and sizes; return the exit code."""
    late = False
    for form, (seconds, wall) in report_seconds().items():
        late |= seconds > REPORT_LIMIT
        print(f"report of 2000 runs, {form:<13} {seconds:6.2f} s, wall {wall:6.2f} s   (limit {REPORT_LIMIT:g} s)")
    problem, samples, record = large_matrix()
    found = analyse(Calibration(problem, 1), samples)
    for form, render in (("svg", svg_of), ("png", png_of)):

        def draw(render: Callable[..., bytes] = render) -> bytes:
            return render(FigureSet(problem, record, samples, found).draw("matrix"))

        (seconds, wall), size = median_seconds(draw), len(draw())
        late |= seconds > MATRIX_LIMIT or size > MATRIX_BYTES
        print(
            f"matrix 20 000 x 6, {form:<15} {seconds:6.2f} s, wall {wall:6.2f} s   {size / 1e6:.2f} MB   "
            f"(limits {MATRIX_LIMIT:g} s, {MATRIX_BYTES / 1e6:g} MB)"
        )
    return int(late)


if __name__ == "__main__":
    sys.exit(main())
