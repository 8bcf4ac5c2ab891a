"""How the parameters scatter around an optimum: what the data determine, and what they leave open."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation

__all__ = ["Shape", "shape_of"]

_SINGULAR = 1e-12  # relative size of a singular value that is 0


@dataclass(frozen=True, slots=True)
class Shape:
    """Scatter around an optimum, in parts of the range.

    Parameters
    ----------
    root
        L with L L' the covariance of what the data determine, shape (d, r).
    open
        Orthonormal directions along which nothing measured changes, shape (d, k).
    degrees_of_freedom
        Of Student's t; infinite where the error of the readings is known.
    undecided
        Which parameters the data do not limit within the searched range, shape (d,).
    """

    root: FloatArray
    open: FloatArray
    degrees_of_freedom: float
    undecided: FloatArray

    @property
    def covariance(self) -> FloatArray:
        """Of what the data determine, shape (d, d)."""
        return np.asarray(self.root @ self.root.T)

    def exchanged(self, first: int, second: int) -> Shape:
        """The same with two parameters in each other's place."""
        order = np.arange(len(self.root))
        order[[first, second]] = second, first
        return replace(self, root=self.root[order], open=self.open[order], undecided=self.undecided[order])


def shape_of(linearisation: Linearisation) -> Shape:
    """Take the scatter from a linearisation; with correlated or uneven residuals as much wider as its widest interval.

    The pseudo-inverse G of the weighted derivatives over what they determine maps readings to estimates, so that the
    covariance is G S G' with S the variances of the weighted readings, and the null space of G' is what is left open.

    Raises
    ------
    StatisticsError
        When the error of a reading is neither known nor can be estimated, or its estimate is 0.
    """
    noise = linearisation.noise
    model = linearisation.model
    if noise is None:
        raise StatisticsError(
            "there are no more measured points than free parameters, so the error of a reading cannot be estimated, "
            "and with it the uncertainty of the parameters; give it (noise, or error in the problem)"
        )
    dimension = len(linearisation.names)
    rank = dimension - sum(combination.open for combination in linearisation.combinations)
    # All left vectors are wanted, and never those of the readings: their square is too large for a logger's file.
    left, singular, _ = np.linalg.svd(model.inverse, full_matrices=model.inverse.shape[1] < dimension)
    rank = min(rank, int((singular > _SINGULAR * max(float(singular.max(initial=0.0)), 1e-300)).sum()))
    scaled = model.inverse * np.sqrt(model.variances)
    if not float(np.abs(scaled).max(initial=0.0)) > 0.0 and rank:
        raise StatisticsError(
            "the readings are met to rounding, so they estimate no error, and the parameters would have no uncertainty"
            "; give the error of a reading (noise, or error in the problem)"
        )
    directions, spread, _ = np.linalg.svd(scaled, full_matrices=False)
    return Shape(
        directions[:, :rank] * spread[:rank] * linearisation.widest,
        left[:, rank:],
        float(noise.degrees_of_freedom),
        np.isnan(linearisation.linear_half_widths),
    )
