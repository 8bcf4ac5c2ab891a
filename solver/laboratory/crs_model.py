"""The oedometer test at constant rate of strain: its parameters and series."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geoswarm.solver.element_test.column import OUTPUT
from geoswarm.solver.element_test.specimen import same_strain
from geoswarm.solver.element_test.trace import Trace
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laboratory.crs_record import Column, Flow, lead
from geoswarm.solver.laboratory.model import LaboratoryModel
from geoswarm.solver.laboratory.quantities import Quantity
from geoswarm.solver.laboratory.record import Record
from geoswarm.solver.laboratory.series import TestSeries
from geoswarm.solver.laboratory.shear_axes import path_series, shear_series
from geoswarm.solver.laboratory.shear_stages import Axes, ShearStage
from geoswarm.solver.parameter_info import ParameterInfo, outside_limits

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.crs import CrsOedometerSpec

__all__ = ["CrsModel"]

_STRESS, _STRAIN, _BASE, _VERTICAL, _HORIZONTAL = range(OUTPUT)
"""Columns of what is observed of a column."""

_FLOW = (
    ParameterInfo(
        "k",
        "k",
        "m/day",
        "Permeability where the test begins; 1e-9 m/s is 8.64e-5 m/day.",
        lower=0.0,
        lower_open=True,
        typical=(1.0e-7, 1.0e-2),
    ),
    ParameterInfo(
        "C_k",
        "C_k",
        "",
        "Change of the void ratio for a tenfold permeability; 0: the permeability is constant.",
        default=0.0,
        lower=0.0,
        typical=(0.2, 2.0),
    ),
)
_AVERAGE = np.array([1.0, 0.0, -2.0 / 3.0])
"""Effective stress as laboratories evaluate it, from what is observed."""

_AXIAL_STRAIN = Quantity("axial_strain", "Axial strain", "axial strain", "", lambda seen: seen.rows[:, _STRAIN])
_VOID_RATIO = Quantity(
    "void_ratio",
    "Mean void ratio",
    "void ratio",
    "",
    lambda seen: seen.voids.of_settlement(seen.rows[:, _STRAIN]),
)
_MEASURED = (
    Quantity(
        "axial_stress",
        "Total vertical stress less the back pressure",
        "axial stress",
        "kPa",
        lambda seen: seen.rows[:, _STRESS],
    ),
    Quantity(
        "pore_pressure",
        "Pore pressure at the base",
        "pore pressure",
        "kPa",
        lambda seen: seen.rows[:, _BASE] + seen.pore,
    ),
    Quantity(
        "effective_stress",
        "Effective stress as laboratories evaluate it: axial stress less 2/3 of the excess pore pressure at the base",
        "effective stress",
        "kPa",
        lambda seen: seen.rows[:, :3] @ _AVERAGE,
    ),
    Quantity(
        "mean_effective_stress",
        "Vertical effective stress, mean over the height",
        "mean effective stress",
        "kPa",
        lambda seen: seen.rows[:, _VERTICAL],
    ),
    Quantity(
        "pore_pressure_ratio",
        "Excess pore pressure at the base over axial stress",
        "pore pressure ratio",
        "",
        lambda seen: seen.rows[:, _BASE] / seen.rows[:, _STRESS],
    ),
    Quantity(
        "K0",
        "Ratio of horizontal to vertical effective stress, means over the height",
        "K0",
        "",
        lambda seen: seen.rows[:, _HORIZONTAL] / seen.rows[:, _VERTICAL],
    ),
    _AXIAL_STRAIN,
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
class CrsModel(LaboratoryModel):
    """Forward model of the oedometer test at constant rate of strain."""

    spec: CrsOedometerSpec

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the law, and of the flow of water."""
        return (*self.law.parameters, *_FLOW)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about the parameters given, or None."""
        flow = outside_limits(_FLOW, parameters)
        if flow is None and parameters.get("C_k", 0.0) > 0.0 and self.spec.initial_void_ratio is None:
            flow = (
                f"C_k = {parameters['C_k']:g}: initial_void_ratio is missing in the section; without it 0 is accepted"
            )
        own = {info.name for info in _FLOW}
        return flow or self.law.inadmissible({name: one for name, one in parameters.items() if name not in own})

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
        fault = self.check(parameters)
        if fault is not None or "k" not in parameters:
            raise InfeasibleError(fault or "the flow of water needs k, which is not given")
        change, growth = parameters.get("C_k", 0.0), 0.0
        if change > 0.0:
            growth = math.log(10.0) * (1.0 + (self.spec.initial_void_ratio or 0.0)) / change
        return Flow(parameters["k"], growth, self.spec.height, self.spec.geometry == "updated")

    def test(self, parameters: Mapping[str, float], *, shearing: bool = True, dense: bool = True) -> Record:
        """Calculate the test.

        Raises
        ------
        ForwardError
            It has no solution for these parameters.
        """
        del shearing, dense  # values between the ends of steps cost nothing more
        soil, spec = self.soil(parameters), self.spec
        column = Column.of(self.placed(soil), spec.intervals)
        start, paths = lead(soil, column, self.flow(parameters), self.stages, self.voids, spec.tolerance)
        count = len(paths)
        return Record(
            start,
            np.empty((0, OUTPUT)),
            Trace(paths),
            np.zeros(count, dtype=np.bool_),
            np.zeros(count),
            np.zeros((count, 1)),
            np.arange(count),
            np.empty((0, 2), dtype=np.int64),
            self.voids,
            spec.back_pressure,
        )

    def series_of(self) -> Sequence[TestSeries]:
        """Stresses, pore pressure, strain and void ratio."""
        voids = (_VOID_RATIO,) if self.spec.initial_void_ratio is not None else ()
        return [
            *shear_series(_AXES, self.stages, 0, "axial strain", (*_MEASURED, *voids), (), (), "the test"),
            *(path_series("effective stress", _AVERAGE, one, "the test") for one in (_AXIAL_STRAIN, *voids)),
        ]
