"""Noise that is not independent and even: what correlated residuals, and residuals of uneven size, do to intervals.

Used where the residuals show it, and for intervals alone: standard errors are those of independent noise of one size.
An interval is the wider of the two.

- *Correlated*: autoregressive of first order within a series. Residuals are less correlated than the noise, as the fit
  takes a part of it along, so the correlation rho is judged by the restricted likelihood (Patterson and Thompson 1971;
  Cressie and Lahiri 1993), and as few readings leave it uncertain, the interval is one of the mixture of Student's t
  over rho, each weighted by that likelihood. n readings are worth n (1 - rho) / (1 + rho) independent ones.
- *Uneven*: each residual stands for its own variance, r_i^2 / (1 - h_i)^2 with the leverage h_i (MacKinnon and White
  1985, HC3); the degrees of freedom follow from how few of them carry it (Lipsitz, Ibrahim and Parzen 1999).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import stdtr, stdtrit

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["Dependence", "allowed_deviations", "dependence_of"]

_SIGNIFICANT = 2.58  # of the correlation of sizes with x, times the root of n - 1: a level of 1 %
_FEWEST = 8
_RHO = np.linspace(0.0, 0.98, 50)
_LEAST_LEFT = 0.05  # of 1 - h
_FEWEST_FREE = 2.0


@dataclass(frozen=True, slots=True)
class Dependence:
    """How the noise of one series departs from independent and even noise.

    Parameters
    ----------
    series
        Its name.
    kind
        ``correlated`` or ``uneven``.
    rho
        Correlation of neighbouring readings; 0 for uneven ones.
    readings, effective
        Number, and how many independent ones they are worth.
    """

    series: str
    kind: Literal["correlated", "uneven"]
    rho: float
    readings: int
    effective: float

    @property
    def sentence(self) -> str:
        """What it means for intervals."""
        if self.kind == "correlated":
            return (
                f"{self.series}: neighbouring residuals are correlated ({self.rho:.2f}), so {self.readings} readings "
                f"are worth {self.effective:.0f} independent ones; intervals allow for that, standard errors do not."
            )
        return (
            f"{self.series}: the size of the residuals changes with x; intervals allow for that, standard errors do "
            "not, and weights from their spread would make better use of the readings (geoswarm reweight --weighting "
            "by_spread)."
        )


def dependence_of(series: str, scaled: FloatArray, basis: FloatArray, correlated: bool) -> Dependence | None:
    """Describe the noise of one series.

    Parameters
    ----------
    scaled
        Residuals in the order of x, scaled to one standard deviation, shape (m,).
    basis
        Rows of the orthonormal basis of the weighted derivatives for these readings, shape (m, r).
    correlated
        Whether a pattern was found in them.
    """
    count = len(scaled)
    if count < _FEWEST or not np.any(scaled):
        return None
    if correlated:
        likelihood, _ = _restricted(scaled, basis)
        rho = float(_RHO[np.argmax(likelihood)])
        if rho <= 0.0:
            return None
        return Dependence(series, "correlated", rho, count, max(count * (1.0 - rho) / (1.0 + rho), 1.0))
    ranks = np.argsort(np.argsort(np.abs(scaled), kind="stable"), kind="stable")
    strength = float(np.corrcoef(ranks, np.arange(count))[0, 1]) * np.sqrt(count - 1.0)
    return Dependence(series, "uneven", 0.0, count, float(count)) if abs(strength) > _SIGNIFICANT else None


def allowed_deviations(
    inverse: FloatArray,
    deviations: FloatArray,
    residuals: FloatArray,
    basis: FloatArray,
    found: list[tuple[Dependence, IntArray]],
    level: float,
    quantile: float,
) -> FloatArray:
    """Deviations of the estimates, shape (d,), whose ``quantile``-fold is the half width of an interval of ``level``.

    Parameters
    ----------
    inverse
        What estimates take from weighted readings, shape (d, n).
    deviations
        Standard deviation of the weighted noise, were it independent and even, shape (n,).
    residuals
        Weighted, shape (n,).
    basis
        Orthonormal basis of the weighted derivatives, shape (n, r).
    found
        Series that depart, with the places of their readings in the order of x.
    level, quantile
        Of the intervals of independent noise.
    """
    departing = np.zeros(len(deviations), dtype=np.bool_)
    variances = np.zeros(len(inverse))
    for dependence, places in found:
        departing[places] = True
        own, rows = inverse[:, places], basis[places]
        if dependence.kind == "uneven":
            half = _uneven_half(own, residuals[places], rows, level)
        else:
            half = _correlated_half(own, residuals[places], rows, level)
        variances += (half / quantile) ** 2
    rest = (inverse * deviations)[:, ~departing]
    return np.asarray(np.sqrt(variances + np.sum(rest**2, axis=1)))


def _uneven_half(inverse: FloatArray, residuals: FloatArray, basis: FloatArray, level: float) -> FloatArray:
    """Half widths, shape (d,), of what one series of uneven noise adds."""
    left = np.maximum(1.0 - np.sum(basis * basis, axis=1), _LEAST_LEFT)
    shares = (inverse * (residuals / left)) ** 2
    variance = shares.sum(axis=1)
    squares = np.maximum(np.sum(shares**2, axis=1), 1e-300)
    # of normal noise: E (sum u)^2 = (sum s)^2 + 2 sum s^2, E sum u^2 = 3 sum s^2, with u the shares and s their means
    degrees = np.maximum(3.0 * variance**2 / squares - 2.0, _FEWEST_FREE)
    return np.asarray(stdtrit(degrees, 0.5 + level / 2.0) * np.sqrt(variance))


def _correlated_half(inverse: FloatArray, residuals: FloatArray, basis: FloatArray, level: float) -> FloatArray:
    """Half widths, shape (d,), of what one series of correlated noise adds: the mixture over rho."""
    from scipy.signal import lfilter

    likelihood, variance = _restricted(residuals, basis)
    shares = np.exp(likelihood - likelihood.max())
    shares /= shares.sum()
    used = np.flatnonzero(shares > 1e-6 * shares.max())
    spreads = np.empty((len(used), len(inverse)))
    for row, index in enumerate(used.tolist()):
        rho = float(_RHO[index])
        before = lfilter(
            [0.0, rho], [1.0, -rho], inverse, axis=1
        )  # of each reading: sum of rho^k times the k-th before
        own = np.sum(inverse * (inverse + 2.0 * before), axis=1)
        spreads[row] = np.sqrt(np.maximum(own, 0.0) * variance[index])
    free = max(float(len(residuals) - basis.shape[1]), 1.0)
    # bisection for the half width that the mixture of Student's t exceeds with 1 - level
    low = np.zeros(len(inverse))
    high = stdtrit(free, 0.5 + level / 2.0) * np.maximum(spreads.max(axis=0), 1e-300)
    for _ in range(50):
        middle = 0.5 * (low + high)
        inside = shares[used] @ (2.0 * stdtr(free, middle / np.maximum(spreads, 1e-300)) - 1.0)
        low, high = np.where(inside < level, middle, low), np.where(inside < level, high, middle)
    return np.asarray(high)


def _restricted(residuals: FloatArray, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Restricted log-likelihood of each rho, and the variance of a reading under it; each of the shape of ``_RHO``.

    Readings are whitened by e_i - rho e_{i-1}, and regressed on the equally whitened derivatives.
    """
    count = len(residuals)
    left, singular, _ = np.linalg.svd(basis, full_matrices=False)
    regressors = left[:, singular > 1e-8]
    free = max(count - regressors.shape[1], 1)
    table = np.column_stack([regressors, residuals])
    ahead, behind = table[1:], table[:-1]
    first, own, lagged, before = np.outer(table[0], table[0]), ahead.T @ ahead, ahead.T @ behind, behind.T @ behind
    likelihood, variance = np.empty(_RHO.size), np.empty(_RHO.size)
    for index, rho in enumerate(_RHO.tolist()):
        square = 1.0 - rho * rho
        gram = first + (own - rho * (lagged + lagged.T) + rho * rho * before) / square  # of the whitened table
        root = np.linalg.cholesky(gram[:-1, :-1])
        along = solve_triangular(root, gram[:-1, -1], lower=True)
        variance[index] = max(float(gram[-1, -1] - along @ along) / free, 1e-300)
        determinants = 0.5 * (count - 1) * np.log(square) + float(np.sum(np.log(np.diag(root))))
        likelihood[index] = -determinants - 0.5 * free * np.log(variance[index])
    return likelihood, variance
