"""Tables of classical evaluation and back-analysis: readings, calculated curve, index properties, identified values."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability import Linearisation
from geoswarm.solver.parameter_estimates.classical import calculated_problem, classical_values
from geoswarm.solver.parameter_estimates.index import estimates_of
from geoswarm.solver.parameter_estimates.values import ClassicalValue
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.document.laboratory_table import Beside, index_table, laboratory_table, stage_table
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.report.terms import values_in_terms

__all__ = ["calculated_values", "laboratory_tables"]


def laboratory_tables(
    problem: Problem,
    values: Mapping[str, float],
    linearisation: Linearisation | None,
    responses: Mapping[str, FloatArray] | None,
    doubt: str,
) -> list[Table]:
    """Return the tables, if there are any.

    Parameters
    ----------
    values
        Value of every parameter.
    responses
        Calculated at the measured points with them; None: they are calculated here.
    doubt
        Follows every interval where the model does not describe the data.
    """
    readings, index = classical_values(problem), estimates_of(problem)
    calculated = calculated_values(problem, values, responses) if readings else ()
    symbols = {one.symbol for one in readings if one.value is not None} | {one.quantity for one in index}
    found = values_in_terms(problem, values, linearisation, symbols)
    tables = []
    if found or any(one.value is not None for one in readings):
        tables.append(laboratory_table(found, doubt, Beside(readings, calculated, index)))
    return [*tables, *filter(None, (stage_table(readings, calculated), index_table(index, problem)))]


def calculated_values(
    problem: Problem, values: Mapping[str, float], responses: Mapping[str, FloatArray] | None
) -> tuple[ClassicalValue, ...]:
    """What the ruler gives on the calculated curve at the measured points; nothing where it cannot be calculated."""
    try:
        if responses is None:
            with np.errstate(all="ignore"):
                responses = problem.model.prepare({o.series: o.x for o in problem.observations})(values)
        return classical_values(calculated_problem(problem, responses))
    except SolverError:
        return ()
