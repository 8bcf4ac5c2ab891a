"""A response surface of the weighted residual vector: cubic radial basis functions with a linear tail.

The residual vector r(u) over unit coordinates u is modelled by its leading principal components z, r = mean + V z, each
interpolated by ``z_k(u) = sum_i w_ik |u - u_i|^3 + a_k + b_k . u`` with ``sum_i w_ik = 0`` and ``sum_i w_ik u_i = 0``
(Powell 1992; Gutmann 2001). Its squared length models the objective far better than a surface of the objective itself:
the vector is nearly linear where its square is a curved valley.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from solver.arrays import FloatArray

__all__ = ["ResidualSurface"]

_COMPONENTS: Final = 40
_NEGLIGIBLE: Final = 1.0e-7  # singular values below this fraction of the largest carry nothing but rounding


class ResidualSurface:
    """Interpolates residual vectors given at distinct points.

    Parameters
    ----------
    points
        Unit coordinates, shape (n, d).
    residuals
        Weighted residual vectors there, shape (n, m).
    """

    def __init__(self, points: FloatArray, residuals: FloatArray) -> None:
        n, d = points.shape
        self._points = points
        mean = residuals.mean(axis=0)
        left, singular, right = np.linalg.svd(residuals - mean, full_matrices=False)
        kept = max(1, min(_COMPONENTS, int(np.sum(singular > _NEGLIGIBLE * singular[0]))))
        basis = right[:kept]
        self._offset = basis @ mean
        # the part of the mean that no component can cancel
        self._rest = max(float(mean @ mean - self._offset @ self._offset), 0.0)
        tail = np.hstack([np.ones((n, 1)), points])
        system = np.zeros((n + d + 1, n + d + 1))
        system[:n, :n] = _distances(points, points) ** 3
        system[:n, n:] = tail
        system[n:, :n] = tail.T
        right_side = np.zeros((n + d + 1, kept))
        right_side[:n] = left[:, :kept] * singular[:kept]
        try:
            weights = np.linalg.solve(system, right_side)
        except np.linalg.LinAlgError:  # points in a plane: the tail is not unique, the smallest one serves
            weights = np.linalg.lstsq(system, right_side, rcond=1e-12)[0]
        self._weights, self._constant, self._slope = weights[:n], weights[n], weights[n + 1 :]

    def components(self, points: FloatArray) -> FloatArray:
        """Modelled residual in principal components, shape (k, c), at k points of shape (k, d)."""
        cubes = _distances(points, self._points) ** 3
        return np.asarray(cubes @ self._weights + self._constant + points @ self._slope + self._offset)

    def objective(self, points: FloatArray) -> FloatArray:
        """Modelled objective, shape (k,), at points of shape (k, d)."""
        z = self.components(points)
        return np.asarray(np.sum(z * z, axis=1) + self._rest)

    def linearised(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Modelled components, shape (c,), and their Jacobian, shape (c, d), at one point."""
        apart = point - self._points
        radius = np.sqrt(np.sum(apart * apart, axis=1))
        z = radius**3 @ self._weights + self._constant + point @ self._slope + self._offset
        gradient = (3.0 * radius[:, None] * apart).T @ self._weights + self._slope
        return z, gradient.T


def _distances(first: FloatArray, second: FloatArray) -> FloatArray:
    apart = first[:, None, :] - second[None, :, :]
    return np.asarray(np.sqrt(np.sum(apart * apart, axis=2)))
