"""Classical evaluation of all laboratory tests of a problem, of any law: of the readings, or of a calculated curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.laboratory.flow.crs import CrsOedometerSpec
from geoswarm.solver.laboratory.shear.simple_shear import DirectSimpleShearSpec
from geoswarm.solver.laboratory.shear.triaxial import TriaxialSpec
from geoswarm.solver.parameter_estimates.compression import (
    compression_constructions,
    compression_readings,
    compression_values,
    consolidation_readings,
)
from geoswarm.solver.parameter_estimates.consolidation import stage_constructions, stage_readings, stage_values
from geoswarm.solver.parameter_estimates.constant_rate import rate_compression, rate_values
from geoswarm.solver.parameter_estimates.observed_curves import load_tests
from geoswarm.solver.parameter_estimates.shear import (
    Sheared,
    sheared_specimen,
    simple_shear_values,
    triaxial_construction,
    triaxial_values,
)
from geoswarm.solver.parameter_estimates.values import ClassicalValue, Construction, NoEvaluationError
from geoswarm.solver.problem import Observation, Problem

__all__ = ["ClassicalEvaluation", "calculated_problem", "classical_evaluation", "classical_values"]


@dataclass(frozen=True, slots=True)
class ClassicalEvaluation:
    """What a ruler gives, and what was drawn for it."""

    values: tuple[ClassicalValue, ...] = ()
    constructions: tuple[Construction, ...] = ()


def classical_values(problem: Problem) -> tuple[ClassicalValue, ...]:
    """Values of the readings of all laboratory tests of a problem."""
    return classical_evaluation(problem).values


def classical_evaluation(problem: Problem) -> ClassicalEvaluation:
    """Evaluate the readings of all laboratory tests of a problem.

    Nothing of the law's parameters is looked at; programs of the user's and layered ground have no such evaluation.
    Readings that ``stage_x_from`` leaves out of the search count: c_v is that of primary consolidation.
    """
    if problem.forward_model.runs_outside:
        return ClassicalEvaluation()
    problem = replace(problem, observations=tuple(_with_early(one) for one in problem.observations))
    values: list[ClassicalValue] = []
    drawn: list[Construction] = []
    for test in load_tests(problem):
        read = compression_readings(problem, test)
        if read is not None:
            values += compression_values(read)
            drawn += compression_constructions(read)
        for stage in stage_readings(problem, test):
            values += stage_values(stage)
            drawn += stage_constructions(stage)
    specimens: list[Sheared] = []
    without: list[ClassicalValue] = []
    for part in parts_of(problem.forward_model, problem.model):
        if isinstance(part.spec, CrsOedometerSpec):
            curve = rate_compression(problem, part)
            if curve is not None:
                values += compression_values(curve)
                drawn += compression_constructions(curve)
            values += rate_values(problem, part)
        if isinstance(part.spec, DirectSimpleShearSpec | TriaxialSpec):
            consolidated = consolidation_readings(problem, part)
            if consolidated is not None:
                values += compression_values(consolidated)
                drawn += compression_constructions(consolidated)
        if isinstance(part.spec, DirectSimpleShearSpec):
            values += simple_shear_values(problem, part)
        elif isinstance(part.spec, TriaxialSpec):
            try:
                specimens.append(sheared_specimen(problem, part))
            except NoEvaluationError as error:
                without.append(ClassicalValue(part.name, "φ", "Mohr circles", None, str(error), "degree"))
    if specimens:
        values += triaxial_values(specimens)
        circles = triaxial_construction(specimens)
        drawn += [] if circles is None else [circles]
    return ClassicalEvaluation((*values, *without), tuple(drawn))


def _with_early(observation: Observation) -> Observation:
    """The observation with the points that ``stage_x_from`` leaves out first: the last of each stage stays its last."""
    return replace(
        observation,
        x=np.concatenate([observation.early_x, observation.x]),
        y=np.concatenate([observation.early_y, observation.y]),
    )


def calculated_problem(problem: Problem, responses: Mapping[str, FloatArray]) -> Problem:
    """The problem with calculated values, shape (m_g,) a series, instead of its readings."""
    none = np.empty(0)
    observations = tuple(
        replace(one, y=responses[one.series], early_x=none, early_y=none) for one in problem.observations
    )
    return replace(problem, observations=observations)
