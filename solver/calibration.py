"""Assembles a problem into what the evaluation of one particle needs: forward run, objective and search space."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, message_of
from geoswarm.solver.objective import LeastSquares, ObservedSeries
from geoswarm.solver.objective.outcome import Calculation, ForwardOutcome
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.running import Failures
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = [
    "Calibration",
    "Evaluation",
    "WarmStartRuns",
    "choose_seed",
    "objective_of",
    "search_space",
    "with_further_tries",
]


@dataclass(frozen=True, slots=True)
class WarmStartRuns:
    """Runs of earlier jobs with the same forward model that a search may learn from.

    Parameters
    ----------
    parameters
        Natural values of this problem's free parameters, shape (k, d).
    responses
        Calculated values of every observed series, k of them.
    """

    parameters: FloatArray
    responses: Sequence[Mapping[str, FloatArray]]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Outcome of one forward calculation; it failed if ``reason`` is not None.

    Parameters
    ----------
    parameters
        Natural values of the free parameters, shape (d,).
    objective
        f, None when failed.
    misfits, responses
        f'_g and calculated values, shape (m_g,), of each observed series; empty when failed, but for the responses of
        parts that a prediction keeps.
    reason, message
        Kind of failure (:data:`geoswarm.solver.errors.FailureReason`) and what happened; for a success, a note or None.
    seconds
        Wall time of the forward calculation [s].
    """

    parameters: FloatArray
    objective: float | None
    misfits: dict[str, float]
    responses: dict[str, FloatArray]
    reason: str | None
    message: str | None
    seconds: float


def objective_of(problem: Problem) -> LeastSquares:
    """The objective of a problem."""
    return LeastSquares(
        [ObservedSeries(o.series, o.x, o.y, o.point_weights, o.weight, o.loss, o.along) for o in problem.observations]
    )


class Calibration:
    """A problem made ready: its forward run, objective and search space.

    Parameters
    ----------
    problem, seed
        What to calibrate, and the seed of all random numbers.
    offer
        Runs of earlier jobs; used by an accelerated search.

    Raises
    ------
    ProblemError
        When the forward model cannot be prepared for the observed points.
    """

    def __init__(self, problem: Problem, seed: int, offer: WarmStartRuns | None = None) -> None:
        self.problem = problem
        self.seed = seed
        self.free_names = problem.free_names
        self.objective = objective_of(problem)
        self.grids = {o.series: o.x for o in problem.observations}
        self.space = search_space(problem)
        self.offered = None
        if offer is not None and len(offer.parameters):
            rows = np.array([self.objective.weighted_residuals(r) for r in offer.responses])
            self.offered = Runs.of(offer.parameters, rows)
        self._run = problem.model.prepare(self.grids)
        self._calculation = Calculation(self._run, self.objective.observed, keeps_parts=problem.method.keeps_parts)

    def make_ready(self) -> None:
        """Let the forward run load what it needs, outside any evaluation and its limits."""
        make_ready = getattr(self._run, "make_ready", None)
        if make_ready is not None:
            make_ready()

    def evaluate(self, parameters: FloatArray) -> Evaluation:
        """Run the forward calculation for natural values of the free parameters, shape (d,).

        Never raises for a failed forward run: the failure is in the returned evaluation.
        """
        refused = self.refused(parameters)
        return self.evaluate_values(self.problem.values(parameters.tolist())) if refused is None else refused

    def evaluate_values(self, values: Mapping[str, float]) -> Evaluation:
        """Run the forward calculation for values of all parameters by name."""
        parameters = np.array([values[name] for name in self.free_names], dtype=np.float64)
        return self.judged(parameters, self._calculation.outcome(values))

    def judged(self, parameters: FloatArray, outcome: ForwardOutcome) -> Evaluation:
        """Return the evaluation for a forward calculation, wherever it ran: its misfits and objective.

        Parameters
        ----------
        parameters
            Natural values of the free parameters, shape (d,).
        """
        reason, message = outcome.reason, outcome.message
        if reason is None:
            try:
                misfits = self.objective.misfits(outcome.responses)
            except ForwardError as error:
                reason, message = error.reason, message_of(error)
            else:
                value = self.objective.value(misfits)
                return Evaluation(parameters, value, misfits, outcome.responses, None, message, outcome.seconds)
        kept = {} if outcome.reason is None else outcome.responses
        return Evaluation(parameters, None, {}, kept, reason, message, outcome.seconds)

    def refused(self, parameters: FloatArray) -> Evaluation | None:
        """Return the failed evaluation of a follow-up at values that are not feasible; a search never asks for
        these."""
        if self.problem.method.role == "follow_up" and not self.space.feasible(parameters):
            return Evaluation(parameters, None, {}, {}, "infeasible", "the constraints are not satisfied there", 0.0)
        return None


def with_further_tries(failures: Failures, first: Evaluation, again: Callable[[], Evaluation]) -> Evaluation:
    """Return an evaluation, or that of its last retry."""
    evaluation, earlier = first, list[str]()
    while evaluation.reason is not None and failures.tries_again(evaluation.reason, earlier):
        earlier.append(evaluation.reason)
        evaluation = again()
    return evaluation


def choose_seed(seed: int | None) -> int:
    """Return the given seed, or a new 32-bit one; every result reports it."""
    return secrets.randbits(32) if seed is None else seed


def search_space(problem: Problem) -> SearchSpace:
    """Return the space of the free parameters of a problem."""
    return SearchSpace(
        names=problem.free_names,
        lower=np.array([p.lower for p in problem.free], dtype=np.float64),
        upper=np.array([p.upper for p in problem.free], dtype=np.float64),
        log=np.array([p.scale == "log" for p in problem.free], dtype=np.bool_),
        feasible=lambda x: problem.satisfies(problem.values(x.tolist())),
        integer=np.array([p.integer for p in problem.free], dtype=np.bool_),
    )
