"""What happens to a job, as it is followed: events, and the cycles of its search."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from geoswarm.records.record import Number, described, record
from geoswarm.records.states import ENDED_STATES

__all__ = ["Event", "Generation"]


@record
class Event:
    """Something that happened to a job; ids grow with time, so that a reader can continue after the last one seen."""

    id: int
    kind: str = described("state, generation or kernels")
    data: dict[str, Any]

    @property
    def ends_job(self) -> bool:
        """Whether the job has ended with this event."""
        return self.kind == "state" and self.data.get("state") in ENDED_STATES


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
