"""What has been calculated so far, as a proposer sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.arrays import BoolArray, FloatArray

__all__ = ["Runs"]


@dataclass(frozen=True, slots=True)
class Runs:
    """All evaluations of a job in (generation, particle) order.

    Parameters
    ----------
    positions
        Natural values of the free parameters, shape (N, d).
    residuals
        Weighted residual vectors, shape (N, m), such that the squared length of a row is its objective:
        sqrt(w_g w_h / m_g) (y_calc - y_meas) over all series. Rows of failed evaluations are nan.
    """

    positions: FloatArray
    residuals: FloatArray

    @property
    def objectives(self) -> FloatArray:
        """f of every run, shape (N,); inf where it failed."""
        squared = np.sum(self.residuals * self.residuals, axis=1)
        return np.where(np.isfinite(squared), squared, np.inf)

    @property
    def succeeded(self) -> BoolArray:
        """Whether a run has a residual vector, shape (N,)."""
        return np.asarray(np.isfinite(self.residuals).all(axis=1))
