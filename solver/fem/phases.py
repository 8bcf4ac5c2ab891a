"""What happens to a mesh, phase by phase: materials, loads, fixities and time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.materials import InterfaceMaterial, Material

__all__ = ["Control", "Fixity", "Geometry", "Phase", "PhaseKind", "Traction"]

Geometry: TypeAlias = Literal["plane_strain", "axisymmetric"]
PhaseKind: TypeAlias = Literal["gravity", "K0", "plastic", "creep"]


@dataclass(frozen=True)
class Traction:
    """Load on a named boundary, kPa.

    Parameters
    ----------
    boundary
        Name in ``mesh.boundaries``.
    normal
        Along the outward normal: tension positive, a pressure is negative.
    x, y
        Along the axes.
    normal_slope, x_slope, y_slope
        Increase of each for a metre of height, kPa/m: the load is value + slope * (y - level).
    level
        Height, m, at which the values hold.
    follower
        The load turns and stretches with the boundary in phases with updated mesh; otherwise direction and area are
        those of the undeformed mesh.
    """

    boundary: str
    normal: float = 0.0
    x: float = 0.0
    y: float = 0.0
    normal_slope: float = 0.0
    x_slope: float = 0.0
    y_slope: float = 0.0
    level: float = 0.0
    follower: bool = False


@dataclass(frozen=True)
class Fixity:
    """Prescribed displacement.

    Parameters
    ----------
    where
        Name in ``mesh.boundaries`` or ``mesh.points``, or node numbers.
    x, y
        Change of the displacement during the phase, m; 0 holds, None leaves free; an array has one value a node in the
        order of ``where`` (the sorted nodes of a boundary).
    """

    where: str | tuple[int, ...]
    x: float | FloatArray | None = None
    y: float | FloatArray | None = None


@dataclass(frozen=True)
class Phase:
    """One phase of a calculation. Regions, materials, loads and fixities go on from phase to phase until changed.

    Parameters
    ----------
    name
        For messages and results.
    kind
        "gravity": stresses start from zero, weight and loads are applied; "K0": stresses from the weight above (or
        ``initial_stress``), no deformation; "plastic": loads, weight and out-of-balance are applied from the present
        state, without time; "creep": the same at once or over ``duration``, then time passes.
    materials
        Material of regions and interfaces by name, for those that get one in this phase. A region that gets soft soil
        creep gets its preconsolidation from the stress of that moment.
    active
        Names of the active regions and interfaces; None: as before, all at first. An interface is active only where
        both its sides are.
    fixities, tractions
        All of them; None: as before. Prescribed changes hold for one phase, the next one holds the dof.
    gravity
        Multiple of the weight at the end of the phase; None: as before, 1 at first.
    duration
        Creep phases: day.
    instant
        Creep phases: loads are applied at once, before time passes; False: linearly over the duration.
    updated_mesh
        Updated Lagrangian: positions follow the displacements; False: small strain on the mesh as it then is.
    reset_displacements
        Displacements count from this phase on.
    initial_stress
        K0 phases: function of coordinates (m, 2) that gives stress (m, 4), kPa, tension positive, xx yy zz xy.
    surcharge
        K0 phases: vertical pressure on top of the surface, kPa.
    output_times
        Creep phases: times since the beginning of the phase, day, at which displacements are recorded; 0 is after an
        instant load. None: at every step.
    load_step, largest_load_step
        First and largest part of the load applied in one step.
    """

    name: str
    kind: PhaseKind = "plastic"
    materials: Mapping[str, Material | InterfaceMaterial] = field(default_factory=dict)
    active: frozenset[str] | None = None
    fixities: tuple[Fixity, ...] | None = None
    tractions: tuple[Traction, ...] | None = None
    gravity: float | None = None
    duration: float = 0.0
    instant: bool = True
    updated_mesh: bool = False
    reset_displacements: bool = False
    initial_stress: Callable[[FloatArray], FloatArray] | None = None
    surcharge: float = 0.0
    output_times: tuple[float, ...] | None = None
    load_step: float = 0.25
    largest_load_step: float = 1.0


@dataclass(frozen=True)
class Control:
    """How accurately and how patiently to solve.

    Parameters
    ----------
    tolerance
        Out-of-balance force over the size of the forces at which a step has converged.
    load_tolerance
        What load steps may leave out of balance on their way, the next one carries it: root of its work over the work
        of the step. The end of a phase is in balance to ``tolerance`` whatever this is.
    iterations
        Most Newton iterations a step.
    modified
        Keep a factorisation as long as the residual falls at least by ``keep_ratio`` an iteration.
    smallest_step
        Part of the load, or of logarithmic time, below which a step is not cut any more.
    blend_below
        Part of the load up to which a step that fails is tried again with elastic stiffness mixed into the tangent.
    time_tolerance
        Creep phases: local error of displacement over the largest displacement of the phase.
    creep_step
        Creep phases: largest step in logarithmic time; halve it to see what time steps do to a result.
    largest_steps
        Most steps of one phase.
    largest_assemblies
        Most assemblies of one phase, those of steps that failed included: the bound of its cost. A change of strength
        in steps, tried where that was not enough, has half as many for its own flow and half for associated flow.
    """

    tolerance: float = 1.0e-6
    load_tolerance: float = 0.03
    iterations: int = 25
    modified: bool = False
    keep_ratio: float = 0.2
    smallest_step: float = 1.0e-3
    blend_below: float = 0.02
    time_tolerance: float = 1.0e-3
    creep_step: float = 2.0
    largest_steps: int = 5000
    largest_assemblies: int = 50000
