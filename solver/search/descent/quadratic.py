"""Quadratic surfaces of residual vectors through runs: what all descents to neighbouring minima learn from together.

Each residual is a quadratic function that holds at one run and meets the others as well as their distance lets expect:
what the surface leaves out grows with its cube. Slopes are free, second derivatives as small as the runs permit
(Powell 2004; Wild 2017, POUNDERS, for least squares). So d + 1 runs give a plane, and each further run, wherever it
was needed, some of the curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.search.bounded import bounded_least_squares

__all__ = ["QuadraticSurface"]

_LENGTH = 10.0  # steps: so far away the quadratic terms count as much as the linear ones
_ROUGH = 1e-5  # of a step: what runs differ by that no surface describes
_FREE = 1e-4  # against slopes: as good as none
_ITERATIONS = 50
_SETTLED = 1e-9  # steps
_DAMPING = 1e-5  # in parts of what all readings say: a direction that those left do not see is not moved along
_ROOM = 1e-12  # the least that a bound must leave
_HALVINGS = 12
_UNSEEN = 1e-6  # of what all readings say of a direction, the part that those left say


@dataclass(frozen=True, slots=True)
class QuadraticSurface:
    """Residuals r(z) = coefficients @ [1, z, z_a z_b for a <= b], shape (m, k), for moves z from a run, in steps."""

    coefficients: FloatArray

    @classmethod
    def through(cls, moves: FloatArray, residuals: FloatArray, at: FloatArray) -> QuadraticSurface:
        """Lay it through runs.

        Parameters
        ----------
        moves, residuals
            Of the other runs, shapes (n, d) and (n, m).
        at
            Residuals of the run where it holds, shape (m,).
        """
        dimension = moves.shape[1]
        terms = _terms(moves)[:, 1:]
        left_out = np.hypot(np.linalg.norm(moves, axis=1) ** 3 / (6.0 * _LENGTH**2), _ROUGH)
        small = np.full(terms.shape[1], _LENGTH)
        small[:dimension] = _FREE
        system = np.concatenate([terms / left_out[:, None], np.diag(small)])
        wanted = np.zeros((len(system), len(at)))
        wanted[: len(moves)] = (residuals - at) / left_out[:, None]
        return cls(np.concatenate([at[:, None], np.linalg.lstsq(system, wanted)[0].T], axis=1))

    def minimum(self, kept: BoolArray, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the lowest point of the sum of some squares in a box, and which parameters they do not determine.

        Parameters
        ----------
        kept
            The residuals that count, shape (m,).
        lower, upper
            The box, shape (d,), around 0.
        """
        dimension = len(lower)
        some = _triangle(self.coefficients[kept])
        whole = _triangle(self.coefficients[:, 1 : dimension + 1])
        z = np.zeros(dimension)
        residuals = _terms(z[None, :])[0] @ some.T
        for _ in range(_ITERATIONS):
            slopes = some @ _term_slopes(z)
            step = bounded_least_squares(
                np.concatenate([slopes, _DAMPING * whole]),
                np.concatenate([-residuals, np.zeros(len(whole))]),
                np.minimum(lower - z, -_ROOM),
                np.maximum(upper - z, _ROOM),
            )
            for _halving in range(_HALVINGS):
                trial = np.clip(z + step, lower, upper)
                there = _terms(trial[None, :])[0] @ some.T
                if there @ there <= residuals @ residuals:
                    break
                step = 0.5 * step
            else:
                break
            moved, z, residuals = float(np.abs(trial - z).max()), trial, there
            if moved < _SETTLED:
                break
        return z, _undetermined(some @ _term_slopes(z), whole)


def _triangle(matrix: FloatArray) -> FloatArray:
    """R of a QR decomposition: the same lengths with as many rows as columns at most."""
    return np.asarray(np.linalg.qr(matrix)[1])


def _terms(z: FloatArray) -> FloatArray:
    """1, the moves and their products, shape (n, d) -> (n, k)."""
    first, second = np.triu_indices(z.shape[1])
    return np.concatenate([np.ones((len(z), 1)), z, z[:, first] * z[:, second]], axis=1)


def _term_slopes(z: FloatArray) -> FloatArray:
    """Derivatives of the terms, shape (d,) -> (k, d)."""
    unit = np.eye(len(z))
    first, second = np.triu_indices(len(z))
    products = unit[first] * z[second, None] + z[first, None] * unit[second]
    return np.concatenate([np.zeros((1, len(z))), unit, products])


def _undetermined(slopes: FloatArray, whole: FloatArray) -> BoolArray:
    """Parameters that lie along directions of which the readings left say next to nothing, shape (d,)."""
    _, sizes, directions = np.linalg.svd(whole)
    seen = sizes > np.finfo(np.float64).eps * len(sizes) * max(float(sizes[0]), 1e-300)
    basis = directions[: len(sizes)][seen].T / sizes[seen]  # moves of length 1 by what all readings say
    _, left, along = np.linalg.svd(slopes @ basis)
    parts = np.zeros(basis.shape[1])
    parts[: len(left)] = left**2
    lost = basis @ along[parts <= _UNSEEN].T
    size = np.linalg.norm(basis, axis=1)
    return np.asarray(np.linalg.norm(lost, axis=1) > 1e-9 * np.where(size > 0.0, size, np.inf))
