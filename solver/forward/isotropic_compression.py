"""Isotropic compression test: a cylindrical specimen under all-round pressure in stages."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from pydantic import Field

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep, equivalent_pressure
from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.staged_load import StagedLoadModel
from geoswarm.solver.forward.staged_section import MAX_LENGTH, MAX_STRESS, MIN_LENGTH, StagedLoadSpec
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.sketches.declared import Load, Reading, Sketch, SpecimenSketch
from geoswarm.solver.sketches.stages import load_panel

__all__ = ["IsotropicCompressionModel", "IsotropicCompressionSpec"]


class IsotropicCompressionSpec(StagedLoadSpec):
    """Isotropic compression in the triaxial cell, drained.

    Series: ``axial_displacement`` and ``radial_displacement`` (m, positive when height and radius decrease) and
    ``volumetric_strain`` over time, each also as ``stage_`` form over the stage number, and ``stage_void_ratio``. The
    specimen stays a cylinder. ``volumetric_strain`` is the engineering one: decrease of the volume over the initial
    volume. Inside, strain is logarithmic unless ``geometry: fixed``. At a material point there are also the law's state
    variables, over time and with ``stage_``.

    Primary consolidation is not modelled: there is no excess pore pressure. Leave out the readings before its end in
    every stage (``stage_x_from`` in the observation), or calibrate the ``stage_`` series.
    """

    kind: Literal["isotropic_compression"] = "isotropic_compression"
    height: float = Field(
        ge=MIN_LENGTH,
        le=MAX_LENGTH,
        description="Height of the specimen at the beginning, m.",
        json_schema_extra=in_unit("m", 0.07, 0.2),
    )
    diameter: float = Field(
        ge=MIN_LENGTH,
        le=MAX_LENGTH,
        description="Diameter of the specimen at the beginning, m.",
        json_schema_extra=in_unit("m", 0.038, 0.1),
    )
    initial_stress: float = Field(
        gt=0.0,
        le=MAX_STRESS,
        description="All-round stress before the first stage, kPa.",
        json_schema_extra=in_unit("kPa", 1, 50),
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """Two loads on a specimen of the usual size."""
        return {
            "kind": "isotropic_compression",
            "height": 0.1,
            "diameter": 0.05,
            "initial_stress": 10,
            "stages": [{"stress": 50, "duration": 1}, {"stress": 100, "duration": 1}],
        }

    @property
    def radius(self) -> float:
        """Half the diameter."""
        return 0.5 * self.diameter

    def sketch(self) -> Sketch:
        """A cylinder under all-round pressure in stages."""
        load = Load("p′", "all-round effective stress")
        specimen = SpecimenSketch(
            self.material_in_words,
            "membrane",
            load,
            lateral=load,
            height=self.height,
            diameter=self.diameter,
            readings=(
                Reading("Δh", "decrease of the height", "top"),
                Reading("Δr", "decrease of the radius", "side"),
            ),
            remark="Excess pore pressures are not calculated.",
        )
        loads = [stage.stress for stage in self.stages]
        panel = load_panel(self.stages, [(load, self.initial_stress, loads)])
        return Sketch("Isotropic compression test", specimen, (panel,))

    def build(self) -> IsotropicCompressionModel:
        """Build the forward model."""
        return IsotropicCompressionModel(self)


@dataclass(frozen=True)
class IsotropicCompressionModel(StagedLoadModel):
    """Forward model of the isotropic compression test at one material point."""

    spec: IsotropicCompressionSpec

    series_time: ClassVar = (
        ("axial_displacement", "Decrease of the height.", "axial displacement", "m"),
        ("radial_displacement", "Decrease of the radius.", "radial displacement", "m"),
        ("volumetric_strain", "Engineering volumetric strain: decrease over initial volume.", "volumetric strain", ""),
    )
    lateral_ratio: ClassVar[float] = 1.0

    def initial_state(self, soil: SoftSoilCreep, OCR: float, POP: float) -> tuple[float, float]:
        """All-round initial stress; p_p = OCR p_eq, or p_eq under the initial stress plus POP."""
        stress = self.spec.initial_stress
        return stress, math.log(OCR * equivalent_pressure(stress + POP, 0.0, soil)[0])

    def initial_lateral(self, soil: Soil) -> float:
        """The all-round stress."""
        del soil
        return self.spec.initial_stress

    def response(self, series: str, strain: FloatArray, zero: FloatArray) -> FloatArray:
        """Displacement or engineering volumetric strain."""
        if series == "axial_displacement":
            return self.spec.height * self.shortening(strain[:, 0], float(zero[0]))
        if series == "radial_displacement":
            return self.spec.radius * self.shortening(strain[:, 1], float(zero[1]))
        return self.shortening(strain[:, 0] + 2.0 * strain[:, 1], float(zero[0] + 2.0 * zero[1]))
