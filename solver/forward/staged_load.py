"""What the laboratory tests with constant loads in stages share: their section of the problem file and their model.

Times and stages
----------------
Stage 1 is applied at time 0, or stage n with ``zero_at_stage: n``; time, displacement and strain are then counted from
just before that stage is applied. Each load acts at once. A point exactly at a change of stage belongs to the *end of
the earlier stage*; therefore the point at time 0 is the reading just before the load, and its displacement is 0.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.constitutive.soft_soil_creep import SoftSoilCreep
from geoswarm.solver.element_test.controls import Stage
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.forward.base import ForwardModelSpec, ForwardRun, SeriesInfo, in_unit
from geoswarm.solver.forward.staged_history import FAST_PATHS, history_of
from geoswarm.solver.laws.base import Law, Soil
from geoswarm.solver.laws.registry import UnknownLawError, find_law, kinds
from geoswarm.solver.parameter_info import ParameterInfo

if TYPE_CHECKING:
    from geoswarm.solver.forward.specimen import Specimen

__all__ = ["MAX_LENGTH", "MAX_STRESS", "MIN_LENGTH", "LoadStage", "SpecimenMesh", "StagedLoadModel", "StagedLoadSpec"]

# Far beyond any test; what lies beyond them is a mistake in units, or meant to overflow something.
MIN_LENGTH, MAX_LENGTH = 1.0e-6, 1.0e3
"""Smallest and largest dimension of a specimen, m."""
MAX_STRESS = 1.0e7
"""Largest stress, kPa."""
MAX_DURATION = 1.0e7
"""Longest stage, day."""
MAX_STAGES = 1000

_SAME_TIME = 1.0e-9
"""Relative difference (and, in days, absolute one) below which a time is that of a change of stage."""

_CURVE_POINTS = 24

_UNIT_WEIGHT = 17.85
"""Of the published clay: bulk density 1.82 g/cm3."""

_TIME_TOLERANCE = 50.0
"""Relative error of a displacement of finite elements over the absolute one of a strain: a strain of some per cent."""


class LoadStage(BaseModel):
    """One load that is kept constant: ``stress`` in kPa for ``duration`` in days."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    stress: float = Field(
        gt=0.0,
        le=MAX_STRESS,
        description="Applied stress, kPa, compression positive.",
        json_schema_extra=in_unit("kPa", 5, 1600),
    )
    duration: float = Field(
        gt=0.0, le=MAX_DURATION, description="Duration, day.", json_schema_extra=in_unit("day", 0.5, 7)
    )


class SpecimenMesh(BaseModel):
    """Elements of a specimen: cells of two six-node triangles each, between its axis and its side."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    columns: int = Field(1, ge=1, le=50, description="Cells from the axis to the side.")
    rows: int = Field(1, ge=1, le=50, description="Cells over the height.")


class StagedLoadSpec(ForwardModelSpec, ABC):
    """Fields of the tests with constant loads in stages."""

    material: str = Field(
        "soft_soil_creep", description="Law of the material.", json_schema_extra={"enum": list(kinds())}
    )
    discretization: Literal["material_point", "finite_element"] = Field(
        "material_point",
        description="How the specimen is represented: one point, or axisymmetric six-node triangles with their weight.",
    )
    height: float = Field(
        ge=MIN_LENGTH,
        le=MAX_LENGTH,
        description="Height of the specimen at the beginning, m.",
        json_schema_extra=in_unit("m"),
    )
    initial_stress: float = Field(gt=0.0, le=MAX_STRESS, description="Stress before the first stage, kPa.")
    stages: tuple[LoadStage, ...] = Field(
        min_length=1, max_length=MAX_STAGES, description="Loads in the order of their application."
    )
    zero_at_stage: int = Field(
        1, ge=1, description="Stage before whose application time, displacement and strain are zero."
    )
    OCR: float | None = Field(None, ge=1.0, description="Default of the parameter OCR (1 unless given here).")
    POP: float | None = Field(
        None,
        ge=0.0,
        description="Default of the parameter POP, kPa; not together with OCR.",
        json_schema_extra=in_unit("kPa", 0, 50),
    )
    formulation: Literal["translated", "untranslated"] = Field(
        "translated", description="Whether stiffness and creep see the mean stress shifted by c cot(phi)."
    )
    tension_cutoff: float | None = Field(
        0.0,
        ge=0.0,
        description="Largest admissible tension, kPa; null for no cut-off.",
        json_schema_extra=in_unit("kPa"),
    )
    geometry: Literal["updated", "fixed"] = Field(
        "updated", description="updated: logarithmic strain, large deformations; fixed: small strain."
    )
    tolerance: float = Field(
        2.0e-5,
        ge=1.0e-8,
        le=1.0e-2,
        description="Time integration error aimed at, as axial logarithmic strain; controlled step by step.",
    )
    unit_weight: float | None = Field(
        None,
        ge=0.0,
        description="Unit weight of the specimen, kN/m³ (finite_element; 17.85 unless given).",
        json_schema_extra=in_unit("kN/m³", 14, 22),
    )
    mesh: SpecimenMesh | None = Field(
        None, description="Elements (finite_element; one cell of two triangles unless given)."
    )
    initial_void_ratio: float | None = Field(
        None,
        gt=0.0,
        description="Void ratio before the first stage; needed by the series stage_void_ratio.",
        json_schema_extra=in_unit("1", 0.5, 3),
    )

    @field_validator("material")
    @classmethod
    def _known(cls, kind: str) -> str:
        try:
            find_law(kind)
        except UnknownLawError as error:
            raise ValueError(str(error)) from error
        return kind

    @property
    def law(self) -> Law:
        """The law of the material."""
        return find_law(self.material)

    @property
    def has_fast_path(self) -> bool:
        """Whether the law has a calculation of its own for loads at a material point."""
        return self.material in FAST_PATHS

    @property
    def components(self) -> int:
        """Stress components that the calculation needs of the law."""
        return 6 if self.discretization == "material_point" else 4

    @property
    def quick(self) -> bool:
        """At one material point, not with finite elements."""
        return self.discretization == "material_point"

    @model_validator(mode="after")
    def _consistent(self) -> StagedLoadSpec:
        if self.OCR is not None and self.POP is not None:
            raise ValueError(f"OCR = {self.OCR:g} and POP = {self.POP:g} kPa are both given; one of them is accepted")
        if self.discretization == "material_point" and (self.unit_weight is not None or self.mesh is not None):
            raise ValueError("unit_weight and mesh are of a specimen with discretization: finite_element")
        if self.zero_at_stage > len(self.stages):
            raise ValueError(f"zero_at_stage = {self.zero_at_stage}: a stage from 1 to {len(self.stages)} is accepted")
        fault = self._missing()
        if fault is not None:
            raise ValueError(fault)
        return self

    def _missing(self) -> str | None:
        """What the law lacks for this test, or what is given that it does not have, in words."""
        law = self.law
        if self.components not in law.components:
            return f"material {law.kind} has no stress update for discretization: {self.discretization}"
        names = {info.name for info in law.parameters} | {one.name for one in law.settings}
        for name in ("OCR", "POP", "formulation", "tension_cutoff"):
            if name not in names and getattr(self, name) != type(self).model_fields[name].default:
                return f"{name} is given, which material {law.kind} does not have"
        return None


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
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the law; the section may give other defaults to some of them."""
        return self._parameters

    @cached_property
    def _parameters(self) -> tuple[ParameterInfo, ...]:
        own = {"OCR": self.spec.OCR, "POP": self.spec.POP}
        return tuple(
            info if own.get(info.name) is None else replace(info, default=own[info.name])
            for info in self.law.parameters
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
        defaults = {info.name: info.default for info in self._parameters}
        choices = {one.name: getattr(self.spec, one.name, one.default) for one in self.law.settings}
        return self.law.soil({**defaults, **parameters, **choices})

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
        over_time = tuple(
            SeriesInfo(name, text, "time", "day", quantity, unit, 0.0, self._end * (1.0 + _SAME_TIME))
            for name, text, quantity, unit in self.series_time
        )
        stages = float(len(self.spec.stages))
        over_stage = [
            SeriesInfo(
                f"stage_{name}", f"{text} At the end of a stage.", "stage", "", quantity, unit, 1.0, stages, True
            )
            for name, text, quantity, unit in self.series_time
        ]
        void_ratio = SeriesInfo(
            "stage_void_ratio",
            "Void ratio at the end of a stage; needs initial_void_ratio.",
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
        return self.law.inadmissible({**own, **parameters})

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
    def load(self, stress: float, duration: float) -> Stage:
        """One stage of loading as a material point is led through it."""

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
        spec = self.spec
        points_count = schedule.times.shape[0]
        strain = np.zeros((1 + points_count + len(spec.stages), 2))
        zero_row = points_count + spec.zero_at_stage - 1 if spec.zero_at_stage > 1 else 0
        calculate = history_of(self, schedule.times, schedule.firsts)

        def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            output, ends = calculate(parameters)
            history = strain.copy()
            history[1 : 1 + points_count] = output
            history[1 + points_count :] = ends
            zero = history[zero_row]
            return {name: self._values(name, history[rows], zero) for name, rows in schedule.rows.items()}

        return run

    @cached_property
    def specimen(self) -> Specimen:
        """The specimen as a boundary value problem."""
        from geoswarm.solver.fem.phases import Control
        from geoswarm.solver.forward.specimen import Specimen, specimen_mesh

        spec = self.spec
        mesh = spec.mesh or SpecimenMesh()
        return Specimen(
            specimen_mesh(self.radius, spec.height, mesh.columns, mesh.rows),
            spec.height,
            self.radius,
            self.lateral_ratio < 0.0,
            spec.initial_stress,
            _UNIT_WEIGHT if spec.unit_weight is None else spec.unit_weight,
            spec.geometry == "updated",
            Control(
                tolerance=min(1.0e-6, 1.0e-4 * _TIME_TOLERANCE * spec.tolerance),
                time_tolerance=min(_TIME_TOLERANCE * spec.tolerance, 0.1),
            ),
        )

    @property
    @abstractmethod
    def radius(self) -> float:
        """Radius of the specimen, m."""

    def _values(self, series: str, strain: FloatArray, zero: FloatArray) -> FloatArray:
        if series != "stage_void_ratio":
            return self.response(series.removeprefix("stage_"), strain, zero)
        initial = self.spec.initial_void_ratio
        assert initial is not None
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
            self._refuse(known.get(name), name, x, tuple(known))
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

    def _refuse(self, info: SeriesInfo | None, name: str, x: FloatArray, known: tuple[str, ...]) -> None:
        if info is None:
            raise ProblemError([Issue("series", f"{name!r} is unknown; known are {', '.join(known)}")])
        if name == "stage_void_ratio" and self.spec.initial_void_ratio is None:
            raise ProblemError(
                [Issue("forward_model.initial_void_ratio", "is missing: stage_void_ratio needs a void ratio above 0")]
            )
        assert info.x_lower is not None
        assert info.x_upper is not None
        wrong = ~((x >= info.x_lower) & (x <= info.x_upper))
        if info.x_integer:
            wrong |= x != np.round(x)
        if wrong.any():
            accepted = f"{'whole numbers ' if info.x_integer else ''}from {info.x_lower:g} to {info.x_upper:g}"
            unit = f" {info.x_unit}" if info.x_unit else ""
            raise ProblemError([Issue(name, f"x = {x[wrong][0]:g}{unit}: {accepted}{unit} are accepted")])
