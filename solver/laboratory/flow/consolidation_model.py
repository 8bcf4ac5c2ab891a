"""The oedometer test with the flow of pore water: how it is calculated, its parameters and series."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.cells import Cells, graded
from geoswarm.solver.element_test.column import PROFILE
from geoswarm.solver.element_test.consolidation import Column, Ground, Watched, follow_loads
from geoswarm.solver.laboratory.flow.load_stages import LATE, LoadStages, within
from geoswarm.solver.laboratory.model import FlowModel
from geoswarm.solver.laboratory.quantities import Quantity
from geoswarm.solver.laboratory.record import Record
from geoswarm.solver.laboratory.series import Axis, Look, TestSeries
from geoswarm.solver.laboratory.water_flow import (
    AXIAL_STRAIN,
    BASE,
    HORIZONTAL,
    K0_MEAN,
    MEAN_STRESS,
    OUTPUT,
    STRAIN,
    STRESS,
    VERTICAL,
    VOID_RATIO,
    permeability_of,
    pore_pressure_at,
)
from geoswarm.solver.units import WATER

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.flow.consolidation import ConsolidationSpec

__all__ = ["ConsolidationModel"]


@dataclass(frozen=True)
class ConsolidationModel(FlowModel):
    """Forward model of the oedometer test with the flow of pore water."""

    spec: ConsolidationSpec

    @cached_property
    def way(self) -> float:
        """Longest way of the water, m. Drained on two sides, the specimen is calculated from its middle to its top."""
        return self.spec.height * (0.5 if self.spec.drainage == "two_sides" else 1.0)

    @cached_property
    def cells(self) -> Cells:
        """Of what is calculated."""
        heights = graded(self.way, self.spec.cells, False, True)
        return Cells(heights, np.zeros(heights.size, dtype=np.int64), open_base=False)

    @cached_property
    def _combined(self) -> FloatArray:
        """What makes a profile and a load (3 j + 1,) what is observed, (OUTPUT, 3 j + 1), but for a constant."""
        share = self.cells.share
        found = np.zeros((OUTPUT, PROFILE, share.size))
        found[STRAIN, 1] = share
        found[BASE, 0] = -self.cells.at(0.0, zero_at_drains=True)
        found[VERTICAL, 0] = found[HORIZONTAL, 2] = share
        loads = np.zeros(OUTPUT)
        loads[STRESS], loads[BASE] = 1.0, -found[BASE].sum()
        return np.column_stack([found.reshape(OUTPUT, -1), loads])

    @cached_property
    def _loads(self) -> LoadStages:
        return LoadStages(self.spec.stages, self.spec.initial_stress, self.spec.zero_at_stage)

    def _ground(self, parameters: Mapping[str, float]) -> Ground:
        spec, cells = self.spec, self.cells
        k, growth = permeability_of(self.law, parameters, self.void_ratio(parameters))
        count = cells.heights.size
        zero = np.zeros(count)
        return Ground(
            cells.share,
            2.0 * k / (WATER * self.way * cells.heights),
            np.full(count, growth),
            np.full(count, spec.initial_stress),
            zero,
            zero,
            zero,
            False,
            spec.geometry == "updated",
        )

    def test(self, parameters: Mapping[str, float], *, shearing: bool = True, dense: bool = True) -> Record:
        """Calculate the test.

        Raises
        ------
        ForwardError
            It has no solution for these parameters.
        """
        del shearing, dense  # values between the ends of steps cost nothing more
        soil, spec, ground = self.soil(parameters), self.spec, self._ground(parameters)
        voids = self.voids(parameters)
        column = Column.of([(soil, self.placed(soil))] * spec.cells)
        rows = [STRAIN, BASE, VERTICAL, HORIZONTAL]
        watched = Watched(self._combined[rows, :-1].copy(), np.array([-1, 0, 0, 0]))
        last = self._loads.last
        found = follow_loads(column, ground, self._loads.movements, watched, spec.tolerance, voids.check)
        constant = self._combined[:, -1] * spec.initial_stress
        paths = [path.seen(lambda rows: rows @ self._combined.T + constant) for path in found]
        start = paths[0].ends[0]
        before = start if spec.zero_at_stage == 1 else paths[last[spec.zero_at_stage - 2]].ends[-1]
        return self.record_of(start, before[np.newaxis], paths, last, voids)

    def series_of(self) -> Sequence[TestSeries]:
        """Settlement, strain, pore pressure, stresses and void ratio."""
        height, voids = self.spec.height, self.knows_voids
        settlement = Quantity(
            "settlement",
            "Settlement of the top, positive downwards",
            "settlement",
            "m",
            lambda seen: height * (seen.rows[:, STRAIN] - seen.reference[STRAIN]),
        )
        where = "at mid-height" if self.spec.drainage == "two_sides" else "at the base"
        moved = (settlement, AXIAL_STRAIN)
        others = (pore_pressure_at(where), MEAN_STRESS, K0_MEAN, *((VOID_RATIO,) if voids else ()))
        found = [TestSeries(axis, one) for axis in self._axes() for one in (*moved, *others)]
        for number in range(len(self.spec.stages)):
            counted, plain = self._within(number, True), self._within(number, False)
            found += [*(TestSeries(counted, one) for one in moved), *(TestSeries(plain, one) for one in others)]
        return found

    def _axes(self) -> tuple[Axis, Axis]:
        loads, numbers = self._loads, np.arange(1.0, len(self.spec.stages) + 1.0)

        def at_times(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
            sample = test.trace.at_times(x + loads.zero)
            return lambda look: look(sample)

        def at_stages(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
            sample = test.trace.ends(test.last_legs[x.astype(np.int64) - 1])
            return lambda look: look(sample)

        words = f"over the time since {loads.since}"
        return (
            Axis("", words, "time", "day", at_times, loads.grid, 0.0, loads.end * LATE),
            Axis("stage_", "at the end of a stage", "stage", "", at_stages, numbers, 1.0, numbers[-1], x_integer=True),
        )

    def _within(self, number: int, from_its_load: bool) -> Axis:
        """A stage alone (0-based); settlement counts from its load."""
        start, duration = float(self._loads.ends[number]), self.spec.stages[number].duration

        def pick(test: Record, x: FloatArray) -> Callable[[Look], FloatArray]:
            sample, before = test.trace.at_times(start + x), test.trace.at_times(np.array([start]))
            return lambda look: look(sample) - (look(before) if from_its_load else 0.0)

        words = f"in stage {number + 1}, over the time since its load began"
        return Axis(f"branch_{number + 1}.", words, "time", "day", pick, within(duration), 0.0, duration * LATE)
