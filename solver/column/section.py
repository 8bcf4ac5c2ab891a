"""Layered ground in one dimension: the section of the problem file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from geoswarm.solver.column.drains import DrainsSection
from geoswarm.solver.column.model import ColumnModel
from geoswarm.solver.column.rest import GroundAtRest
from geoswarm.solver.forward.base import ForwardModelSpec, in_unit
from geoswarm.solver.forward.fields import Geometry, LawSettings, StepError, require_stage
from geoswarm.solver.forward.staged_section import MAX_DURATION, MAX_STAGES, MAX_STRESS
from geoswarm.solver.index_properties import IndexProperties, IndexSection
from geoswarm.solver.laboratory.section import Loading, Part, ratio_fault, settings_fault
from geoswarm.solver.section import Name
from geoswarm.solver.sketches.declared import Drains, Ground, Layer, Load, Sketch
from geoswarm.solver.sketches.stages import load_panel
from geoswarm.solver.user_laws.material import LawChoice, law_of
from geoswarm.solver.user_laws.section import UserLawSection

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["ColumnSpec", "LayerSection", "SoilSection"]

_DEEPEST = 1.0e3


class SoilSection(Part):
    """A soil; parameters of its law, and k and C_k, are parameters of the problem by its name: ``clay.k``."""

    material: LawChoice = Field(description="Law of the soil.")
    settings: LawSettings = Field({})
    unit_weight: float = Field(
        gt=0.0,
        le=100.0,
        description="Total unit weight, kN/m³, with the water in the pores.",
        json_schema_extra=in_unit("kN/m³", 14, 22),
    )
    initial_void_ratio: float | None = Field(
        None,
        gt=0.0,
        le=100.0,
        description="Void ratio before the first stage, also of a law with e0; needed by series of the void ratio, and "
        "by C_k with other laws.",
        json_schema_extra=in_unit("1", 0.4, 3),
    )
    initial_ratio: float | Literal["K0"] = Field(
        "K0",
        description="Horizontal over vertical effective stress before the first stage; K0: that of the law.",
        json_schema_extra=in_unit("1", 0.4, 1),
    )
    index_properties: IndexSection | None = Field(
        None, description="Index properties of the soil, from which its parameters are estimated; no part of a run."
    )
    consolidated: float = Field(
        1.0,
        ge=0.0,
        le=1.0,
        description="Part of the effective stress by weight that the soil bears before the first stage; the rest is "
        "excess pore pressure: 1, unless the ground is young.",
        json_schema_extra=in_unit("1", 0, 1),
    )

    @property
    def law(self) -> Law:
        """The law of the soil."""
        return law_of(self.material)

    @property
    def known(self) -> IndexProperties | None:
        """Its index properties."""
        return None if self.index_properties is None else self.index_properties.properties()

    @model_validator(mode="after")
    def _fits_the_law(self) -> SoilSection:
        fault = settings_fault(self.law, self.settings) or ratio_fault(self.law, self.initial_ratio)
        if fault is not None:
            raise fault
        return self


class LayerSection(Part):
    """A layer of a soil."""

    soil: str = Field(max_length=100, description="Name of its soil.")
    thickness: float = Field(
        gt=0.0, le=_DEEPEST, description="Thickness before the first stage, m.", json_schema_extra=in_unit("m", 1, 20)
    )
    cells: int | None = Field(
        None, ge=2, le=500, description="Number of cells; by its part of the height unless given."
    )


class ColumnStage(Loading):
    """A load on the ground surface, more or less than the one before, and the time under it."""

    stress: float = Field(
        ge=0.0,
        le=MAX_STRESS,
        description="Load on the ground surface at its end, kPa, in addition to initial_surcharge.",
        json_schema_extra=in_unit("kPa", 10, 200),
    )
    duration: float = Field(
        1.0, gt=0.0, le=MAX_DURATION, description="Duration, day.", json_schema_extra=in_unit("day", 7, 1000)
    )


class ColumnPoint(Part):
    """An instrument; it moves with the ground."""

    depth: float = Field(
        ge=0.0,
        description="Depth below the ground surface before the first stage, m.",
        json_schema_extra=in_unit("m", 0, 20),
    )


class ColumnSpec(ForwardModelSpec):
    """Layered ground in one dimension with coupled consolidation: an embankment on soft ground.

    Layers lie from the ground surface downwards; each is of one of ``soils``, of any law. Water flows to the ground
    surface, to the base where it is drained, and to vertical drains. Loads act at once, or grow over
    ``loading_time``.

    Parameters have the name of their soil before them: ``clay.lambda``, ``clay.k`` (m/day, where the calculation
    begins), ``clay.C_k``, with drains ``clay.k_ratio`` (horizontal over vertical permeability), ``drains.smear_ratio``.

    Series over time: ``settlement`` of the ground surface, and for every point P ``P.settlement``, ``P.pore_pressure``,
    ``P.excess_pore_pressure``, ``P.effective_stress`` and ``P.void_ratio``.
    """

    depends_on_section: ClassVar[bool] = True
    consolidates: ClassVar[bool] = True

    kind: Literal["column"] = "column"
    soils: dict[Name, SoilSection] = Field(min_length=1, max_length=100, description="Soils by a name of your choice.")
    layers: tuple[LayerSection, ...] = Field(
        min_length=1, max_length=200, description="Layers from the ground surface downwards."
    )
    stages: tuple[ColumnStage, ...] = Field(
        min_length=1, max_length=MAX_STAGES, description="Loads on the ground surface, in their order."
    )
    points: dict[Name, ColumnPoint] = Field(
        default={}, max_length=500, description="Settlement plates and piezometers by a name of your choice."
    )
    zero_at_stage: int = Field(1, ge=1, description="Stage just before which time and settlements are zero.")
    water_table: float = Field(
        0.0,
        ge=-_DEEPEST,
        le=_DEEPEST,
        description="Depth of the water table below the ground surface, m; above it pore pressures are zero at rest. "
        "Negative: free water stands on the ground.",
        json_schema_extra=in_unit("m", 0, 3, shown=True),
    )
    initial_surcharge: float = Field(
        1.0,
        gt=0.0,
        le=MAX_STRESS,
        description="Effective stress on the ground surface before the first stage, kPa.",
        json_schema_extra=in_unit("kPa", 1, 20),
    )
    base: Literal["closed", "drained"] = Field("closed", description="Whether water leaves at the base.")
    buoyancy: float = Field(
        0.0,
        ge=0.0,
        le=50.0,
        description="Loss of load for each metre that the ground at the water table settles, kN/m³: unit weight of "
        "water, where fill sinks below the water table; 0: none.",
        json_schema_extra=in_unit("kN/m³", 0, 9.81),
    )
    drains: DrainsSection | None = Field(None, description="Vertical drains.")
    geometry: Geometry = "updated"
    tolerance: StepError = 1.0e-4
    cells: int = Field(
        50,
        ge=4,
        le=1000,
        description="Number of cells over the height, smaller at ends of layers; errors fall with its square.",
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """A crust on clay under an embankment in two lifts."""
        return {
            "kind": "column",
            "soils": {
                "crust": {"material": "elastic", "unit_weight": 18, "initial_ratio": 0.6},
                "clay": {"material": "modified_cam_clay", "unit_weight": 15.5, "initial_void_ratio": 1.6},
            },
            "layers": [{"soil": "crust", "thickness": 1.5}, {"soil": "clay", "thickness": 6}],
            "water_table": 1.5,
            "stages": [
                {"stress": 20, "loading_time": 10, "duration": 60},
                {"stress": 40, "loading_time": 10, "duration": 300},
            ],
            "points": {"S1": {"depth": 1.5}, "P1": {"depth": 4.5}},
        }

    @property
    def index_properties_of_soils(self) -> Mapping[str, IndexProperties | None]:
        """Of all soils; the void ratio is that of the section where there is one."""
        return {name: soil.known for name, soil in self.soils.items()}

    @property
    def user_laws(self) -> tuple[UserLawSection, ...]:
        """Those of the soils that are in libraries."""
        return tuple(soil.material for soil in self.soils.values() if isinstance(soil.material, UserLawSection))

    def with_files(self, folder: Path | None, path: str) -> Self:
        """With what is known of the libraries of soils."""
        if not self.user_laws:
            return self
        soils = {}
        for name, soil in self.soils.items():
            law = soil.material
            if isinstance(law, UserLawSection):
                soil = soil.model_copy(update={"material": law.with_files(folder, f"{path}.soils.{name}.material")})
            soils[name] = soil
        return self.model_copy(update={"soils": soils})

    @property
    def components(self) -> int:
        """Stress components of the calculation: 4 where all laws take them."""
        return 4 if all(4 in soil.law.components for soil in self.soils.values()) else 6

    @property
    def kernels(self) -> frozenset[str]:
        """Those of a consolidating column, and the laws'."""
        return frozenset({"consolidation", *(soil.law.kind for soil in self.soils.values())})

    @property
    def quick(self) -> bool:
        """With laws of ours."""
        return not self.user_laws

    @property
    def height(self) -> float:
        """Of all layers, m."""
        return sum(layer.thickness for layer in self.layers)

    @property
    def at_rest(self) -> GroundAtRest:
        """The ground before the first stage."""
        thicknesses = np.array([layer.thickness for layer in self.layers])
        weights = np.array([self.soils[layer.soil].unit_weight for layer in self.layers])
        return GroundAtRest(thicknesses, weights, self.water_table, self.initial_surcharge)

    @model_validator(mode="after")
    def _consistent(self) -> ColumnSpec:
        known = ", ".join(self.soils)
        for number, layer in enumerate(self.layers):
            if layer.soil not in self.soils:
                raise ValueError(f"layers[{number}].soil must be one of {known}, got {layer.soil!r}")
        used = {layer.soil for layer in self.layers}
        for name, soil in self.soils.items():
            if name == "drains":
                raise ValueError("soils.drains: the name is reserved for drains; choose another")
            if name not in used:
                raise ValueError(f"soils.{name}: no layer uses this soil")
            if self.components not in soil.law.components:
                raise ValueError(
                    f"soils.{name}.material = {soil.law.kind}: it has no stress update for {self.components} "
                    "components, which another soil needs"
                )
        height = self.height
        for name, point in self.points.items():
            if point.depth > height * (1.0 + 1.0e-12):
                raise ValueError(f"points.{name}.depth must be at most the height, {height:g} m, got {point.depth:g} m")
        if self.drains is not None and self.drains.bottom > height * (1.0 + 1.0e-12):
            raise ValueError(
                f"drains.bottom must be at most the height of all layers, {height:g} m, got {self.drains.bottom:g} m"
            )
        rest = self.at_rest
        bounds, least = rest.bounds, rest.effective(rest.bounds)
        if not least.min() > 0.0:
            number = int(np.argmin(least))
            raise ValueError(
                f"layers: the effective stress before the first stage is {least[number]:.3g} kPa at a depth of "
                f"{bounds[number]:g} m; above 0 is accepted: a higher initial surcharge or unit weight, or a deeper "
                "water table"
            )
        require_stage(self.zero_at_stage, self.stages)
        return self

    def sketch(self) -> Sketch:
        """Layers with water, drains and instruments, and the load over time."""
        load = Load("Δσ", "load on the ground surface")
        drains = self.drains
        ground = Ground(
            tuple(
                Layer(one.soil, self.soils[one.soil].law.kind.replace("_", " "), one.thickness) for one in self.layers
            ),
            load,
            self.water_table,
            self.base == "drained",
            None if drains is None else Drains(drains.top, drains.bottom, drains.spacing),
            tuple((name, point.depth) for name, point in self.points.items()),
        )
        loads = [stage.stress for stage in self.stages]
        return Sketch("Layered ground", ground, (load_panel(self.stages, [(load, 0.0, loads)]),))

    def build(self) -> ColumnModel:
        """Build the forward model."""
        return ColumnModel(self)
