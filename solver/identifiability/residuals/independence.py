"""Residuals at the optimum: how large, whether they are correlated, and whether repeats tell noise from lack of fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import fdtrc, ndtr

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.objective import counted_in_order
from geoswarm.solver.residuals import OUTLYING

__all__ = ["LackOfFit", "SeriesResiduals", "durbin_watson", "examine_residuals", "repeats_test", "runs_test"]

_LEVEL = 0.05
_FEWEST = 8


@dataclass(frozen=True, slots=True)
class LackOfFit:
    """Repeats (points of one x) against the scatter around the model; F test of Draper and Smith (1998), section 2.1.

    Parameters
    ----------
    noise
        Standard deviation of the repeats (pure error), base unit.
    repeats
        Its degrees of freedom: points beyond the first at each x.
    ratio, probability
        F = mean square of the lack of fit over that of the pure error, and the probability of a larger one if the model
        were right; None when there are too few different x, or no error at all.
    """

    noise: float
    repeats: int
    ratio: float | None
    probability: float | None

    @property
    def significant(self) -> bool:
        """Whether the model misses the data by more than noise explains (5 %)."""
        return self.probability is not None and self.probability < _LEVEL


@dataclass(frozen=True, slots=True)
class SeriesResiduals:
    """Residuals of one series.

    Parameters
    ----------
    series
        Its name.
    x, residuals
        Points and residuals in the order of x, shape (m,), base units; points of weight 0 left out.
    deviation
        Root of the weighted mean square, base unit.
    bias
        Weighted mean.
    runs, expected_runs, runs_probability
        Runs of one sign, how many independent residuals have on average, and the probability of as few (one-sided;
        Wald and Wolfowitz 1940). None with fewer than eight points.
    durbin_watson
        2 without serial correlation, towards 0 with a positive one (Durbin and Watson 1950). None as above.
    durbin_watson_probability
        Probability of a value as small, normal approximation. None as above.
    lack_of_fit
        None without repeats.
    warnings
        What to be careful about, in sentences.
    loss_weights
        Weights that a robust loss gives the points, 0 to 1, shape (m,); None without a loss.
    """

    series: str
    x: FloatArray
    residuals: FloatArray
    deviation: float
    bias: float
    runs: int | None
    expected_runs: float | None
    runs_probability: float | None
    durbin_watson: float | None
    durbin_watson_probability: float | None
    lack_of_fit: LackOfFit | None
    warnings: tuple[str, ...]
    loss_weights: FloatArray | None = None

    @property
    def outliers(self) -> int | None:
        """How many points a robust loss all but sets aside; None without a loss."""
        return None if self.loss_weights is None else int((self.loss_weights < OUTLYING).sum())

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        from dataclasses import asdict

        data = asdict(self)
        arrays = {"x": self.x.tolist(), "residuals": self.residuals.tolist(), "warnings": list(self.warnings)}
        weights = None if self.loss_weights is None else self.loss_weights.tolist()
        return data | arrays | {"loss_weights": weights, "outliers": self.outliers}


def examine_residuals(
    calibration: Calibration, responses: Mapping[str, FloatArray], noise: Mapping[str, float] | None = None
) -> tuple[SeriesResiduals, ...]:
    """Examine the residuals of every observed series.

    Parameters
    ----------
    responses
        Calculated values at the optimum, shape (m_g,), base units.
    noise
        Known standard deviation of a reading by series, base units.
    """
    dimension = calibration.space.dimension
    losses = calibration.objective.point_losses(responses)
    found = []
    for o in calibration.objective.observed:
        used = counted_in_order(o.x, o.point_weights)
        x, weights = o.x[used], o.point_weights[used]
        residuals = o.residuals(responses[o.series])[used]
        scaled = residuals * np.sqrt(weights)
        known = None if noise is None or o.loss is not None else noise.get(o.series)
        one = _examine(o.series, x, residuals, scaled, weights, dimension, known)
        if o.series in losses:
            one = replace(one, loss_weights=losses[o.series][used])
        found.append(one)
    return tuple(found)


def _examine(
    series: str,
    x: FloatArray,
    residuals: FloatArray,
    scaled: FloatArray,
    weights: FloatArray,
    dimension: int,
    noise: float | None,
) -> SeriesResiduals:
    deviation = float(np.sqrt(np.mean(scaled**2)))
    runs = expected = runs_probability = watson = watson_probability = None
    warnings = []
    if len(x) >= _FEWEST and deviation > 0:
        runs, expected, runs_probability = runs_test(scaled)
        watson, watson_probability = durbin_watson(scaled)
        if min(runs_probability or 1.0, watson_probability) < _LEVEL:
            warnings.append(
                f"{series}: residuals are correlated (Durbin-Watson {watson:.2f}, {runs} runs where {expected:.0f} are "
                "expected): the model misses a part of the data, or readings are not independent."
            )
    lack = repeats_test(x, scaled, weights, dimension)
    if lack is not None and lack.significant:
        warnings.append(
            f"{series}: the model misses the data by more than the scatter of repeats explains "
            f"(F = {lack.ratio:.3g}, probability {lack.probability:.2g})."
        )
    if noise is not None and deviation > 2.0 * noise:
        warnings.append(f"{series}: residuals ({deviation:.3g}) are {deviation / noise:.1f} times the stated noise.")
    bias = float(np.average(residuals, weights=weights))
    return SeriesResiduals(
        series, x, residuals, deviation, bias, runs, expected, runs_probability, watson, watson_probability, lack,
        tuple(warnings),
    )  # fmt: skip


def runs_test(residuals: FloatArray) -> tuple[int, float, float | None]:
    """Count runs of one sign in residuals, shape (m,), in the order of x.

    Returns
    -------
    tuple
        Runs, their expectation 2 n+ n- / (n+ + n-) + 1, and the probability of as few (normal approximation with
        continuity correction); None when all have one sign and none can be expected.
    """
    signs = residuals[residuals != 0.0] > 0.0
    plus, minus = int(signs.sum()), int((~signs).sum())
    total = plus + minus
    runs = 1 + int(np.count_nonzero(signs[1:] != signs[:-1])) if total else 0
    expected = 2.0 * plus * minus / total + 1.0 if total else 0.0
    if plus == 0 or minus == 0 or total < 3:
        # a residual of one sign throughout: 2^(1 - n) by chance
        return runs, expected, 2.0 ** (1 - total) if total else None
    variance = (expected - 1.0) * (expected - 2.0) / (total - 1.0)
    if variance <= 0:
        return runs, expected, None
    return runs, expected, float(ndtr((runs + 0.5 - expected) / np.sqrt(variance)))


def durbin_watson(residuals: FloatArray) -> tuple[float, float]:
    """Durbin-Watson statistic of residuals, shape (m,), in the order of x, and the probability of one as small.

    d = sum (r_i - r_(i-1))^2 / sum r_i^2. Independent residuals: mean near 2, variance 4 (m - 2) / (m^2 - 1) (normal
    approximation of the von Neumann ratio, without the model's degrees of freedom).
    """
    count = len(residuals)
    statistic = float(np.sum(np.diff(residuals) ** 2) / np.sum(residuals**2))
    deviation = np.sqrt(4.0 * (count - 2.0) / (count * count - 1.0))
    return statistic, float(ndtr((statistic - 2.0) / deviation))


def repeats_test(x: FloatArray, scaled: FloatArray, weights: FloatArray, dimension: int) -> LackOfFit | None:
    """Split the weighted squares into those within repeats and the rest.

    Parameters
    ----------
    scaled
        Residuals times the root of ``weights``, shape (m,).
    dimension
        Fitted parameters.

    Returns
    -------
    LackOfFit or None
        None without repeats.
    """
    values, group = np.unique(x, return_inverse=True)
    repeats = len(x) - len(values)
    if repeats == 0:
        return None
    residuals = scaled / np.sqrt(weights)
    means = np.bincount(group, weights * residuals) / np.bincount(group, weights)
    pure = float(np.sum(weights * (residuals - means[group]) ** 2))
    rest = float(np.sum(scaled**2)) - pure
    free = len(values) - dimension
    noise = float(np.sqrt(pure / repeats))
    if free < 1 or pure <= 0:
        return LackOfFit(noise, repeats, None, None)
    ratio = max(rest, 0.0) / free / (pure / repeats)
    return LackOfFit(noise, repeats, ratio, float(fdtrc(free, repeats, ratio)))
