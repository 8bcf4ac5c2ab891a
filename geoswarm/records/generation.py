"""One cycle of a search."""

from __future__ import annotations

from datetime import datetime

from geoswarm.records.record import Number, described, record

__all__ = ["Generation"]


@record
class Generation:
    """One finished generation."""

    number: int
    evaluations: int = described("total so far")
    failed: int = described("failed evaluations so far")
    best_objective: Number = described("lowest objective inside this generation")
    objective: Number = described("lowest objective so far")
    parameters: dict[str, float] | None = described("parameters of the lowest objective so far")
    created_at: datetime
    finished_at: datetime
    diversity: float | None = described(
        "scatter of the particles: near 1 all over the space, 0 at one point; null: not requested"
    )
