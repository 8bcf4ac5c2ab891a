"""How a polished search solves sixteen sets of the NIST archive from the start values that it gives.

Run with ``python -m benchmarks.search.nist [--seeds 5] [--runs 1000] [NAME ...]``. Bounds are the start values over 100
and times 100, of their sign, or over and times 1000, 10000 ... where the certified values lie outside; the scale is
``log``, as documented for bounds so far apart, and the start values are the ``initial`` ones. A search has solved a set
when its sum of squares is within 1 % of the certified one. Prints the table of docs/statistics.md.
"""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from tests.verification.nist.archive import NAMES, archive_set

FACTORS = (1e2, 1e3, 1e4, 1e5)
WITHIN = 1.01


def factor_of(name: str, start: int) -> float:
    """The least factor whose bounds hold the certified values; those of another sign than their start aside."""
    one = archive_set(name)
    ratio = np.abs(np.log(np.abs(one.certified / one.starts[start - 1])))
    return next(factor for factor in FACTORS if ratio.max() <= np.log(factor))


def solve(case: tuple[str, int, int], runs: int) -> tuple[float, int]:
    """Sum of squares over the certified one, and evaluations, of a set, a start and a seed."""
    name, start, seed = case
    one = archive_set(name)
    stopping = {"max_evaluations": runs}
    document = one.document(start, factor_of(name, start), "log", stopping=stopping, answer={"max_evaluations": "off"})
    for section, value in zip(document["parameters"].values(), one.starts[start - 1].tolist(), strict=True):
        section["initial"] = value if section["scale"] == "linear" else abs(value)
    problem = parse_problem(document)
    result = calibrate(problem, seed=seed)
    best = np.inf if result.objective is None else result.objective
    return best * len(one.x) / one.residual_sum_of_squares, result.evaluations


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=NAMES, metavar="NAME")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    print("| set | free | first start, of " + str(arguments.seeds) + " | runs | second start | runs |")
    print("|---|---|---|---|---|---|")
    with ProcessPoolExecutor(arguments.processes) as pool:
        for name in arguments.names:
            cells = [name, str(archive_set(name).starts.shape[1])]
            for start in (1, 2):
                cases = [(name, start, seed) for seed in range(1, arguments.seeds + 1)]
                ends = list(pool.map(partial(solve, runs=arguments.runs), cases))
                needed = [count for ratio, count in ends if ratio < WITHIN]
                lowest = min(ratio for ratio, _ in ends)
                solved = str(len(needed)) + ("" if needed else f" (lowest sum {lowest:.3g} times the certified one)")
                factor = factor_of(name, start)
                solved += "" if factor == FACTORS[0] else f" (bounds / and x {factor:g})"
                cells += [solved, f"{min(needed)} to {max(needed)}" if needed else ""]
            print("| " + " | ".join(cells) + " |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
