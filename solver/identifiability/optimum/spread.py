"""Spread of the estimates around the optimum: covariance, standard errors, half widths of intervals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri, stdtrit

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.noise import Noise
from geoswarm.solver.identifiability.optimum.combinations import Directions
from geoswarm.solver.identifiability.optimum.minimising import MinimisingStep
from geoswarm.solver.identifiability.residuals.dependence import Dependence, allowed_deviations

__all__ = ["Spread", "mean_variance", "reading_variances"]


def reading_variances(calibration: Calibration, weights: FloatArray, noise: Noise) -> FloatArray:
    """Return the variance of every weighted reading, shape (n,)."""
    variances: FloatArray = weights * np.concatenate(
        [
            np.full(o.y.size, noise.deviations[o.series] ** 2) / np.where(o.point_weights > 0, o.point_weights, 1.0)
            for o in calibration.objective.observed
        ]
    )
    return variances


def mean_variance(calibration: Calibration, weights: FloatArray, noise: Noise) -> float:
    """Return the mean variance of a weighted reading that has a weight."""
    return float(reading_variances(calibration, weights, noise).sum() / max(int((weights > 0).sum()), 1))


@dataclass(frozen=True, slots=True)
class Spread:
    """Spread of the estimates in parts of the range.

    Covariance (d, d), deviations and distance (d,) are those of independent noise; half widths of the intervals and the
    rises of the profiles at their ends, (d,), allow for dependence and for tests that differ. ``widening``, (d,), says
    how many times wider that makes them, ``between_tests``, (d,), whether the tests decide.
    """

    covariance: FloatArray
    deviations: FloatArray
    half: FloatArray
    distance: FloatArray
    profile_increase: FloatArray
    widening: FloatArray
    between_tests: BoolArray

    @classmethod
    def of(
        cls,
        calibration: Calibration,
        weighted: FloatArray,
        weights: FloatArray,
        residuals: FloatArray,
        step: MinimisingStep,
        found: Directions,
        noise: Noise | None,
        level: float,
        dependence: list[tuple[Dependence, IntArray]],
        between: FloatArray | None,
    ) -> Spread:
        """Propagate the noise of the readings to the parameters; with unknown noise nothing is known.

        ``between``: half widths of intervals between tests, (d,), nan where there is none.
        """
        dimension = weighted.shape[1]
        nothing = np.full(dimension, np.nan)
        covariance = np.full((dimension, dimension), np.nan)
        if noise is None:
            return cls(
                covariance, nothing, nothing, nothing, nothing, np.ones(dimension), np.zeros(dimension, np.bool_)
            )
        quantile = _quantile(level, noise)
        variances = reading_variances(calibration, weights, noise)
        # the pseudo-inverse over the determined directions is exact for parameters outside the open ones
        inverse = found.inverse(weighted)
        scaled = inverse * np.sqrt(variances)
        full, curvature = scaled @ scaled.T, np.sum(inverse**2, axis=1)
        deviations = np.sqrt(np.where(found.determined, np.diag(full), np.nan))
        allowed = deviations
        if dependence:
            x = np.concatenate([o.x for o in calibration.objective.observed])
            wider = allowed_deviations(
                inverse, np.sqrt(variances), residuals, found.basis, dependence, x, level, quantile
            )
            allowed = np.maximum(deviations, wider)
        tests = np.full(dimension, np.nan) if between is None else between / quantile
        between_tests = tests > allowed
        allowed = np.where(between_tests, tests, allowed)
        half = quantile * allowed
        half = np.where(2.0 * half <= 1.0, half, np.nan)  # wider than the range: the data do not limit it
        widening = np.divide(allowed, deviations, out=np.ones_like(deviations), where=deviations > 0.0)
        deviations = np.where(2.0 * quantile * deviations <= 1.0, deviations, np.nan)
        known = ~np.isnan(deviations)
        covariance[np.ix_(known, known)] = full[np.ix_(known, known)]
        ratio = allowed**2 / np.where(found.determined, curvature, 1.0)
        mean = mean_variance(calibration, weights, noise)
        increase = quantile**2 * np.where(found.determined, ratio, mean)
        distance = np.full_like(deviations, np.nan)
        distance[deviations == 0.0] = 0.0  # a perfect fit
        np.divide(np.abs(step.move), deviations, out=distance, where=deviations > 0.0)
        return cls(covariance, deviations, half, distance, increase, widening, between_tests)

    def without_intervals(self) -> Spread:
        """The same, but for what the derivatives are too uncertain for."""
        nothing = np.full_like(self.deviations, np.nan)
        return replace(
            self,
            covariance=np.full_like(self.covariance, np.nan),
            deviations=nothing,
            half=nothing,
            profile_increase=nothing,
        )


def _quantile(level: float, noise: Noise) -> float:
    """Student's; normal for known noise."""
    if np.isinf(noise.degrees_of_freedom):
        return float(ndtri(0.5 + level / 2.0))
    return float(stdtrit(noise.degrees_of_freedom, 0.5 + level / 2.0))
