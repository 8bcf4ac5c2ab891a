"""Test runs of problems that are not jobs yet, outside the process that was asked for them."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.problem import Problem
from geoswarm.solver.runner.evaluator import Evaluator, InlineEvaluator, RunLimits
from geoswarm.solver.runner.kernels import make_ready
from geoswarm.solver.runner.runner import Runner
from geoswarm.solver.runs.check import CheckReport, check_problem
from geoswarm.workers.settings import Settings

__all__ = ["Sandbox", "limits_of"]


class Sandbox:
    """Makes one test run at a time, in an evaluation process that the limits of a worker hold for.

    Safe to use from several threads. The process is started by the first test run and stays for the next.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._lock = threading.Lock()
        self._evaluator: Evaluator | None = None
        self._number = 0

    def check(self, problem: Problem) -> CheckReport:
        """Make a test run and estimate the cost of a problem; see :func:`geoswarm.solver.runs.check.check_problem`."""
        with self._lock:
            self._number += 1
            return check_problem(problem, self._evaluate)

    def fields(self, problem: Problem, parameters: FloatArray, part: str) -> Evaluation:
        """Run a forward calculation for the fields of a body, see :mod:`geoswarm.solver.runner.evaluator`."""
        with self._lock:
            self._number += 1
            return self._evaluate(Calibration(problem, 0), parameters, part)

    def evaluate(self, problem: Problem, parameters: Sequence[float]) -> Evaluation:
        """Run a forward calculation with natural values of the free parameters."""
        with self._lock:
            self._number += 1
            return self._evaluate(Calibration(problem, 0), np.array(parameters, dtype=np.float64))

    def close(self) -> None:
        """End the evaluation process."""
        with self._lock:
            if self._evaluator is not None:
                self._evaluator.close()
            self._evaluator = None

    def _evaluate(self, calibration: Calibration, position: FloatArray, fields: str | None = None) -> Evaluation:
        if self._evaluator is None:
            self._evaluator = Runner(self._settings.passed_environment) if self._settings.isolate else InlineEvaluator()
            self._evaluator.start()
        make_ready(self._evaluator, calibration.problem)
        limits = limits_of(calibration.problem, self._settings).within(
            self._settings.check_seconds, of_time="GEOSWARM_CHECK_SECONDS of the service"
        )
        name = f"test run {self._number}"
        (outcome,) = self._evaluator.run(name, calibration, position[np.newaxis], limits, fields=fields)
        return outcome.evaluation


def limits_of(problem: Problem, settings: Settings) -> RunLimits:
    """Return the limits of a problem, and of these workers where they are tighter."""
    most = (settings.evaluation_seconds, settings.evaluation_memory_mb)
    return RunLimits.of(problem).within(*most, of_time="GEOSWARM_EVALUATION_SECONDS of the workers")
