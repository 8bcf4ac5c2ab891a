"""What the forward models of laboratory tests on any law share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.load_paths import LoadPath, Path, PointState, point_under
from geoswarm.solver.element_test.specimen import specimen_load_paths
from geoswarm.solver.element_test.trace import Trace
from geoswarm.solver.errors import InfeasibleError, unknown_series
from geoswarm.solver.forward.base import ForwardRun, SeriesInfo
from geoswarm.solver.forward.isolation import run_isolated
from geoswarm.solver.laboratory.record import Record, Voids, consolidated, sheared
from geoswarm.solver.laboratory.section import FlowSpec, LaboratorySpec, Loading
from geoswarm.solver.laboratory.series import TestSeries
from geoswarm.solver.laboratory.shear_stages import Axes, ShearStage
from geoswarm.solver.laboratory.water_flow import FLOW, flow_fault
from geoswarm.solver.laws.base import Law, Soil
from geoswarm.solver.laws.initial_state import (
    horizontal_stress,
    incomplete,
    knows_voids,
    settled,
    soil_of,
    void_ratio_parameters,
    voids_column,
)
from geoswarm.solver.parameter_info import ParameterInfo, outside_limits
from geoswarm.solver.user_laws.law import UserLaw

__all__ = ["FlowModel", "LaboratoryModel", "ShearModel"]


@dataclass(frozen=True)
class LaboratoryModel(ABC):
    """Forward model of a test whose series are picked from a record of it; a subclass says how it is calculated."""

    spec: LaboratorySpec

    @cached_property
    def law(self) -> Law:
        """The law of the material."""
        return self.spec.law

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the law."""
        return self.law_parameters

    @cached_property
    def law_parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the law, with what the section settles."""
        return void_ratio_parameters(self.law, self.spec.initial_void_ratio)

    def incomplete(self, declared: Collection[str]) -> str | None:
        """What the law lacks among the parameters given."""
        return incomplete(self.law, self.law_parameters, declared)

    @property
    def open_parameters(self) -> bool:
        """No parameters beyond :attr:`parameters`."""
        return False

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Series over strain, time, stages and cycles."""
        return tuple(one.info for one in self._catalogue.values())

    @cached_property
    def _catalogue(self) -> dict[str, TestSeries]:
        return {one.info.name: one for one in self.series_of()}

    @abstractmethod
    def series_of(self) -> Sequence[TestSeries]:
        """All series of the test."""

    def initial_stress(self, soil: Soil) -> list[float]:
        """Stress under which the soil is placed, xx, yy (vertical) and zz, kPa.

        Raises
        ------
        InfeasibleError
            It is unknown, or violates the strength.
        """
        vertical, ratio = self.spec.initial_stress, self.spec.initial_ratio
        horizontal = horizontal_stress(vertical, None if ratio == "K0" else ratio, soil)
        return [horizontal, vertical, horizontal]

    @property
    def knows_voids(self) -> bool:
        """Whether the void ratio is known: from the section, or from the law."""
        return knows_voids(self.law, self.spec.initial_void_ratio)

    def void_ratio(self, parameters: Mapping[str, float]) -> float | None:
        """Void ratio before the first stage, where it is known; raises as :meth:`placed`."""
        given, column = self.spec.initial_void_ratio, voids_column(self.law)
        if given is not None or column is None:
            return given
        return float(self.placed(self.soil(parameters)).internal[column])

    def voids(self, parameters: Mapping[str, float]) -> Voids:
        """Void ratio and water of the specimen."""
        return Voids(self.void_ratio(parameters), self.spec.geometry == "fixed", None)

    def soil(self, parameters: Mapping[str, float]) -> Soil:
        """The soil of one forward calculation.

        Raises
        ------
        InfeasibleError
            A value is outside what the law admits.
        """
        return soil_of(self.law, self.law_parameters, parameters, self.spec.settings)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about the soil parameters given, or None."""
        return outside_limits(settled(self.law_parameters), parameters) or self.law.inadmissible(parameters)

    def grid(self, series: str) -> FloatArray:
        """Points at which a curve looks smooth; none where they depend on the parameters."""
        return self._catalogue[series].axis.grid

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of the given series at the given points; see the protocol.

        Raises
        ------
        ProblemError
            A series is unknown, or a point is outside the test.
        """
        wanted = {name: self._series(name, x) for name, x in points.items()}
        shearing = any(one.axis.shearing for one in wanted.values())
        dense = any(one.axis.dense for one in wanted.values())

        together: dict[tuple[int, bytes], list[str]] = {}  # what is looked at in the same states
        for name, one in wanted.items():
            together.setdefault((id(one.axis), points[name].tobytes()), []).append(name)

        def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            test = self.test(parameters, shearing=shearing, dense=dense)
            found: dict[str, FloatArray] = {}
            for names in together.values():
                picked = wanted[names[0]].axis.pick(test, points[names[0]])
                found |= {name: wanted[name].values(test, picked) for name in names}
            return found

        return run_isolated(run, [self.law] if isinstance(self.law, UserLaw) else [])

    @abstractmethod
    def test(self, parameters: Mapping[str, float], *, shearing: bool = True, dense: bool = True) -> Record:
        """Calculate the test.

        Parameters
        ----------
        shearing, dense
            Whether what follows consolidation is wanted, and values between the ends of steps.

        Raises
        ------
        ForwardError
            It has no solution for these parameters.
        """

    def placed(self, soil: Soil) -> PointState:
        """State of a soil before the first stage; raises as :meth:`initial_stress`."""
        normal = self.initial_stress(soil)
        state = point_under([*normal, *[0.0] * (self.spec.components - 3)], soil)
        if not np.isfinite(state.internal).all():
            raise InfeasibleError(
                f"initial stress = {normal[1]:g} kPa vertical, {normal[0]:g} kPa horizontal: material "
                f"{soil.law.kind} has no state under it with these parameters; another initial stress, within its range"
            )
        return state

    def _series(self, name: str, x: FloatArray) -> TestSeries:
        one = self._catalogue.get(name)
        if one is None:
            raise unknown_series(name, self._catalogue)
        one.info.require(x)
        return one


@dataclass(frozen=True)
class FlowModel(LaboratoryModel):
    """Forward model of a test in which pore water flows along a column of points."""

    spec: FlowSpec

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the law, and of the flow of water."""
        return (*self.law_parameters, *FLOW)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about the parameters given, or None."""
        fault = outside_limits(settled(self.law_parameters), parameters)
        return fault or flow_fault(self.law, parameters, self.knows_voids)

    def record_of(
        self, start: FloatArray, zero: FloatArray, paths: Sequence[Path], last: IntArray, voids: Voids
    ) -> Record:
        """The record of what is observed along paths, whose rows hold the pore pressure; there are no cycles.

        ``start`` and ``zero``: what is observed before, (w,), and where strain counts from, (0 or 1, w); ``last``: the
        last path of each stage.
        """
        count = len(paths)
        return Record(
            start,
            zero,
            Trace(paths),
            np.zeros(count, dtype=np.bool_),
            np.zeros(count),
            np.zeros((count, 1)),
            last,
            np.empty((0, 2), dtype=np.int64),
            voids,
            self.spec.back_pressure,
        )


@dataclass(frozen=True)
class ShearModel(LaboratoryModel):
    """Forward model of a test that consolidates a specimen and shears it; a subclass says how it is led."""

    @property
    @abstractmethod
    def axes(self) -> Axes:
        """How the specimen is led."""

    @property
    def back_pressure(self) -> float:
        """Pore pressure of the drained specimen, kPa."""
        return 0.0

    @property
    @abstractmethod
    def consolidation(self) -> Sequence[Sequence[LoadPath]]:
        """The load paths of each stage of consolidation."""

    @property
    @abstractmethod
    def shearing(self) -> Sequence[ShearStage]:
        """The stages of shearing."""

    def load_paths_of(self, loads: Iterable[tuple[Loading, float, float | None]]) -> Sequence[Sequence[LoadPath]]:
        """Load paths of stages of consolidation: vertical and horizontal stress, kPa; None: no horizontal strain."""
        return [
            specimen_load_paths(
                f"consolidation {number}",
                self.spec.components,
                vertical,
                horizontal,
                stage.duration,
                stage.loading_time,
                self.law.depends_on_time,
            )
            for number, (stage, vertical, horizontal) in enumerate(loads, start=1)
        ]

    def test(self, parameters: Mapping[str, float], *, shearing: bool = True, dense: bool = True) -> Record:
        """Calculate the test.

        Raises
        ------
        ForwardError
            It has no solution for these parameters.
        """
        soil, voids, tolerance = self.soil(parameters), self.voids(parameters), self.spec.tolerance
        start = self.placed(soil)
        rows, state = consolidated(soil, start, self.consolidation, voids, tolerance)
        stages = self.shearing if shearing else ()
        return sheared(soil, self.axes, start, rows, state, stages, voids, self.back_pressure, tolerance, dense)
