"""Constants of the control of steps, of a material point as of a column of points."""

from __future__ import annotations

from typing import Final

__all__ = ["AS_FOUND", "DONE", "GROWTH", "LOCAL_SHARE", "NO_STEP", "PAUSED"]

DONE: Final = 0
PAUSED: Final = 1
NO_STEP: Final = 2
"""How stepping ended: at the end, for want of room, or without a solution."""

LOCAL_SHARE: Final = 0.1
"""Part of the tolerance that is granted to one step."""
GROWTH: Final = 6.0
"""Of the length, at most, from a step to the next."""
AS_FOUND: Final = -1.0
"""Weight of a flag or counter among the state variables: no mean of several ways is taken, and it has no error."""
