"""Triaxial test: a cylindrical specimen is consolidated and sheared, drained or not, once or in cycles."""

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
from geoswarm.solver.laws.initial_state import knows_voids
from geoswarm.solver.sentences import SentenceError, setting
from geoswarm.solver.sketches.declared import Load, Panel, Reading, Sketch, SpecimenSketch
from geoswarm.solver.sketches.stages import load_panel, movement_panels

if TYPE_CHECKING:
    from geoswarm.solver.laboratory.shear.triaxial_model import TriaxialModel

__all__ = ["TriaxialConsolidation", "TriaxialSpec"]


class _Stresses(Part):
    axial: float = Field(
        gt=0.0,
        le=MAX_STRESS,
        description="Axial effective stress at the end, kPa.",
        json_schema_extra=in_unit("kPa", 25, 800),
    )
    radial: float | Literal["K0"] | None = Field(
        None,
        description="Radial effective stress at the end, kPa; K0: no radial strain; as axial unless given.",
        json_schema_extra=in_unit("kPa"),
    )

    @model_validator(mode="after")
    def _radial_stress(self) -> _Stresses:
        if isinstance(self.radial, float) and not 0.0 < self.radial <= MAX_STRESS:
            raise ValueError(f"radial must be above 0 and at most {MAX_STRESS:g} kPa, or K0; got {self.radial:g} kPa")
        return self


class TriaxialConsolidation(Loading, _Stresses):
    """One stage of consolidation: effective stresses, drained."""


class _Ends(Part):
    axial_strain: float | None = Field(
        None,
        ge=-2.0,
        le=0.9,
        description="Axial strain at the end, since the beginning of shearing; negative: extension.",
        json_schema_extra=in_unit("1", -0.2, 0.2, shown=True),
    )
    deviator_stress: float | None = Field(
        None,
        ge=-MAX_STRESS,
        le=MAX_STRESS,
        description="Deviator stress at the end, kPa; negative: extension. Give exactly one of the two.",
        json_schema_extra=in_unit("kPa", shown=True),
    )


class _Amplitudes(Part):
    axial_strain_amplitude: float | None = Field(
        None,
        gt=0.0,
        le=0.4,
        description="Half the range of the axial strain.",
        json_schema_extra=in_unit("1", 1e-5, 0.05, shown=True),
    )
    deviator_stress_amplitude: float | None = Field(
        None,
        gt=0.0,
        le=MAX_STRESS,
        description="Half the range of the deviator stress, kPa. Give exactly one of the two.",
        json_schema_extra=in_unit("kPa", 5, 200, shown=True),
    )


class _Water(Part):
    drainage: Literal["drained", "undrained"] | None = Field(
        None, description="Drainage of this stage; that of the test unless given."
    )
    constant: Literal["radial_stress", "mean_stress", "axial_stress"] = Field(
        "radial_stress", description="Stress that is held constant: effective with drainage, total without."
    )


class TriaxialMonotonic(_Water, Monotonic, _Ends):
    """Shearing to an axial strain or a deviator stress."""

    ends: ClassVar[tuple[str, str]] = ("axial_strain", "deviator_stress")


class TriaxialCyclic(_Water, Cyclic, _Amplitudes):
    """Cycles of axial strain or deviator stress about the state at their beginning."""

    ends: ClassVar[tuple[str, str]] = ("axial_strain_amplitude", "deviator_stress_amplitude")


class TriaxialHold(_Water, Hold):
    """Nothing is moved, time passes: creep or relaxation."""


TriaxialStage: TypeAlias = Annotated[TriaxialMonotonic | TriaxialCyclic | TriaxialHold, Field(discriminator="kind")]


class TriaxialSpec(LaboratorySpec):
    """Triaxial test: consolidation and shearing of a cylinder, drained or undrained.

    Stresses are effective. ``q`` is axial less radial stress, negative in extension; strains of shearing are
    engineering strains since its beginning, compression positive.

    Series over the axial strain (``q``, ``p``, ``pore_pressure`` ...) are the values where that strain is reached for
    the first time. The curve of an unloading loop is that of its stage: ``branch_2.q`` is q in the second stage, where
    the strain is first reached in it. ``time_q`` runs over the time since the beginning of shearing, ``stage_q`` over
    stages and ``consolidation_q`` over those of consolidation (values at their ends), ``cycle_q`` over cycles (at
    their ends; ``cycle_max_q`` and ``cycle_min_q`` inside them), ``path_q`` over the mean stress p, where that is
    first reached. What is never reached counts as its closest approach. q and p over the strain describe
    a path that turns better.

    Undrained, the volume is constant, or the water has a ``water_bulk_modulus``; the pore pressure is the total stress
    that the test keeps less the effective one.
    """

    kind: Literal["triaxial"] = "triaxial"
    initial_ratio: float | Literal["K0"] = Field(
        1.0,
        description="Radial over axial stress under which the soil is placed; K0: that of the law.",
        json_schema_extra=in_unit("1", 0.4, 1),
    )
    consolidation: tuple[TriaxialConsolidation, ...] = Field(
        (),
        max_length=1000,
        description="Stages of consolidation, drained, in their order.",
        json_schema_extra={"x-shown": True},
    )
    drainage: Literal["drained", "undrained"] = Field(
        "drained", description="Drainage during shearing.", json_schema_extra={"x-shown": True}
    )
    shearing: tuple[TriaxialStage, ...] = Field(
        min_length=1, max_length=1000, description="Stages of shearing, in their order."
    )
    back_pressure: float = Field(
        0.0,
        ge=0.0,
        le=MAX_STRESS,
        description="Pore pressure before shearing, kPa; it is only added to the pore pressure.",
        json_schema_extra=in_unit("kPa", 0, 600),
    )
    water_bulk_modulus: float | None = Field(
        None,
        gt=0.0,
        description="Bulk modulus of the pore water, kPa, undrained; rigid unless given. Needs a void ratio.",
        json_schema_extra=in_unit("kPa", 1e4, 2.2e6),
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """A consolidated drained test with one loop."""
        return {
            "kind": "triaxial",
            "material": "mohr_coulomb",
            "initial_stress": 20,
            "consolidation": [{"axial": 100}],
            "shearing": [
                {"kind": "monotonic", "axial_strain": 0.005},
                {"kind": "monotonic", "deviator_stress": 20},
                {"kind": "monotonic", "axial_strain": 0.1},
            ],
            "initial_void_ratio": 0.7,
        }

    def is_undrained(self, stage: _Water) -> bool:
        """Whether a stage of shearing is undrained."""
        return (stage.drainage or self.drainage) == "undrained"

    def remedy_for(self, series: str) -> str:
        """Also drainage, for a pore pressure."""
        if series.endswith("pore_pressure") and not any(self.is_undrained(stage) for stage in self.shearing):
            return "; it needs undrained shearing (drainage: undrained)"
        return super().remedy_for(series)

    @model_validator(mode="after")
    def _consistent(self) -> TriaxialSpec:
        undrained = any(self.is_undrained(stage) for stage in self.shearing)
        if self.water_bulk_modulus is not None and not undrained:
            raise SentenceError(
                setting("water_bulk_modulus"), " is given, but no stage of shearing is undrained; leave it out"
            )
        if self.water_bulk_modulus is not None and not knows_voids(self.law, self.initial_void_ratio):
            water = setting("water_bulk_modulus")
            raise SentenceError(
                *(
                    setting("initial_void_ratio"),
                    " is missing: with ",
                    water,
                    " the porosity gives the stiffness of the ",
                ),
                *("water; a value above 0 is accepted, or leave ", water, " out for rigid water"),
            )
        require_pace(self.law, self.shearing)
        return self

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Rigid water, where nothing is said of it."""
        if self.water_bulk_modulus is not None or not any(self.is_undrained(stage) for stage in self.shearing):
            return ()
        return (
            "The bulk modulus of water is not given, so pore water is rigid and undrained shearing keeps the volume, "
            "as in a saturated specimen; give it, above 0 kPa, with the void ratio where B was clearly below 1.",
        )

    def sketch(self) -> Sketch:
        """A cylinder in its cell, consolidated and sheared."""
        undrained = all(self.is_undrained(stage) for stage in self.shearing)
        readings = [Reading("q, εa", "deviator stress and axial strain", "top")]
        if any(self.is_undrained(stage) for stage in self.shearing):
            readings.append(Reading("u", "pore pressure", "base"))
        if not undrained:
            readings.append(Reading("εv", "volumetric strain, by the water that leaves", "water"))
        end: Literal["shut", "drained"] = "shut" if undrained else "drained"
        axial, radial = Load("σ′a", "axial effective stress"), Load("σ′r", "radial effective stress")
        specimen = SpecimenSketch(
            self.material_in_words,
            "membrane",
            Load("σ′a = σ′r + q", axial.words),
            lateral=radial,
            top=end,
            base=end,
            back_pressure=self.back_pressure,
            readings=tuple(readings),
            remark=f"Placed under σ′a = {self.initial_stress:g} kPa, σ′r/σ′a = {self.initial_ratio}.",
        )
        panels = movement_panels(
            self.build().shearing,
            Load("εa", "axial strain"),
            Load("q", "deviator stress"),
            timed=is_timed(self.shearing),
        )
        if self.consolidation:
            panels = (self._consolidated(axial, radial), *panels)
        return Sketch("Triaxial test", specimen, panels)

    def diagrams(self) -> tuple[Diagram, ...]:
        """The stress path, by q and the pore pressure at constant cell pressure; the shear modulus at small strains."""
        back = self.back_pressure

        def mean(readings: Readings, start: Mapping[str, float]) -> FloatArray:
            excess = readings["pore_pressure"] - back if "pore_pressure" in readings else 0.0
            return start["p"] + (readings["q"] - start["q"]) / 3.0 - excess

        undrained = any(self.is_undrained(stage) for stage in self.shearing)
        needs = ("q", "pore_pressure") if undrained else ("q",)
        cell = all(stage.constant == "radial_stress" for stage in self.shearing)
        caption = "Deviator stress over mean effective stress while the specimen is sheared"
        if cell:
            caption += "; where p' was not read itself, from q and pore pressure at constant cell pressure"
        derived = (Derived("p", needs, mean),) if cell else ()
        path = Diagram("stress_path", "Stress path", f"{caption}.", "p", "q", derived=derived)
        return path, shear_modulus_diagram("shear_modulus", self._secants())

    def _secants(self) -> tuple[Derived, ...]:
        """Shear strain and secant shear modulus by q, where that begins at 0, the axial and the volumetric strain."""
        undrained = all(self.is_undrained(stage) for stage in self.shearing)
        needs = ("axial_strain",) if undrained else ("axial_strain", "volumetric_strain")

        def strain(readings: Readings, start: Mapping[str, float]) -> FloatArray:
            del start
            sheared = 1.5 * readings["axial_strain"]
            return sheared if undrained else sheared - 0.5 * readings["volumetric_strain"]

        def modulus(readings: Readings, start: Mapping[str, float]) -> FloatArray:
            return over_strain(0.5 * readings["q"], strain(readings, start))

        sheared = Derived("shear_strain", needs, strain)
        last = self.consolidation[-1] if self.consolidation else None
        ratio = self.initial_ratio if last is None else 1.0 if last.radial in (None, last.axial) else 0.0
        return (sheared, Derived("shear_modulus", ("q", *needs), modulus)) if ratio == 1.0 else (sheared,)

    def _consolidated(self, axial: Load, radial: Load) -> Panel:
        """The programme of consolidation; the radial stress beside the axial one where it is another and known."""
        start = self.initial_stress
        tracks = [(axial, start, [stage.axial for stage in self.consolidation])]
        given = [stage.axial if stage.radial is None else stage.radial for stage in self.consolidation]
        known = [value for value in given if value != "K0"]
        ratio = self.initial_ratio
        if len(known) == len(given) and known != tracks[0][2] and ratio != "K0":
            tracks.append((radial, ratio * start, known))
        if len(known) < len(given):
            title = "Consolidation, without radial strain where K0 is given"
        else:
            title = "Consolidation" if known != tracks[0][2] else "Consolidation, isotropic"
        return load_panel(self.consolidation, tracks, title)

    def build(self) -> TriaxialModel:
        """Build the forward model."""
        from geoswarm.solver.laboratory.shear.triaxial_model import TriaxialModel

        return TriaxialModel(self)
