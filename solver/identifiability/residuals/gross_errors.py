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
_SHARE = 8  # at most one reading in so many is looked for, and one in any case
_MOST = 10
_MET = 1.2  # scatter of the others, over the stated error, up to which that error is believed
_FREE_LEVERAGE = 1e-6  # what the fit leaves of a reading that it does not follow


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
    kept = np.ones(len(residuals), dtype=np.bool_)
    tried: list[Excluded] = []
    count = 0
    for _ in range(min(max(len(own) // _SHARE, 1), _MOST)):
        found = _furthest(residuals, basis, own, kept, known)
        if found is None:
            break
        worst, limit = found
        tried.append(worst)
        kept[worst.index] = False
        if abs(worst.deviations) > limit:
            count = len(tried)
    return tuple(sorted(tried[:count], key=lambda one: -abs(one.deviations)))


def _furthest(
    residuals: FloatArray, basis: FloatArray, own: IntArray, kept: np.ndarray, known: bool
) -> tuple[Excluded, float] | None:
    """The reading furthest from the others among those kept, and the limit of its distance; None with too few."""
    rows = np.flatnonzero(kept)
    orthonormal = np.linalg.qr(basis[rows])[0] if basis.shape[1] else basis[rows]
    left = residuals[rows] - orthonormal @ (orthonormal.T @ residuals[rows])
    inside = np.isin(rows, own)
    rest = 1.0 - np.sum(orthonormal[inside] ** 2, axis=1)
    free = float(rest.sum())
    usable = rest > _FREE_LEVERAGE
    if free < _FEWEST_FREE or not usable.any():
        return None
    own_left = left[inside]
    safe = np.where(usable, rest, 1.0)
    apart = np.where(usable, own_left**2 / safe, 0.0)
    # residuals and leverages of all readings of the series, in rows, without the one of the column
    hat = orthonormal[inside] @ orthonormal[inside].T
    without = own_left[:, None] + hat * (own_left / safe)
    leverages = np.diag(hat)[:, None] + hat**2 / safe
    np.fill_diagonal(without, 0.0)
    np.fill_diagonal(leverages, 1.0)
    degrees = np.sum(1.0 - leverages, axis=0)
    others = np.sqrt(np.sum(without**2, axis=0) / np.maximum(degrees, _LEAST_FREE))
    if known:
        others = np.maximum(others, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        distances = np.where((apart > 0.0) & (degrees >= _LEAST_FREE), np.sqrt(apart) / others, 0.0)
    worst = int(np.argmax(distances))
    probability = GROSS_LEVEL / (2.0 * int(inside.sum()))
    trusted = known and others[worst] <= _MET
    limit = float(-ndtri(probability)) if trusted else float(-stdtrit(degrees[worst], probability))
    sign = float(np.sign(own_left[worst]))
    return Excluded(
        int(rows[inside][worst]), sign * float(distances[worst]), float(own_left[worst] / rest[worst])
    ), limit
