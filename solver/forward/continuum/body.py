"""What sections and meshes of the user have in common in a problem file: materials, phases, what is observed."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.forward.continuum.geometry import Name
from geoswarm.solver.forward.continuum.materials import InterfaceSection, MaterialSection, UserSoil
from geoswarm.solver.forward.continuum.phases import BoundaryName, Fixity, PhaseSection, VectorSection
from geoswarm.solver.user_laws.section import UserLawSection

__all__ = ["BodySections", "ControlSection", "check_names"]


class ControlSection(BaseModel):
    """How accurately to solve."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    tolerance: float = Field(1.0e-6, gt=0.0, le=1.0e-2, description="Out-of-balance forces over the forces.")
    load_tolerance: float = Field(
        0.03,
        ge=0.0,
        le=0.1,
        description="What load steps may leave to the next one: root of the work left over the work of the step.",
    )
    time_tolerance: float = Field(
        1.0e-3, gt=0.0, le=0.1, description="Error of a time step of creep over the displacement of its phase."
    )
    creep_step: float = Field(2.0, gt=0.0, le=5.0, description="Largest time step of creep, as logarithm of time.")
    largest_steps: int = Field(
        500, ge=1, le=100_000, description="Most steps of one phase; a calculation that needs more has diverged."
    )
    largest_assemblies: int = Field(
        10_000,
        ge=1,
        le=1_000_000,
        description="Most assemblies of forces of one phase: bounds what parameters without an equilibrium cost.",
    )
    smallest_step: float = Field(
        1.0e-3, gt=0.0, le=1.0, description="Part of the load below which a step is not cut any more."
    )
    modified_newton: bool = Field(False, description="Keep a factorisation over iterations as long as they converge.")


class BodySections(BaseModel):
    """Materials, phases and observations of a body; mixed into sections of forward models."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    depends_on_section: ClassVar[bool] = True

    materials: dict[Name, MaterialSection] = Field(min_length=1, max_length=100, description="Materials by name.")
    fixities: dict[BoundaryName, Fixity] = Field(
        default={}, description="Boundaries that are held: horizontal, vertical, both or free."
    )
    phases: list[PhaseSection] = Field(min_length=1, max_length=100, description="Phases in their order.")
    zero_at_phase: Name | None = Field(
        None, description="Phase before which time and displacement are zero; the first creep phase unless given."
    )
    vectors: dict[Name, VectorSection] = Field(
        default={}, max_length=50, description="Displacement vectors of points over periods, by name."
    )
    nominal: dict[Name, float] = Field(
        default={},
        description="Usual values of the parameters in the geometry, for which the mesh is planned; also defaults.",
    )
    control: ControlSection = Field(default=ControlSection(), description="Accuracy.")

    @property
    def user_laws(self) -> tuple[UserLawSection, ...]:
        """Those of soils in libraries."""
        return tuple(one for one in self.materials.values() if isinstance(one, UserSoil))

    def with_files(self, folder: Path | None, path: str) -> Self:
        """With what is known of the libraries of its soils."""
        if not self.user_laws:
            return self
        materials = {
            name: one.with_files(folder, f"{path}.materials.{name}") if isinstance(one, UserSoil) else one
            for name, one in self.materials.items()
        }
        return self.model_copy(update={"materials": materials})

    @property
    def kernels(self) -> frozenset[str]:
        """Those of finite elements and of the laws of its soils."""
        soils = {one.law for one in self.materials.values() if not isinstance(one, InterfaceSection)}
        return frozenset({"section", "elastic", *soils})


def check_names(body: BodySections, mesh: Mesh) -> None:
    """Compare the names in phases and observations with those of the mesh.

    Raises
    ------
    ProblemError
        A name is unknown, or something has no material; each with its path.
    """
    issues = [*_phase_issues(body, mesh), *_vector_issues(body, mesh)]
    names = [phase.name for phase in body.phases]
    if body.zero_at_phase is not None and body.zero_at_phase not in names:
        issues.append(_unknown("forward_model.zero_at_phase", body.zero_at_phase, "phases", names))
    twice = sorted({name for name in names if names.count(name) > 1})
    issues += [Issue("forward_model.phases", f"the name {name} is given to two phases") for name in twice]
    if issues:
        raise ProblemError(issues)


def _unknown(path: str, name: str, what: str, known: Iterable[str]) -> Issue:
    return Issue(path, f"{name} is unknown; known {what}: {', '.join(known) or 'none'}")


def _phase_issues(body: BodySections, mesh: Mesh) -> list[Issue]:
    issues = []
    parts = (*mesh.region_names, *mesh.interface_names)
    missing = set(parts)
    issues += [
        _unknown(f"forward_model.fixities.{name}", name, "boundaries", mesh.boundaries)
        for name in body.fixities
        if name not in mesh.boundaries
    ]
    for number, phase in enumerate(body.phases):
        path = f"forward_model.phases[{number}]"
        for part, material in phase.materials.items():
            place = f"{path}.materials.{part}"
            if part not in parts:
                issues.append(_unknown(place, part, "regions and interfaces", parts))
            elif material not in body.materials:
                issues.append(_unknown(place, material, "materials", body.materials))
            elif isinstance(body.materials[material], InterfaceSection) != (part in mesh.interface_names):
                wanted = "an interface needs law: interface" if part in mesh.interface_names else "only for interfaces"
                issues.append(Issue(place, f"material {material} does not fit: {wanted}"))
            missing.discard(part)
        for key in ("activate", "deactivate"):
            issues += [
                _unknown(f"{path}.{key}", name, "regions and interfaces", parts)
                for name in getattr(phase, key)
                if name not in parts
            ]
        missing -= set(phase.deactivate)
        boundaries = [
            *(("fixities", name) for name in phase.fixities),
            *(("loads", load.boundary) for load in phase.loads),
        ]
        issues += [
            _unknown(f"{path}.{key}", name, "boundaries", mesh.boundaries)
            for key, name in boundaries
            if name not in mesh.boundaries
        ]
        if number == 0 and missing:
            text = f"{', '.join(sorted(missing))} without a material; the first phase gives one to each active part"
            issues.append(Issue(f"{path}.materials", text))
        if (phase.kind in ("gravity", "K0")) != (number == 0):
            text = "must be gravity or K0 for the first phase, plastic or creep for later ones"
            issues.append(Issue(f"{path}.kind", f"{text}; got {phase.kind}"))
    return issues


def _vector_issues(body: BodySections, mesh: Mesh) -> list[Issue]:
    issues = [
        _unknown(f"forward_model.vectors.{name}.points", point, "points", mesh.points)
        for name, vector in body.vectors.items()
        for point in vector.points
        if point not in mesh.points
    ]
    issues += [
        Issue(f"forward_model.vectors.{name}", "is also the name of a point; choose another name")
        for name in body.vectors
        if name in mesh.points
    ]
    return issues
