"""Oedometer test in stages of loading with the flow of pore water: consolidation on one or two sides."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, model_validator

from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.fields import require_stage
from geoswarm.solver.forward.staged_section import MAX_STAGES, MAX_STRESS
from geoswarm.solver.laboratory.flow.consolidation_model import ConsolidationModel
from geoswarm.solver.laboratory.section import FlowSpec, Loading
from geoswarm.solver.sketches.declared import Load, Reading, Sketch, SpecimenSketch
from geoswarm.solver.sketches.stages import load_panel

__all__ = ["ConsolidationSpec"]


class ConsolidationStage(Loading):
    """A load, more or less than the one before, and the time under it."""

    stress: float = Field(
        gt=0.0,
        le=MAX_STRESS,
        description="Total vertical stress at its end, less the back pressure, kPa.",
        json_schema_extra=in_unit("kPa", 5, 1600),
    )


class ConsolidationSpec(FlowSpec):
    """Oedometer in stages of loading, with the flow of pore water: settlement within a stage, and pore pressure.

    The specimen is a column of any law in which pore water flows to one or both ends; k is the permeability where the
    test begins, C_k its change with the void ratio. Loads act at once, or grow over ``loading_time``. Strain is
    settlement over the initial height.

    Series over time (``settlement``, ``axial_strain``, ``pore_pressure`` ...) begin with the first stage, or stage n
    with ``zero_at_stage: n``. ``branch_2.settlement`` is that within stage 2, over the time since its load began, and
    counted from then. ``stage_settlement`` is that at ends of stages, over their numbers.
    """

    kind: Literal["consolidation"] = "consolidation"
    drainage: Literal["one_side", "two_sides"] = Field(
        "two_sides",
        description="one_side: at the top, the pore pressure is that at the base; two_sides: the one at mid-height.",
        json_schema_extra={"x-shown": True},
    )
    stages: tuple[ConsolidationStage, ...] = Field(
        min_length=1, max_length=MAX_STAGES, description="Loads in the order of their application."
    )
    zero_at_stage: int = Field(1, ge=1, description="Stage just before which time, settlement and strain are zero.")
    cells: int = Field(
        30,
        ge=4,
        le=500,
        description="Number of cells over the height, smaller at drained ends; errors fall with its square.",
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """Loading and unloading."""
        return {
            "kind": "consolidation",
            "material": "modified_cam_clay",
            "height": 0.02,
            "initial_stress": 25,
            "stages": [
                {"stress": 50, "duration": 1},
                {"stress": 100, "duration": 1},
                {"stress": 25, "duration": 1},
            ],
            "initial_void_ratio": 1.2,
        }

    @model_validator(mode="after")
    def _zero_at_a_stage(self) -> ConsolidationSpec:
        require_stage(self.zero_at_stage, self.stages)
        return self

    def sketch(self) -> Sketch:
        """A flat specimen in a ring, drained on one side or on two, under loads in stages."""
        load = Load("σv", "total vertical stress less the back pressure")
        one_side = self.drainage == "one_side"
        specimen = SpecimenSketch(
            self.material_in_words,
            "ring",
            load,
            base="closed" if one_side else "drained",
            height=self.height,
            back_pressure=self.back_pressure,
            readings=(
                Reading("s", "settlement of the top", "top"),
                Reading(
                    "u",
                    f"pore pressure at {'the base' if one_side else 'mid-height'}",
                    "base" if one_side else "inside",
                ),
            ),
        )
        loads = [stage.stress for stage in self.stages]
        panel = load_panel(self.stages, [(load, self.initial_stress, loads)])
        return Sketch("Oedometer test with consolidation", specimen, (panel,))

    def build(self) -> ConsolidationModel:
        """Build the forward model."""
        return ConsolidationModel(self)
