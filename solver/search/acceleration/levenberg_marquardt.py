"""Bounded least squares on a cheap model (Levenberg 1944, Marquardt 1963, with the projection of active bounds)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from solver.arrays import FloatArray

__all__ = ["Linearised", "minimise"]

Linearised: TypeAlias = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Point (d,) -> residuals (c,) and their Jacobian (c, d)."""

_ITERATIONS = 15
_TRIES = 6
_SMALL_GAIN = 1.0e-8


def minimise(model: Linearised, start: FloatArray, lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, float]:
    """Return a local minimum of |r|^2 inside the box, shape (d,), and its value."""
    x, damping = start, 1.0e-3
    r, jacobian = model(x)
    value = float(r @ r)
    for _ in range(_ITERATIONS):
        gradient, hessian = jacobian.T @ r, jacobian.T @ jacobian
        free = ~(((x <= lower) & (gradient > 0.0)) | ((x >= upper) & (gradient < 0.0)))
        scale = np.diag(hessian) + 1.0e-12 * np.trace(hessian) + 1.0e-300
        if not free.any():
            break
        for _ in range(_TRIES):
            step = np.zeros_like(x)
            matrix = (hessian + damping * np.diag(scale))[np.ix_(free, free)]
            step[free] = -np.linalg.solve(matrix, gradient[free])
            trial = np.clip(x + step, lower, upper)
            r_trial, jacobian_trial = model(trial)
            value_trial = float(r_trial @ r_trial)
            if value_trial < value:
                break
            damping *= 4.0
        else:
            break
        gain = value - value_trial
        x, r, jacobian, value = trial, r_trial, jacobian_trial, value_trial
        damping = max(damping / 5.0, 1.0e-8)
        if gain <= _SMALL_GAIN * value:
            break
    return x, value
