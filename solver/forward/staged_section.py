"""What the laboratory tests with constant loads in stages share in their sections of the problem file."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.fields import Geometry, OneMaterialSpec, require_stage
from geoswarm.solver.sentences import SentenceError, setting
from geoswarm.solver.user_laws.material import LawChoice

if TYPE_CHECKING:
    pass

__all__ = ["MAX_DURATION", "MAX_LENGTH", "MAX_STRESS", "MIN_LENGTH", "LoadStage", "SpecimenMesh", "StagedLoadSpec"]

# Far beyond any test; what lies beyond them is a mistake in units, or meant to overflow something.
MIN_LENGTH, MAX_LENGTH = 1.0e-6, 1.0e3
"""Smallest and largest dimension of a specimen, m."""
MAX_STRESS = 1.0e7
"""Largest stress, kPa."""
MAX_DURATION = 1.0e7
"""Longest stage, day."""
MAX_STAGES = 1000


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


class StagedLoadSpec(OneMaterialSpec, ABC):
    """Fields of the tests with constant loads in stages."""

    series_need: ClassVar[Mapping[str, str]] = {"void_ratio": "initial_void_ratio"}

    material: LawChoice = Field("soft_soil_creep", description="Law of the material.")
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
    zero_at_stage: int = Field(1, ge=1, description="Stage just before which time, displacement and strain are zero.")
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
    geometry: Geometry = "updated"
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
        description="Void ratio before the first stage, for stage_void_ratio. Of a law with e0 it is that: give one.",
        json_schema_extra=in_unit("1", 0.5, 3),
    )

    @property
    @abstractmethod
    def radius(self) -> float:
        """Radius of the specimen at the beginning, m."""

    @property
    def has_fast_path(self) -> bool:
        """Whether the law has a calculation of its own for loads at a material point."""
        from geoswarm.solver.forward.staged_history import FAST_PATHS  # with Numba, for which a check need not wait

        return self.law.kind in FAST_PATHS

    @property
    def kernels(self) -> frozenset[str]:
        """Those of finite elements, of the fast path, or of tests on any law."""
        if self.discretization == "finite_element":
            return frozenset({"section", "elastic", self.law.kind})
        return frozenset({"oedometer"}) if self.has_fast_path else frozenset({"element_test", self.law.kind})

    @property
    def components(self) -> int:
        """Stress components that the calculation needs of the law."""
        return 6 if self.discretization == "material_point" else 4

    @property
    def quick(self) -> bool:
        """At one material point, not with finite elements, and with a law of ours."""
        return self.discretization == "material_point" and not self.user_laws

    @model_validator(mode="after")
    def _consistent(self) -> StagedLoadSpec:
        if self.OCR is not None and self.POP is not None:
            raise ValueError(f"OCR = {self.OCR:g} and POP = {self.POP:g} kPa are both given; give only one of them")
        if self.discretization == "material_point" and (self.unit_weight is not None or self.mesh is not None):
            raise SentenceError(
                *(setting("unit_weight"), " and ", setting("mesh"), " are of a specimen with "),
                setting("discretization", "finite_element"),
            )
        require_stage(self.zero_at_stage, self.stages)
        fault = self._missing()
        if fault is not None:
            raise fault
        return self

    def _missing(self) -> SentenceError | None:
        """What the law lacks for this test, or what is given that it does not have, in words."""
        law = self.law
        if self.components not in law.components:
            return SentenceError(
                f"material {law.kind} has no stress update for ", setting("discretization", self.discretization)
            )
        names = {info.name for info in law.parameters} | {one.name for one in law.settings}
        for name in ("OCR", "POP", "formulation", "tension_cutoff"):
            if name not in names and getattr(self, name) != type(self).model_fields[name].default:
                return SentenceError(setting(name), f" is given, which material {law.kind} does not have")
        return None
