"""What happens to a job, as it is followed."""

from __future__ import annotations

from typing import Any

from geoswarm.records.record import described, record
from geoswarm.records.states import ENDED_STATES

__all__ = ["Event"]


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
