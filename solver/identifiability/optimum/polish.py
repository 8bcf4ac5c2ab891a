"""Polishing an optimum in this process: from where a search ended down to the minimum, as searches do that polish.

A swarm stops in the neighbourhood of the optimum; a few least-squares steps bring the digits that standard errors need.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.search.descent.refinement import Refinement
from geoswarm.solver.search.determinism import one_thread
from geoswarm.solver.search.runs import Runs

__all__ = ["Polished", "polish"]

_LONGEST = 200  # iterations, each of some generations


@dataclass(frozen=True, slots=True)
class Polished:
    """Result of :func:`polish`.

    Parameters
    ----------
    parameters
        Shape (d,), natural values.
    objective, start_objective
        f there and at the start; never above it.
    evaluation
        Of the forward calculation at ``parameters``.
    evaluations
        Forward calculations that it took.
    converged
        Whether it came to a minimum.
    at_bounds
        Parameters that ended on a bound.
    """

    parameters: FloatArray
    objective: float
    start_objective: float
    evaluation: Evaluation
    evaluations: int
    converged: bool
    at_bounds: tuple[str, ...]


def polish(calibration: Calibration, start: FloatArray, *, max_evaluations: int = 2000) -> Polished:
    """Minimise the objective from ``start`` by least squares inside the bounds.

    The descent with which a search ends that polishes (:mod:`geoswarm.solver.search.descent.refinement`), on the
    weighted residuals, whose squares sum up to f. Runs in sequence, in this process.

    Parameters
    ----------
    start
        Shape (d,), natural values inside the bounds.
    max_evaluations
        Forward calculations at most; the points of one step are evaluated together.

    Raises
    ------
    StatisticsError
        When the evaluation of the start fails.
    """
    made = _Made(calibration)
    first = made.add(np.asarray(start, dtype=np.float64))
    if first.objective is None:
        raise StatisticsError(f"the start of polishing fails ({first.reason}): {first.message}")
    space = calibration.space
    with one_thread():
        state = Refinement.begin(space, made.runs, 0)
        while not state.finished and len(made.evaluations) + len(state.asked) <= max_evaluations:
            for point in space.from_unit(state.asked):
                made.add(point)
            state = state.advance(space, made.runs, _LONGEST)
    last = made.evaluations[state.row]
    assert last.objective is not None
    unit = (space.to_search(last.parameters) - space.search_lower) / (space.search_upper - space.search_lower)
    ends = (unit <= 1e-9) | (unit >= 1.0 - 1e-9)
    return Polished(
        parameters=last.parameters,
        objective=last.objective,
        start_objective=first.objective,
        evaluation=last,
        evaluations=len(made.evaluations),
        converged=state.outcome == "converged",
        at_bounds=tuple(n for n, end in zip(calibration.free_names, ends, strict=True) if end),
    )


@dataclass
class _Made:
    """Evaluations made so far, as a descent sees them."""

    calibration: Calibration
    evaluations: list[Evaluation] = field(default_factory=list)

    def add(self, parameters: FloatArray) -> Evaluation:
        """Evaluate natural values, shape (d,)."""
        self.evaluations.append(self.calibration.evaluate(parameters))
        return self.evaluations[-1]

    @property
    def runs(self) -> Runs:
        """All of them; residuals are calculated on access."""
        objectives = [np.inf if run.objective is None else run.objective for run in self.evaluations]
        return Runs(np.array([run.parameters for run in self.evaluations]), np.array(objectives), self._residuals)

    def _residuals(self, chosen: IntArray) -> FloatArray:
        weighted = self.calibration.objective.weighted_residuals
        return np.array([weighted(self.evaluations[row].responses) for row in chosen.tolist()])
