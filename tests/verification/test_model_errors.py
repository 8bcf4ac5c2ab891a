"""What 95 % intervals hold under correlated noise and outliers; figures of 1000 repeats are in docs/statistics.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import from_evaluations
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import polish
from tests.solver.identifiability.cases import WHITE, free, problem_of


@dataclass(frozen=True)
class Study:
    """A line or a decay read ``count`` times, with noise of 0.1, ``outliers`` of them ten times as noisy.

    ``white``: the problem states that errors are independent.
    """

    bent: bool
    count: int
    rho: float = 0.0
    outliers: float = 0.0
    loss: str | None = None
    white: bool = False

    def covered(self, repeats: int) -> FloatArray:
        """Share of the intervals that hold the truth, shape (2,)."""
        random = np.random.default_rng(0)
        x = np.linspace(0.0, 2.0, self.count)
        truth = np.array([2.0, 1.0] if self.bent else [1.0, 2.0])
        formula = "a * exp(-b * x)" if self.bent else "a + b * x"
        bounds = free(0.05, 20.0) if self.bent else free(-50.0, 50.0)
        curve = truth[0] * np.exp(-truth[1] * x) if self.bent else truth[0] + truth[1] * x
        held = []
        for _ in range(repeats):
            noise = random.normal(0.0, 0.1, self.count)
            for i in range(1, self.count):
                noise[i] = self.rho * noise[i - 1] + np.sqrt(1.0 - self.rho**2) * noise[i]
            far = random.uniform(size=self.count) < self.outliers
            y = curve + noise + np.where(far, random.normal(0.0, 1.0, self.count), 0.0)
            section: dict[str, Any] = {"series": "y", "points": {"x": x.tolist(), "y": y.tolist()}}
            if self.loss is not None:
                section |= {"loss": self.loss, "error": 0.1}
            stated: dict[str, Any] = {"noise": WHITE} if self.white else {}
            given = {"a": bounds, "b": bounds}
            calibration = Calibration(problem_of(formula, given, y, x, observations=[section], **stated), 1)
            best = polish(calibration, truth).parameters
            found = from_evaluations(calibration, *evaluate_differences(calibration, best)).intervals
            held.append((found[:, 0] <= truth) & (truth <= found[:, 1]))
        return np.asarray(np.mean(held, axis=0))


@pytest.mark.parametrize("study", [Study(False, 20), Study(False, 50, rho=0.8), Study(True, 50, 0.0, 0.1, "huber")])
@pytest.mark.slow
def test_few_repeats(study: Study) -> None:
    assert (study.covered(60) >= 0.85).all()


@pytest.mark.slow
@pytest.mark.parametrize("study", [Study(False, 20, white=True), Study(True, 20, white=True), Study(False, 50)])
def test_right_models_are_held_as_stated(study: Study) -> None:
    share = study.covered(1000)
    assert (np.abs(share - 0.95) <= 0.02).all(), share


@pytest.mark.slow
@pytest.mark.parametrize(("count", "least"), [(8, 0.86), (15, 0.88), (20, 0.9), (50, 0.9), (200, 0.9)])
def test_correlated_residuals_are_held(count: int, least: float) -> None:
    share = Study(False, count, rho=0.8).covered(1000)
    assert (share >= least).all(), share


@pytest.mark.slow
@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy"])
def test_outliers_do_not_spoil_robust_intervals(loss: str) -> None:
    share = Study(False, 50, 0.0, 0.1, loss).covered(1000)
    assert (np.abs(share - 0.95) <= 0.03).all(), share
