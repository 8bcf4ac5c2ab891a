"""Statistics as JSON: plain types, null for what is not finite; stored evaluations under other weights."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from geoswarm.solver.identifiability import Reweighted
    from geoswarm.solver.problem import Problem

__all__ = ["jsonable", "reweighted_document"]


def jsonable(value: Any) -> Any:
    """Return plain JSON values of nested mappings, sequences, arrays and numbers; nan and infinity become None."""
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [jsonable(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return jsonable(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def reweighted_document(problem: Problem, after: Reweighted) -> dict[str, Any]:
    """Return shares, best evaluations and the problem of stored evaluations under other weights.

    Returns
    -------
    dict
        ``weights`` (share of each series), ``best`` and ``best_before`` (generation, particle,
        objective under the new weights, all parameters), ``moved``, ``warnings`` and ``problem`` with the new weights.
        Numbers that are not finite remain: see :func:`jsonable`.
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
