"""Constants of the control of steps, of a material point as of a column of points, and what substeps begin from."""

from __future__ import annotations

from typing import Final

from geoswarm.solver.kernels.jit import kernel

__all__ = ["AS_FOUND", "DONE", "GROWTH", "LOCAL_SHARE", "NO_STEP", "PAUSED", "expected_part"]

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


@kernel
def expected_part(count: int, step: int, early: float, late: float, bent: float) -> float:
    """Strain to begin from in a substep of the way of two or four, on a parabola through what the way before found.

    Parameters
    ----------
    count, step
        Substeps of the way, 2 or 4, and which it is.
    early, late
        Of the way of four: strain increments of both substeps of the way of two. Of that of two: both are that of one.
    bent
        Of the way of two: expected difference of its strain increments.
    """
    if count == 2:
        return 0.5 * early + (0.5 * bent if step == 1 else -0.5 * bent)
    if step == 0:
        return 0.625 * early - 0.125 * late
    if step == 1:
        return 0.375 * early + 0.125 * late
    if step == 2:
        return 0.125 * early + 0.375 * late
    return 0.625 * late - 0.125 * early
