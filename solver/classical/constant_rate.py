"""Oedometer test at constant rate of strain: effective stress, coefficient of consolidation and permeability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.classical.curves import NoEvaluationError

__all__ = ["WATER", "ConstantRate", "constant_rate"]

WATER: Final = 9.81
"""Unit weight of water, kN/m³."""

_SEEN = 0.01
"""Least pore pressure over the total stress needed for a coefficient of consolidation."""


@dataclass(frozen=True, slots=True)
class ConstantRate:
    """What the readings of such a test give, between them.

    Parameters
    ----------
    effective
        Mean vertical effective stress at the readings, kPa, shape (n,).
    stress
        The same in the middle between two readings that allow an evaluation, kPa, shape (m,).
    strain
        Settlement over the initial height there, shape (m,).
    c_v, k
        Coefficient of consolidation, m^2/day, and permeability, m/day, there, shape (m,).
    """

    effective: FloatArray
    stress: FloatArray
    strain: FloatArray
    c_v: FloatArray
    k: FloatArray


def constant_rate(
    time: npt.ArrayLike, strain: npt.ArrayLike, stress: npt.ArrayLike, base: npt.ArrayLike, height: float
) -> ConstantRate:
    """Evaluate the steady state (Wissa, Christian, Davis & Heiberg 1971, J. Soil Mech. Found. Div. 97, 1393-1413).

    Linear theory: the pore pressure is a parabola, so the mean effective stress is ``sigma_v - 2/3 u_b``, ``c_v = H^2
    (d sigma_v/dt)/(2 u_b)`` and ``k = gamma_w H^2 (d eps/dt)/(2 u_b)``, H the height at the time.

    Parameters
    ----------
    time
        Day, increasing, shape (n,).
    strain
        Settlement over the initial height.
    stress, base
        Total vertical stress less the back pressure, and excess pore pressure at the closed base, kPa.
    height
        Of the specimen before the test, m; it drains at the top.

    Raises
    ------
    NoEvaluationError
        There are too few readings, or nowhere an excess pore pressure of 1 % of the stress while the stress grows.
    """
    t, eps, sigma, u = (np.asarray(one, dtype=np.float64) for one in (time, strain, stress, base))
    if not (t.ndim == 1 and t.shape == eps.shape == sigma.shape == u.shape and t.size >= 3):
        raise NoEvaluationError(f"{t.size} readings; at least 3 of time, strain, stress and pore pressure are needed")
    if not all(np.isfinite(one).all() for one in (t, eps, sigma, u)) or not (np.diff(t) > 0.0).all():
        raise NoEvaluationError("times must increase, and times, strains, stresses and pore pressures be finite")
    if not height > 0.0:
        raise NoEvaluationError(f"the height must be above 0 m, got {height:g}")
    effective = sigma - 2.0 / 3.0 * u
    middle_u, middle = 0.5 * (u[1:] + u[:-1]), 0.5 * (sigma[1:] + sigma[:-1])
    seen: BoolArray = (middle_u > _SEEN * middle) & (np.diff(sigma) > 0.0) & (np.diff(eps) > 0.0)
    if not seen.any():
        raise NoEvaluationError(
            "no excess pore pressure of 1 % of the stress at the base while the stress grows: the test is too slow"
        )
    path = height * (1.0 - 0.5 * (eps[1:] + eps[:-1]))
    rate = np.diff(t)
    c_v = path**2 * np.diff(sigma) / rate / (2.0 * np.where(seen, middle_u, 1.0))
    k = WATER * path * height * np.diff(eps) / rate / (2.0 * np.where(seen, middle_u, 1.0))
    between = 0.5 * (effective[1:] + effective[:-1])
    return ConstantRate(effective, between[seen], 0.5 * (eps[1:] + eps[:-1])[seen], c_v[seen], k[seen])
