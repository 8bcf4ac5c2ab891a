"""The classical evaluation of the readings of a laboratory test, to stand beside what was identified.

It looks at the readings alone, at no soil law. Oedometer tests only, with strains that count from the first stage.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.classical.compression import compression_index, swelling_index
from geoswarm.solver.classical.consolidation import log_time
from geoswarm.solver.classical.errors import NoEvaluationError
from geoswarm.solver.classical.preconsolidation import casagrande, log_log
from geoswarm.solver.problem.stages import stage_of, stage_times
from geoswarm.solver.report.compression import measured_strain
from geoswarm.solver.report.laboratory import StagedTest, staged_tests

if TYPE_CHECKING:
    from geoswarm.solver.arrays import FloatArray
    from geoswarm.solver.problem import Problem

__all__ = ["ClassicalValue", "classical_values"]


@dataclass(frozen=True, slots=True)
class ClassicalValue:
    """One value of the readings: test, symbol as of the identified value, method, and value or why there is none."""

    part: str
    symbol: str
    method: str
    value: float | None
    why: str = ""


def classical_values(problem: Problem) -> tuple[ClassicalValue, ...]:
    """Evaluate the readings of all oedometer tests of a problem."""
    found: list[ClassicalValue] = []
    for test in staged_tests(problem):
        if test.confined and test.model.spec.zero_at_stage == 1:
            found += _of_stages(problem, test)
            found += _of_creep(problem, test)
    return tuple(found)


def _of_stages(problem: Problem, test: StagedTest) -> Iterator[ClassicalValue]:
    """Indices and preconsolidation stress of the readings at the ends of stages."""
    spec = test.model.spec
    e = spec.initial_void_ratio
    stages, strain = measured_strain(problem, test)
    if stages.size == 0:
        return
    stress = np.array([stage.stress for stage in spec.stages])[stages - 1]
    y = -strain if e is None else e - (1.0 + e) * strain
    under = "/(1 + e₀)" if e is None else ""
    methods: list[tuple[str, str, Callable[[FloatArray, FloatArray], float]]] = [
        (f"Cc{under}", "steepest part", compression_index),
        (f"Cs{under}", "unloading", swelling_index),
        ("σ′p", "Casagrande", casagrande),
    ]
    if e is not None:
        methods.append(("σ′p", "log-log", log_log))
    for symbol, method, evaluate in methods:
        try:
            yield ClassicalValue(test.part, symbol, method, float(evaluate(stress, y)))
        except NoEvaluationError as error:
            yield ClassicalValue(test.part, symbol, method, None, str(error))


def _of_creep(problem: Problem, test: StagedTest) -> Iterator[ClassicalValue]:
    """Secondary compression at the end of the stage with the largest stress of those whose readings allow it."""
    spec = test.model.spec
    e = spec.initial_void_ratio
    prefix = f"{test.part}." if test.part else ""
    symbol = "Cα" if e is not None else "Cα/(1 + e₀)"
    for name, scale in (("settlement", 1.0 / spec.height), ("axial_strain", 1.0)):
        one = next((o for o in problem.observations if o.series == f"{prefix}{name}"), None)
        if one is None:
            continue
        starts = stage_times(problem.forward_model, one.series)
        belongs = stage_of(one.x, starts)
        why = "no stage has readings of virgin loading that allow it"
        largest = np.maximum.accumulate([spec.initial_stress, *(stage.stress for stage in spec.stages)])
        for number in sorted(set(belongs.tolist()), key=lambda n: -spec.stages[n - 1].stress):
            if spec.stages[number - 1].stress <= largest[number - 1]:
                continue
            mine = (belongs == number) & (one.x > starts[number - 1])
            try:
                # the drainage path has no influence on secondary compression
                told = log_time(one.x[mine] - starts[number - 1], one.y[mine] * scale, 1.0)
            except NoEvaluationError as error:
                why = str(error)
                continue
            assert told.secondary is not None
            value = told.secondary * (1.0 if e is None else 1.0 + e)
            yield ClassicalValue(test.part, symbol, f"log time, stage {number}", value)
            return
        yield ClassicalValue(test.part, symbol, "log time", None, why)
        return
