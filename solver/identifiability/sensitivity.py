"""Linearised uncertainty at the optimum: combinations that the data leave open, covariance, errors and intervals.

With J the derivatives of all responses, W the diagonal of the weights w_g w_h / m_g that the objective gives the points
and S the diagonal of their noise variances, the estimate that minimises the objective has the covariance

    C = (J' W J)^-1  J' W S W J  (J' W J)^-1                         (Seber and Wild 2003, section 2.8)

which is the usual s^2 (J' J)^-1 for one series. Parameters are taken in parts of their range in search coordinates, so
that singular values compare what a move through the whole searched range would change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtri, stdtrit

from solver.arrays import FloatArray
from solver.calibration import Calibration, Evaluation
from solver.identifiability.differences import (
    DifferenceDesign,
    Jacobian,
    check_points,
    design,
    differentiate,
)
from solver.identifiability.noise import Noise, estimate_noise, known_noise

__all__ = ["Combination", "Linearisation", "design", "from_evaluations", "linearise"]

_EXACT = 1e-7  # relative size of a singular value that differences cannot tell from 0
_TAKES_PART = 0.05  # component from which a parameter belongs to a combination
_INFLUENCE = 1e-9


@dataclass(frozen=True, slots=True)
class Combination:
    """A direction in the space of the parameters.

    Parameters
    ----------
    singular_value
        Of the weighted derivatives with columns of unit length: 0 for a direction that changes nothing measured.
    components
        Move of each parameter, parts of its range in search coordinates, unit length; small ones left out.
    open
        True when the data leave the combination undetermined.
    """

    singular_value: float
    components: dict[str, float]
    open: bool


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
        Parameters on which no measured value depends.
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
    """

    names: tuple[str, ...]
    scales: tuple[str, ...]
    optimum: FloatArray
    combinations: tuple[Combination, ...]
    without_influence: tuple[str, ...]
    influences: FloatArray
    noise: Noise | None
    degrees_of_freedom: int
    covariance: FloatArray | None
    standard_errors: FloatArray
    intervals: FloatArray
    unit_widths: FloatArray
    level: float
    derivative_error: float

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
        if name in self.without_influence:
            return "no measured value depends on it"
        tied = self.tied_to(name)
        if tied:
            return f"it acts only in combination with {' and '.join(tied)}"
        if self.noise is None:
            return "there are no more measured points than free parameters, so the noise cannot be estimated; give it"
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
            "derivative_error": self.derivative_error,
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
        Known standard deviation of a reading, base units, one for all series or one each; estimated when absent.

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

    lengths = np.linalg.norm(weighted, axis=0)
    longest = max(float(lengths.max()), 1e-300)
    values = np.concatenate([o.y for o in observed]) * root
    # below this a derivative is rounding of the response
    floor = max(_INFLUENCE * longest, 1e-11 * float(np.linalg.norm(values)))
    active = lengths > np.maximum(floor, 3.0 * np.linalg.norm(errors, axis=0))
    relative_error = np.linalg.norm(errors, axis=0)[active] / lengths[active]
    derivative_error = float(relative_error.max(initial=0.0))

    combinations, basis = _combinations(calibration.free_names, weighted, lengths, active, derivative_error)
    determined = _determined(active, combinations, calibration.free_names)
    estimate = (
        known_noise(calibration.problem, noise)
        if noise is not None
        else estimate_noise(
            calibration.problem,
            {o.series: jacobian.responses[o.series] - o.y for o in observed},
            _degrees_taken(weighted, basis, [(o.series, o.y.size) for o in observed]),
        )
    )
    return _assemble(
        calibration, jacobian, weighted, weights, combinations, basis, determined, active, lengths / longest, estimate,
        level, derivative_error,
    )  # fmt: skip


def _combinations(
    names: tuple[str, ...], weighted: FloatArray, lengths: FloatArray, active: Any, derivative_error: float
) -> tuple[tuple[Combination, ...], FloatArray]:
    """All directions, and the determined ones as an orthonormal basis of the responses, shape (n, rank)."""
    index = np.flatnonzero(active)
    found = []
    basis = np.empty((len(weighted), 0))
    if index.size:
        columns = weighted[:, index] / lengths[index]
        left, singular, right = np.linalg.svd(columns, full_matrices=False)
        tolerance = max(
            _EXACT, 3.0 * min(derivative_error, 0.1) if derivative_error > 1e-3 else 10 * derivative_error**2
        )
        is_open = singular <= tolerance * singular[0]
        basis = left[:, ~is_open]
        for value, direction, opened in zip(singular, right, is_open, strict=True):
            move = direction / lengths[index]
            move = move / np.linalg.norm(move)
            move *= np.sign(move[np.argmax(np.abs(move))])
            components = {
                names[i]: float(m)
                for i, m, unit in zip(index, move, direction, strict=True)
                if abs(m) >= _TAKES_PART or (opened and abs(unit) >= _TAKES_PART)
            }
            found.append(Combination(float(value), components, bool(opened)))
    found += [Combination(0.0, {names[i]: 1.0}, True) for i in np.flatnonzero(~active)]
    return tuple(found), basis


def _determined(active: Any, combinations: tuple[Combination, ...], names: tuple[str, ...]) -> Any:
    """Parameters that take no part in an open combination, shape (d,)."""
    tied = {name for combination in combinations if combination.open for name in combination.components}
    return active & np.array([name not in tied for name in names])


def _degrees_taken(weighted: FloatArray, basis: FloatArray, sizes: list[tuple[str, int]]) -> dict[str, float]:
    """Trace of each series' block of the hat matrix; their sum is the rank."""
    del weighted
    leverage = np.sum(basis * basis, axis=1)
    taken, start = {}, 0
    for series, size in sizes:
        taken[series] = float(leverage[start : start + size].sum())
        start += size
    return taken


def _assemble(
    calibration: Calibration,
    jacobian: Jacobian,
    weighted: FloatArray,
    weights: FloatArray,
    combinations: tuple[Combination, ...],
    basis: FloatArray,
    determined: Any,
    active: Any,
    influences: FloatArray,
    noise: Noise | None,
    level: float,
    derivative_error: float,
) -> Linearisation:
    space = calibration.space
    dimension = space.dimension
    span = space.search_upper - space.search_lower
    deviations = np.full(dimension, np.nan)
    unit_covariance = None
    if noise is not None:
        unit_covariance = _covariance(calibration, weighted, weights, basis, determined, noise)
        deviations = np.sqrt(np.diag(unit_covariance))
    degrees = int((weights > 0).sum()) - dimension
    quantile = _quantile(level, noise)
    half = quantile * deviations
    half = np.where(2.0 * half <= 1.0, half, np.nan)  # wider than the range: the data do not limit it
    deviations = np.where(np.isnan(half), np.nan, deviations)
    centre = space.to_search(jacobian.optimum)
    ends = np.column_stack([centre - half * span, centre + half * span])
    log = space.log[:, None]
    intervals = np.where(log, np.exp(np.where(log, ends, 0.0)), ends)
    slope = np.where(space.log, jacobian.optimum, 1.0)
    covariance = None
    if unit_covariance is not None:
        covariance = unit_covariance * np.outer(span, span)
        hidden = np.isnan(deviations)
        covariance[hidden, :] = np.nan
        covariance[:, hidden] = np.nan
    return Linearisation(
        names=calibration.free_names,
        scales=tuple("log" if is_log else "linear" for is_log in space.log),
        optimum=jacobian.optimum,
        combinations=combinations,
        without_influence=tuple(
            n for n, is_active in zip(calibration.free_names, active, strict=True) if not is_active
        ),
        influences=influences,
        noise=noise,
        degrees_of_freedom=degrees,
        covariance=covariance,
        standard_errors=deviations * span * slope,
        intervals=intervals,
        unit_widths=2.0 * half,
        level=level,
        derivative_error=derivative_error,
    )


def _covariance(
    calibration: Calibration,
    weighted: FloatArray,
    weights: FloatArray,
    basis: FloatArray,
    determined: Any,
    noise: Noise,
) -> FloatArray:
    """Covariance in parts of the range, shape (d, d), nan for parameters that are not determined."""
    variances = np.concatenate(
        [
            np.full(o.y.size, noise.deviations[o.series] ** 2) / np.where(o.point_weights > 0, o.point_weights, 1.0)
            for o in calibration.objective.observed
        ]
    )
    dimension = weighted.shape[1]
    covariance = np.full((dimension, dimension), np.nan)
    if basis.shape[1] == 0 or not determined.any():
        return covariance
    # the pseudo-inverse over the determined directions; exact for parameters outside the open ones
    inverse = np.linalg.pinv(basis.T @ weighted) @ basis.T
    spread = inverse * np.sqrt(weights * variances)
    full = spread @ spread.T
    keep = np.ix_(determined, determined)
    covariance[keep] = full[keep]
    return covariance


def _quantile(level: float, noise: Noise | None) -> float:
    if noise is None:
        return float("nan")
    if np.isinf(noise.degrees_of_freedom):
        return float(ndtri(0.5 + level / 2.0))
    return float(stdtrit(noise.degrees_of_freedom, 0.5 + level / 2.0))


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
