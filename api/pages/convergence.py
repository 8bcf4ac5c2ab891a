"""The convergence plot of the first paint: drawn on the server, so that a job can be read without scripts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from geoswarm.records.job import Generation
from geoswarm.solver.words import power_of_ten

__all__ = ["LEFT", "PLOT_WIDTH", "RIGHT", "Convergence", "convergence"]

PLOT_WIDTH, PLOT_HEIGHT = 640, 300
LEFT, RIGHT, TOP, BOTTOM = 64, 12, 12, 40


@dataclass(frozen=True, slots=True)
class Convergence:
    """Pixel coordinates of a convergence plot: objective (logarithmic) over evaluations."""

    best: str
    generations: list[tuple[float, float]]
    y_ticks: list[tuple[float, str]]
    x_ticks: list[tuple[float, str]]


def convergence(views: Sequence[Generation]) -> Convergence | None:
    """Place the best objective so far (line) and of each generation (dots); None when there is nothing to draw."""
    best = [(v.evaluations, v.objective) for v in views if v.objective is not None and v.objective > 0]
    own = [(v.evaluations, v.best_objective) for v in views if v.best_objective is not None and v.best_objective > 0]
    if not best:
        return None
    levels = [math.log10(f) for _, f in (*best, *own) if math.isfinite(f)]
    low, high = math.floor(min(levels)), math.ceil(max(levels))
    high = max(high, low + 1)
    last = max(n for n, _ in best)

    def place(evaluations: int, objective: float) -> tuple[float, float]:
        x = LEFT + (PLOT_WIDTH - LEFT - RIGHT) * evaluations / last
        y = TOP + (PLOT_HEIGHT - TOP - BOTTOM) * (high - math.log10(objective)) / (high - low)
        return round(x, 1), round(y, 1)

    corners: list[str] = []
    for n, f in best:
        x, y = place(n, f)
        corners.append(f"H{x} V{y}" if corners else f"M{x} {y}")
    decade = max(1, math.ceil((high - low) / 6))
    return Convergence(
        best=" ".join(corners),
        generations=[place(n, f) for n, f in own if math.isfinite(f)],
        y_ticks=[(place(0, 10.0**power)[1], power_of_ten("1", str(power))) for power in range(low, high + 1, decade)],
        x_ticks=[(place(n, 10.0**low)[0], str(n)) for n in (0, last // 2, last)],
    )
