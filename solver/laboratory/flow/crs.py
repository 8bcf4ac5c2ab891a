"""Oedometer test at constant rate of strain: drained at the top, pore pressure measured at the base."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import Field, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.diagram import Derived, Diagram, Readings
from geoswarm.solver.forward.staged_section import MAX_DURATION
from geoswarm.solver.laboratory.pace import Hold
from geoswarm.solver.laboratory.section import FlowSpec, Part, exactly_one
from geoswarm.solver.laboratory.shear_stages import ShearStage, is_timed
from geoswarm.solver.sentences import Key, SentenceError
from geoswarm.solver.sketches.declared import Load, Reading, Sketch, SpecimenSketch
from geoswarm.solver.sketches.stages import movement_panels

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.flow.crs_model import CrsModel

__all__ = ["CrsMovement", "CrsOedometerSpec"]


class CrsMovement(Part):
    """The top is moved at a constant rate, down or up."""

    kind: Literal["monotonic"] = "monotonic"
    axial_strain: float = Field(
        ge=-0.5,
        le=0.9,
        description="Axial strain at the end, settlement over the initial height; less than before: unloading.",
        json_schema_extra=in_unit("1", 0.0, 0.3),
    )
    rate: float | None = Field(
        None,
        gt=0.0,
        description="Axial strain rate, 1/day (1 %/h is 0.24); or give duration.",
        json_schema_extra=in_unit("1/day", 0.01, 2, shown=True),
    )
    duration: float | None = Field(
        None,
        gt=0.0,
        le=MAX_DURATION,
        description="Duration, day; give exactly one of the two.",
        json_schema_extra=in_unit("day", shown=True),
    )

    @model_validator(mode="after")
    def _one_pace(self) -> CrsMovement:
        exactly_one(self, "rate", "duration")
        return self

    def stage(self, name: str) -> ShearStage:
        """As it is calculated."""
        durations = None if self.duration is None else (self.duration,)
        return ShearStage(name, "strain", (self.axial_strain,), durations, self.rate)


class CrsHold(Hold):
    """The top stays (relaxation), or the total vertical stress (creep); pore pressures dissipate."""


CrsStage: TypeAlias = Annotated[CrsMovement | CrsHold, Field(discriminator="kind")]


class CrsOedometerSpec(FlowSpec):
    """Oedometer test at constant rate of strain (CRS): drained at the top, closed at the base.

    The specimen is a column of points of any law in which pore water flows; k is the permeability where the test
    begins, C_k its change with the void ratio. ``axial_stress`` is the total vertical stress less the back pressure,
    ``pore_pressure`` that at the base. Strain is settlement over the initial height.

    Series over the axial strain are the values where that strain is reached for the first time; the curve of a stage
    alone is ``branch_2.axial_stress``. ``time_axial_stress`` runs over the time since the beginning, ``stage_`` over
    stages (values at their ends), ``path_axial_strain`` and ``path_void_ratio`` over the effective stress, where that
    is first reached. What is never reached counts as its closest approach.
    """

    kind: Literal["crs_oedometer"] = "crs_oedometer"
    stages: tuple[CrsStage, ...] = Field(min_length=1, max_length=1000, description="Stages, in their order.")
    intervals: int = Field(
        20, ge=4, le=500, description="Number of intervals over the height; errors fall with their square."
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """Loading, unloading and reloading."""
        return {
            "kind": "crs_oedometer",
            "material": "modified_cam_clay",
            "height": 0.02,
            "initial_stress": 20,
            "stages": [
                {"kind": "monotonic", "axial_strain": 0.12, "rate": 0.24},
                {"kind": "monotonic", "axial_strain": 0.11, "rate": 0.12},
                {"kind": "monotonic", "axial_strain": 0.2, "rate": 0.24},
            ],
            "initial_void_ratio": 1.2,
        }

    @model_validator(mode="after")
    def _something_moves(self) -> CrsOedometerSpec:
        before: float | None = 0.0
        for number, stage in enumerate(self.stages):
            if isinstance(stage, CrsMovement):
                if stage.axial_strain == before:
                    strain = f"stages[{number}].axial_strain"
                    end = f" = {before:g}: the stage before ends there; another value is accepted, or "
                    raise SentenceError(Key(strain, strain), end, "a stage of kind hold")
                before = stage.axial_strain
            elif stage.keep == "stress":
                before = None
        return self

    def sketch(self) -> Sketch:
        """A flat specimen in a ring, drained at the top, whose top is moved."""
        specimen = SpecimenSketch(
            self.material_in_words,
            "ring",
            Load("σv", "total vertical stress less the back pressure, while the top is moved"),
            base="closed",
            height=self.height,
            back_pressure=self.back_pressure,
            readings=(
                Reading("σv, εa", "vertical stress and axial strain", "top"),
                Reading("u", "pore pressure at the base", "base"),
            ),
            remark=f"Placed under σ′v = {self.initial_stress:g} kPa.",
        )
        strain = Load("εa", "axial strain")
        panels = movement_panels(self.build().stages, strain, None, timed=is_timed(self.stages), title="Compression")
        return Sketch("Oedometer test at constant rate of strain", specimen, panels)

    def diagrams(self) -> tuple[Diagram, ...]:
        """The compression curve over effective stress as laboratories evaluate it."""
        back, initial = self.back_pressure, self.initial_void_ratio

        def effective(readings: Readings, start: Mapping[str, float]) -> FloatArray:
            del start
            return readings["axial_stress"] - 2.0 / 3.0 * (readings["pore_pressure"] - back)

        def voids(readings: Readings, start: Mapping[str, float]) -> FloatArray:
            del start
            assert initial is not None
            return initial - (1.0 + initial) * readings["axial_strain"]

        derived = [Derived("effective_stress", ("axial_stress", "pore_pressure"), effective)]
        if initial is not None:
            derived.append(Derived("void_ratio", ("axial_strain",), voids))
        return (
            Diagram(
                "compression_line",
                "Compression curve",
                "Over the logarithm of effective stress as laboratories evaluate it: axial stress less 2/3 of the "
                "excess pore pressure at the base.",
                "effective_stress",
                "axial_strain" if initial is None else "void_ratio",
                log=True,
                downwards=initial is None,
                derived=tuple(derived),
            ),
        )

    def build(self) -> CrsModel:
        """Build the forward model."""
        from geoswarm.solver.laboratory.flow.crs_model import CrsModel

        return CrsModel(self)
