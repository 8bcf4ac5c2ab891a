"""Layered ground in one dimension: its parameters and series, and how they are calculated."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.column.drains import Taken
from geoswarm.solver.column.readings import Readings
from geoswarm.solver.column.rest import GroundAtRest
from geoswarm.solver.element_test.cells import Cells, graded
from geoswarm.solver.element_test.consolidation import Column, Ground, Watched, follow_loads
from geoswarm.solver.element_test.load_paths import PointState, points_under
from geoswarm.solver.element_test.trace import Trace
from geoswarm.solver.errors import InfeasibleError, unknown_series
from geoswarm.solver.forward.base import ForwardRun, SeriesInfo
from geoswarm.solver.forward.isolation import run_isolated
from geoswarm.solver.laboratory.flow.load_stages import LATE, LoadStages
from geoswarm.solver.laboratory.record import no_voids
from geoswarm.solver.laboratory.water_flow import FLOW, flow_fault, permeability_of
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.initial_state import (
    horizontal_stress,
    incomplete,
    knows_voids,
    settled,
    soil_of,
    void_ratio_parameters,
    voids_column,
)
from geoswarm.solver.laws.sources import HANSBO, HOLTZ, TERZAGHI
from geoswarm.solver.parameter_info import ParameterInfo, outside_limits
from geoswarm.solver.units import WATER
from geoswarm.solver.user_laws.law import UserLaw

if TYPE_CHECKING:
    from geoswarm.solver.column.section import ColumnSpec

__all__ = ["ColumnModel"]

_LEAST_CELLS = 4
"""Of a layer, unless it says otherwise."""
_WATCHED = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Cells whose pore pressure has to be a parabola within a step, as parts of their number."""

_RATIO = ParameterInfo(
    "k_ratio",
    "k_h/k_v",
    "",
    "Horizontal over vertical permeability, for the flow to drains.",
    default=1.0,
    lower=0.0,
    lower_open=True,
    typical=(1.0, 5.0),
    source=f"{TERZAGHI}, article 14: 1 to 1.5 for most soft clays, more where they are layered",
)


@dataclass(frozen=True)
class ColumnModel:
    """Forward model of layered ground in one dimension with coupled consolidation."""

    spec: ColumnSpec

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the soils, with their names before them, and of the drains."""
        return self._parameters

    @cached_property
    def _parameters(self) -> tuple[ParameterInfo, ...]:
        found = [
            replace(info, name=f"{name}.{info.name}", description=f"{info.description.rstrip('.')}; soil {name}.")
            for name in self.spec.soils
            for info in self._of_soil(name)
        ]
        return (*found, *(replace(info, name=f"drains.{info.name}") for info in self._of_drains))

    def _of_soil(self, name: str) -> tuple[ParameterInfo, ...]:
        """Parameters of a soil."""
        return (*self._of_law(name), *FLOW, *((_RATIO,) if self.spec.drains else ()))

    def _of_law(self, name: str) -> tuple[ParameterInfo, ...]:
        """Parameters of the law of a soil, with what its section settles."""
        soil = self.spec.soils[name]
        return void_ratio_parameters(soil.law, soil.initial_void_ratio)

    @cached_property
    def _of_drains(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the drains, for what the section says of them."""
        drains, found = self.spec.drains, []
        if drains is not None and drains.smear_diameter is not None:
            text = "Permeability of undisturbed over that of disturbed soil about drains."
            found.append(
                ParameterInfo(
                    "smear_ratio",
                    "k_h/k_s",
                    "",
                    text,
                    drains.smear_ratio,
                    0.0,
                    lower_open=True,
                    typical=(1, 5),
                    source=HANSBO,
                )
            )
        if drains is not None and drains.discharge_capacity is not None:
            text = "Flow through a drain at a unit gradient."
            given = drains.discharge_capacity
            found.append(
                ParameterInfo(
                    "discharge_capacity",
                    "q_w",
                    "m**3/day",
                    text,
                    given,
                    0.0,
                    lower_open=True,
                    typical=(0.1, 3.0),
                    source=HOLTZ,
                )
            )
        return tuple(found)

    @property
    def open_parameters(self) -> bool:
        """No parameters beyond :attr:`parameters`."""
        return False

    def _own(self, name: str, parameters: Mapping[str, float]) -> dict[str, float]:
        """What is given for a soil, or for the drains, by the names that it knows."""
        start = f"{name}."
        return {key.removeprefix(start): value for key, value in parameters.items() if key.startswith(start)}

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about the parameters given, with the soil that refuses them, or None."""
        for name, soil in self.spec.soils.items():
            given = self._own(name, parameters)
            fault = outside_limits([_RATIO], given)
            given.pop(_RATIO.name, None)
            fault = fault or outside_limits(settled(self._of_law(name)), given)
            fault = fault or flow_fault(soil.law, given, knows_voids(soil.law, soil.initial_void_ratio))
            if fault is not None:
                return f"{name}: {fault}"
        fault = outside_limits(self._of_drains, self._own("drains", parameters))
        return None if fault is None else f"drains: {fault}"

    @cached_property
    def rest(self) -> GroundAtRest:
        """Before the first stage."""
        return self.spec.at_rest

    @cached_property
    def cells(self) -> Cells:
        """Of all layers, from the base."""
        spec, height = self.spec, self.spec.height
        heights, layers = [], []
        drained = spec.base == "drained"
        for number, layer in enumerate(reversed(spec.layers)):
            usual = max(_LEAST_CELLS, round(spec.cells * layer.thickness / height))
            part = graded(layer.thickness, layer.cells or usual, number > 0 or drained, True)
            heights.append(part)
            layers.append(np.full(part.size, number))
        return Cells(np.concatenate(heights), np.concatenate(layers), drained)

    @cached_property
    def _soil_of_cells(self) -> list[str]:
        names = [layer.soil for layer in reversed(self.spec.layers)]
        return [names[layer] for layer in self.cells.layers.tolist()]

    @cached_property
    def _depths(self) -> FloatArray:
        """Of the centres of the cells, (j,), m."""
        return self.spec.height - self.cells.centres

    @cached_property
    def _weight(self) -> FloatArray:
        """Effective stress of the cells if nothing is left to consolidate, (j,), kPa."""
        return self.rest.effective(self._depths)

    @cached_property
    def _lift(self) -> FloatArray:
        """Loss of load for a unit of lost length of each cell, (j,), kPa."""
        spec, cells = self.spec, self.cells
        table = spec.height - max(spec.water_table, 0.0)
        return spec.buoyancy * cells.heights * cells.below(table)

    @cached_property
    def _loads(self) -> LoadStages:
        return LoadStages(self.spec.stages, 0.0, self.spec.zero_at_stage)

    @cached_property
    def _voids(self) -> list[float | None]:
        """Initial void ratio of the cells, where it is known."""
        return [self.spec.soils[name].initial_void_ratio for name in self._soil_of_cells]

    @cached_property
    def readings(self) -> Readings:
        """What instruments show, from profiles."""
        spec = self.spec
        moving = spec.geometry == "updated"
        depths = {name: point.depth for name, point in spec.points.items()}
        return Readings(self.cells, self.rest, self._weight, self._lift, self._voids, depths, moving)

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Settlement of the ground surface, and what instruments show, over time."""
        return self._series

    @cached_property
    def _series(self) -> tuple[SeriesInfo, ...]:
        words, end = f"over the time since {self._loads.since}", self._loads.end * LATE
        return tuple(
            SeriesInfo(name, f"{text}, {words}.", "time", "day", quantity, unit, 0.0, end, x_increasing=False)
            for name, text, quantity, unit in self.readings.names
        )

    def grid(self, series: str) -> FloatArray:
        """Times at which a curve looks smooth, day."""
        del series  # the same for all
        return self._loads.grid

    def incomplete(self, declared: Collection[str]) -> str | None:
        """What laws lack among the parameters given, with the soils."""
        for name, soil in self.spec.soils.items():
            own = {one.removeprefix(f"{name}.") for one in declared if one.startswith(f"{name}.")}
            fault = incomplete(soil.law, self._of_law(name), own)
            if fault is not None:
                return f"{name}: {fault}"
        return None

    def _first_voids(self, column: Column) -> FloatArray:
        """Void ratio of the cells before the first stage, of the section or of the law, (j,); 0 where it is unknown."""
        voids = np.zeros(self.cells.heights.size)
        for name, soil in self.spec.soils.items():
            here, state = self._places[name], voids_column(soil.law)
            if soil.initial_void_ratio is not None:
                voids[here] = soil.initial_void_ratio
            elif state is not None:
                voids[here] = column.internal[here, state]
        return voids

    def ground(self, parameters: Mapping[str, float], column: Column) -> Ground:
        """What water meets in a column before the first stage.

        Raises
        ------
        InfeasibleError
            A parameter is missing or inadmissible.
        """
        spec, cells = self.spec, self.cells
        k, growth, ratio = np.empty(cells.heights.size), np.empty(cells.heights.size), np.ones(cells.heights.size)
        for name, soil in spec.soils.items():
            here = self._places[name]
            given = self._own(name, parameters)
            ratio[here] = given.pop(_RATIO.name, 1.0)
            try:
                known = knows_voids(soil.law, soil.initial_void_ratio)
                k[here], growth[here] = permeability_of(soil.law, given, 0.0 if known else None)
            except InfeasibleError as error:
                raise InfeasibleError(f"{name}: {error}") from None
        zero = np.zeros(k.size)
        taken = Taken(zero, zero)
        if spec.drains is not None:
            drains = spec.drains.model_copy(update=self._own("drains", parameters))
            taken = Taken.by(drains, ratio * k, spec.height - cells.faces)
        return Ground(
            cells.share,
            2.0 * k / (WATER * spec.height * cells.heights),
            growth * (1.0 + self._first_voids(column)),
            self._weight,
            self._lift,
            taken.sink,
            taken.resist,
            cells.open_base,
            spec.geometry == "updated",
        )

    @cached_property
    def _places(self) -> dict[str, FloatArray]:
        """Which cells are of each soil."""
        return {name: np.array(self._soil_of_cells) == name for name in self.spec.soils}

    def column(self, parameters: Mapping[str, float]) -> Column:
        """Soils and states of the cells before the first stage.

        Raises
        ------
        InfeasibleError
            A parameter is inadmissible, or a soil has no state under its stress.
        """
        soils = {name: self._soil(name, parameters) for name in self.spec.soils}
        surcharge = self.spec.initial_surcharge
        placed = {}
        for name in dict.fromkeys(self._soil_of_cells):
            full = self._weight[self._places[name]]
            vertical = surcharge + self.spec.soils[name].consolidated * (full - surcharge)
            placed[name] = iter(self._placed(name, soils[name], vertical))
        return Column.of([(soils[name], next(placed[name])) for name in self._soil_of_cells])

    def _soil(self, name: str, parameters: Mapping[str, float]) -> Soil:
        section = self.spec.soils[name]
        own = {info.name for info in section.law.parameters}
        given = {key: value for key, value in self._own(name, parameters).items() if key in own}
        try:
            return soil_of(section.law, self._of_law(name), given, section.settings)
        except InfeasibleError as error:
            raise InfeasibleError(f"{name}: {error}") from None

    def _placed(self, name: str, soil: Soil, vertical: FloatArray) -> list[PointState]:
        """States under vertical stresses (m,), kPa."""
        given = self.spec.soils[name].initial_ratio
        ratio = soil.law.K0(soil.constants) if given == "K0" else given
        stress = np.zeros((vertical.size, self.spec.components))
        try:
            stress[:, 1] = vertical
            stress[:, 0] = stress[:, 2] = [horizontal_stress(one, ratio, soil) for one in vertical.tolist()]
            states = points_under(stress, soil)
        except InfeasibleError as error:
            raise InfeasibleError(f"{name}: {error}") from None
        for state in states:
            if not np.isfinite(state.internal).all():
                raise InfeasibleError(
                    f"{name}: material {soil.law.kind} has no state under {state.stress[1]:g} kPa vertical, "
                    f"{state.stress[0]:g} kPa horizontal with these parameters; another initial surcharge or unit "
                    "weight, within its range"
                )
        return states

    @cached_property
    def _watched(self) -> Watched:
        """Settlement and some pore pressures."""
        count = self.cells.heights.size
        places = np.array([int(part * count) for part in _WATCHED])
        rows = np.zeros((1 + places.size, 3, count))
        rows[0, 1] = self.cells.share
        for row, place in zip(rows[1:], places.tolist(), strict=True):
            row[0, place], row[1] = -1.0, -self._lift
        return Watched(rows.reshape(len(rows), -1), np.append([-1], places))

    def calculate(self, parameters: Mapping[str, float]) -> Trace:
        """States of the ground over time: profiles and loads.

        Raises
        ------
        ForwardError
            There is no solution for these parameters.
        """
        column = self.column(parameters)
        ground = self.ground(parameters, column)
        return Trace(
            follow_loads(column, ground, self._loads.movements, self._watched, self.spec.tolerance, self._void_check)
        )

    @cached_property
    def _void_check(self) -> Callable[[str, FloatArray], None]:
        """Refuses strains that leave no voids."""
        initial = np.array([np.nan if e is None else e for e in self._voids])
        most = initial / (1.0 + initial)
        large = self.spec.geometry == "updated"

        def check(stage: str, strain: FloatArray) -> None:
            lost = -np.expm1(-strain) if large else strain
            wrong = np.flatnonzero(lost >= most)
            if wrong.size:
                first = wrong[0]
                raise no_voids(stage, initial[first], lost[first], f" of {self._soil_of_cells[first]}")

        return check

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of the given series at the given times; see the protocol.

        Raises
        ------
        ProblemError
            A series is unknown, or a time is outside the calculation.
        """
        known = {info.name: info for info in self.series}
        for name, x in points.items():
            if name not in known:
                raise unknown_series(name, known)
            known[name].require(x)
        zero = self._loads.zero

        def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            trace = self.calculate(parameters)
            reference = trace.at_times(np.array([zero])).rows[0]
            return {
                name: self.readings.of(name, trace.at_times(x + zero).rows, reference) for name, x in points.items()
            }

        laws = [soil.law for soil in self.spec.soils.values()]
        return run_isolated(run, [law for law in laws if isinstance(law, UserLaw)])
