"""What the forward models of laboratory tests with constant loads in stages share.

Times and stages
----------------
Stage 1 is applied at time 0, or stage n with ``zero_at_stage: n``; time, displacement and strain are then counted from
just before that stage is applied. Each load acts at once. A point exactly at a change of stage belongs to the *end of
the earlier stage*; therefore the point at time 0 is the reading just before the load, and its displacement is 0.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep
from geoswarm.solver.errors import InfeasibleError, Issue, ProblemError, unknown_series
from geoswarm.solver.forward.base import ForwardRun, SeriesInfo
from geoswarm.solver.forward.isolation import run_isolated
from geoswarm.solver.forward.staged_history import history_of, voids
from geoswarm.solver.forward.staged_section import SpecimenMesh, StagedLoadSpec
from geoswarm.solver.laws.base import Law, Soil
from geoswarm.solver.laws.initial_state import incomplete, settled, void_ratio_parameters, voids_column
from geoswarm.solver.parameter_info import ParameterInfo, outside_limits
from geoswarm.solver.user_laws.law import UserLaw

if TYPE_CHECKING:
    from geoswarm.solver.forward.specimen import StagedSpecimen

__all__ = ["StagedLoadModel"]

_SAME_TIME = 1.0e-9
"""Relative difference (and, in days, absolute one) below which a time is that of a change of stage."""

_CURVE_POINTS = 24

_VOIDS = "stage_void_ratio"

_RATIO, _LATERAL = -1, 2
"""Columns of a row of states; the state variables follow the lateral stress. -1: lateral over axial stress."""

_UNIT_WEIGHT = 17.85
"""Of the published clay: bulk density 1.82 g/cm3."""

_TIME_TOLERANCE = 50.0
"""Relative error of a displacement of finite elements over the absolute one of a strain: a strain of some per cent."""


@dataclass(frozen=True, slots=True)
class _Schedule:
    """Where the prepared points lie: times per stage for the kernel, and each series' rows in its results."""

    times: FloatArray
    firsts: IntArray
    rows: dict[str, IntArray]


@dataclass(frozen=True)
class StagedLoadModel(ABC):
    """Forward model of a test with constant loads in stages; a subclass names the test's series and initial state."""

    spec: StagedLoadSpec

    series_time: ClassVar[tuple[tuple[str, str, str, str], ...]]
    """Series over time: name, description, quantity, unit."""

    lateral_ratio: ClassVar[float]
    """Lateral over axial stress; negative: no lateral strain."""

    @property
    def confined(self) -> bool:
        """Whether a ring holds the side."""
        return self.lateral_ratio < 0.0

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the law; the section may give other defaults to some of them."""
        return self._parameters

    @cached_property
    def _parameters(self) -> tuple[ParameterInfo, ...]:
        own = {"OCR": self.spec.OCR, "POP": self.spec.POP}
        return tuple(
            info if own.get(info.name) is None else replace(info, default=own[info.name])
            for info in void_ratio_parameters(self.law, self.spec.initial_void_ratio)
        )

    @cached_property
    def law(self) -> Law:
        """The law of the material."""
        return self.spec.law

    def soil(self, parameters: Mapping[str, float]) -> Soil:
        """The soil of one forward calculation.

        Raises
        ------
        InfeasibleError
            A value is outside what the law admits.
        """
        if (fault := outside_limits(settled(self._parameters), parameters)) is not None:
            raise InfeasibleError(fault)
        defaults = {info.name: info.default for info in self._parameters}
        choices = {one.name: getattr(self.spec, one.name, one.default) for one in self.law.settings}
        return self.law.soil({**defaults, **parameters, **choices})

    def incomplete(self, declared: Collection[str]) -> str | None:
        """What the law lacks among the parameters given."""
        return incomplete(self.law, self._parameters, declared)

    @property
    def open_parameters(self) -> bool:
        """No parameters beyond :attr:`parameters`."""
        return False

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Series over time, and over the stage number (value at the end of the stage)."""
        return self._series

    @cached_property
    def _series(self) -> tuple[SeriesInfo, ...]:
        named = (*self.series_time, *(one[:4] for one in self._state_series))
        over_time = tuple(
            SeriesInfo(name, text, "time", "day", quantity, unit, 0.0, self._end * (1.0 + _SAME_TIME))
            for name, text, quantity, unit in named
        )
        stages = float(len(self.spec.stages))
        over_stage = [
            SeriesInfo(
                f"stage_{name}", f"{text} At the end of a stage.", "stage", "", quantity, unit, 1.0, stages, True
            )
            for name, text, quantity, unit in named
        ]
        void_ratio = SeriesInfo(
            _VOIDS,
            "Void ratio at the end of a stage; needs initial_void_ratio, or a law that has e0.",
            "stage",
            "",
            "void ratio",
            "",
            1.0,
            stages,
            True,
        )
        return (*over_time, *over_stage, void_ratio)

    @cached_property
    def _state_series(self) -> tuple[tuple[str, str, str, str, int], ...]:
        """Series of stress and state variables at a material point: name, description, quantity, unit, column."""
        if self.spec.discretization == "finite_element":
            return ()
        taken = {name for name, *_ in self.series_time} | {"void_ratio"}
        stress = (
            ("lateral_stress", "Horizontal effective stress.", "horizontal stress", "kPa", _LATERAL),
            ("K0", "Ratio of horizontal to vertical effective stress.", "K0", "", _RATIO),
        )
        own = (
            (one.name, f"{one.description.rstrip('.')}. State variable of the law.", one.symbol, one.unit, column)
            for column, one in enumerate(self.law.state, start=_LATERAL + 1)
            if one.name not in taken
        )
        return (*(stress if self.confined else ()), *own)

    @cached_property
    def _stage_ends(self) -> FloatArray:
        return np.cumsum([stage.duration for stage in self.spec.stages])

    @property
    def _zero(self) -> float:
        """Time from the first stage to the zero of time, day."""
        return float(self._stage_ends[self.spec.zero_at_stage - 2]) if self.spec.zero_at_stage > 1 else 0.0

    @property
    def _end(self) -> float:
        return float(self._stage_ends[-1]) - self._zero

    def grid(self, series: str) -> FloatArray:
        """Points at which a curve looks smooth: logarithmic in each stage, its end included; or the stage numbers."""
        if series.startswith("stage_"):
            return np.arange(1.0, len(self.spec.stages) + 1.0)
        starts = self._stage_ends - [stage.duration for stage in self.spec.stages]
        pieces = [np.zeros(1)]
        for start, stage in list(zip(starts, self.spec.stages, strict=True))[self.spec.zero_at_stage - 1 :]:
            fractions = np.geomspace(1.0e-5, 1.0, _CURVE_POINTS)
            pieces.append(start + stage.duration * fractions - self._zero)
        return np.concatenate(pieces)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about the soil parameters given, or None."""
        own = {name: value for name in ("OCR", "POP") if (value := getattr(self.spec, name)) is not None}
        return outside_limits(settled(self._parameters), parameters) or self.law.inadmissible({**own, **parameters})

    @abstractmethod
    def initial_state(self, soil: SoftSoilCreep, OCR: float, POP: float) -> tuple[float, float]:
        """Initial lateral stress, kPa, and ln of the preconsolidation pressure, of soft soil creep."""

    @abstractmethod
    def initial_lateral(self, soil: Soil) -> float:
        """Initial lateral stress of a soil of any law, kPa.

        Raises
        ------
        InfeasibleError
            The law knows none, or it violates the strength.
        """

    @abstractmethod
    def response(self, series: str, strain: FloatArray, zero: FloatArray) -> FloatArray:
        """Series over time from axial and lateral strain since the beginning, (n, 2), and at the zero of time, (2,)."""

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of the given series at the given points; see the protocol.

        Raises
        ------
        ProblemError
            A series is unknown, or a point is outside the test.
        """
        schedule = self._schedule(points)
        points_count, zero_at = schedule.times.shape[0], self.spec.zero_at_stage
        zero_row = points_count + zero_at - 1 if zero_at > 1 else 0
        columns = {name: column for name, _, _, _, column in self._state_series}
        of_state = {
            name: columns[name.removeprefix("stage_")] for name in points if name.removeprefix("stage_") in columns
        }
        calculate = history_of(self, schedule.times, schedule.firsts, bool(of_state))
        stage_of_row = np.concatenate(
            [
                [0],
                1 + np.repeat(np.arange(len(self.spec.stages)), np.diff(schedule.firsts)),
                1 + np.arange(len(self.spec.stages)),
            ]
        )
        vertical = np.array([self.spec.initial_stress, *(stage.stress for stage in self.spec.stages)])[stage_of_row]

        def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            start, output, ends = calculate(parameters)
            history = np.concatenate([start[np.newaxis], output, ends])
            strain, zero = history[:, :2], history[zero_row, :2]
            initial = voids(self, parameters) if _VOIDS in schedule.rows else 0.0
            found = {}
            for name, rows in schedule.rows.items():
                column = of_state.get(name)
                if column is None:
                    found[name] = self._values(name, strain[rows], zero, initial)
                elif column == _RATIO:
                    found[name] = history[rows, _LATERAL] / vertical[rows]
                else:
                    found[name] = history[rows, column]
            return found

        return run_isolated(run, [self.law] if isinstance(self.law, UserLaw) else [])

    @cached_property
    def specimen(self) -> StagedSpecimen:
        """The specimen as a boundary value problem."""
        from geoswarm.solver.fem.phases import Control
        from geoswarm.solver.forward.specimen import StagedSpecimen, specimen_mesh

        spec = self.spec
        mesh = spec.mesh or SpecimenMesh()
        return StagedSpecimen(
            specimen_mesh(spec.radius, spec.height, mesh.columns, mesh.rows),
            spec.height,
            spec.radius,
            self.confined,
            spec.initial_stress,
            _UNIT_WEIGHT if spec.unit_weight is None else spec.unit_weight,
            spec.geometry == "updated",
            Control(
                tolerance=min(1.0e-6, 1.0e-4 * _TIME_TOLERANCE * spec.tolerance),
                time_tolerance=min(_TIME_TOLERANCE * spec.tolerance, 0.1),
            ),
        )

    def _values(self, series: str, strain: FloatArray, zero: FloatArray, initial: float) -> FloatArray:
        if series != _VOIDS:
            return self.response(series.removeprefix("stage_"), strain, zero)
        return initial - (1.0 + initial) * self.shortening(strain[:, 0] + 2.0 * strain[:, 1], 0.0)

    def shortening(self, strain: FloatArray, zero: float) -> FloatArray:
        """Decrease of a length (or volume) since the zero of time over its value at the beginning of the test."""
        if self.spec.geometry == "fixed":
            return strain - zero
        return math.exp(-zero) * -np.expm1(zero - strain)

    def _schedule(self, points: Mapping[str, FloatArray]) -> _Schedule:
        """Merge all points; rows count the beginning (0), then the times inside stages, then the ends of stages."""
        known = {info.name: info for info in self.series}
        for name, x in points.items():
            if name not in known:
                raise unknown_series(name, known)
            self._require(known[name], x)
        wanted = [x + self._zero for name, x in points.items() if not name.startswith("stage_")]
        times = np.unique(np.concatenate(wanted)) if wanted else np.empty(0)
        stage = np.searchsorted(self._stage_ends * (1.0 + _SAME_TIME) + _SAME_TIME, times, side="left")
        stage = np.minimum(stage, len(self.spec.stages) - 1)
        at_end = times >= self._stage_ends[stage] * (1.0 - _SAME_TIME) - _SAME_TIME
        inside = ~at_end & (times > _SAME_TIME)
        starts = self._stage_ends - [entry.duration for entry in self.spec.stages]
        count = int(inside.sum())
        row_of_time = np.zeros(times.shape[0], dtype=np.int64)
        row_of_time[inside] = 1 + np.arange(count)
        row_of_time[at_end] = 1 + count + stage[at_end]
        rows = {
            name: (count + x.astype(np.int64))
            if name.startswith("stage_")
            else row_of_time[np.searchsorted(times, x + self._zero)]
            for name, x in points.items()
        }
        firsts = np.searchsorted(stage[inside], np.arange(len(self.spec.stages) + 1)).astype(np.int64)
        return _Schedule(times[inside] - starts[stage[inside]], firsts, rows)

    def _require(self, info: SeriesInfo, x: FloatArray) -> None:
        if info.name == _VOIDS and self.spec.initial_void_ratio is None and voids_column(self.law) is None:
            raise ProblemError(
                [Issue("forward_model.initial_void_ratio", "is missing: stage_void_ratio needs a void ratio above 0")]
            )
        info.require(x)
