"""One cycle of a search."""

from __future__ import annotations

from datetime import datetime

from geoswarm.records.record import Number, record, told

__all__ = ["Generation"]


@record
class Generation:
    """One finished generation."""

    number: int
    evaluations: int = told("total so far")
    failed: int = told("failed evaluations so far")
    best_objective: Number = told("lowest objective inside this generation")
    objective: Number = told("lowest objective so far")
    parameters: dict[str, float] | None = told("parameters of the lowest objective so far")
    created_at: datetime
    finished_at: datetime
    diversity: float | None = told(
        "scatter of the particles: near 1 all over the space, 0 at one point; null: not requested"
    )
