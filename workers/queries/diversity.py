"""Diversity of generations, calculated from their stored evaluations when it is asked for."""

from __future__ import annotations

import numpy as np
from sqlalchemy import Connection, select

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.search.diversity import diversity
from geoswarm.solver.space import search_space
from geoswarm.workers.queries.jobs import get_problem
from geoswarm.workers.store.codec import unpack_array, unpack_problem
from geoswarm.workers.store.tables import evaluations

__all__ = ["diversities"]


def diversities(connection: Connection, job_id: str, first: int, last: int) -> dict[int, float]:
    """Return the diversity of generations ``first`` to ``last`` by number.

    See :mod:`geoswarm.solver.search.diversity`.
    """
    row = get_problem(connection, job_id)
    if row is None:
        return {}
    space = search_space(parse_problem(unpack_problem(row.problem)))
    statement = (
        select(evaluations.c.generation, evaluations.c.parameters)
        .where(evaluations.c.job_id == job_id, evaluations.c.generation.between(first, last))
        .order_by(evaluations.c.generation, evaluations.c.particle)
    )
    positions: dict[int, list[bytes]] = {}
    for evaluation in connection.execute(statement):
        positions.setdefault(evaluation.generation, []).append(evaluation.parameters)
    return {
        number: diversity(space.to_unit(np.array([unpack_array(values) for values in generation])))
        for number, generation in positions.items()
    }
