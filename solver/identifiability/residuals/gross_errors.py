"""Readings that the others of their series exclude: gross errors of reading, writing or transmission.

Externally studentised residuals (Cook and Weisberg 1982, section 2.2.2) compare a reading with what the others say of
it, by their scatter alone; several errors are looked for with the generalised extreme studentised deviate (Rosner
1983, Technometrics 25), which a pair of errors cannot hide from as from one test after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["GROSS_LEVEL", "Excluded", "excluded_readings"]

GROSS_LEVEL = 0.01
"""Probability of naming any reading of a series that is right, under normal noise."""

_FEWEST_FREE = 3.0  # readings of a series beyond the parameters that they determine
_LEAST_FREE = 1.5  # the same, without the one that is compared with the others
_SHARE = 8  # at most one reading in this number is looked for, and one in any case
_MOST = 10
_MET = 1.2  # scatter of the others, over the stated error, up to which that error is believed
_FREE_LEVERAGE = 1e-6  # what the fit leaves of a reading that it does not follow
_ROUNDING = 1e-9  # of sums of leverages
_LIKELY = 20  # readings furthest from the fit of all that are compared with what the others say alone
_COMPARED = 4_000_000  # readings times those compared with them, at most


@dataclass(frozen=True, slots=True)
class Excluded:
    """One reading that the others exclude.

    Parameters
    ----------
    index
        Of the reading, in the arrays that were given.
    deviations
        Its distance from what the others say, in standard deviations of their scatter and of that prediction.
    expected
        Its residual, calculated - measured, that the others exclude: from their fit, in units of the noise.
    """

    index: int
    deviations: float
    expected: float

    def is_beside(self, other: Excluded) -> bool:
        """Whether another one is its neighbour, on the same side of the curve."""
        return abs(self.index - other.index) == 1 and self.deviations * other.deviations > 0.0


def excluded_readings(residuals: FloatArray, basis: FloatArray, own: IntArray, *, known: bool) -> tuple[Excluded, ...]:
    """Find the readings of one series that its others exclude.

    Parameters
    ----------
    residuals
        Of all readings of all series, in units of their noise, shape (n,), at the minimum or one step away from it.
    basis
        Orthonormal columns that the parameters can change, shape (n, rank).
    own
        Readings of the series, shape (m,).
    known
        The unit of the residuals is a stated error, not an estimate.

    Returns
    -------
    tuple of Excluded
        The furthest first; empty where there are too few readings to tell.
    """
    kept, tried, count = own, list[Excluded](), 0
    gram, along = basis.T @ basis, basis.T @ residuals  # of all readings that are still in
    for _ in range(min(max(len(own) // _SHARE, 1), _MOST)):
        found = _furthest(kept, residuals[kept], basis[kept], gram, along, known)
        if found is None:
            break
        worst, limit = found
        tried.append(worst)
        kept, row = kept[kept != worst.index], basis[worst.index]
        gram, along = gram - np.outer(row, row), along - row * residuals[worst.index]
        if abs(worst.deviations) > limit:
            count = len(tried)
    return tuple(sorted(tried[:count], key=lambda one: -abs(one.deviations)))


def _furthest(
    indices: IntArray, residuals: FloatArray, rows: FloatArray, gram: FloatArray, along: FloatArray, known: bool
) -> tuple[Excluded, float] | None:
    """The reading of a series that is furthest from its others, and the limit of its distance; None with too few.

    Parameters
    ----------
    indices, residuals, rows
        Of the readings of the series, shapes (m,), (m,) and (m, rank).
    gram, along
        Products of the rows of all readings of all series with each other, and with the residuals.
    """
    coefficients, solved = np.linalg.solve(gram, along), np.linalg.solve(gram, rows.T)
    left = residuals - rows @ coefficients
    leverages = np.sum(rows * solved.T, axis=1)
    rest = 1.0 - leverages
    if float(rest.sum()) < _FEWEST_FREE - _ROUNDING:
        return None
    usable = np.flatnonzero((rest > _FREE_LEVERAGE) & (left != 0.0))
    most = min(_LIKELY, max(_COMPARED // len(left), 1))
    likely = usable[np.argsort(-np.abs(left[usable]) / np.sqrt(rest[usable]), kind="stable")[:most]]
    # residuals and leverages of all readings of the series, in rows, without the one of the column
    hat = rows @ solved[:, likely]
    without = left[:, None] + hat * (left[likely] / rest[likely])
    degrees = 1.0 - leverages[:, None] - hat**2 / rest[likely]
    without[likely, np.arange(likely.size)] = degrees[likely, np.arange(likely.size)] = 0.0
    free = np.sum(degrees, axis=0)
    others = np.sqrt(np.sum(without**2, axis=0) / np.maximum(free, _LEAST_FREE))
    if known:
        others = np.maximum(others, 1.0)
    with np.errstate(divide="ignore"):
        distances = np.abs(left[likely]) / np.sqrt(rest[likely]) / others
    distances[free < _LEAST_FREE] = 0.0
    if not distances.any():
        return None
    place = int(np.argmax(distances))
    worst = int(likely[place])
    probability = GROSS_LEVEL / (2.0 * len(indices))
    trusted = known and others[place] <= _MET
    limit = float(-ndtri(probability)) if trusted else float(-stdtrit(free[place], probability))
    deviations = float(np.copysign(distances[place], left[worst]))
    return Excluded(int(indices[worst]), deviations, float(left[worst] / rest[worst])), limit
