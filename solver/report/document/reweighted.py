"""Stored evaluations under other weights, as the HTTP interface and the command line show them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from geoswarm.solver.identifiability import Reweighted
from geoswarm.solver.problem import Problem

__all__ = ["reweighted_document"]


def reweighted_document(problem: Problem, after: Reweighted) -> dict[str, Any]:
    """Return shares, best evaluations and the problem of stored evaluations under other weights.

    Returns
    -------
    dict
        ``weights`` (share of each series), ``best`` and ``best_before`` (generation, particle,
        objective under the new weights, all parameters), ``moved``, ``warnings`` and ``problem`` with the new weights.
        Numbers that are not finite remain: see :func:`geoswarm.solver.report.jsonable.jsonable`.
    """
    samples = after.samples

    def place(index: int) -> dict[str, Any]:
        return {
            "generation": int(samples.generations[index]),
            "particle": int(samples.particles[index]),
            "objective": float(samples.objectives[index]),
            "parameters": problem.values(samples.parameters[index].tolist()),
        }

    return {
        "weights": [asdict(share) for share in after.shares],
        "best": place(after.best_after),
        "best_before": place(after.best_before),
        "moved": after.best_before != after.best_after,
        "warnings": list(after.warnings),
        "problem": after.problem.document(),
    }
