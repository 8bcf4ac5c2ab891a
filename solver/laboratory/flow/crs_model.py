"""The oedometer test at constant rate of strain: its parameters and series."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.element_test.consolidation import Column
from geoswarm.solver.element_test.specimen import same_strain
from geoswarm.solver.laboratory.flow.crs_record import Flow, lead
from geoswarm.solver.laboratory.model import FlowModel
from geoswarm.solver.laboratory.quantities import Quantity
from geoswarm.solver.laboratory.record import Record
from geoswarm.solver.laboratory.series import TestSeries
from geoswarm.solver.laboratory.shear_axes import path_series, shear_series
from geoswarm.solver.laboratory.shear_stages import Axes, ShearStage
from geoswarm.solver.laboratory.water_flow import (
    AXIAL_STRAIN,
    BASE,
    K0_MEAN,
    MEAN_STRESS,
    OUTPUT,
    STRESS,
    VOID_RATIO,
    permeability_of,
    pore_pressure_at,
)

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.flow.crs import CrsOedometerSpec

__all__ = ["CrsModel"]

_AVERAGE = np.array([1.0, 0.0, -2.0 / 3.0])
"""Effective stress as laboratories evaluate it, from what is observed."""

_MEASURED = (
    Quantity(
        "axial_stress",
        "Total vertical stress less the back pressure",
        "axial stress",
        "kPa",
        lambda seen: seen.rows[:, STRESS],
    ),
    pore_pressure_at("at the base"),
    Quantity(
        "effective_stress",
        "Effective stress as laboratories evaluate it: axial stress less 2/3 of the excess pore pressure at the base",
        "effective stress",
        "kPa",
        lambda seen: seen.rows[:, :3] @ _AVERAGE,
    ),
    MEAN_STRESS,
    Quantity(
        "pore_pressure_ratio",
        "Excess pore pressure at the base over axial stress",
        "pore pressure ratio",
        "",
        lambda seen: seen.rows[:, BASE] / seen.rows[:, STRESS],
    ),
    K0_MEAN,
    AXIAL_STRAIN,
)
_AXES = Axes(
    strain=np.ones(1),
    stress=np.ones(1),
    kept={},
    alike=np.empty((0, 1)),
    volume=np.ones(1),
    inner=same_strain,
    engineering=same_strain,
    largest=1.0,
)
"""Of what is observed: stress and strain of the column, one component each."""


@dataclass(frozen=True)
class CrsModel(FlowModel):
    """Forward model of the oedometer test at constant rate of strain."""

    spec: CrsOedometerSpec

    @cached_property
    def stages(self) -> Sequence[ShearStage]:
        """As the section has them."""
        return [
            stage.stage(f"{number}") if stage.kind == "monotonic" else stage.stage(f"{number}", False, "")
            for number, stage in enumerate(self.spec.stages, start=1)
        ]

    def flow(self, parameters: Mapping[str, float]) -> Flow:
        """How water flows: ln k grows by ln(10)/C_k for each unit of the void ratio.

        Raises
        ------
        InfeasibleError
            A parameter is missing or inadmissible.
        """
        spec = self.spec
        k, growth = permeability_of(self.law, parameters, self.void_ratio(parameters))
        return Flow(k, growth, spec.height, spec.geometry == "updated")

    def test(self, parameters: Mapping[str, float], *, shearing: bool = True, dense: bool = True) -> Record:
        """Calculate the test.

        Raises
        ------
        ForwardError
            It has no solution for these parameters.
        """
        del shearing, dense  # values between the ends of steps cost nothing more
        soil, spec, voids = self.soil(parameters), self.spec, self.voids(parameters)
        column = Column.of([(soil, self.placed(soil))] * (spec.intervals + 1))
        start, paths = lead(column, self.flow(parameters), self.stages, voids, spec.tolerance)
        return self.record_of(start, np.empty((0, OUTPUT)), paths, np.arange(len(paths)), voids)

    def series_of(self) -> Sequence[TestSeries]:
        """Stresses, pore pressure, strain and void ratio."""
        voids = (VOID_RATIO,) if self.knows_voids else ()
        return [
            *shear_series(_AXES, self.stages, 0, "axial strain", (*_MEASURED, *voids), (), (), "the test"),
            *(path_series("effective stress", _AVERAGE, one, "the test") for one in (AXIAL_STRAIN, *voids)),
        ]
