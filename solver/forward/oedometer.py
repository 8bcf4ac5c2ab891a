"""Oedometer test: one-dimensional compression of a confined specimen under vertical loads in stages."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from pydantic import Field, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep
from geoswarm.solver.element_test.axial import equivalent_axial_pressure, lateral_limits
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.staged_load import StagedLoadModel
from geoswarm.solver.forward.staged_section import MAX_LENGTH, MAX_STRESS, MIN_LENGTH, StagedLoadSpec
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.initial_state import horizontal_stress
from geoswarm.solver.sketches.declared import Load, Reading, Sketch, SpecimenSketch
from geoswarm.solver.sketches.stages import load_panel

__all__ = ["OedometerModel", "OedometerSpec"]


class OedometerSpec(StagedLoadSpec):
    """Oedometer: settlement of the top of a confined specimen.

    Series: ``settlement`` (m) and ``axial_strain`` over time, and ``stage_settlement``, ``stage_axial_strain``,
    ``stage_void_ratio`` over the stage number. Settlement is positive downwards. ``axial_strain`` is the engineering
    (laboratory) strain: settlement over the initial height. Inside, strain is logarithmic unless ``geometry: fixed``.
    At a material point there are also ``lateral_stress`` (kPa), ``K0`` and the law's state variables, each over time
    and with ``stage_``.

    Primary consolidation is not modelled: there is no excess pore pressure. Leave out the readings before its end in
    every stage (``stage_x_from`` in the observation), or calibrate ``stage_settlement``.
    """

    kind: Literal["oedometer"] = "oedometer"
    height: float = Field(
        ge=MIN_LENGTH,
        le=MAX_LENGTH,
        description="Height of the specimen at the beginning, m.",
        json_schema_extra=in_unit("m", 0.01, 0.05),
    )
    initial_stress: float = Field(
        gt=0.0,
        le=MAX_STRESS,
        description="Vertical stress before the first stage, kPa.",
        json_schema_extra=in_unit("kPa", 0.2, 20),
    )
    diameter: float | None = Field(
        None,
        ge=MIN_LENGTH,
        le=MAX_LENGTH,
        description="Diameter of the ring, m (finite_element; the ring is smooth, so it has no effect).",
        json_schema_extra=in_unit("m", 0.05, 0.1),
    )
    K0: float | None = Field(
        None,
        gt=0.0,
        description="Initial ratio of horizontal to vertical stress; that of the law (K0nc) unless given.",
        json_schema_extra=in_unit("1", 0.4, 1),
    )

    @model_validator(mode="after")
    def _at_rest(self) -> OedometerSpec:
        if self.K0 is None and not self.law.knows_K0:
            raise ValueError(f"K0 is missing: material {self.law.kind} has none")
        return self

    @classmethod
    def example(cls) -> dict[str, Any]:
        """Two loads on a specimen of the usual height."""
        return {
            "kind": "oedometer",
            "height": 0.02,
            "initial_stress": 0.2,
            "stages": [{"stress": 50, "duration": 1}, {"stress": 100, "duration": 1}],
            "initial_void_ratio": 1.0,
        }

    @property
    def radius(self) -> float:
        """That of the ring; as large as the height unless a diameter is given."""
        return self.height if self.diameter is None else 0.5 * self.diameter

    def sketch(self) -> Sketch:
        """A flat specimen in a ring under loads in stages."""
        load = Load("σ′v", "vertical effective stress")
        specimen = SpecimenSketch(
            self.material_in_words,
            "ring",
            load,
            height=self.height,
            diameter=self.diameter,
            readings=(Reading("s", "settlement of the top", "top"),),
            remark="Excess pore pressures are not calculated.",
        )
        loads = [stage.stress for stage in self.stages]
        return Sketch("Oedometer test", specimen, (load_panel(self.stages, [(load, self.initial_stress, loads)]),))

    def build(self) -> OedometerModel:
        """Build the forward model."""
        return OedometerModel(self)


@dataclass(frozen=True)
class OedometerModel(StagedLoadModel):
    """Forward model of the oedometer test at one material point."""

    spec: OedometerSpec

    series_time: ClassVar = (
        ("settlement", "Settlement of the top, positive downwards.", "settlement", "m"),
        ("axial_strain", "Engineering axial strain: settlement over the initial height.", "axial strain", ""),
    )
    lateral_ratio: ClassVar[float] = -1.0

    def initial_state(self, soil: SoftSoilCreep, OCR: float, POP: float) -> tuple[float, float]:
        """Horizontal stress K0 times the vertical one; p_p = OCR p_eq, or p_eq under the vertical stress plus POP.

        Raises
        ------
        InfeasibleError
            The initial stress violates the strength.
        """
        vertical = self.spec.initial_stress
        horizontal = vertical * (soil.K0nc if self.spec.K0 is None else self.spec.K0)
        lower, upper, _, _ = lateral_limits(vertical, soil)
        if not lower <= horizontal <= upper:
            raise InfeasibleError(_violated(horizontal, vertical, lower, upper))
        pressure = equivalent_axial_pressure(vertical, horizontal, soil)
        if POP > 0.0:
            past = vertical + POP
            return horizontal, math.log(max(pressure, equivalent_axial_pressure(past, soil.K0nc * past, soil)))
        return horizontal, math.log(OCR * pressure)

    def initial_lateral(self, soil: Soil) -> float:
        """K0 times the vertical stress; K0 of the law unless the section gives it."""
        return horizontal_stress(self.spec.initial_stress, self.spec.K0, soil)

    def response(self, series: str, strain: FloatArray, zero: FloatArray) -> FloatArray:
        """Settlement or engineering strain."""
        shortening = self.shortening(strain[:, 0], float(zero[0]))
        return self.spec.height * shortening if series == "settlement" else shortening


def _violated(horizontal: float, vertical: float, lower: float, upper: float) -> str:
    return (
        f"initial horizontal stress = {horizontal:g} kPa (K0 = {horizontal / vertical:g}) violates the "
        f"strength; K0 must be from {max(lower, 0.0) / vertical:g} to {upper / vertical:g}"
    )
