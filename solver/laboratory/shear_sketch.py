"""What the sketches of tests that are sheared share."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import BaseModel

__all__ = ["is_timed"]

_PACES = ("duration", "rate", "period")


def is_timed(stages: Sequence[BaseModel]) -> bool:
    """Whether all stages of shearing say how long they take."""
    return all(any(getattr(stage, name, None) is not None for name in _PACES) for stage in stages)
