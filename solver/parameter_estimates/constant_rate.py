"""Oedometer test at constant rate of strain: compression curve, coefficient of consolidation and permeability."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.forward.combined import ModelPart
from geoswarm.solver.laboratory.flow.crs import CrsMovement, CrsOedometerSpec
from geoswarm.solver.parameter_estimates.compression import CompressionReadings, height_of
from geoswarm.solver.parameter_estimates.observed_curves import observed, rising
from geoswarm.solver.parameter_estimates.values import ClassicalValue, NoEvaluationError, straight_line
from geoswarm.solver.problem import Problem
from geoswarm.solver.units import WATER

__all__ = ["ConstantRate", "constant_rate", "rate_compression", "rate_values"]

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


_IN_DECADE = 8
"""Points for each decade of stress that readings are gathered to: slopes between close readings are noise."""
_VIRGIN = 0.5
"""c_v is the median of the readings above this part of the largest effective stress."""
_STEADY, _LEAST = 0.2, 8
"""The line of log k over the void ratio begins at this part of the largest strain, where the state is steady, and needs
so many readings."""


def rate_compression(problem: Problem, part: ModelPart) -> CompressionReadings | None:
    """Mean void ratio (or minus the strain) over the mean effective stress, gathered; None without both readings."""
    read = _readings(problem, part)
    if read is None:
        return None
    strain, stress, base = read
    if base is None:
        return None
    effective = stress - 2.0 / 3.0 * base
    e = part.spec.initial_void_ratio  # type: ignore[attr-defined]  # of this test
    y = height_of(strain, e)
    good = effective > 0.0
    if not good.any():
        return None
    bins = np.floor(_IN_DECADE * np.log10(effective[good])).astype(int)
    gathered = [
        (10.0 ** float(np.log10(effective[good][bins == one]).mean()), float(y[good][bins == one].mean()))
        for one in sorted(set(bins.tolist()))
    ]
    both = np.array(gathered)
    return CompressionReadings(part.name, True, e, both[:, 0], both[:, 1])


def rate_values(problem: Problem, part: ModelPart) -> Iterator[ClassicalValue]:
    """c_v and k of the steady state; with e_0 also k there and its change C_k."""
    assert isinstance(part.spec, CrsOedometerSpec)
    strain, stress, base = _readings(problem, part) or (None, None, None)
    method = "Wissa et al. (1971), median of the upper half of the stresses"
    if strain is None or stress is None or base is None:
        why = "axial_stress and pore_pressure over the axial strain of the first stage are needed"
        yield ClassicalValue(part.name, "c_v", method, None, why, "m²/day")
        return
    first = part.spec.stages[0]
    assert isinstance(first, CrsMovement)
    rate = first.rate or first.axial_strain / (first.duration or 1.0)
    try:
        found = constant_rate(strain / rate, strain, stress, base, part.spec.height)
    except NoEvaluationError as error:
        yield ClassicalValue(part.name, "c_v", method, None, str(error), "m²/day")
        return
    upper = found.stress >= _VIRGIN * found.stress.max()
    yield ClassicalValue(part.name, "c_v", method, float(np.median(found.c_v[upper])), unit="m²/day")
    yield ClassicalValue(part.name, "k", method, float(np.median(found.k[upper])), unit="m/day")
    e = part.spec.initial_void_ratio
    late = found.strain >= _STEADY * found.strain.max()
    if e is None or late.sum() < _LEAST:
        return
    slope, offset, _ = straight_line((1.0 + e) * found.strain[late], np.log10(found.k[late]))
    how = "line of log k over e (Tavenas et al. 1983)"
    yield ClassicalValue(part.name, "k", f"{how}, at e₀", 10.0**offset, unit="m/day")
    if slope < 0.0:
        yield ClassicalValue(part.name, "C_k", how, -1.0 / slope)


def _readings(problem: Problem, part: ModelPart) -> tuple[FloatArray, FloatArray, FloatArray | None] | None:
    """Strain, total stress and excess pore pressure of the first stage, which has to be a movement downwards."""
    spec = part.spec
    if not isinstance(spec, CrsOedometerSpec) or not isinstance(spec.stages[0], CrsMovement):
        return None
    series = observed(problem, part.name)
    stress = series.get("branch_1.axial_stress") or series.get("axial_stress")
    base = series.get("branch_1.pore_pressure") or series.get("pore_pressure")
    if stress is None:
        return None
    strain, sigma = rising(stress)
    mine = strain <= spec.stages[0].axial_strain
    strain, sigma = strain[mine], sigma[mine]
    if base is None or strain.size == 0:
        return strain, sigma, None
    inside = (strain >= base.x.min()) & (strain <= base.x.max())
    pore = np.interp(strain[inside], *rising(base)) - spec.back_pressure
    return strain[inside], sigma[inside], pore
