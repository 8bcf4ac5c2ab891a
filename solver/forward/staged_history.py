"""How a staged test is calculated: by the fast path of its law, by the general driver, or with finite elements."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.axial import equivalent_axial_pressure
from geoswarm.solver.element_test.constant_load import FAILED_SOIL, FINISHED, constant_load_history
from geoswarm.solver.element_test.controls import Stage
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.errors import DivergedError, InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.soft_soil_creep import creep_soil

if TYPE_CHECKING:
    from geoswarm.solver.constitutive.soft_soil_creep import SoftSoilCreep
    from geoswarm.solver.forward.staged_load import StagedLoadModel

__all__ = ["FAST_PATHS", "Calculate", "history_of"]

Calculate: TypeAlias = Callable[[Mapping[str, float]], tuple[FloatArray, FloatArray]]
"""Parameters by name -> axial and lateral strain at the times (m, 2) and at the ends of the stages (n, 2)."""

Place: TypeAlias = Callable[["StagedLoadModel", Mapping[str, float]], tuple[Soil, float]]
"""A soil and its lateral stress before the first stage, kPa."""


def history_of(model: StagedLoadModel, times: FloatArray, firsts: IntArray) -> Calculate:
    """Prepare the calculation of a test.

    Parameters
    ----------
    times, firsts
        As :func:`geoswarm.solver.element_test.constant_load.constant_load_history` takes them.
    """
    fast = FAST_PATHS.get(model.spec.material)
    if fast is not None:
        return fast(model, times, firsts)
    if model.spec.discretization == "finite_element":
        return _specimen(model, times, firsts, _placed)
    return _general(model, times, firsts)


def _loads(model: StagedLoadModel) -> tuple[FloatArray, FloatArray]:
    """Stresses, kPa, and durations, day, of the stages."""
    stages = model.spec.stages
    return np.array([stage.stress for stage in stages]), np.array([stage.duration for stage in stages])


def _upright(stage: Stage) -> Stage:
    """A stage whose axis is yy, which is vertical where laws place a soil, in place of zz."""
    turned = tuple(
        replace(one, coefficients=tuple(one.coefficients[i] for i in (0, 2, 1, 5, 4, 3))) for one in stage.controls
    )
    return replace(stage, controls=turned)


def _general(model: StagedLoadModel, times: FloatArray, firsts: IntArray) -> Calculate:
    """Any law at a material point."""
    spec = model.spec
    stages = [_upright(model.load(stage.stress, stage.duration)) for stage in spec.stages]
    wanted = [times[first:last] for first, last in pairwise(firsts.tolist())]
    moments = [np.append(inside, stage.duration) for inside, stage in zip(wanted, stages, strict=True)]
    last = np.cumsum([len(one) for one in moments]) - 1
    inside = np.ones(last[-1] + 1, dtype=np.bool_)
    inside[last] = False

    def calculate(parameters: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        soil, lateral = _placed(model, parameters)
        start = point_under([lateral, spec.initial_stress, lateral, 0.0, 0.0, 0.0], soil)
        strain = follow(soil, start, stages, moments, tolerance=spec.tolerance).strain[:, [1, 0]]
        return strain[inside], strain[last]

    return calculate


def _specimen(model: StagedLoadModel, times: FloatArray, firsts: IntArray, place: Place) -> Calculate:
    """Any law with finite elements."""
    specimen, (stresses, durations) = model.specimen, _loads(model)

    def calculate(parameters: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        soil, lateral = place(model, parameters)
        return specimen.history(soil, lateral / model.spec.initial_stress, stresses, durations, times, firsts)

    return calculate


def _placed(model: StagedLoadModel, parameters: Mapping[str, float]) -> tuple[Soil, float]:
    """A soil of any law."""
    soil = model.soil(parameters)
    return soil, model.initial_lateral(soil)


def _soft_soil_creep(model: StagedLoadModel, times: FloatArray, firsts: IntArray) -> Calculate:
    """Soft soil creep, whose loads at a material point are scalar equations."""
    spec = model.spec
    if spec.discretization == "finite_element":
        return _specimen(model, times, firsts, _placed_creep)
    stresses, durations = _loads(model)

    def calculate(parameters: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        soil, lateral, log_pp = _initial_creep(model, parameters)
        status, stage, time, output, ends = constant_load_history(
            soil,
            stresses,
            durations,
            model.lateral_ratio,
            spec.initial_stress,
            lateral,
            log_pp,
            spec.tolerance,
            times,
            firsts,
        )
        if status != FINISHED:
            raise DivergedError(_failure(model, status, stage, time))
        return output, ends

    return calculate


def _initial_creep(model: StagedLoadModel, parameters: Mapping[str, float]) -> tuple[SoftSoilCreep, float, float]:
    """A creeping soil, its lateral stress before the first stage, kPa, and its ln p_p."""
    spec = model.spec
    soil = creep_soil(parameters, spec.formulation, spec.tension_cutoff)
    OCR, POP = parameters.get("OCR", spec.OCR or 1.0), parameters.get("POP", spec.POP or 0.0)
    if not (OCR >= 1.0 and POP >= 0.0 and (OCR == 1.0 or POP == 0.0)):
        raise InfeasibleError(model.check({"OCR": OCR, "POP": POP}))
    return soil, *model.initial_state(soil, OCR, POP)


def _placed_creep(model: StagedLoadModel, parameters: Mapping[str, float]) -> tuple[Soil, float]:
    """A creeping soil; OCR or POP of the test is the ratio of pressures that the law takes."""
    soil, lateral, log_pp = _initial_creep(model, parameters)
    past = math.exp(log_pp - math.log(equivalent_axial_pressure(model.spec.initial_stress, lateral, soil)))
    return Soil(model.law, np.array([*soil, past, 0.0])), lateral


def _failure(model: StagedLoadModel, status: int, stage: int, time: float) -> str:
    load = model.spec.stages[stage].stress
    if status == FAILED_SOIL:
        return f"stage {stage + 1} ({load:g} kPa): the load is above the strength of the soil"
    return (
        f"stage {stage + 1} ({load:g} kPa): no step meets the tolerance {model.spec.tolerance:g} "
        f"{time:.3g} day after its application; a larger tolerance may"
    )


FAST_PATHS: Mapping[str, Callable[[StagedLoadModel, FloatArray, IntArray], Calculate]] = {
    "soft_soil_creep": _soft_soil_creep
}
"""Calculations of one law that are faster than the general ones and agree with them."""
