"""The calculation: phases applied to a mesh, one after another."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.fem.body import Body, State, copied
from geoswarm.solver.fem.initial import initial_internal, log_time_scale, point_coordinates, stress_at_rest
from geoswarm.solver.fem.materials import InterfaceMaterial, Material
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.multifrontal import equations_of
from geoswarm.solver.fem.newton import assemble
from geoswarm.solver.fem.phases import Control, Fixity, Geometry, Phase, Traction
from geoswarm.solver.fem.results import History, PhaseResult
from geoswarm.solver.fem.setup import (
    MaterialTables,
    SoilTable,
    dead_loads,
    edge_owners,
    fixed_dofs,
    fronts_of,
    load_table,
    material_tables,
    weights,
)
from geoswarm.solver.fem.stepping import PhaseSteps, Recorder
from geoswarm.solver.laws.registry import find_law

__all__ = ["Calculation", "solve_phases"]

_FLOOR = 1.0e-4
"""kPa: forces are never taken for smaller than this stress on the size of the mesh."""

_BALANCED = 1.0e-3
"""Share of the tolerance at which a creep phase needs no step for its instant load."""


def solve_phases(
    mesh: Mesh,
    phases: Sequence[Phase],
    *,
    geometry: Geometry = "plane_strain",
    observe: Sequence[str | int] = (),
    control: Control | None = None,
) -> list[PhaseResult]:
    """Lead a body through phases.

    Parameters
    ----------
    mesh
        As it is before the first phase.
    phases
        In their order.
    geometry
        "plane_strain", or "axisymmetric" with x the radius and y the axis.
    observe
        Names in ``mesh.points``, or node numbers, whose displacements are recorded.
    control
        Accuracy and patience.

    Raises
    ------
    DivergedError
        A phase finds no equilibrium; the message names it, how far it came and why.
    ValueError
        A phase names something that the mesh does not have, or leaves an active region without a material.
    """
    calculation = Calculation(mesh, geometry=geometry, observe=observe, control=control)
    return [calculation.run(phase) for phase in phases]


class Calculation:
    """A body between two phases; arguments as for :func:`solve_phases`."""

    def __init__(
        self,
        mesh: Mesh,
        *,
        geometry: Geometry = "plane_strain",
        observe: Sequence[str | int] = (),
        control: Control | None = None,
    ) -> None:
        unknown = [name for name in observe if isinstance(name, str) and name not in mesh.points]
        if unknown:
            known = ", ".join(sorted(mesh.points)) or "none"
            raise ValueError(f"point {unknown[0]!r} is not in the mesh; known: {known}")
        self.mesh = mesh
        self.control = control or Control()
        self._axisymmetric = geometry == "axisymmetric"
        self._observed = np.array(
            [mesh.points[one] if isinstance(one, str) else one for one in observe], dtype=np.int64
        )
        self._plan = fronts_of(mesh)
        self._equations = equations_of(self._plan)
        self._materials: dict[str, Material | InterfaceMaterial] = {}
        self._active = frozenset([*mesh.region_names, *mesh.interface_names])
        self._fixities: tuple[Fixity, ...] = ()
        self._tractions: tuple[Traction, ...] = ()
        self._gravity = 1.0
        self._width = 0
        self.positions = np.array(mesh.nodes, dtype=np.float64)
        self.displacements = np.zeros(mesh.nodes.shape)
        self._state = self._blank()
        self._size = float(np.ptp(mesh.nodes, axis=0).max())

    def run(self, phase: Phase) -> PhaseResult:
        """Carry out one phase; raises as :func:`solve_phases`."""
        self._materials.update(self._known(phase))
        self._active = self._active if phase.active is None else phase.active
        self._fixities = self._fixities if phase.fixities is None else phase.fixities
        self._tractions = self._tractions if phase.tractions is None else phase.tractions
        self._gravity = self._gravity if phase.gravity is None else phase.gravity
        tables = material_tables(self.mesh, self._materials, self._active)
        self._make_room()
        if phase.kind in ("gravity", "K0"):
            self._state = self._blank()
        self._state.stress[tables.material < 0] = 0.0
        self._state.traction[tables.interface_material < 0] = 0.0
        self._state.gap[tables.interface_material < 0] = 0.0
        if phase.kind == "K0":
            self._state.stress[:] = self._at_rest(phase, tables)
        if phase.kind != "gravity":
            self._place(phase.materials, tables)
        if phase.reset_displacements:
            self.displacements = np.zeros(self.mesh.nodes.shape)
        steps, history = self._prepare(phase, tables)
        if phase.kind in ("gravity", "plastic"):
            steps.load()
        elif phase.kind == "creep":
            self._creep(phase, tables, steps)
        if phase.kind != "K0":
            self._state = steps.state
            self.positions = steps.positions
            self.displacements = self.displacements + steps.moved.reshape(-1, 2)
        if phase.kind == "gravity":
            self._place(self._materials, tables)
        return self._result(phase, tables, steps, history)

    def _known(self, phase: Phase) -> dict[str, Material | InterfaceMaterial]:
        names = (*self.mesh.region_names, *self.mesh.interface_names)
        for name in (*phase.materials, *(phase.active or ())):
            if name not in names:
                raise ValueError(
                    f"phase {phase.name!r}: {name!r} is not a region or interface; known: {', '.join(names)}"
                )
        return dict(phase.materials)

    def _blank(self) -> State:
        count = self.mesh.triangles.shape[0]
        return State(
            np.zeros((count, 3, 4)),
            np.zeros((count, 3, self._width)),
            np.zeros((count, 3), dtype=np.bool_),
            np.zeros((self.mesh.interfaces.shape[0], 3, 2)),
            np.zeros((self.mesh.interfaces.shape[0], 3)),
        )

    def _triangles(self, name: str, tables: MaterialTables) -> IntArray:
        """Active triangles of a region."""
        region = self.mesh.region_names.index(name)
        chosen: IntArray = np.flatnonzero((self.mesh.regions == region) & (tables.material >= 0))
        return chosen

    def _place(self, placed: Mapping[str, Material | InterfaceMaterial], tables: MaterialTables) -> None:
        """Set the initial state of regions that get a soil."""
        for name, material in placed.items():
            if isinstance(material, Material) and material.soil.law.state:
                chosen, width = self._triangles(name, tables), len(material.soil.law.state)
                internal = initial_internal(self._state.stress[chosen], material.soil)
                self._state.internal[chosen] = 0.0
                self._state.internal[chosen, :, :width] = internal

    def _make_room(self) -> None:
        """Make room for the state variables of all laws: their updates write them in every phase."""
        soils = [material.soil for material in self._materials.values() if isinstance(material, Material)]
        more = max((len(soil.law.state) for soil in soils), default=0) - self._width
        if more > 0:
            self._width += more
            internal = np.pad(self._state.internal, ((0, 0), (0, 0), (0, more)))
            self._state = self._state._replace(internal=internal)

    def _at_rest(self, phase: Phase, tables: MaterialTables) -> FloatArray:
        if phase.initial_stress is not None:
            points = point_coordinates(self.mesh, self.positions)
            stress = np.asarray(phase.initial_stress(points.reshape(-1, 2)), dtype=np.float64).reshape(-1, 3, 4)
        else:
            ratio = np.zeros(self.mesh.triangles.shape[0])
            for name in self.mesh.region_names:
                material = self._materials.get(name)
                if name in self._active and material is not None and not isinstance(material, InterfaceMaterial):
                    ratio[self._triangles(name, tables)] = material.lateral_ratio()
            stress = stress_at_rest(
                self.mesh, self.positions, self._gravity * tables.unit_weight, ratio, phase.surcharge
            )
        stress[tables.material < 0] = 0.0
        return stress

    def _prepare(self, phase: Phase, tables: MaterialTables) -> tuple[PhaseSteps, list[tuple[float, FloatArray]]]:
        edges, edge_loads = load_table(self.mesh, self._tractions, tables.material, True)
        owner, places = edge_owners(self.mesh, edges)
        body = Body(
            self._axisymmetric,
            phase.updated_mesh,
            self.mesh.triangles,
            tables.material,
            tables.soils.updates,
            tables.soils.constants,
            tables.soils.strength,
            tables.soils.elastic,
            tables.soils.tensors,
            tables.soils.tensor_shear,
            self.mesh.interfaces,
            tables.interface_material,
            tables.interface_constants,
            edges,
            owner,
            places,
        )
        fixed, target = fixed_dofs(self.mesh, self._fixities, tables.material, phase.fixities is not None)
        dead_edges, dead_numbers = load_table(self.mesh, self._tractions, tables.material, False)
        end_forces = self._gravity * weights(self.mesh, tables.unit_weight, self._axisymmetric)
        end_forces += dead_loads(self.mesh, dead_edges, dead_numbers, self.mesh.nodes, self._axisymmetric)
        history: list[tuple[float, FloatArray]] = []
        before = self.displacements[self._observed]

        def record(time: float, moved: FloatArray) -> None:
            history.append((time, before + moved.reshape(-1, 2)[self._observed]))

        steps = PhaseSteps(
            phase,
            self.control,
            body,
            self._plan,
            self._equations,
            self.positions,
            self._state,
            copied(self._state),
            self._balanced_forces(body, fixed),
            end_forces,
            edge_loads,
            fixed,
            target,
            _FLOOR * self._size * (self._size if self._axisymmetric else 1.0),
            float(np.abs(self.displacements).max()),
            record,
        )
        return steps, history

    def _balanced_forces(self, body: Body, fixed: BoolArray) -> FloatArray:
        """Forces that the present stresses carry, whatever the materials say to them."""
        soils = _elastic_alone()
        bare = body._replace(
            material=np.minimum(body.material, 0),
            updates=soils.updates,
            constants=soils.constants,
            strength=soils.strength,
            elastic=soils.elastic,
            tensors=soils.tensors,
            tensor_shear=soils.tensor_shear,
            interface_material=np.minimum(body.interface_material, 0),
            interface_constants=np.array([[1.0, 1.0, math.inf, 0.0, 0.0, math.inf]]),
        )
        dofs = self.mesh.nodes.size
        inner, outer, zero = np.zeros(dofs), np.zeros(dofs), np.zeros(dofs)
        loads = np.zeros((body.edges.shape[0], 7))
        spare = copied(self._state)
        assemble(
            bare,
            self.positions,
            zero,
            -math.inf,
            self._state._replace(gap=np.zeros_like(self._state.gap)),
            spare,
            zero,
            loads,
            fixed,
            False,
            0.0,
            self._equations.tangents,
            inner,
            outer,
        )
        return inner

    def _creep(self, phase: Phase, tables: MaterialTables, steps: PhaseSteps) -> None:
        if phase.instant:
            follower = dead_loads(self.mesh, steps.body.edges, steps.edge_loads, self.positions, self._axisymmetric)
            missing = np.where(steps.fixed, 0.0, steps.end_forces + follower - steps.start_forces)
            size = max(float(np.linalg.norm(steps.start_forces)), steps.floor)
            if np.linalg.norm(missing) > _BALANCED * self.control.tolerance * size or steps.target.any():
                steps.phase = phase
                observed = steps.record
                steps.record = _ignore
                steps.load()
                steps.record = observed
        wanted = () if phase.output_times is None else phase.output_times
        if wanted and (list(wanted) != sorted(set(wanted)) or wanted[0] < 0.0 or wanted[-1] > phase.duration):
            raise ValueError(f"phase {phase.name!r}: output_times must increase from 0 to {phase.duration:g} day")
        if phase.output_times is None or (wanted and wanted[0] == 0.0):
            steps.record(0.0, steps.moved)
        if phase.duration <= 0.0:
            return
        times = np.array([time for time in wanted if time > 0.0])
        observed = steps.record
        if phase.output_times is not None and (not times.size or times[-1] < phase.duration):
            times = np.append(times, phase.duration)
            steps.record = _until(observed, wanted[-1] if wanted else -1.0)
        log_scale = math.log(phase.duration)
        for name in self.mesh.region_names:
            material = self._materials.get(name)
            if name in self._active and isinstance(material, Material):
                chosen = self._triangles(name, tables)
                stress, internal = steps.state.stress[chosen], steps.state.internal[chosen]
                log_scale = min(log_scale, log_time_scale(stress, internal, material.soil))
        steps.creep(log_scale, not phase.instant, times)

    def _result(
        self, phase: Phase, tables: MaterialTables, steps: PhaseSteps, history: list[tuple[float, FloatArray]]
    ) -> PhaseResult:
        positions = self.positions
        carried = self._balanced_forces(steps.body._replace(updated=False), steps.fixed)
        outer = steps.end_forces + dead_loads(
            self.mesh, steps.body.edges, steps.edge_loads, positions, self._axisymmetric
        )
        reactions = np.where(steps.fixed, carried - outer, 0.0).reshape(-1, 2)
        observed = self._observed.size
        return PhaseResult(
            phase.name,
            History(
                np.array([time for time, _ in history]),
                np.array([values for _, values in history]).reshape(len(history), observed, 2),
            ),
            self.displacements.copy(),
            positions.copy(),
            self._state.stress.copy(),
            self._state.internal.copy(),
            self._state.plastic & (tables.material >= 0)[:, np.newaxis],
            self._state.traction.copy(),
            reactions,
            steps.work.steps,
            steps.work.iterations,
            steps.work.factorisations,
            steps.path,
        )


@cache
def _elastic_alone() -> SoilTable:
    """One elastic soil: it lets every stress be."""
    return SoilTable.of([find_law("elastic").soil({"E": 1.0, "nu": 0.0})])


def _ignore(time: float, moved: FloatArray) -> None:
    """Record nothing."""


def _until(record: Recorder, last: float) -> Recorder:
    return lambda time, moved: record(time, moved) if time <= last else None
