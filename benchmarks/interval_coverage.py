"""How often 95 % intervals hold the truth: repeated experiments with a known one.

Run with ``python benchmarks/interval_coverage.py [--repeats 1000] [--posteriors 100] [NAME ...]``. Intervals are those
of a report: at the polished optimum, widened where residuals are correlated, by likelihood where the model is
nonlinear. Those of the posterior come from a search of 300 runs, without a further one. Exits with 1 when a goal is
missed by more than chance explains (two standard errors). ``--series`` instead prints what intervals hold by the number
of readings and the correlation of their errors, unseen and unstated.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from math import sqrt
from typing import Any

import numpy as np
from scipy.special import stdtrit

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, Samples, from_evaluations
from geoswarm.solver.identifiability.optimum.bending import likelihood_intervals
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.identifiability.stored.posterior import sample_posterior
from geoswarm.solver.identifiability.stored.verdicts import WIDTH_LIMIT
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate

Curve = Callable[[FloatArray, FloatArray], FloatArray]
NOMINAL = (0.93, 0.97)
CAUTIOUS = (0.93, 1.0)
"""Below 50 readings intervals allow for a correlation that these cannot exclude."""
AT_LEAST = (0.90, 1.0)
SWARM = {"kind": "particle_swarm", "particles": 20, "acceleration": "none"}


@dataclass(frozen=True)
class Case:
    """A model with its truth, its readings and their errors.

    Parameters
    ----------
    formula, curve
        The model, and once more in NumPy: curve(truth (d,), x (n,)).
    truth, bounds
        Of a, b, ...
    count, sigma
        Readings between x = 0 and 4, and the standard deviation of their errors.
    rho
        Correlation of an error with the one before.
    outliers
        Share of the readings with errors ten times as large.
    loss
        Of the observation.
    scale
        Of the parameters.
    goal
        Least and largest share of the intervals that hold the truth; the upper end of what robust and correlated ones
        may hold is no goal.
    posterior
        Intervals are those of the posterior sample.
    """

    formula: str
    curve: Curve
    truth: tuple[float, ...]
    bounds: tuple[tuple[float, float], ...]
    count: int
    sigma: float
    rho: float = 0.0
    outliers: float = 0.0
    loss: str | None = None
    goal: tuple[float, float] = NOMINAL
    posterior: bool = False
    scale: str = "linear"

    def problem(self, random: np.random.Generator) -> Problem:
        """One experiment."""
        x = np.linspace(0.0, 4.0, self.count)
        error = random.standard_normal(self.count)
        for i in range(1, self.count):
            error[i] = self.rho * error[i - 1] + sqrt(1.0 - self.rho**2) * error[i]
        far = random.uniform(size=self.count) < self.outliers
        y = self.curve(np.array(self.truth), x) + self.sigma * np.where(far, 10.0, 1.0) * error
        observed: dict[str, Any] = {"series": "y", "points": {"x": x.tolist(), "y": y.tolist()}}
        if self.loss is not None:
            observed |= {"loss": self.loss, "error": self.sigma}
        names = "abcdefg"[: len(self.truth)]
        return parse_problem(
            {
                "forward_model": {"kind": "formula", "series": {"y": self.formula}},
                "parameters": {
                    n: {"lower": low, "upper": high, "scale": self.scale}
                    for n, (low, high) in zip(names, self.bounds, strict=True)
                },
                "observations": [observed],
                "method": SWARM,
                "answer": {"max_evaluations": "off"},
                "stopping": {"max_evaluations": 300},
            }
        )

    def intervals(self, problem: Problem, seed: int) -> FloatArray:
        """95 % intervals of one experiment, shape (d, 2); nan where there is none."""
        calibration = Calibration(problem, seed)
        if self.posterior:
            samples = Samples.from_result(problem, calibrate(problem, seed=seed))
            return sample_posterior(calibration, samples, steps=4000, seed=seed).intervals
        return self.report(calibration).intervals

    def report(self, calibration: Calibration) -> Linearisation:
        """What a report says of the optimum."""
        best = polish(calibration, np.array(self.truth)).parameters
        found = from_evaluations(calibration, *evaluate_differences(calibration, best))
        return likelihood_intervals(calibration, found)


def line(p: FloatArray, x: FloatArray) -> FloatArray:
    """A straight line."""
    return np.asarray(p[0] + p[1] * x)


def rise(p: FloatArray, x: FloatArray) -> FloatArray:
    """Saturation, mildly curved at this noise."""
    return np.asarray(p[0] * (1.0 - np.exp(-p[1] * x)))


def banana(p: FloatArray, x: FloatArray) -> FloatArray:
    """One combination that is bent, b - a^2, known ten times better than a."""
    return np.asarray(p[0] * x + 10.0 * (p[1] - p[0] ** 2) * np.exp(-x))


def _line(count: int, **options: Any) -> Case:
    return Case("a + b * x", line, (1.0, 0.5), ((-20.0, 20.0), (-20.0, 20.0)), count, 0.05, **options)


def _rise(count: int, **options: Any) -> Case:
    return Case("a * (1 - exp(-b * x))", rise, (2.0, 0.8), ((0.1, 10.0), (0.05, 8.0)), count, 0.05, **options)


def _banana(**options: Any) -> Case:
    bounds = ((-1.0, 4.0), (-4.0, 14.0))
    return Case("a * x + 10 * (b - a**2) * exp(-x)", banana, (1.2, 1.5), bounds, 20, 0.3, goal=AT_LEAST, **options)


CASES = {
    "line, 20 readings": _line(20, goal=CAUTIOUS),
    "curve, 20 readings": _rise(20, goal=CAUTIOUS),
    "curve, 50 readings": _rise(50),
    "AR(1) 0.8, line, 20 readings": _line(20, rho=0.8, goal=AT_LEAST),
    "AR(1) 0.8, line, 50 readings": _line(50, rho=0.8, goal=AT_LEAST),
    "AR(1) 0.8, curve, 40 readings": _rise(40, rho=0.8, goal=AT_LEAST),
    "outliers, huber, line, 50 readings": _line(50, outliers=0.1, loss="huber"),
    "outliers, cauchy, line, 50 readings": _line(50, outliers=0.1, loss="cauchy"),
    "banana, by likelihood": _banana(),
    "banana, posterior": _banana(posterior=True),
}


def held(case: Case, repeats: int) -> Iterator[tuple[BoolArray, BoolArray]]:
    """Whether each interval holds the truth, and whether there is one, shape (d,), repeat after repeat."""
    random = np.random.default_rng(2026)
    truth = np.array(case.truth)
    for seed in range(repeats):
        found = case.intervals(case.problem(random), seed)
        yield (found[:, 0] <= truth) & (truth <= found[:, 1]), np.isfinite(found).all(axis=1)


def print_series(repeats: int, seed: int) -> None:
    """A (1 - exp(-k x)), noise of 0.1, by readings and correlation; the usual intervals are those of white noise."""
    print("| readings | correlation | usual | held | widened, median | identified, truth outside |")
    print("|---|---|---|---|---|---|")
    for count, rho in product((5, 8, 15, 25, 40, 100), (0.0, 0.3, 0.5, 0.8)):
        case = replace(_rise(count, rho=rho), sigma=0.1, bounds=((0.1, 100.0), (0.02, 20.0)), scale="log")
        random = np.random.default_rng([seed, count, int(10 * rho)])
        truth, rows = np.array(case.truth), []
        for _ in range(repeats):
            found = case.report(Calibration(case.problem(random), 1))
            half = float(stdtrit(found.degrees_of_freedom, 0.975)) * found.standard_errors / found.optimum
            usual = np.abs(np.log(found.optimum / truth)) <= half
            low, high = found.intervals.T
            outside = (truth < low) | (truth > high)
            sure = (found.unit_widths <= WIDTH_LIMIT) & [
                not (found.fit.wrong or found.needs_profile(n)) for n in found.names
            ]
            rows.append([usual, ~outside, found.widening, outside & sure])
        usual, held, widened, wrong = np.array(rows, dtype=np.float64).transpose(1, 0, 2)
        shares = (100.0 * share.mean(axis=0) for share in (usual, held, wrong))
        first, second, third = (", ".join(f"{value:.1f}" for value in share) + " %" for share in shares)
        middle = ", ".join(f"{value:.2f}" for value in np.median(widened, axis=0))
        print(f"| {count} | {rho:g} | {first} | {second} | {middle} | {third} |", flush=True)


def main() -> int:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=1000)
    parser.add_argument("--posteriors", type=int, default=100, help="repeats of posterior samples, of seconds each")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"any of {', '.join(CASES)}")
    parser.add_argument("--series", action="store_true", help="by the number of readings and their correlation instead")
    parser.add_argument("--seed", type=int, default=2026, help="of the readings of --series")
    given = parser.parse_args()
    if given.series:
        print_series(given.repeats, given.seed)
        return 0
    missed = 0
    print("| case | repeats | held | without an interval |\n|---|---|---|---|")
    for name in given.names or CASES:
        case = CASES[name]
        repeats = given.posteriors if case.posterior else given.repeats
        told = list(held(case, repeats))
        there = np.array([known for _, known in told])
        inside = np.array([holds for holds, _ in told])
        shares = [float(holds[known].mean()) for holds, known in zip(inside.T, there.T, strict=True)]
        chance = 2.0 * sqrt(0.05 * 0.95 / repeats)
        missed += any(not case.goal[0] - chance <= share <= case.goal[1] + chance for share in shares)
        words = ", ".join(f"{100.0 * share:.1f}" for share in shares)
        print(f"| {name} | {repeats} | {words} % | {100.0 * (1.0 - there.mean()):.1f} % |", flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
