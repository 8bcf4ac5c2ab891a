"""Models of the neighbourhood of one run: Gauss-Newton for residual vectors, quadratic for a scalar objective."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.bounded import bounded_least_squares
from geoswarm.solver.search.determinism import one_thread

__all__ = ["gauss_newton_point", "neighbour_distance", "quadratic_point"]

_LARGEST_RADIUS = 0.3
_SOFTENING = 0.3  # of the weights, as a fraction of the largest distance


def gauss_newton_point(points: FloatArray, components: FloatArray, centre: int, reach: float) -> FloatArray:
    """Minimum of the linear model through an evaluation, in a box around it.

    Parameters
    ----------
    points, components
        Evaluations in the unit box, shape (n, d), and their residual components, shape (n, k).
    centre
        Index of the evaluation in the middle; the slopes are fitted to its nearest neighbours.
    reach
        Half the width of the box as a fraction of the distance to the farthest neighbour used.
    """
    slopes, farthest = _slopes(points, components, centre)
    middle = points[centre]
    half = reach * min(farthest, _LARGEST_RADIUS)
    lower, upper = np.maximum(-half, -middle), np.minimum(half, 1.0 - middle)
    lower, upper = np.minimum(lower, -1e-15), np.maximum(upper, 1e-15)
    step = bounded_least_squares(slopes.T, -components[centre], lower, upper, most_steps=50)
    return np.asarray(np.clip(middle + step, 0.0, 1.0))


def neighbour_distance(points: FloatArray, centre: int) -> float:
    """Distance from an evaluation to the (d + 1)-th nearest: within it slopes in all directions can be known."""
    distances = np.sqrt(((points - points[centre]) ** 2).sum(axis=1))
    return float(np.sort(distances)[min(points.shape[1] + 1, len(points) - 1)])


def _slopes(points: FloatArray, components: FloatArray, centre: int) -> tuple[FloatArray, float]:
    """Slopes, shape (d, k), fitted to neighbours of an evaluation, and the distance to the farthest of them."""
    middle, d = points[centre], points.shape[1]
    distances = np.sqrt(((points - middle) ** 2).sum(axis=1))
    count = max(2 * d + 2, 6)
    near = np.argsort(distances, kind="stable")[:count]
    apart = distances[near]
    farthest = max(float(distances[near].max()), 1e-12)
    weights = 1.0 / (apart / max(float(apart[-1]), 1e-300) + _SOFTENING) ** 2
    steps = (points[near] - middle) / farthest
    normal = (steps * weights[:, None]).T @ steps + 1e-9 * weights.max() * np.eye(d)
    change = components[near] - components[centre]
    slopes = np.linalg.solve(normal, (steps * weights[:, None]).T @ change) / farthest
    return slopes, farthest


def quadratic_point(points: FloatArray, objectives: FloatArray, centre: int, reach: float) -> FloatArray | None:
    """Minimum of a quadratic through an evaluation, in a box around it; None with fewer than d + 2 points.

    With fewer points than coefficients the smallest curvature that fits is taken.
    """
    middle, d = points[centre], points.shape[1]
    distances = np.sqrt(((points - middle) ** 2).sum(axis=1))
    coefficients = (d + 1) * (d + 2) // 2
    near = np.argsort(distances, kind="stable")[: coefficients + max(2, d)]
    if len(near) < d + 2:
        return None
    radius = min(max(float(distances[near[min(len(near) - 1, coefficients)]]), 1e-12), _LARGEST_RADIUS)
    steps = (points[near] - middle) / radius
    rows, columns = np.triu_indices(d)
    basis = np.concatenate([steps, steps[:, rows] * steps[:, columns]], axis=1)
    weights = 1.0 / (distances[near] / radius + 0.2) ** 1.5
    spread = max(float(np.ptp(objectives[near])), 1e-300)
    change = (objectives[near] - objectives[centre]) / spread
    weighted = basis * weights[:, None]
    damping = np.diag(np.r_[np.full(d, 1e-6), np.full(len(rows), 1e-5)])
    fitted = np.linalg.solve(weighted.T @ weighted + damping, weighted.T @ (weights * change))
    slope, curvature = fitted[:d], np.zeros((d, d))
    curvature[rows, columns] = fitted[d:]
    curvature = curvature + curvature.T

    def model(step: FloatArray) -> tuple[float, FloatArray]:
        bent = curvature @ step
        return float(slope @ step + 0.5 * step @ bent), slope + bent

    from scipy.optimize import minimize  # takes half a second to import

    lower, upper = np.maximum(-middle / radius, -reach), np.minimum((1.0 - middle) / radius, reach)
    bounds = list(zip(lower, upper, strict=True))
    starts = (np.zeros(d), np.clip(-0.5 * reach * np.sign(slope), lower, upper))
    with one_thread():  # SciPy's own BLAS, which may have come with this import
        found = [minimize(model, start, jac=True, bounds=bounds, method="L-BFGS-B") for start in starts]
    step = min(found, key=lambda result: float(result.fun)).x
    return np.asarray(np.clip(middle + radius * step, 0.0, 1.0))
