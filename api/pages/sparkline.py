"""The course of a search as a small line in a list."""

from __future__ import annotations

import math
from collections.abc import Sequence

__all__ = ["SPARK_HEIGHT", "SPARK_WIDTH", "sparkline"]

SPARK_WIDTH, SPARK_HEIGHT = 96, 24
MARGIN = 2.0


def sparkline(trend: Sequence[float | None] | None) -> str | None:
    """Corners of a step line of the lowest objective, logarithmic; None when there is nothing to draw."""
    levels = [math.log10(f) for f in trend or () if f is not None and f > 0 and math.isfinite(f)]
    if len(levels) < 2:
        return None
    low, high = min(levels), max(levels)
    span = high - low or 1.0
    step = (SPARK_WIDTH - 2 * MARGIN) / (len(levels) - 1)
    corners: list[str] = []
    for index, level in enumerate(levels):
        x = MARGIN + index * step
        y = MARGIN + (SPARK_HEIGHT - 2 * MARGIN) * (high - level) / span
        corners.append(f"H{x:.1f} V{y:.1f}" if corners else f"M{x:.1f} {y:.1f}")
    return " ".join(corners)
