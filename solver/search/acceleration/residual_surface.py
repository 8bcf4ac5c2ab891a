"""Response surface of the weighted residual vector: cubic radial basis functions over its leading components.

A cubic radial basis function with a linear tail interpolates every component (Regis & Shoemaker 2007 give the form).
The objective of the surface is the sum of its squared components, so a curved valley of the objective comes from
components that are nearly linear: far fewer evaluations are needed than for a surface of the objective itself.

Residuals often span decades. ``compression`` s fits arsinh(r / s) instead of r: zero stays zero, far points lose their
weight. Several surfaces with different s disagree where they know little, which spreads their minima.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["Components", "CubicSurface", "ResidualSurface", "minimise"]

_RIDGE = 1e-9  # on the diagonal: equal points must not make the system singular
_MOST_COMPONENTS = 12
_LARGEST_ARSINH = 30.0
_STRETCHES, _FLATTEST = 4, 0.01  # rounds, and the least factor of a direction
_LARGEST_SHARE = 1e6  # unexplained: finite, also where there is no scatter
_ADDED_IN_TURN = 7  # NumPy adds so few numbers one after the other; doing so by columns takes a fraction of its time


@dataclass(frozen=True, slots=True)
class Components:
    """Leading components of residual vectors: f = sum(values^2, axis 1) + rest.

    ``values`` has shape (n, k); ``rest`` is what the components leave out at the better half of the points.
    """

    values: FloatArray
    rest: float

    @classmethod
    def of(cls, residuals: FloatArray, dimension: int) -> Components:
        """Rotate residuals, shape (n, m), best first, onto the directions that explain them: at most 12 or d + 2.

        Each vector counts by its direction and not by its length, else the far points alone would choose.
        """
        n, m = residuals.shape
        squares = (residuals * residuals).sum(axis=1)
        if m == 1 or not squares.any():  # all runs meet all readings exactly
            return cls(residuals[:, :1], 0.0)
        floor = float(np.median(squares[: max(1, n // 4)]))
        scaled = residuals / np.sqrt(squares + floor + 1e-300)[:, None]
        if m <= n:
            variance, directions = np.linalg.eigh(scaled.T @ scaled)
        else:
            variance, points = np.linalg.eigh(scaled @ scaled.T)
            positive = variance > 1e-13 * max(float(variance[-1]), 0.0)
            variance = variance[positive]
            directions = scaled.T @ (points[:, positive] / np.sqrt(variance))
        count = int((variance > 1e-12 * max(float(variance[-1]), 1e-300)).sum())
        count = max(1, min(count, max(_MOST_COMPONENTS, dimension + 2)))
        values: FloatArray = residuals @ directions[:, ::-1][:, :count]
        rest = squares - (values * values).sum(axis=1)
        return cls(values, max(0.0, float(np.median(rest[: max(1, n // 2)]))))


class CubicSurface:
    """Interpolates values, shape (n, k), at points, shape (n, d); reproduces linear functions exactly."""

    def __init__(self, points: FloatArray, values: FloatArray) -> None:
        n, d = points.shape
        system = np.zeros((n + d + 1, n + d + 1))
        distances = np.sqrt(_squared_distances(points, points))
        system[:n, :n] = distances**3 + _RIDGE * np.eye(n)
        system[:n, n] = system[n, :n] = 1.0
        system[:n, n + 1 :] = points
        system[n + 1 :, :n] = points.T
        system[n + 1 :, n + 1 :] = -1e-10 * np.eye(d)  # fewer than d + 1 points determine no slope: the smallest
        inverse = np.linalg.inv(system)
        coefficients = inverse[:, :n] @ values
        self._points = points
        self._columns = np.ascontiguousarray(points.T)
        self._weights = coefficients[:n]
        self._level = coefficients[n]
        self._slope = coefficients[n + 1 :]
        diagonal = np.diag(inverse)[:n]
        self.hold_out = values - coefficients[:n] / np.where(diagonal == 0.0, np.inf, diagonal)[:, None]
        """Prediction at each point from all others, shape (n, k) (Rippa 1999)."""

    def __call__(self, at: FloatArray) -> FloatArray:
        """Values at points, shape (p, d) -> (p, k)."""
        cubes = _squared_distances(at, self._points) ** 1.5
        values: FloatArray = cubes @ self._weights + self._level + at @ self._slope
        return values

    def with_slopes(self, at: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values and their derivatives, shapes (p, k) and (p, k, d)."""
        (p, d), (n, k) = at.shape, self._weights.shape
        distances = np.sqrt(_squared_distances(at, self._points))
        values = distances**3 @ self._weights + self._level + at @ self._slope
        weighted = (3.0 * distances)[:, None, :] * (at[:, :, None] - self._columns)
        slopes = weighted.reshape(p * d, n) @ self._weights
        return values, slopes.reshape(p, d, k).transpose(0, 2, 1) + self._slope.T


class ResidualSurface:
    """Surface of the components over stretched parameters; ``compression`` None leaves the components as they are.

    A radial function knows no directions, but responses often change a hundred times faster along one combination of
    parameters than along another. So distances are taken after a linear map of the parameters: the eigenvectors of the
    mean outer product of the slopes at the better half of the points (active directions, Constantine, Dow & Wang 2014),
    each times its root mean square slope, relative to the steepest and at least 1 %. The slopes are those of the
    surface itself: this is repeated as long as runs that are left out are predicted better.
    """

    _surface: CubicSurface
    _stretch: FloatArray

    def __init__(self, points: FloatArray, components: Components, scale: float, compression: float | None) -> None:
        self._scale = scale if compression is None else scale * compression
        self._compressed = compression is not None
        self._rest = components.rest
        scaled = components.values / self._scale
        self._values = np.arcsinh(scaled) if self._compressed else scaled
        self._lay_over(points, np.eye(points.shape[1]))
        for _ in range(_STRETCHES):
            surface, stretch, unexplained = self._surface, self._stretch, self.unexplained
            self._lay_over(points, self._steepness(points[: max(2, len(points) // 2)]))
            if self.unexplained >= unexplained:
                self._surface, self._stretch = surface, stretch
                break

    def _lay_over(self, points: FloatArray, stretch: FloatArray) -> None:
        self._surface, self._stretch = CubicSurface(points @ stretch, self._values), stretch

    def _steepness(self, points: FloatArray) -> FloatArray:
        """Directions in which the components change at these points, times how fast they do, shape (d, d)."""
        slopes = self._surface.with_slopes(points @ self._stretch)[1] @ self._stretch.T
        squares, directions = np.linalg.eigh(np.einsum("nkd,nke->de", slopes, slopes))
        steepness = np.sqrt(np.maximum(squares, 0.0) / max(float(squares[-1]), 1e-300))
        return np.asarray(directions * np.maximum(steepness, _FLATTEST))

    def residuals(self, at: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Scaled components r and their derivatives, shapes (p, k), (p, k, d)."""
        values, slopes = self._surface.with_slopes(at @ self._stretch)
        slopes = slopes @ self._stretch.T
        if not self._compressed:
            return values, slopes
        values = np.clip(values, -_LARGEST_ARSINH, _LARGEST_ARSINH)
        return np.sinh(values), np.cosh(values)[:, :, None] * slopes

    def objective(self, at: FloatArray) -> FloatArray:
        """f of the surface, shape (p, d) -> (p,)."""
        return self._squares(self._surface(at @ self._stretch))

    @property
    def unexplained(self) -> float:
        """Share of the scatter of the components that is not predicted where each point is left out in turn.

        Over the better half of the points: near 0 the surface knows its way, above 1 their mean would predict better.
        """
        half = max(2, len(self._values) // 2)
        known, predicted = self._values[:half], self._surface.hold_out[:half]
        scatter = float(((known - known.mean(axis=0)) ** 2).sum())
        missed = float(((predicted - known) ** 2).sum())
        return missed / scatter if missed < _LARGEST_SHARE * scatter else _LARGEST_SHARE

    def _squares(self, values: FloatArray) -> FloatArray:
        if self._compressed:
            values = np.sinh(np.clip(values, -_LARGEST_ARSINH, _LARGEST_ARSINH))
        total: FloatArray = (values**2).sum(axis=1) * self._scale**2 + self._rest
        return total


def minimise(
    surface: ResidualSurface,
    starts: FloatArray,
    lower: FloatArray | float = 0.0,
    upper: FloatArray | float = 1.0,
    iterations: int = 20,
) -> tuple[FloatArray, FloatArray]:
    """Levenberg-Marquardt from all starts at once in a box; returns end points (s, d) and their f (s,)."""
    at = np.clip(starts, lower, upper)
    unit = np.eye(at.shape[1])
    damping = np.full(len(at), 1e-2)
    residuals, slopes = surface.residuals(at)
    best = (residuals**2).sum(axis=1)
    for _ in range(iterations):
        gradient = np.einsum("skd,sk->sd", slopes, residuals)
        free = ~(((at <= lower) & (gradient > 0.0)) | ((at >= upper) & (gradient < 0.0)))
        hessian = slopes.transpose(0, 2, 1) @ slopes
        hessian = hessian * (free[:, :, None] & free[:, None, :])
        diagonal = np.einsum("sdd->sd", hessian)
        floor = 1e-12 * np.maximum(diagonal.sum(axis=1), 1e-300)[:, None]
        extra = damping[:, None] * np.maximum(diagonal, floor) + floor + ~free
        system = hessian + extra[:, :, None] * unit
        step = -np.linalg.solve(system, (gradient * free)[:, :, None])[:, :, 0]
        trial = (at + step.clip(-0.3, 0.3)).clip(lower, upper)
        trial_residuals, trial_slopes = surface.residuals(trial)
        found = (trial_residuals**2).sum(axis=1)
        better = found < best
        settled = better & (best - found < 1e-7 * best)
        at = np.where(better[:, None], trial, at)
        residuals = np.where(better[:, None], trial_residuals, residuals)
        slopes = np.where(better[:, None, None], trial_slopes, slopes)
        best = np.where(better, found, best)
        damping = np.where(better, 0.3 * damping, 4.0 * damping).clip(1e-9, 1e9)
        if (settled | (damping > 1e6)).all():
            break
    return at, surface.objective(at)


def _squared_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    squares: FloatArray
    if a.shape[1] > _ADDED_IN_TURN:
        squares = ((a[:, None, :] - b[None]) ** 2).sum(axis=2)
        return squares
    squares = np.zeros((len(a), len(b)))
    for of_a, of_b in zip(a.T, b.T, strict=True):
        squares += (of_a[:, None] - of_b) ** 2
    return squares
