"""How a staged test is calculated: by the fast path of its law, by the general driver, or with finite elements."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.axial import equivalent_axial_pressure
from geoswarm.solver.element_test.constant_load import FAILED_SOIL, FINISHED, constant_load_history
from geoswarm.solver.element_test.load_paths import follow_load_path, point_under
from geoswarm.solver.element_test.specimen import specimen_load_paths
from geoswarm.solver.errors import DivergedError, InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.initial_state import voids_column
from geoswarm.solver.laws.soft_soil_creep import creep_soil

if TYPE_CHECKING:
    from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep
    from geoswarm.solver.forward.staged_load import StagedLoadModel

__all__ = ["FAST_PATHS", "Calculate", "history_of", "voids"]

Calculate: TypeAlias = Callable[[Mapping[str, float]], tuple[FloatArray, FloatArray, FloatArray]]
"""Parameters by name -> rows before the first stage (w,), at the times (m, w) and at the ends of the stages (n, w).

A row holds axial and lateral strain and, where they are wanted, lateral stress, kPa, and the law's state variables.
"""

Place: TypeAlias = Callable[["StagedLoadModel", Mapping[str, float]], tuple[Soil, float]]
"""A soil and its lateral stress before the first stage, kPa."""


def history_of(model: StagedLoadModel, times: FloatArray, firsts: IntArray, states: bool) -> Calculate:
    """Prepare the calculation of a test.

    Parameters
    ----------
    times, firsts
        As :func:`geoswarm.solver.element_test.constant_load.constant_load_history` takes them.
    states
        Whether lateral stress and state variables are wanted, too; not of finite elements.
    """
    fast = FAST_PATHS.get(model.spec.law.kind)
    if fast is not None:
        return fast(model, times, firsts, states)
    if model.spec.discretization == "finite_element":
        return _specimen(model, times, firsts, _placed)
    return _general(model, times, firsts, states)


def _loads(model: StagedLoadModel) -> tuple[FloatArray, FloatArray]:
    """Stresses, kPa, and durations, day, of the stages."""
    stages = model.spec.stages
    return np.array([stage.stress for stage in stages]), np.array([stage.duration for stage in stages])


def _general(model: StagedLoadModel, times: FloatArray, firsts: IntArray, states: bool) -> Calculate:
    """Any law at a material point, in as few components as it takes; yy is the axis."""
    spec, law = model.spec, model.law
    n = 4 if 4 in law.components else 6
    load_paths = []
    for number, stage in enumerate(spec.stages, start=1):
        lateral = None if model.confined else model.lateral_ratio * stage.stress
        name = f"{number} ({stage.stress:g} kPa)"
        load_paths.append(specimen_load_paths(name, n, stage.stress, lateral, stage.duration, 0.0, law.depends_on_time))
    wanted = [
        times[first:last] / stage.duration for (first, last), stage in zip(_parts(firsts), spec.stages, strict=True)
    ]
    count = len(law.state) if states else 0
    columns = [n + 1, n, *([0] if states else []), *range(2 * n, 2 * n + count)]

    def calculate(parameters: Mapping[str, float]) -> tuple[FloatArray, FloatArray, FloatArray]:
        soil, lateral = _placed(model, parameters)
        state = point_under([lateral, spec.initial_stress, lateral, *[0.0] * (n - 3)], soil)
        start = np.concatenate([state.stress, state.strain, state.internal])
        rows, ends = [np.empty((0, start.size))], []
        for (load, *hold), fractions in zip(load_paths, wanted, strict=True):
            path = follow_load_path(soil, load, state, spec.tolerance, dense=False)
            for load_path in hold:
                path = follow_load_path(soil, load_path, path.end, spec.tolerance, dense=bool(fractions.size))
                rows.append(path.at(fractions))
            if not hold:  # nothing happens after the load
                rows.append(np.repeat(path.ends[-1:], fractions.size, axis=0))
            state = path.end
            ends.append(path.ends[-1])
        return start[columns], np.concatenate(rows)[:, columns], np.array(ends)[:, columns]

    return calculate


def _parts(firsts: IntArray) -> list[tuple[int, int]]:
    return list(pairwise(firsts.tolist()))


def voids(model: StagedLoadModel, parameters: Mapping[str, float]) -> float:
    """Void ratio before the first stage: that of the section, or of the law under the initial stress."""
    given, column = model.spec.initial_void_ratio, voids_column(model.law)
    if given is not None or column is None:
        return math.nan if given is None else given
    soil, lateral = _placed(model, parameters)
    stress = [lateral, model.spec.initial_stress, lateral, *[0.0] * (3 if 6 in model.law.components else 1)]
    return float(point_under(stress, soil).internal[column])


def _specimen(model: StagedLoadModel, times: FloatArray, firsts: IntArray, place: Place) -> Calculate:
    """Any law with finite elements."""
    specimen, (stresses, durations) = model.specimen, _loads(model)

    def calculate(parameters: Mapping[str, float]) -> tuple[FloatArray, FloatArray, FloatArray]:
        soil, lateral = place(model, parameters)
        ratio = lateral / model.spec.initial_stress
        return np.zeros(2), *specimen.history(soil, ratio, stresses, durations, times, firsts)

    return calculate


def _placed(model: StagedLoadModel, parameters: Mapping[str, float]) -> tuple[Soil, float]:
    """A soil of any law."""
    soil = model.soil(parameters)
    return soil, model.initial_lateral(soil)


def _soft_soil_creep(model: StagedLoadModel, times: FloatArray, firsts: IntArray, states: bool) -> Calculate:
    """Soft soil creep, whose loads at a material point are scalar equations."""
    spec = model.spec
    if spec.discretization == "finite_element":
        return _specimen(model, times, firsts, _placed_creep)
    stresses, durations = _loads(model)

    def calculate(parameters: Mapping[str, float]) -> tuple[FloatArray, FloatArray, FloatArray]:
        soil, lateral, log_pp = _initial_creep(model, parameters)
        inside = np.empty((times.size if states else 0, 2))
        at_ends = np.empty((stresses.size if states else 0, 2))
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
            inside,
            at_ends,
        )
        if status != FINISHED:
            raise DivergedError(_failure(model, status, stage, time))
        if not states:
            return np.zeros(2), output, ends
        start = np.array([0.0, 0.0, lateral, log_pp])
        return start, np.concatenate([output, inside], axis=1), np.concatenate([ends, at_ends], axis=1)

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


FAST_PATHS: Mapping[str, Callable[[StagedLoadModel, FloatArray, IntArray, bool], Calculate]] = {
    "soft_soil_creep": _soft_soil_creep
}
"""Calculations of one law that are faster than the general ones and agree with them."""
