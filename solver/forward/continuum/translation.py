"""From a problem's materials and phases to those of the finite elements, for given parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.fem.materials import InterfaceMaterial, Material
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.forward.continuum.body import BodySections, ControlSection
from geoswarm.solver.forward.continuum.materials import InterfaceSection, MaterialSection
from geoswarm.solver.forward.continuum.phases import LoadSection
from geoswarm.solver.forward.continuum.quantity import Number, value_of

__all__ = ["control_of", "material_of", "phases_of"]

AnyMaterial = Material | InterfaceMaterial


def control_of(section: ControlSection) -> Control:
    """Accuracy."""
    return Control(
        tolerance=section.tolerance,
        load_tolerance=section.load_tolerance,
        time_tolerance=section.time_tolerance,
        creep_step=section.creep_step,
        modified=section.modified_newton,
        smallest_step=section.smallest_step,
        largest_steps=section.largest_steps,
        largest_assemblies=section.largest_assemblies,
    )


def material_of(name: str, section: MaterialSection, values: Mapping[str, float]) -> AnyMaterial:
    """Material with its constants for parameters by name.

    Raises
    ------
    InfeasibleError
        A constant is outside its range; the message names the material.
    """
    try:
        return _material(section, values)
    except InfeasibleError as error:
        raise InfeasibleError(f"material {name}: {error}") from error


def _material(section: MaterialSection, values: Mapping[str, float]) -> AnyMaterial:
    def number(given: Number) -> float:
        return value_of(given, values)

    def optional(given: Number | None) -> float | None:
        return None if given is None else value_of(given, values)

    if isinstance(section, InterfaceSection):
        return InterfaceMaterial(
            number(section.normal_stiffness),
            number(section.shear_stiffness),
            number(section.c),
            number(section.phi),
            number(section.psi),
            number(section.tension_cutoff),
        )
    law = section.soil_law
    given = {info.name: optional(section.given(info.name)) for info in law.parameters}
    for one in law.settings:
        chosen = section.given(one.name)
        given[one.name] = chosen if one.choices else optional(chosen)
    return Material(law.soil(given), number(section.unit_weight))


def phases_of(
    body: BodySections, mesh: Mesh, values: Mapping[str, float], times: Mapping[str, tuple[float, ...]]
) -> Iterator[Phase]:
    """Phases for parameters by name.

    Parameters
    ----------
    times
        By the name of a creep phase, when to record displacements, day since its beginning.

    Raises
    ------
    InfeasibleError
        A number is outside its range.
    """
    materials = {name: material_of(name, section, values) for name, section in body.materials.items()}
    held: dict[str, str] = {}
    _hold(held, body.fixities, mesh)
    loads: dict[str, Traction] = {}
    active = {*mesh.region_names, *mesh.interface_names}
    for phase in body.phases:
        _hold(held, phase.fixities, mesh)
        active = (active - set(phase.deactivate)) | set(phase.activate)
        for load in phase.loads:
            loads[load.boundary] = _traction(load, values)
        yield Phase(
            phase.name,
            phase.kind,
            materials={part: materials[name] for part, name in phase.materials.items()},
            active=frozenset(active),
            fixities=tuple(
                Fixity(
                    name, 0.0 if how in ("horizontal", "both") else None, 0.0 if how in ("vertical", "both") else None
                )
                for name, how in held.items()
                if how != "free"
            ),
            tractions=tuple(loads.values()),
            duration=0.0 if phase.duration is None else value_of(phase.duration, values),
            updated_mesh=phase.updated_mesh,
            reset_displacements=phase.reset_displacements,
            output_times=times.get(phase.name, ()) if phase.kind == "creep" else None,
        )


def _hold(held: dict[str, str], fixities: Mapping[str, str], mesh: Mesh) -> None:
    """Change fixities; one of a whole side (``right``) changes those of its pieces (``right.cover``)."""
    for name, how in fixities.items():
        pieces = [piece for piece in mesh.boundaries if piece.startswith(f"{name}.")] or [name]
        for piece in pieces:
            held[piece] = how


def _traction(load: LoadSection, values: Mapping[str, float]) -> Traction:
    return Traction(
        load.boundary,
        normal=-value_of(load.pressure, values),
        normal_slope=value_of(load.pressure_increase, values),
        x=value_of(load.x, values),
        y=value_of(load.y, values),
        level=value_of(load.level, values),
        follower=load.follows,
    )
