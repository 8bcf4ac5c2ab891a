"""Noise that is not independent and even: what correlated residuals, and residuals of uneven size, do to intervals.

Used where the residuals show it, where readings are too few to exclude it, and where the problem states it; for
intervals alone: standard errors are those of independent noise of one size. An interval is the wider of the two.

- *Correlated*: autoregressive of first order within a series; of unevenly spaced readings either by their order or by
  their distance in x, correlation rho^(distance / median distance), as the likelihood decides. Residuals are less
  correlated than the noise, as the fit takes a part of it along, so the correlation rho is judged by the restricted
  likelihood (Patterson and Thompson 1971; Cressie and Lahiri 1993), and as few readings leave it uncertain, the
  interval is one of the mixture of Student's t over rho, each weighted by that likelihood and its prior: independent
  as likely as not, otherwise even in Fisher's arctanh rho, 1 / (1 - rho^2), up to 0.98. n readings are
  worth n^2 / sum R independent ones, with R their correlations: n (1 - rho) / (1 + rho) of many even ones. It is looked
  for where a pattern was found in the residuals, and where the likelihood speaks for it.
- *Possible*: below 50 readings the same mixture applies if nothing was found. Its width over that of independent noise
  widens what the series adds, as several series have one estimate of their noise.
- *Stated*: the same without the prior probability of independence, for any number of readings.
- *Uneven*: each residual stands for its own variance, r_i^2 / (1 - h_i)^2 with the leverage h_i (MacKinnon and White
  1985, HC3); the degrees of freedom follow from how few of them carry it (Lipsitz, Ibrahim and Parzen 1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy.linalg import solve_banded, solve_triangular
from scipy.special import stdtr, stdtrit

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = [
    "ALLOWANCES",
    "FEW",
    "Dependence",
    "DependenceKind",
    "allowed_deviations",
    "dependence_in_words",
    "dependence_of",
]

DependenceKind: TypeAlias = Literal["correlated", "uneven", "possible", "stated"]
"""Found correlated or of uneven size; possibly correlated, which few readings cannot exclude; stated as correlated."""

ALLOWANCES: tuple[DependenceKind, ...] = ("correlated", "stated", "uneven", "possible")
"""The kinds, in the order in which a report names the first that widens an interval."""

_MOST_NAMED = 3
_SIGNIFICANT = 2.58  # of the correlation of sizes with x, times the root of n - 1: a level of 1 %
_FEWEST, _FEWEST_POSSIBLE = 8, 3
_RHO = np.linspace(0.0, 0.98, 50)
_LEAST_LEFT = 0.05  # of 1 - h
_FEWEST_FREE = 2.0
_EVEN = 0.01  # of the median distance: smaller differences do not count
_LEAST_GAP, _MOST_GAP = 0.05, 1e3  # repeats are not the same reading
_FEWEST_TO_SPEAK = 18  # readings: fewer leave the correlation open
FEW = 50
"""Readings of a series below which tests for patterns miss a correlation, so that intervals allow for it unseen."""
_SPEAKS, _SPEAKS_OF_FEW = 3.84, 1.0  # twice the gain of log-likelihood: by chance more in 2.5, of few in 16 %
_INDEPENDENT = 0.5  # prior probability
_MANY = 1e6  # degrees of freedom, as good as infinite
_FURTHER_WAY = 1.0  # that much more where there are two ways to choose from


@dataclass(frozen=True, slots=True)
class Dependence:
    """How the noise of one series departs from independent and even noise.

    Parameters
    ----------
    series
        Its name.
    kind
        How.
    rho
        Correlation of neighbouring readings, of ``by_x`` at their median distance; 0 for uneven ones.
    readings, effective
        Number, and how many independent ones they are worth.
    by_x
        Whether the correlation falls with the distance in x and not with the number of readings between.
    """

    series: str
    kind: DependenceKind
    rho: float
    readings: int
    effective: float
    by_x: bool = False

    @property
    def sentence(self) -> str:
        """What it means for intervals."""
        how = f"{self.rho:.2f}{' at their median distance in x' if self.by_x else ''}"
        return _sentence(self.kind, self.series, how, self.readings, self.effective)


def dependence_in_words(found: Sequence[Dependence]) -> list[str]:
    """A sentence for each series, or one for all with the same kind of noise where they are many."""
    kinds: dict[str, list[Dependence]] = {}
    for one in found:
        kinds.setdefault(one.kind, []).append(one)
    said = []
    for kind, own in kinds.items():
        if len(own) <= _MOST_NAMED:
            said += [one.sentence for one in own]
            continue
        low, high = (f"{limit(one.rho for one in own):.2f}" for limit in (min, max))
        how = low if low == high else f"{low} to {high}"
        readings, effective = sum(one.readings for one in own), sum(one.effective for one in own)
        said.append(_sentence(kind, f"{len(own)} series", how, readings, effective))
    return said


def _sentence(kind: str, who: str, how: str, readings: int, effective: float) -> str:
    match kind:
        case "possible":
            return (
                f"{who}: {readings} readings cannot exclude that the errors of neighbours are correlated; intervals "
                "allow for that, standard errors do not. If they are known to be independent, state noise: {kind: "
                "white} in the problem."
            )
        case "stated":
            return (
                f"{who}: the problem states that the errors of neighbours are correlated; intervals allow for that, "
                "standard errors do not."
            )
        case "correlated":
            return (
                f"{who}: neighbouring residuals are correlated ({how}), so {readings} readings are equivalent to "
                f"{effective:.0f} independent ones; intervals allow for that, standard errors do not."
            )
        case _:
            return (
                f"{who}: the size of the residuals changes with x; intervals allow for that, standard errors do not, "
                "and weights from their spread (weighting by_spread) would make better use of the readings."
            )


def dependence_of(
    series: str, scaled: FloatArray, basis: FloatArray, x: FloatArray, correlated: bool, stated: bool = False
) -> Dependence | None:
    """Describe the noise of one series.

    Parameters
    ----------
    scaled
        Residuals in the order of x, scaled to one standard deviation, shape (m,).
    basis
        Rows of the orthonormal basis of the weighted derivatives for these readings, shape (m, r).
    x
        Of the readings, rising, shape (m,).
    correlated
        Whether a pattern was found in them.
    stated
        Whether the problem states that they are correlated.
    """
    count = len(scaled)
    if count < _FEWEST_POSSIBLE or not np.any(scaled):
        return None
    unseen = Dependence(series, "stated" if stated else "possible", 0.0, count, float(count))
    if stated or count < _FEWEST:
        return unseen
    likelihood, _, gaps, _ = _candidates(scaled, basis, x)
    way, index = (int(place) for place in np.unravel_index(np.argmax(likelihood), likelihood.shape))
    gain = 2.0 * float(likelihood[way, index] - likelihood[0, 0])
    speaks = gain > (_SPEAKS_OF_FEW if count < FEW else _SPEAKS) + _FURTHER_WAY * (len(gaps) - 1)
    if not correlated:
        ranks = np.argsort(np.argsort(np.abs(scaled), kind="stable"), kind="stable")
        strength = float(np.corrcoef(ranks, np.arange(count))[0, 1]) * np.sqrt(count - 1.0)
        if abs(strength) > _SIGNIFICANT:
            return Dependence(series, "uneven", 0.0, count, float(count))
    if index > 0 and (correlated or (speaks and count >= _FEWEST_TO_SPEAK)):
        rho = float(_RHO[index])
        total = float(np.sum(_along(np.ones((1, count)), rho ** gaps[way]) ** 2))
        return Dependence(series, "correlated", rho, count, max(count**2 / total, 1.0), way == 1)
    return unseen if count < FEW else None


def allowed_deviations(
    inverse: FloatArray,
    deviations: FloatArray,
    residuals: FloatArray,
    basis: FloatArray,
    found: list[tuple[Dependence, IntArray]],
    x: FloatArray,
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
    x
        Of the readings, shape (n,).
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
            half, factor = _correlated_half(own, residuals[places], rows, x[places], level, dependence.kind)
            if dependence.kind != "correlated":
                spread = np.sqrt(np.sum((own * deviations[places]) ** 2, axis=1))
                half = quantile * spread * np.maximum(factor, 1.0)
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


def _correlated_half(
    inverse: FloatArray, residuals: FloatArray, basis: FloatArray, x: FloatArray, level: float, kind: DependenceKind
) -> tuple[FloatArray, FloatArray]:
    """Half widths, shape (d,), of what one series of correlated noise adds, and how many times wider they are.

    The mixture over correlations.
    """
    likelihood, variance, gaps, free = _candidates(residuals, basis, x)
    prior = 1.0 / (1.0 - _RHO**2)
    if kind != "stated":
        prior[0] = _INDEPENDENT / (1.0 - _INDEPENDENT) * prior[1:].sum()
    likelihood = likelihood + np.log(prior)
    shares = np.exp(likelihood - likelihood.max())
    shares /= shares.sum()
    used = np.argwhere(shares > 1e-6 * shares.max())
    spreads = np.empty((len(used), len(inverse)))
    for row, (way, index) in enumerate(used.tolist()):
        own = np.sum(_along(inverse, _RHO[index] ** gaps[way]) ** 2, axis=1)
        spreads[row] = np.sqrt(own * variance[way, index])
    plain = stdtrit(free, 0.5 + level / 2.0) * np.sqrt(np.sum(inverse**2, axis=1) * variance[0, 0])
    # bisection for the half width that the mixture of Student's t exceeds with 1 - level
    low = np.zeros(len(inverse))
    high = stdtrit(free, 0.5 + level / 2.0) * np.maximum(spreads.max(axis=0), 1e-300)
    kept = shares[used[:, 0], used[:, 1]]
    for _ in range(50):
        middle = 0.5 * (low + high)
        inside = kept @ (2.0 * stdtr(free, middle / np.maximum(spreads, 1e-300)) - 1.0)
        low, high = np.where(inside < level, middle, low), np.where(inside < level, high, middle)
    return high, np.divide(high, plain, out=np.ones_like(high), where=plain > 0.0)


def _along(rows: FloatArray, rho: FloatArray) -> FloatArray:
    """Rows a, shape (k, n), by a root of the correlations R of n readings: the squares of a row sum up to a' R a.

    R^-1 = D' D, with D e the whitened (e_i - rho_i e_{i-1}) / sqrt(1 - rho_i^2); so the row is that of D'^-1 a.
    """
    scale = np.append(1.0, 1.0 / np.sqrt(1.0 - rho**2))
    bands = np.stack([np.append(0.0, -rho * scale[1:]), scale])
    return np.asarray(solve_banded((0, 1), bands, rows.T).T)


def _gaps(x: FloatArray) -> list[FloatArray]:
    """Distances of neighbours in their median, shape (m - 1,): by reading, and where they are uneven by x as well."""
    even = np.ones(len(x) - 1)
    steps = np.diff(x)
    middle = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    if middle <= 0.0 or np.ptp(steps) <= _EVEN * middle:
        return [even]
    return [even, np.clip(steps / middle, _LEAST_GAP, _MOST_GAP)]


def _candidates(
    residuals: FloatArray, basis: FloatArray, x: FloatArray
) -> tuple[FloatArray, FloatArray, list[FloatArray], float]:
    """Restricted log-likelihood and variance of a reading, of shape (ways, correlations), gaps of the ways, freedom."""
    gaps = _gaps(x)
    left, singular, _ = np.linalg.svd(basis, full_matrices=False)
    table = np.column_stack([left[:, singular > 1e-8], residuals])
    free = len(table) - table.shape[1] + 1
    if free < 1:  # the fit takes along all that the series says of its noise
        return np.zeros((len(gaps), _RHO.size)), np.ones((len(gaps), _RHO.size)), gaps, _MANY
    found = np.array([[_restricted(table, rho**way) for rho in _RHO.tolist()] for way in gaps])
    return found[..., 0], found[..., 1], gaps, float(free)


def _restricted(table: FloatArray, rho: FloatArray) -> tuple[float, float]:
    """Restricted log-likelihood of correlations of neighbours, shape (m - 1,), and the variance of a reading.

    Readings are whitened by (e_i - rho_i e_{i-1}) / sqrt(1 - rho_i^2), and regressed on the equally whitened
    derivatives: the columns of ``table`` before its last, which are the residuals.
    """
    count, columns = table.shape
    free = count - columns + 1
    square = 1.0 - rho * rho
    white = (table[1:] - rho[:, None] * table[:-1]) / np.sqrt(square)[:, None]
    gram = np.outer(table[0], table[0]) + white.T @ white
    root = np.linalg.cholesky(gram[:-1, :-1])
    along = solve_triangular(root, gram[:-1, -1], lower=True)
    variance = max(float(gram[-1, -1] - along @ along) / free, 1e-300)
    determinants = 0.5 * float(np.sum(np.log(square))) + float(np.sum(np.log(np.diag(root))))
    return -determinants - 0.5 * free * np.log(variance), variance
