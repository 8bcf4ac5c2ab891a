"""Parameters of a laboratory test in the terms that laboratories use: Cc, Cs, C_alpha and the preconsolidation stress.

With e_0 the void ratio before the test and ln 10 = 2.303:

- ``Cc = ln 10 lambda* (1 + e_0)`` and ``C_alpha = ln 10 mu* (1 + e_0)``, exact for small strains and stresses that are
  large against c cot(phi) (Vermeer & Neher 1999; PLAXIS Material Models Manual, soft soil creep).
- ``Cs = ln 10 kappa* (1 + e_0)`` under all-round stress. In the oedometer the horizontal stress changes in another
  proportion than the vertical one, so there is no single relation: elasticity gives ``d eps = kappa* (1 + nu_ur) /
  ((1 - nu_ur) (1 + 2 K)) d ln(sigma_v)`` at the stress ratio K. Here K = 1 is taken, the mean of an unloading:
  ``Cs = ln 10 kappa* (1 + e_0) (1 + nu_ur) / (3 (1 - nu_ur))``. The manual's ``kappa* = 2 Cs / (2.3 (1 + e_0))`` is the
  same with 0.5 instead of 0.45 (nu_ur = 0.15).
- ``sigma_p``: the vertical stress, with the horizontal one K0nc times it (or the all-round stress), whose equivalent
  pressure is the initial p_p. With POP it is the initial stress plus POP; with OCR and without cohesion OCR times it.

Without e_0 the ratios to ``1 + e_0`` are given. Compression positive; kPa.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.forward.staged_section import StagedLoadSpec
from geoswarm.solver.identifiability import Linearisation
from geoswarm.solver.parameter_estimates.observed_curves import LoadTest
from geoswarm.solver.problem import Problem

if TYPE_CHECKING:
    from geoswarm.solver.forward.staged_load import StagedLoadModel

__all__ = ["LaboratoryValue", "interval_of", "laboratory_values", "staged_tests"]

_STEP = 1e-5
"""Of the differences, in search coordinates: on a log scale relative."""
_NO_INFLUENCE = 1e-6
"""Relative change of a value over that of a parameter; rounding makes some 1e-10."""

Quantity = Callable[[Mapping[str, float]], float]


@dataclass(frozen=True, slots=True)
class LaboratoryValue:
    """One value in the laboratory's terms.

    Parameters
    ----------
    part
        Test that it belongs to; empty where there is but one.
    symbol, name, unit
        What it is.
    value
        At the best parameters.
    interval
        95 % interval from those of the parameters; None where one of them has none, or none is free.
    relation
        Where it comes from, in a formula.
    """

    part: str
    symbol: str
    name: str
    unit: str
    value: float
    interval: tuple[float, float] | None
    relation: str


def staged_tests(problem: Problem) -> Iterator[LoadTest]:
    """The laboratory tests of a problem on soft soil (with or without creep), which laboratories have terms for."""
    for part in parts_of(problem.forward_model, problem.model):
        if isinstance(part.spec, StagedLoadSpec):
            from geoswarm.solver.forward.staged_load import StagedLoadModel
            from geoswarm.solver.laws.soft_soil_creep import SoftSoilCreepLaw

            if isinstance(part.model, StagedLoadModel) and isinstance(part.model.law, SoftSoilCreepLaw):
                yield LoadTest(part.name, part.model, part.values)


def laboratory_values(
    problem: Problem, values: Mapping[str, float], linearisation: Linearisation | None
) -> tuple[LaboratoryValue, ...]:
    """Give the parameters of all laboratory tests in the laboratory's terms.

    Parameters
    ----------
    values
        Value of every parameter.
    linearisation
        Gives the intervals. What follows from one free parameter has its interval, converted; what follows from several
        has that of the linearised logarithm.
    """
    found = []
    for test in staged_tests(problem):
        for symbol, name, unit, relation, quantity in _quantities(test, test.values(values)):

            def of_all(given: Mapping[str, float], test: LoadTest = test, quantity: Quantity = quantity) -> float:
                return quantity(test.values(given))

            interval = None if linearisation is None else interval_of(problem, of_all, linearisation)
            found.append(LaboratoryValue(test.part, symbol, name, unit, of_all(values), interval, relation))
    return tuple(found)


def _quantities(test: LoadTest, at: Mapping[str, float]) -> Iterator[tuple[str, str, str, str, Quantity]]:
    """Symbol, name, unit, relation and function of the parameters."""
    spec = test.model.spec
    e = spec.initial_void_ratio
    factor = math.log(10.0) * (1.0 if e is None else 1.0 + e)
    under, times = ("/(1 + e₀)", "") if e is None else ("", " (1 + e₀)")
    kind = "ratio" if e is None else "index"
    yield f"Cc{under}", f"compression {kind}", "", f"2.303 λ*{times}", lambda p: factor * p["lambda_star"]
    if test.confined:
        relation = f"2.303 κ*{times} (1 + ν)/(3 (1 − ν)), about"
        yield f"Cs{under}", f"swelling {kind}", "", relation, lambda p: factor * p["kappa_star"] * _confined(p)
    else:
        yield f"Cs{under}", f"swelling {kind}", "", f"2.303 κ*{times}", lambda p: factor * p["kappa_star"]
    if "mu_star" in at:
        yield f"Cα{under}", f"creep {kind}", "", f"2.303 μ*{times}", lambda p: factor * p["mu_star"]
    name = "preconsolidation stress, vertical" if test.confined else "preconsolidation stress, all-round"
    if at.get("POP", spec.POP or 0.0) > 0.0:
        relation = "σ′₀ + POP"
    elif at["c"] == 0.0:
        relation = "OCR σ′₀"
    else:
        relation = "where p_eq = OCR p_eq(σ′₀)"
    yield "σ′p", name, "kPa", relation, lambda p: preconsolidation_stress(test.model, p)


def _confined(parameters: Mapping[str, float]) -> float:
    nu = parameters.get("nu_ur", 0.15)
    return (1.0 + nu) / (3.0 * (1.0 - nu))


def preconsolidation_stress(model: StagedLoadModel, parameters: Mapping[str, float]) -> float:
    """Stress [kPa] whose equivalent pressure, in normally consolidated compression, is the initial p_p."""
    from geoswarm.solver.element_test.axial import equivalent_axial_pressure
    from geoswarm.solver.laws.soft_soil_creep import SoftSoilCreepLaw

    spec = model.spec
    assert isinstance(model.law, SoftSoilCreepLaw)
    soil = model.law.kernel_constants(parameters, spec.formulation, spec.tension_cutoff)
    OCR, POP = parameters.get("OCR", spec.OCR or 1.0), parameters.get("POP", spec.POP or 0.0)
    _, log_pp = model.initial_state(soil, OCR, POP)
    ratio = soil.K0nc if model.confined else model.lateral_ratio

    def too_low(stress: float) -> bool:
        return math.log(equivalent_axial_pressure(stress, ratio * stress, soil)) < log_pp

    low, high = 0.0, spec.initial_stress
    while too_low(high):
        low, high = high, 2.0 * high
    while low < (middle := 0.5 * (low + high)) < high:  # until no number lies between
        low, high = (middle, high) if too_low(middle) else (low, middle)
    return high


def interval_of(
    problem: Problem, quantity: Callable[[Mapping[str, float]], float], found: Linearisation
) -> tuple[float, float] | None:
    """Interval of a positive quantity from those of the free parameters that it follows from."""
    logs = np.array([scale == "log" for scale in found.scales])
    centre = np.where(logs, np.log(np.where(logs, found.optimum, 1.0)), found.optimum)
    scales = np.where(logs, 1.0, np.maximum(np.abs(centre), _STEP))

    def at(place: np.ndarray) -> float:
        return quantity(problem.values(np.where(logs, np.exp(np.where(logs, place, 0.0)), place).tolist()))

    try:
        middle = at(centre)
        slopes = np.zeros(len(centre))
        for index, scale in enumerate(scales.tolist()):
            moved = centre.copy()
            moved[index] += _STEP * scale
            slopes[index] = math.log(at(moved) / middle) / (_STEP * scale)
        acting = np.flatnonzero(np.abs(slopes) * scales > _NO_INFLUENCE)
        if acting.size == 0 or not np.isfinite(found.intervals[acting]).all():
            return None
        if acting.size == 1:
            ends = []
            for end in found.intervals[acting[0]].tolist():
                moved = centre.copy()
                moved[acting[0]] = math.log(end) if logs[acting[0]] else end
                ends.append(at(moved))
            return min(ends), max(ends)
    except (InfeasibleError, ValueError):  # beyond what the soil admits, or the logarithm of what is not positive
        return None
    if found.covariance is None:
        return None
    first = int(acting[0])
    low, high = (math.log(end) if logs[first] else float(end) for end in found.intervals[first])
    quantile = 0.5 * (high - low) / math.sqrt(found.covariance[first, first])
    own = found.covariance[np.ix_(acting, acting)]
    half = quantile * math.sqrt(float(slopes[acting] @ own @ slopes[acting]))
    return middle * math.exp(-half), middle * math.exp(half)
