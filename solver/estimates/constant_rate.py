"""Compression curve and coefficient of consolidation of an oedometer test at constant rate of strain."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.classical.constant_rate import constant_rate
from geoswarm.solver.classical.curves import NoEvaluationError, straight_line
from geoswarm.solver.estimates.compression import CompressionReadings
from geoswarm.solver.estimates.value import ClassicalValue
from geoswarm.solver.forward.combined import ModelPart
from geoswarm.solver.laboratory.flow.crs import CrsMovement, CrsOedometerSpec
from geoswarm.solver.problem import Problem

__all__ = ["rate_compression", "rate_values"]

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
    y = -strain if e is None else e - (1.0 + e) * strain
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
    prefix = f"{part.name}." if part.name else ""
    observed = {o.series.removeprefix(prefix): o for o in problem.observations if o.series.startswith(prefix)}
    stress = observed.get("branch_1.axial_stress") or observed.get("axial_stress")
    base = observed.get("branch_1.pore_pressure") or observed.get("pore_pressure")
    if stress is None:
        return None
    mine = stress.x <= spec.stages[0].axial_strain
    order = np.argsort(stress.x[mine], kind="stable")
    strain, sigma = stress.x[mine][order], stress.y[mine][order]
    if base is None or strain.size == 0:
        return strain, sigma, None
    along = np.argsort(base.x, kind="stable")
    inside = (strain >= base.x.min()) & (strain <= base.x.max())
    pore = np.interp(strain[inside], base.x[along], base.y[along]) - spec.back_pressure
    return strain[inside], sigma[inside], pore
