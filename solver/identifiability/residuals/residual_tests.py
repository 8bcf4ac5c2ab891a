"""One joint test of whether residuals hold a pattern, by series and stage, calibrated by simulation.

Each part (a series, or one stage of it) is looked at in several ways: smooth deviations (what the first one, two and
three cosines over the rank of x explain, and eight where there are many readings, as far as the fit leaves them; Hart
1997), and autocorrelation (Durbin and Watson 1950). Few ways of low order find a bend among few readings best. What
they take in residuals of a right model follows from simulated noise that goes through the same fit: the derivatives at
the optimum are projected out, so fitted parameters, weights, few points and several series are accounted for. The least
of all probabilities is compared with that of the simulated residuals (Westfall and Young 1993): the level holds for all
parts and ways together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["FEWEST_IN_PART", "Part", "PartResult", "examine_parts", "examine_size", "smooth_share", "weighted_basis"]

FEWEST_IN_PART = 6
"""Readings that a series or a stage needs to be looked at on its own."""

_DRAWS = 999
_SEED = 20080501
_COSINES = 8
_FIRST = (1, 2, 3)  # numbers of cosines that are looked at together
_MANY = 30  # readings from which all cosines are looked at together, too
_LEFT = 0.1  # share of a cosine that the fit must leave for it to be used
_UNEVEN = 1.645
_NOTHING = 1e-9  # expected square of what a part leaves, in units of its noise: less is rounding
_OPEN = 1e-7  # singular value, relative to the largest, of a direction that the data leave open


@dataclass(frozen=True, slots=True)
class Part:
    """Residuals to be tested together.

    Parameters
    ----------
    indices
        Of the readings, in the order of x, shape (m,).
    x
        Of these readings; those of equal x (repeats) share their rank.
    series
        Indices of all readings of the series it belongs to, whose spread measures the noise.
    """

    indices: IntArray
    x: FloatArray
    series: IntArray


@dataclass(frozen=True, slots=True)
class PartResult:
    """Probability of a pattern as strong by chance: of this part alone, and adjusted for all parts and ways."""

    alone: float
    adjusted: float


def weighted_basis(weighted: FloatArray) -> FloatArray:
    """Orthonormal basis, shape (n, r), of what the columns of weighted derivatives, shape (n, d), span."""
    lengths = np.linalg.norm(weighted, axis=0)
    used = lengths > 1e-12 * max(float(lengths.max(initial=0.0)), 1e-300)
    if not used.any():
        return np.empty((len(weighted), 0))
    left, singular, _ = np.linalg.svd(weighted[:, used] / lengths[used], full_matrices=False)
    return np.asarray(left[:, singular > _OPEN * singular[0]], dtype=np.float64)


def examine_parts(
    residuals: FloatArray,
    factors: FloatArray,
    deviations: FloatArray,
    basis: FloatArray,
    parts: list[Part],
    *,
    known: bool,
) -> tuple[PartResult, ...]:
    """Test the parts.

    Parameters
    ----------
    residuals
        Of n readings, each scaled to one standard deviation within its series, shape (n,).
    factors
        What makes weighted residuals of them: root of the weight in the objective over that inside the series, (n,).
    deviations
        Standard deviation of the scaled noise, shape (n,); known, or estimated.
    basis
        Orthonormal basis of the weighted derivatives, shape (n, r).
    known
        The noise is known: patterns are measured by it. Otherwise by the spread of the residuals themselves, and
        where their size changes with x, random signs of them stand beside normal noise, so that this is no pattern.

    Returns
    -------
    tuple of PartResult
        In the order of the parts.
    """
    random = np.random.default_rng(_SEED)
    count = len(residuals)
    found = _projected(residuals[None, :] * factors, basis) / factors
    normal = random.standard_normal((_DRAWS, count)) * (deviations * factors)
    draws = [_projected(normal, basis) / factors]
    if not known and any(_uneven(found[0, part.indices]) for part in parts):
        left = np.sqrt(np.maximum(1.0 - np.sum(basis * basis, axis=1), 0.05))
        signs = random.choice((-1.0, 1.0), size=(_DRAWS, count))
        draws.append(_projected(signs * (found / left * factors), basis) / factors)
    results = []
    for simulated in draws:
        observed_p, simulated_p = [], []
        for part in parts:
            ways = _Ways.of(part, draws[0], deviations, known)
            alone, null = _probabilities(ways.statistics(found), ways.statistics(simulated))
            observed_p.append(alone)
            simulated_p.append(null)
        least = np.min(np.stack(simulated_p), axis=0)
        results.append([(p, float((1 + np.sum(least <= p)) / (_DRAWS + 1))) for p in observed_p])
    return tuple(PartResult(max(r[i][0] for r in results), max(r[i][1] for r in results)) for i in range(len(parts)))


def examine_size(
    residuals: FloatArray, factors: FloatArray, deviations: FloatArray, basis: FloatArray, parts: list[IntArray]
) -> tuple[tuple[float, float], ...]:
    """How the residuals of each part compare with the stated noise, arguments as in :func:`examine_parts`.

    Returns
    -------
    tuple
        Of each part: the ratio of the root mean squares, found over expected of a right model, and the probability of
        one as large in any part.
    """
    normal = np.random.default_rng(_SEED).standard_normal((_DRAWS, len(residuals))) * (deviations * factors)
    simulated = _projected(normal, basis) / factors / deviations
    found = residuals / deviations
    # a part that its own parameters meet exactly has nothing left to compare
    expected = np.array([max(float(np.mean(np.sum(simulated[:, part] ** 2, axis=1))), _NOTHING) for part in parts])
    largest = np.max([np.sum(simulated[:, p] ** 2, axis=1) / e for p, e in zip(parts, expected, strict=True)], axis=0)
    ratios = [float(np.sum(found[part] ** 2) / e) for part, e in zip(parts, expected, strict=True)]
    return tuple((float(np.sqrt(r)), float((1 + np.sum(largest >= r)) / (_DRAWS + 1))) for r in ratios)


def smooth_share(x: FloatArray, residuals: FloatArray) -> tuple[float, float]:
    """How large a pattern is, whatever its probability.

    Returns
    -------
    tuple
        Share of the squares of residuals, shape (m,), in the order of x, that the first eight cosines take beyond their
        number, and their first autocorrelation.
    """
    cosines = _cosines(x, min(_COSINES, len(x) // 2))[:, 1:]
    squares = max(float(residuals @ residuals), 1e-300)
    smooth = float(np.sum((residuals @ cosines) ** 2)) / squares - cosines.shape[1] / len(x)
    return smooth, float(residuals[1:] @ residuals[:-1]) / squares


def _uneven(residuals: FloatArray) -> bool:
    """Whether the size of residuals grows or falls with x (rank correlation, 10 %)."""
    ranks = np.argsort(np.argsort(np.abs(residuals), kind="stable"), kind="stable")
    correlation = float(np.corrcoef(ranks, np.arange(len(ranks)))[0, 1])
    return bool(abs(correlation) * np.sqrt(len(ranks) - 1.0) > _UNEVEN)


def _projected(weighted: FloatArray, basis: FloatArray) -> FloatArray:
    return weighted - (weighted @ basis) @ basis.T


def _probabilities(observed: FloatArray, simulated: FloatArray) -> tuple[float, FloatArray]:
    """Least probability over the ways: of the observed residuals, (k, 1), and of each draw, shape (draws,)."""
    total = simulated.shape[1]
    above = np.array([np.sum(s >= o[0]) for s, o in zip(simulated, observed, strict=True)])
    order = np.sort(simulated, axis=1)
    ranks = np.stack([total - np.searchsorted(o, s, side="left") for o, s in zip(order, simulated, strict=True)])
    least = ranks.min(axis=0) / total
    own = float((above.min() + 1) / (total + 1))
    # the joint probability over the ways of this part
    return float((1 + np.sum(least <= own)) / (total + 1)), _ranked(least)


def _ranked(values: FloatArray) -> FloatArray:
    """Share of the draws that are as small, shape (draws,)."""
    return np.asarray(np.searchsorted(np.sort(values), values, side="right") / len(values))


@dataclass(frozen=True, slots=True)
class _Ways:
    """How one part is looked at: cosines that the fit leaves, each freed of the ones before it, of unit variance."""

    part: Part
    cosines: FloatArray
    known: bool
    deviations: FloatArray

    @classmethod
    def of(cls, part: Part, draws: FloatArray, deviations: FloatArray, known: bool) -> _Ways:
        cosines = _cosines(part.x, min(_COSINES, len(part.indices) // 2))
        scaled = draws[:, part.indices] / deviations[part.indices]
        return cls(part, _freed(cosines, scaled), known, deviations)

    def statistics(self, residuals: FloatArray) -> FloatArray:
        """All ways for residuals, shape (k, n): shape (ways, k); large means a pattern."""
        own = residuals[:, self.part.indices] / self.deviations[self.part.indices]
        sums = np.cumsum((own @ self.cosines) ** 2, axis=1).T
        together = _FIRST if own.shape[1] < _MANY else (*_FIRST, _COSINES)
        smooth = [sums[min(first, len(sums)) - 1] for first in together if len(sums)]
        if self.known:
            return np.stack([*smooth, np.sum(own * own, axis=1)])
        whole = residuals[:, self.part.series] / self.deviations[self.part.series]
        spread = np.maximum(np.sum(whole * whole, axis=1), 1e-300)
        own_spread = np.maximum(np.sum(own * own, axis=1), 1e-300)
        watson = -np.sum(np.diff(own, axis=1) ** 2, axis=1) / own_spread
        return np.stack([*(s / np.maximum(spread - s, 1e-9 * spread) for s in smooth), watson])


def _freed(cosines: FloatArray, draws: FloatArray) -> FloatArray:
    """Combinations of the cosines, shape (m, k), that are independent and of unit variance among the draws."""
    found: list[FloatArray] = []
    taken: list[FloatArray] = []
    for cosine in cosines.T:
        values, combined = draws @ cosine, cosine
        before = float(np.mean(values**2))
        for vector, sample in zip(found, taken, strict=True):
            share = float(np.mean(values * sample))
            values, combined = values - share * sample, combined - share * vector
        variance = float(np.mean(values**2))
        if before > _LEFT and variance > _LEFT * before:
            found.append(combined / np.sqrt(variance))
            taken.append(values / np.sqrt(variance))
    return np.stack(found, axis=1) if found else np.empty((len(cosines), 0))


def _cosines(x: FloatArray, highest: int) -> FloatArray:
    """Cosines 0 to ``highest`` of unit length over the mean ranks of x, shape (m, highest + 1)."""
    values, group, counts = np.unique(x, return_inverse=True, return_counts=True)
    del values
    ends = np.cumsum(counts)
    ranks = (ends - counts + ends) / 2.0 / len(x)
    table = np.cos(np.pi * np.outer(ranks[group], np.arange(highest + 1)))
    return np.asarray(table / np.linalg.norm(table, axis=0))
