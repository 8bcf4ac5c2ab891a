"""A response surface over stored evaluations, validated on evaluations left out of it.

It models the *responses*, not the objective: a few principal components of the weighted residuals, each a cubic radial
basis function with a linear trend over the parameters in parts of their range. Objectives under any weights follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.objective import LeastSquares

if TYPE_CHECKING:
    from scipy.interpolate import RBFInterpolator

    _Fitted: TypeAlias = "tuple[FloatArray, FloatArray, RBFInterpolator]"

__all__ = ["ResponseSurface", "fit_surface"]

_MOST_SAMPLES = 600
_FOLDS = 5
_LIKELY = 30.0
_CELLS = 400
_VARIANCE = 1e-10  # share of the residuals' variance that components may leave out
_MOST_COMPONENTS = 20


@dataclass(frozen=True, slots=True)
class ResponseSurface:
    """Fast stand-in for the forward calculation near the optimum.

    Parameters
    ----------
    names
        Of the d free parameters.
    runs
        Rows of the samples that it was fitted to, the best first.
    lower, upper
        Region it was fitted in, shape (d,), parts of the range; it must not be used outside.
    objective_error
        Root mean square of (predicted - calculated f) over those of the hold-out evaluations that are good fits
        (below four times the best objective, at least 20), relative to their f.
    checked
        Number of those.
    predicted
        f of each run by a surface that was fitted without it, shape (count,).
    """

    names: tuple[str, ...]
    runs: IntArray
    lower: FloatArray
    upper: FloatArray
    objective_error: float
    checked: int
    predicted: FloatArray
    _whole: _Fitted
    _parts: tuple[_Fitted, ...]
    _objective: LeastSquares

    @property
    def count(self) -> int:
        """Evaluations it was fitted to."""
        return len(self.runs)

    def residuals(self, unit: FloatArray) -> FloatArray:
        """Weighted residuals without losses, shape (k, n), at points (k, d) in parts of the range."""
        return _residuals(self._whole, unit)

    def objective(self, unit: FloatArray) -> FloatArray:
        """f, shape (k,), at points (k, d) in parts of the range."""
        return _objectives(self._whole, unit, self._objective)

    def spread(self, unit: FloatArray) -> FloatArray:
        """Largest difference of f from the surfaces that were fitted without a fifth of the runs, shape (k,)."""
        here = self.objective(unit)
        return np.asarray(np.max([np.abs(_objectives(p, unit, self._objective) - here) for p in self._parts], axis=0))

    def inside(self, unit: FloatArray) -> BoolArray:
        """Whether points (k, d) lie in the fitted region, shape (k,)."""
        return np.asarray(((unit >= self.lower) & (unit <= self.upper)).all(axis=1))


def fit_surface(calibration: Calibration, samples: Samples, *, seed: int = 0) -> ResponseSurface:
    """Fit to at most 600 of the best stored evaluations with responses, and check it by five-fold hold-out.

    Raises
    ------
    StatisticsError
        When responses are not stored, or there are fewer than 10 (d + 1) different evaluations.
    """
    if not samples.responses:
        raise StatisticsError("a response surface needs the stored responses of the evaluations")
    needed = 10 * (samples.dimension + 1)
    order = _chosen(calibration, samples) if samples.size >= needed else np.arange(samples.size)
    if len(order) < needed:
        raise StatisticsError(f"a response surface needs {needed} different evaluations, there are {len(order)}")
    unit = samples.unit[order]
    objective = calibration.objective
    residuals = objective.plain_residuals({o.series: samples.responses[o.series][order] for o in objective.observed})
    objectives = samples.objectives[order]
    predicted, parts = _hold_out(unit, residuals, objective, seed)
    error, checked = _error(predicted, objectives)
    return ResponseSurface(
        samples.names,
        order,
        unit.min(axis=0),
        unit.max(axis=0),
        error,
        checked,
        predicted,
        _fit(unit, residuals),
        parts,
        objective,
    )


def _chosen(calibration: Calibration, samples: Samples) -> IntArray:
    """Indices of evaluations to fit to, the best first.

    All whose likelihood is not negligible (a factor of exp(-30) for unknown noise), and sixteen times beyond, so that
    the sample does not run against the edge; at least the best 300. Of those that crowd in one cell of a fine grid, as
    the particles of a converged swarm do, the best; of too many, every n-th by rank.
    """
    points = calibration.problem.counted_points
    order = np.argsort(samples.objectives, kind="stable")
    limit = 16.0 * np.exp(2.0 * _LIKELY / max(points, 1)) * samples.objectives[order[0]]
    count = max(int((samples.objectives <= limit).sum()), _MOST_SAMPLES // 2)
    order = order[:count]
    unit = samples.unit[order]
    extent = np.maximum(np.ptp(unit, axis=0), 1e-9)
    cells = np.floor((unit - unit.min(axis=0)) / extent * _CELLS)
    _, first = np.unique(cells, axis=0, return_index=True)
    order = order[np.sort(first)]
    if len(order) > _MOST_SAMPLES:
        order = order[np.unique(np.linspace(0, len(order) - 1, _MOST_SAMPLES).astype(np.int64))]
    return np.asarray(order)


def _fit(unit: FloatArray, residuals: FloatArray) -> _Fitted:
    from scipy.interpolate import RBFInterpolator  # takes most of a second to import

    mean = residuals.mean(axis=0)
    left, singular, right = np.linalg.svd(residuals - mean, full_matrices=False)
    share = np.cumsum(singular[::-1] ** 2)[::-1]
    count = max(1, min(int(np.sum(share > _VARIANCE * share[0])), _MOST_COMPONENTS))
    scores = left[:, :count] * singular[:count]
    return mean, right[:count], RBFInterpolator(unit, scores, kernel="cubic", degree=1)


def _residuals(fitted: _Fitted, unit: FloatArray) -> FloatArray:
    mean, components, interpolator = fitted
    return np.asarray(mean + interpolator(unit) @ components)


def _objectives(fitted: _Fitted, unit: FloatArray, objective: LeastSquares) -> FloatArray:
    return np.asarray(np.sum(objective.with_losses(_residuals(fitted, unit)) ** 2, axis=1))


def _hold_out(
    unit: FloatArray, residuals: FloatArray, objective: LeastSquares, seed: int
) -> tuple[FloatArray, tuple[_Fitted, ...]]:
    """f of each run by the surface that was fitted without it, shape (k,), and these surfaces."""
    fold = np.random.default_rng(seed).permutation(len(unit)) % _FOLDS
    predicted = np.empty(len(unit))
    parts = []
    for number in range(_FOLDS):
        held = fold == number
        parts.append(_fit(unit[~held], residuals[~held]))
        predicted[held] = _objectives(parts[-1], unit[held], objective)
    return predicted, tuple(parts)


def _error(predicted: FloatArray, objectives: FloatArray) -> tuple[float, int]:
    """Relative error of good fits, and how many there are."""
    good = objectives <= max(4.0 * float(objectives.min()), float(np.sort(objectives)[min(19, len(objectives) - 1)]))
    with np.errstate(over="ignore"):  # infinite where objectives are too far apart
        relative = predicted[good] / np.maximum(objectives[good], 1e-300) - 1.0
        return float(np.sqrt(np.mean(relative**2))), int(good.sum())
