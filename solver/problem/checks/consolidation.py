"""Primary consolidation in the readings of a test in stages, which the soil laws do not contain.

Two curves are fitted to the readings of each stage: one of creep alone, d_0 + C ln(1 + t / tau), and one of primary
consolidation with secondary compression, d_0 + P U(T) + S lg(1 + t / t_90), where U(T) is Terzaghi's degree of
consolidation (1943) and T = 0.848 t / t_90. Where the second is far better, t_90 is what Taylor's construction over the
root of time gives, and primary consolidation ends (99.4 %) at t_100 = 2.36 t_90.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.problem.stages import section_of_test, stage_of, stage_times
from geoswarm.solver.sentences import Key, Sentence, plain
from geoswarm.solver.units import convert

__all__ = ["PrimaryConsolidation", "consolidation_degree", "find_consolidation"]

_T90 = 0.848
_END = 2.36  # T = 2
_FEWEST = 8  # readings of a stage
_BEFORE, _AFTER = 3, 1  # readings before and after t_90
_BETTER = 0.2  # sum of squares over that of creep alone
_PRIMARY = 0.4  # share of the stage's movement that is primary
_GRID = 60
_MOST_READINGS = 300


@dataclass(frozen=True, slots=True)
class PrimaryConsolidation:
    """Stages of one series whose readings look like primary consolidation.

    Parameters
    ----------
    series
        Name.
    stages
        Their numbers, from 1.
    t90, t100
        Times after the load, the median of these stages [x_unit].
    x_unit
        Unit of x in the data.
    early
        Readings of all stages before t100.
    place
        Of the observation in the problem.
    """

    series: str
    stages: tuple[int, ...]
    t90: float
    t100: float
    x_unit: str
    early: int
    place: str = ""

    @property
    def sentence(self) -> str:
        """The finding and the remedy in the words of the problem file."""
        return plain(self.parts)

    @property
    def parts(self) -> Sentence:
        """The finding and the remedy."""
        several = len(self.stages) > 1
        named = f"stage{'s' if several else ''} {', '.join(map(str, self.stages))}"
        least = f"{self.t100:.2g}" if self.t100 < 10 else f"{self.t100:.0f}"
        return (
            f"{self.series}: the readings of {named} look like primary consolidation (90 % after "
            f"{self.t90:.3g} {self.x_unit}, its end after {least} {self.x_unit}), which the soil laws do not "
            f"contain. Leave out the {self.early} readings before its end: ",
            Key(f"{self.place}.stage_x_from", f"stage_x_from: {least} in the observation", f"{least} {self.x_unit}"),
            "; or calibrate stage_settlement.",
        )


def consolidation_degree(factor: FloatArray) -> FloatArray:
    """Terzaghi's average degree of consolidation U, shape (n,), of time factors T, shape (n,)."""
    early = 2.0 * np.sqrt(np.maximum(factor, 0.0) / np.pi)
    late = 1.0 - 8.0 / np.pi**2 * np.exp(-(np.pi**2) / 4.0 * np.maximum(factor, 0.0))
    return np.where(factor < 0.2, early, late)


def find_consolidation(problem: Problem) -> tuple[PrimaryConsolidation, ...]:
    """Look for primary consolidation in all observations over the time of a test in stages; runs nothing.

    What calculates the flow of pore water has it in its curves.
    """
    found = []
    for index, observation in enumerate(problem.observations):
        starts = stage_times(problem.forward_model, observation.series)
        _, test, _ = section_of_test(problem.forward_model, observation.series)
        if starts.size == 0 or test.consolidates:
            continue
        stages = stage_of(observation.x, starts)
        times = {}
        for stage in np.unique(stages).tolist():
            own = (stages == stage) & (observation.point_weights > 0)
            t90 = _t90(observation.x[own] - starts[stage - 1], observation.y[own])
            if t90 is not None:
                times[int(stage)] = t90
        if not times:
            continue
        info = next(i for i in problem.model.series if i.name == observation.series)
        unit = observation.x_unit or info.x_unit
        middle = float(np.median(list(times.values())))
        zero, t90, t100 = convert([0.0, middle, _END * middle], info.x_unit, unit).tolist()
        early = int(np.sum(observation.x - starts[stages - 1] < _END * middle))
        times_after = t90 - zero, t100 - zero
        place = f"observations[{index}]"
        found.append(PrimaryConsolidation(observation.series, tuple(times), *times_after, unit, early, place))
    return tuple(found)


def _t90(times: FloatArray, values: FloatArray) -> float | None:
    """Time of 90 % primary consolidation after the load, of readings in one stage; None where there is none."""
    used = times > 0.0
    times, values = times[used], values[used]
    if times.size > _MOST_READINGS:
        thin = np.unique(np.linspace(0, times.size - 1, _MOST_READINGS).astype(np.int64))
        times, values = times[thin], values[thin]
    moved = float(np.ptp(values)) if times.size else 0.0
    if times.size < _FEWEST or moved == 0.0:
        return None
    grid = np.geomspace(float(times.min()), float(times.max()), _GRID)
    creep = _fit([np.log1p(times / np.geomspace(grid[0] / 1e3, grid[-1], _GRID)[:, None])], values)[0].min()
    tried = [t90 for t90 in grid if np.sum(times < t90) >= _BEFORE and np.sum(times > t90) >= _AFTER]
    if not tried:
        return None
    parts_of_t90 = times / np.array(tried)[:, None]
    squares, parts = _fit([consolidation_degree(_T90 * parts_of_t90), np.log10(1.0 + parts_of_t90)], values)
    squares[parts[:, 0] * parts[:, 1] < 0.0] = np.inf
    best = int(np.argmin(squares))
    scale = max(float(creep), 1e-12 * moved**2)
    found = squares[best] <= _BETTER * scale and abs(parts[best, 0]) >= _PRIMARY * moved
    return float(tried[best]) if found else None


def _fit(columns: Sequence[FloatArray], values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sums of squares, shape (k,), and coefficients without the constant, (k, c), of k linear fits.

    ``columns`` are c arrays of shape (k, m), ``values`` has shape (m,).
    """
    table = np.stack([*columns, np.ones_like(columns[0])], axis=-1)
    parts = np.linalg.pinv(table) @ values
    left = np.einsum("kmc,kc->km", table, parts) - values
    return np.asarray((left**2).sum(axis=1)), np.asarray(parts[:, :-1])
