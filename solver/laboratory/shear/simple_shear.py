"""Direct simple shear test: a flat specimen between rings is consolidated and sheared along its top."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import Field, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.diagram import Derived, Diagram, Readings
from geoswarm.solver.forward.staged_section import MAX_STRESS
from geoswarm.solver.laboratory.pace import Cyclic, Hold, Monotonic, require_pace
from geoswarm.solver.laboratory.section import LaboratorySpec, Loading, Part
from geoswarm.solver.laboratory.shear_stages import is_timed, over_strain, shear_modulus_diagram
from geoswarm.solver.sketches.declared import Load, Reading, Sketch, SpecimenSketch
from geoswarm.solver.sketches.stages import load_panel, movement_panels

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.shear.simple_shear_model import SimpleShearModel

__all__ = ["DirectSimpleShearSpec", "SimpleShearConsolidation"]

Constant: TypeAlias = Literal["volume", "normal_stress"]


class _Load(Part):
    normal_stress: float = Field(
        gt=0.0,
        le=MAX_STRESS,
        description="Vertical effective stress at the end, kPa.",
        json_schema_extra=in_unit("kPa", 25, 800),
    )


class SimpleShearConsolidation(Loading, _Load):
    """One stage of consolidation: vertical effective stress without horizontal strain."""


class _Ends(Part):
    shear_strain: float | None = Field(
        None,
        ge=-0.9,
        le=0.9,
        description="Shear strain at the end, since the beginning of shearing; negative: the other way.",
        json_schema_extra=in_unit("1", -0.3, 0.3, shown=True),
    )
    shear_stress: float | None = Field(
        None,
        ge=-MAX_STRESS,
        le=MAX_STRESS,
        description="Shear stress at the end, kPa. Give exactly one of the two.",
        json_schema_extra=in_unit("kPa", shown=True),
    )


class _Amplitudes(Part):
    shear_strain_amplitude: float | None = Field(
        None,
        gt=0.0,
        le=0.4,
        description="Half the range of the shear strain.",
        json_schema_extra=in_unit("1", 1e-5, 0.05, shown=True),
    )
    shear_stress_amplitude: float | None = Field(
        None,
        gt=0.0,
        le=MAX_STRESS,
        description="Half the range of the shear stress, kPa. Give exactly one of the two.",
        json_schema_extra=in_unit("kPa", 5, 200, shown=True),
    )


class _Kept(Part):
    constant: Constant | None = Field(
        None, description="What is held constant in this stage: volume or normal_stress; as in the test unless given."
    )


class SimpleShearMonotonic(_Kept, Monotonic, _Ends):
    """Shearing to a shear strain or a shear stress."""

    ends: ClassVar[tuple[str, str]] = ("shear_strain", "shear_stress")


class SimpleShearCyclic(_Kept, Cyclic, _Amplitudes):
    """Cycles of shear strain or shear stress about the state at their beginning."""

    ends: ClassVar[tuple[str, str]] = ("shear_strain_amplitude", "shear_stress_amplitude")


class SimpleShearHold(_Kept, Hold):
    """Nothing is moved, time passes: creep or relaxation."""


SimpleShearStage: TypeAlias = Annotated[
    SimpleShearMonotonic | SimpleShearCyclic | SimpleShearHold, Field(discriminator="kind")
]


class DirectSimpleShearSpec(LaboratorySpec):
    """Direct simple shear test: consolidation without horizontal strain, then shearing along horizontal planes.

    The volume stays, as that of an undrained specimen does, or the vertical effective stress. Horizontal normal
    strains are held by the rings throughout. Stresses are effective.

    Series over the shear strain (``shear_stress``, ``normal_stress``, ``pore_pressure`` ...) are the values where that
    strain is reached for the first time. The curve of a stage alone is ``branch_2.shear_stress``;
    ``time_shear_stress`` runs over the time since the beginning of shearing, ``stage_`` over stages,
    ``consolidation_`` over those of consolidation, ``cycle_``, ``cycle_max_`` and ``cycle_min_`` over cycles, and
    ``path_shear_stress`` over the vertical effective stress, where that is first reached. What is never reached counts
    as its closest approach.

    ``pore_pressure`` is the decrease of the vertical stress at constant volume: the pore pressure of an undrained
    specimen under a constant total stress.
    """

    kind: Literal["direct_simple_shear"] = "direct_simple_shear"
    consolidation: tuple[SimpleShearConsolidation, ...] = Field(
        (),
        max_length=1000,
        description="Stages of consolidation, drained, in their order.",
        json_schema_extra={"x-shown": True},
    )
    constant: Constant = Field(
        "volume",
        description="What is held constant during shearing: volume, or normal_stress, the vertical effective one.",
        json_schema_extra={"x-shown": True},
    )
    shearing: tuple[SimpleShearStage, ...] = Field(
        min_length=1, max_length=1000, description="Stages of shearing, in their order."
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """A test at constant volume."""
        return {
            "kind": "direct_simple_shear",
            "material": "modified_cam_clay",
            "initial_stress": 20,
            "consolidation": [{"normal_stress": 100}],
            "shearing": [{"kind": "monotonic", "shear_strain": 0.25}],
        }

    def keeps_volume(self, stage: _Kept) -> bool:
        """Whether a stage of shearing keeps the volume."""
        return (stage.constant or self.constant) == "volume"

    def remedy_for(self, series: str) -> str:
        """Also a constant volume, for a pore pressure."""
        if series.endswith("pore_pressure") and not any(self.keeps_volume(stage) for stage in self.shearing):
            return "; it needs shearing at constant volume (constant: volume)"
        return super().remedy_for(series)

    @model_validator(mode="after")
    def _consistent(self) -> DirectSimpleShearSpec:
        require_pace(self.law, self.shearing)
        return self

    def sketch(self) -> Sketch:
        """A flat specimen between rings, consolidated and sheared along its top."""
        keeps = all(self.keeps_volume(stage) for stage in self.shearing)
        normal, strain, stress = (
            Load("σ′v", "vertical effective stress"),
            Load("γ", "shear strain"),
            Load("τ", "shear stress"),
        )
        height = (
            Reading("σ′v", "vertical stress that keeps the height", "top")
            if keeps
            else Reading("εv", "vertical strain", "top")
        )
        specimen = SpecimenSketch(
            self.material_in_words,
            "sliding rings",
            normal,
            shear=Load("τ, γ", "shear stress and shear strain, both measured"),
            readings=(height,),
            remark="While it is sheared its volume stays." if keeps else "",
        )
        panels = movement_panels(
            self.build().shearing, strain, stress, timed=is_timed(self.shearing), stress_at_first=0.0
        )
        if self.consolidation:
            loads = [stage.normal_stress for stage in self.consolidation]
            tracks = [(normal, self.initial_stress, loads)]
            panels = (load_panel(self.consolidation, tracks, "Consolidation"), *panels)
        return Sketch("Direct simple shear test", specimen, panels)

    def diagrams(self) -> tuple[Diagram, ...]:
        """The stress path, at constant volume by the pore pressure; the shear modulus, where strains were small."""
        keeps = all(self.keeps_volume(stage) for stage in self.shearing)

        def normal(readings: Readings, start: Mapping[str, float]) -> FloatArray:
            return start["normal_stress"] - readings["pore_pressure"]

        def secant(readings: Readings, start: Mapping[str, float]) -> FloatArray:
            del start
            return over_strain(readings["shear_stress"], readings["shear_strain"])

        modulus = (Derived("secant_modulus", ("shear_stress", "shear_strain"), secant),)
        derived = (Derived("normal_stress", ("pore_pressure",), normal),) if keeps else ()
        caption = "Shear stress over vertical effective stress while the specimen is sheared."
        path = Diagram("stress_path", "Stress path", caption, "normal_stress", "shear_stress", derived=derived)
        return path, shear_modulus_diagram("secant_modulus", modulus)

    def build(self) -> SimpleShearModel:
        """Build the forward model."""
        from geoswarm.solver.laboratory.shear.simple_shear_model import SimpleShearModel

        return SimpleShearModel(self)
