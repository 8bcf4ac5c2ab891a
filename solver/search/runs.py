"""What has been calculated so far, as a proposer sees it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Runs", "latest_residuals"]


@dataclass(frozen=True, slots=True)
class Runs:
    """All evaluations that a search learns from: those offered by earlier jobs, then (generation, particle) in order.

    Parameters
    ----------
    positions
        Natural values of the free parameters, shape (N, d).
    objectives
        f of every run, shape (N,); inf where it failed.
    residuals
        Gives the weighted residual vectors of chosen successful runs, indices (k,) -> (k, m), such that the squared
        length of a row is its objective: sqrt(w_g w_h / m_g) (y_calc - y_meas) over all series. A function, because
        only a selection is ever looked at and all of them may be too many for memory.
    responses
        Gives the calculated values of chosen successful runs of this job by series, indices (k,); none are known where
        runs are given by their residuals.
    """

    positions: FloatArray
    objectives: FloatArray
    residuals: Callable[[IntArray], FloatArray]
    responses: Callable[[IntArray], Sequence[Mapping[str, FloatArray]]] = lambda _: ()

    @classmethod
    def of(cls, positions: FloatArray, residuals: FloatArray) -> Runs:
        """From residual vectors in memory, shape (N, m); rows of failed evaluations are nan."""
        squared = np.sum(residuals * residuals, axis=1)
        return cls(positions, np.where(np.isfinite(squared), squared, np.inf), lambda chosen: residuals[chosen])

    @property
    def succeeded(self) -> BoolArray:
        """Whether a run has a residual vector, shape (N,)."""
        return np.asarray(np.isfinite(self.objectives))


def latest_residuals(runs: Runs | None, count: int) -> FloatArray:
    """Residuals of the last ``count`` of all runs, shape (count, m); nan where a run failed."""
    if runs is None:
        raise ValueError("this search needs the runs so far")
    succeeded = runs.succeeded[-count:]
    known = runs.residuals(np.nonzero(succeeded)[0] + len(runs.positions) - count)
    residuals: FloatArray = np.full((count, known.shape[1]), np.nan)
    residuals[succeeded] = known
    return residuals
