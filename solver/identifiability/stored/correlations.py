"""Correlations of the parameters among good fits: which parameters the data cannot distinguish."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Literal, TypeAlias

import numpy as np
from scipy.special import ndtri

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.samples import Samples

__all__ = [
    "COORDINATES",
    "NOT_CORRELATED",
    "Coordinates",
    "Correlation",
    "CorrelationMethod",
    "Correlations",
    "correlate",
    "correlate_at",
]

NOT_CORRELATED = 0.5
"""Below this |r| two parameters count as not correlated (Meier et al. 2008)."""

CorrelationMethod: TypeAlias = Literal["pearson", "spearman"]
Coordinates: TypeAlias = Literal["linear", "search"]

COORDINATES: tuple[Coordinates, ...] = ("linear", "search")

_FEWEST = 4  # Fisher's z needs more than three samples
_HEAVY_TAIL = 3.0  # excess kurtosis beyond which Fisher's variance is too small
_RESAMPLES = 1000
_FEWEST_RESAMPLES = 200
_MOST_DRAWS = 4_000_000  # of all resamples together: answers for thousands of good fits come within a second
_AT_ONCE = 50  # resamples


@dataclass(frozen=True, slots=True)
class Correlation:
    """Correlation of two parameters.

    Parameters
    ----------
    first, second
        Names of the parameters.
    coefficient
        r, -1 to 1; None when it is undefined (fewer than three samples, or a constant parameter).
    lower, upper
        Confidence interval of r on ``level``; None when it cannot be given.
    count
        Number of samples.
    interval
        How the interval was found: ``fisher`` (z transformation; for Spearman with the variance of Bonett and Wright
        2000) or ``bootstrap`` (percentiles of 1000 resamples, 200 of very many samples, where a heavy-tailed parameter
        or |r| = 1 rules Fisher's out), or ``none``.
    """

    first: str
    second: str
    coefficient: float | None
    lower: float | None
    upper: float | None
    count: int
    interval: Literal["fisher", "bootstrap", "none"]

    @property
    def correlated(self) -> bool:
        """Whether |r| is at least 0.5 and its interval excludes 0."""
        if self.coefficient is None or self.lower is None or self.upper is None:
            return False
        return abs(self.coefficient) >= NOT_CORRELATED and not self.lower <= 0.0 <= self.upper


@dataclass(frozen=True, slots=True)
class Correlations:
    """Correlations of all pairs of parameters.

    Parameters
    ----------
    names
        Names of the d parameters.
    pairs
        One entry a pair, in the order of ``itertools.combinations(names, 2)``.
    method, coordinates
        Pearson's or Spearman's r; over natural values (``linear``) or search coordinates.
    level
        Of the intervals.
    biased
        True when particles of a swarm take part: the coefficient then describes the swarm's path as well.
    """

    names: tuple[str, ...]
    pairs: tuple[Correlation, ...]
    method: CorrelationMethod
    coordinates: Coordinates
    level: float
    biased: bool

    def __iter__(self) -> Iterator[Correlation]:
        return iter(self.pairs)

    def get(self, first: str, second: str) -> Correlation:
        """The correlation of two parameters, in either order."""
        for pair in self.pairs:
            if {pair.first, pair.second} == {first, second}:
                return pair
        raise KeyError(f"no pair ({first}, {second}); parameters: {', '.join(self.names)}")

    def matrix(self) -> FloatArray:
        """Coefficients, shape (d, d), nan where undefined."""
        matrix = np.eye(len(self.names))
        place = {name: index for index, name in enumerate(self.names)}
        for pair in self.pairs:
            i, j = place[pair.first], place[pair.second]
            matrix[i, j] = matrix[j, i] = np.nan if pair.coefficient is None else pair.coefficient
        return matrix


def correlate(
    samples: Samples, *, method: CorrelationMethod = "pearson", coordinates: Coordinates = "linear"
) -> Correlations:
    """Correlate all pairs of parameters of (usually filtered) samples, with intervals of 95 %.

    Where a sampling and a swarm are put together, only the Monte Carlo samples are used, as the swarm's are biased.
    """
    return correlate_at(samples, (0.95,), method=method, coordinates=coordinates)[0]


def correlate_at(
    samples: Samples,
    levels: Sequence[float],
    *,
    method: CorrelationMethod = "pearson",
    coordinates: Coordinates = "linear",
) -> list[Correlations]:
    """Do the same as :func:`correlate` for several levels, from the same resamples."""
    used = samples.select(samples.unbiased) if samples.source == "mixed" else samples
    values = used.parameters if coordinates == "linear" else used.coordinates
    if method == "spearman":
        values = _ranks(values)
    values = _of_ordinary_size(values)
    resamples = _Resamples(values, np.random.default_rng(0))
    tails = [_kurtosis(column) if method == "pearson" else 0.0 for column in values.T]
    biased = bool((~used.unbiased).any())
    found = []
    for level in levels:
        pairs = tuple(
            _pair(used.names, (i, j), values, max(tails[i], tails[j]), method, level, resamples)
            for i, j in combinations(range(used.dimension), 2)
        )
        found.append(Correlations(used.names, pairs, method, coordinates, level, biased))
    return found


def _of_ordinary_size(values: FloatArray) -> FloatArray:
    """Columns by powers of two, which changes no correlation, so that their squares are ordinary numbers; (n, d)."""
    sizes = np.abs(values).max(axis=0, initial=0.0)
    return np.asarray(np.ldexp(values, -np.frexp(sizes)[1]))


def _ranks(values: FloatArray) -> FloatArray:
    """Ranks 1 to n in each column, equal values share the mean of theirs; scipy.stats takes 0.3 s to import for it."""
    ranks = np.empty_like(values, dtype=float)
    for column in range(values.shape[1]):
        _, which, counts = np.unique(values[:, column], return_inverse=True, return_counts=True)
        ranks[:, column] = (np.cumsum(counts) - (counts - 1) / 2)[which]
    return ranks


def _pair(
    names: Sequence[str],
    pair: tuple[int, int],
    values: FloatArray,
    tail: float,
    method: CorrelationMethod,
    level: float,
    resamples: _Resamples,
) -> Correlation:
    first, second = names[pair[0]], names[pair[1]]
    count = len(values)
    r = _pearson(values[:, pair[0]], values[:, pair[1]]) if count > 2 else None
    if r is None or count < _FEWEST:
        return Correlation(first, second, r, None, None, count, "none")
    if abs(r) > 1.0 - 1e-12 or tail > _HEAVY_TAIL:
        lower, upper = resamples.interval(pair, level)
        return Correlation(first, second, r, lower, upper, count, "bootstrap")
    variance = (1.0 if method == "pearson" else 1.0 + r * r / 2.0) / (count - 3)
    half = float(ndtri(0.5 + level / 2.0)) * np.sqrt(variance)
    z = np.arctanh(r)
    return Correlation(first, second, r, float(np.tanh(z - half)), float(np.tanh(z + half)), count, "fisher")


def _pearson(x: FloatArray, y: FloatArray) -> float | None:
    dx, dy = x - x.mean(), y - y.mean()
    scale = np.sqrt((dx @ dx) * (dy @ dy))
    rounding = 1e-14 * len(x) * max(abs(x).max(), 1e-300) * max(abs(y).max(), 1e-300)
    if not scale > rounding:
        return None
    return float(np.clip((dx @ dy) / scale, -1.0, 1.0))


def _kurtosis(x: FloatArray) -> float:
    """Excess kurtosis; 0 for a normal variable."""
    if x.size == 0:
        return 0.0
    d = x - x.mean()
    variance = float((d * d).mean())
    return float((d**4).mean()) / variance**2 - 3.0 if variance > 0 else 0.0


class _Resamples:
    """Correlations of all pairs in resamples of the same draws, which are made when the first pair asks.

    Parameters
    ----------
    values
        Samples, shape (n, d).
    """

    def __init__(self, values: FloatArray, random: np.random.Generator) -> None:
        self._values = values
        self._random = random

    def interval(self, pair: tuple[int, int], level: float) -> tuple[float, float]:
        """Percentile interval of r."""
        found = self._coefficients[:, pair[0], pair[1]]
        found = found[np.isfinite(found)]
        lower, upper = np.quantile(found, [0.5 - level / 2.0, 0.5 + level / 2.0]) if found.size else (-1.0, 1.0)
        return float(lower), float(upper)

    @cached_property
    def _coefficients(self) -> FloatArray:
        """r of every resample and pair, shape (resamples, d, d); nan where a column of it is constant."""
        count, dimension = self._values.shape
        spread = self._values.std(axis=0)
        z = (self._values - self._values.mean(axis=0)) / np.where(spread > 0.0, spread, 1.0)
        i, j = np.triu_indices(dimension)
        summed = np.hstack([z, z[:, i] * z[:, j]])
        number = int(np.clip(_MOST_DRAWS // count, _FEWEST_RESAMPLES, _RESAMPLES))
        means = np.empty((number, summed.shape[1]))
        for start in range(0, number, _AT_ONCE):
            here = range(start, min(start + _AT_ONCE, number))
            drawn = [np.bincount(self._random.integers(0, count, count), minlength=count) for _ in here]
            means[here.start : here.stop] = np.array(drawn, dtype=np.float64) @ summed / count
        covariance = np.empty((number, dimension, dimension))
        covariance[:, i, j] = means[:, dimension:] - means[:, i] * means[:, j]
        covariance[:, j, i] = covariance[:, i, j]
        variance = np.diagonal(covariance, axis1=1, axis2=2)
        scale = np.sqrt(np.where(variance > 1e-12, variance, np.nan))
        return np.asarray(np.clip(covariance / (scale[:, :, None] * scale[:, None, :]), -1.0, 1.0))
