"""Linearised uncertainty at the optimum: combinations that the data leave open, covariance, errors and intervals.

With J the derivatives of all responses, W the diagonal of the weights w_g w_h / m_g that the objective gives the points
and S the diagonal of their noise variances, the estimate that minimises the objective has the covariance

    C = (J' W J)^-1  J' W S W J  (J' W J)^-1                         (Seber and Wild 2003, section 2.8)

which is the usual s^2 (J' J)^-1 for one series. Parameters are taken in parts of their range in search coordinates, so
that singular values compare what a move through the whole searched range would change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.combinations import Combination, Directions, find_directions
from geoswarm.solver.identifiability.dependence import Dependence, dependence_of
from geoswarm.solver.identifiability.differences import (
    DifferenceDesign,
    Jacobian,
    check_points,
    design,
    differentiate,
)
from geoswarm.solver.identifiability.lack_of_fit import FitVerdict, examine_fit, is_exact
from geoswarm.solver.identifiability.minimising import MinimisingStep, minimising_step
from geoswarm.solver.identifiability.noise import Noise, estimate_noise, known_noise, problem_noise
from geoswarm.solver.identifiability.spread import Spread, mean_variance

__all__ = ["Linearisation", "design", "from_evaluations", "linearise"]

_FAR = 0.2
_AT_BOUND = 1e-9


@dataclass(frozen=True, slots=True)
class Linearisation:
    """What the data determine at the optimum, linearised.

    Parameters
    ----------
    names, scales
        Of the d free parameters.
    optimum
        Shape (d,), natural values.
    combinations
        All d directions, the best determined first.
    without_influence
        Parameters on which no measured value depends there, or less than its noise through the whole range.
    unclear
        Parameters whose derivatives are too uncertain to tell whether and how they act; with any of these, no parameter
        has an interval.
    held
        Parameters at a bound beyond which the data pull, with ``lower`` or ``upper``: there the minimum lies on it.
    influences
        Length of the weighted derivative of each parameter over the longest one, shape (d,).
    noise
        Known or estimated; None when it is neither (no more points than parameters).
    degrees_of_freedom
        n - d, n measured points.
    covariance
        Of search coordinates, shape (d, d); nan in rows and columns of parameters without an interval. None without
        noise.
    standard_errors
        Shape (d,), natural values (delta method on a log scale); nan where there is no interval.
    intervals
        Shape (d, 2), natural values: Student's t, normal with known noise; on a log scale symmetric in the logarithm.
        nan where there is none.
    unit_widths
        Width of the intervals in parts of the range, shape (d,).
    level
        Of the intervals.
    derivative_error
        Largest estimated relative error of a derivative column.
    distance
        How far, in standard errors, a Gauss-Newton step inside the bounds would move each parameter, shape (d,); nan
        where there is no standard error. Far from 0, ``optimum`` is not the minimum yet: polish it first.
    profile_increase
        How much the profile objective of each parameter rises to the ends of its interval, shape (d,); for a parameter
        without one, by the mean noise variance of the weighted points. nan without noise.
    fit
        Whether the model describes the data; where it does not, no interval holds.
    dependence
        Series whose residuals are correlated, or of uneven size; intervals allow for it.
    """

    names: tuple[str, ...]
    scales: tuple[str, ...]
    optimum: FloatArray
    combinations: tuple[Combination, ...]
    without_influence: tuple[str, ...]
    unclear: tuple[str, ...]
    held: tuple[tuple[str, str], ...]
    influences: FloatArray
    noise: Noise | None
    degrees_of_freedom: int
    covariance: FloatArray | None
    standard_errors: FloatArray
    intervals: FloatArray
    unit_widths: FloatArray
    level: float
    derivative_error: float
    distance: FloatArray
    profile_increase: FloatArray
    fit: FitVerdict
    dependence: tuple[Dependence, ...] = ()

    @property
    def at_optimum(self) -> bool:
        """Whether no parameter is more than a fifth of its standard error away from the nearest minimum.

        False where no distance is known.
        """
        return bool(np.isfinite(self.distance).any()) and not bool((self.distance > _FAR).any())

    @property
    def far(self) -> float | None:
        """The largest distance from the minimum in standard errors; None where none is known."""
        known = self.distance[np.isfinite(self.distance)]
        return float(known.max()) if known.size else None

    def influence(self, name: str) -> float:
        """Length of the parameter's weighted derivative over the longest one, 0 to 1."""
        return float(self.influences[self.names.index(name)])

    def tied_to(self, name: str) -> tuple[str, ...]:
        """Parameters with which it forms combinations that the data leave open."""
        found = {
            partner: None
            for combination in self.combinations
            if combination.open and name in combination.components and len(combination.components) > 1
            for partner in combination.components
            if partner != name
        }
        return tuple(found)

    def interval(self, name: str) -> tuple[float, float] | None:
        """Confidence interval, natural values, or None."""
        low, high = self.intervals[self.names.index(name)]
        return (float(low), float(high)) if np.isfinite(low) and np.isfinite(high) else None

    def unit_width(self, name: str) -> float:
        """Width of the interval in parts of the searched range; nan without one."""
        return float(self.unit_widths[self.names.index(name)])

    def correlation(self) -> FloatArray:
        """Correlations of the estimates in search coordinates, shape (d, d), nan where there is none."""
        if self.covariance is None:
            return np.full((len(self.names), len(self.names)), np.nan)
        deviation = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.covariance / np.outer(deviation, deviation))

    def why_no_interval(self, name: str) -> str:
        """Say why a parameter has no interval."""
        if name in self.unclear:
            return "its sensitivities are too uncertain to tell how it acts; the forward model is rough there"
        if name in self.without_influence:
            return "no measured value depends on it"
        tied = self.tied_to(name)
        if tied:
            return f"it acts only in combination with {' and '.join(tied)}"
        if self.noise is None:
            return "there are no more measured points than free parameters, so the noise cannot be estimated; give it"
        if self.unclear:
            return f"the sensitivities to {' and '.join(self.unclear)} are too uncertain"
        return "its interval would be wider than the searched range"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; None for nan."""
        rows = {
            name: {
                "value": float(self.optimum[i]),
                "standard_error": _number(self.standard_errors[i]),
                "interval": None if self.interval(name) is None else list(self.interval(name) or ()),
                "influence": float(self.influences[i]),
                "why_no_interval": None if self.interval(name) else self.why_no_interval(name),
            }
            for i, name in enumerate(self.names)
        }
        return {
            "parameters": rows,
            "level": self.level,
            "degrees_of_freedom": self.degrees_of_freedom,
            "noise": None if self.noise is None else {"origin": self.noise.origin, "deviations": self.noise.deviations},
            "combinations": [
                {"singular_value": c.singular_value, "components": c.components, "open": c.open}
                for c in self.combinations
            ],
            "correlation": [[_number(v) for v in row] for row in self.correlation().tolist()],
            "unclear": list(self.unclear),
            "derivative_error": self.derivative_error,
            "distance": [_number(v) for v in self.distance],
            "at_optimum": self.at_optimum,
            "held": dict(self.held),
            "fit": self.fit.to_json(),
            "dependence": [asdict(one) | {"sentence": one.sentence} for one in self.dependence],
        }


def from_evaluations(
    calibration: Calibration,
    plan: DifferenceDesign,
    evaluations: Sequence[Evaluation],
    *,
    noise: Mapping[str, float] | float | None = None,
    level: float = 0.95,
) -> Linearisation:
    """Linearise from the evaluations of :func:`design`'s positions, in their order.

    Parameters
    ----------
    noise
        Known standard deviation of a reading, base units, one for all series or one each; that of the problem file
        when absent, and estimated where it states none.

    Raises
    ------
    TooFewPointsError
        When there are fewer measured points than free parameters.
    StatisticsError
        When too few evaluations succeeded, or ``noise`` is wrong.
    """
    return linearise(calibration, differentiate(calibration, plan, evaluations), noise=noise, level=level)


def linearise(
    calibration: Calibration,
    jacobian: Jacobian,
    *,
    noise: Mapping[str, float] | float | None = None,
    level: float = 0.95,
) -> Linearisation:
    """Linearise from derivatives, wherever they come from; arguments and errors as :func:`from_evaluations`."""
    check_points(calibration)
    observed = calibration.objective.observed
    series = [o.series for o in observed]
    weights = np.concatenate([o.weight * o.point_weights / o.y.size for o in observed])
    root = np.sqrt(weights)
    weighted = np.concatenate([jacobian.derivatives[s] for s in series]) * root[:, None]
    errors = np.concatenate([jacobian.error[s] for s in series]) * root[:, None]
    residuals = np.concatenate([jacobian.responses[o.series] - o.y for o in observed]) * root
    found = find_directions(calibration.free_names, weighted, errors, np.concatenate([o.y for o in observed]) * root)
    stated = known_noise(calibration.problem, noise) if noise is not None else problem_noise(calibration.problem)
    estimate = (
        stated
        if stated is not None
        else estimate_noise(
            calibration.problem,
            {o.series: jacobian.responses[o.series] - o.y for o in observed},
            dict(zip(series, _blocks(found.leverage, [o.y.size for o in observed]), strict=True)),
        )
    )
    noise_level = 0.0 if estimate is None else float(np.sqrt(mean_variance(calibration, weights, estimate)))
    unclear = found.unclear(calibration.free_names, noise_level)
    step = minimising_step(weighted, residuals, found, calibration.space.to_unit(jacobian.optimum))
    inner = _inner(calibration, jacobian.optimum)
    fit = examine_fit(
        calibration,
        jacobian.responses,
        {name: columns[:, inner] for name, columns in jacobian.derivatives.items()},
        None if stated is None else stated.deviations,
    )
    dependence = _dependence(calibration, jacobian, residuals, weights, found, fit)
    spread = Spread.of(calibration, weighted, weights, residuals, step, found, estimate, level, dependence)
    if unclear:
        spread = spread.without_intervals()
    return _assemble(
        calibration,
        jacobian,
        found,
        estimate,
        level,
        spread,
        step,
        unclear,
        int((weights > 0).sum()),
        fit,
        tuple(one for one, _ in dependence),
    )


def _dependence(
    calibration: Calibration,
    jacobian: Jacobian,
    residuals: FloatArray,
    weights: FloatArray,
    found: Directions,
    fit: FitVerdict,
) -> list[tuple[Dependence, IntArray]]:
    """Series whose residuals are correlated or of uneven size, and their readings in the order of x."""
    departing = []
    start = 0
    patterned = {m.series for m in fit.misfits if m.reason == "pattern"}
    for o in calibration.objective.observed:
        places = start + np.flatnonzero(weights[start : start + o.y.size] > 0)
        places = places[np.argsort(o.x[places - start], kind="stable")]
        start += o.y.size
        if is_exact(o, jacobian.responses[o.series] - o.y):
            continue
        one = dependence_of(o.series, residuals[places], found.basis[places], o.series in patterned)
        if one is not None:
            departing.append((one, places))
    return departing


def _inner(calibration: Calibration, optimum: FloatArray) -> BoolArray:
    """Parameters that do not lie at a bound, shape (d,): only they were fitted."""
    unit = calibration.space.to_unit(optimum)
    return np.asarray((unit > _AT_BOUND) & (unit < 1.0 - _AT_BOUND))


def _blocks(leverage: FloatArray, sizes: Sequence[int]) -> list[float]:
    """Trace of each series' block of the hat matrix; their sum is the rank."""
    return [float(part.sum()) for part in np.split(leverage, np.cumsum(sizes)[:-1])]


def _assemble(
    calibration: Calibration,
    jacobian: Jacobian,
    found: Directions,
    noise: Noise | None,
    level: float,
    spread: Spread,
    step: MinimisingStep,
    unclear: tuple[str, ...],
    points: int,
    fit: FitVerdict,
    dependence: tuple[Dependence, ...],
) -> Linearisation:
    space = calibration.space
    span = space.search_upper - space.search_lower
    centre = space.to_search(jacobian.optimum)
    ends = np.column_stack([centre - spread.half * span, centre + spread.half * span])
    log = space.log[:, None]
    return Linearisation(
        names=calibration.free_names,
        scales=tuple("log" if is_log else "linear" for is_log in space.log),
        optimum=jacobian.optimum,
        combinations=found.combinations,
        without_influence=tuple(
            name
            for name, is_active in zip(calibration.free_names, found.active, strict=True)
            if not is_active and name not in unclear
        ),
        unclear=unclear,
        held=tuple(
            (name, "lower" if side < 0 else "upper")
            for name, side in zip(calibration.free_names, step.held, strict=True)
            if side
        ),
        influences=found.influences,
        noise=noise,
        degrees_of_freedom=points - space.dimension,
        covariance=None if noise is None else spread.covariance * np.outer(span, span),
        standard_errors=spread.deviations * span * np.where(space.log, jacobian.optimum, 1.0),
        intervals=np.where(log, np.exp(np.where(log, ends, 0.0)), ends),
        unit_widths=2.0 * spread.half,
        level=level,
        derivative_error=found.derivative_error,
        distance=spread.distance,
        profile_increase=spread.profile_increase,
        fit=fit,
        dependence=dependence,
    )


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
