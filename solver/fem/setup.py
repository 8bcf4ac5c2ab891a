"""From a mesh and a phase to the arrays of the kernels: materials, fixities, loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.fem.edges import LOAD_NUMBERS, edge_forces
from geoswarm.solver.fem.materials import INTERFACE_CONSTANTS, InterfaceMaterial, Material
from geoswarm.solver.fem.mesh.mesh import IndexArray, Mesh
from geoswarm.solver.fem.ordering import Fronts, plan_fronts
from geoswarm.solver.fem.phases import Fixity, Traction
from geoswarm.solver.fem.triangle import SHAPES, SLOPES, WEIGHT
from geoswarm.solver.laws.base import Soil, StrengthPlaces

__all__ = [
    "MaterialTables",
    "SoilTable",
    "dead_loads",
    "edge_owners",
    "fixed_dofs",
    "fronts_of",
    "load_table",
    "material_tables",
    "weights",
]

_KEPT: Final = 4
_MEAN_STRESS: Final = 100.0
"""kPa: where the elastic moduli that are mixed into a tangent are taken."""
_plans: dict[bytes, Fronts] = {}


@dataclass(frozen=True)
class SoilTable:
    """Of each soil: the address of its stress update (m,), constants (m, c) and others as in :class:`Body`."""

    updates: IntArray
    constants: FloatArray
    strength: IntArray
    elastic: FloatArray
    tensors: IntArray
    tensor_shear: FloatArray

    @classmethod
    def of(cls, soils: Sequence[Soil]) -> SoilTable:
        """Those of soils in their order."""
        constants = np.zeros((len(soils), max((soil.constants.size for soil in soils), default=0)))
        strength = np.full((len(soils), len(StrengthPlaces._fields)), -1, dtype=np.int64)
        elastic = np.zeros((len(soils), 2))
        most = max((len(soil.law.tensors) for soil in soils), default=0)
        tensors, shear = np.full((len(soils), most), -1, dtype=np.int64), np.ones((len(soils), most))
        for number, soil in enumerate(soils):
            constants[number, : soil.constants.size] = soil.constants
            if soil.law.strength is not None:
                strength[number] = soil.law.strength
            if soil.law.perfectly_plastic:
                elastic[number] = soil.law.elastic_moduli(soil.constants, _MEAN_STRESS)
            for place, one in enumerate(soil.law.tensors):
                tensors[number, place], shear[number, place] = one
        updates = np.array([soil.law.update.address for soil in soils], dtype=np.int64)
        return cls(updates, constants, strength, elastic, tensors, shear)


@dataclass(frozen=True)
class MaterialTables:
    """Index of each triangle and interface into tables of constants, -1: inactive; the regions' materials in order."""

    material: IntArray
    soils: SoilTable
    interface_material: IntArray
    interface_constants: FloatArray
    unit_weight: FloatArray
    """(e,): kN/m3, 0 where inactive."""


def elements_of(mesh: Mesh) -> IndexArray:
    """Nodes (e + k, 6) of all triangles and interfaces."""
    return np.concatenate([mesh.triangles, mesh.interfaces]).astype(np.int32)


def fronts_of(mesh: Mesh) -> Fronts:
    """Order of elimination of a mesh; meshes of the same topology share it, wherever their nodes are."""
    elements = elements_of(mesh)
    key = elements.tobytes()
    if key not in _plans:
        while len(_plans) >= _KEPT:
            del _plans[next(iter(_plans))]
        _plans[key] = plan_fronts(elements, mesh.nodes[elements].mean(axis=1), mesh.nodes.shape[0])
    return _plans[key]


def material_tables(
    mesh: Mesh, materials: Mapping[str, Material | InterfaceMaterial], active: frozenset[str]
) -> MaterialTables:
    """Tables for the active regions and interfaces; a region that is active and has no material is a ValueError."""
    regions: list[int] = []
    soils: list[Soil] = []
    weight: list[float] = []
    for name in mesh.region_names:
        material = materials.get(name)
        if name not in active:
            regions.append(-1)
            weight.append(0.0)
            continue
        if material is None or isinstance(material, InterfaceMaterial):
            raise ValueError(f"region {name!r} has no soil material; give it one before or when it becomes active")
        regions.append(len(soils))
        soils.append(material.soil)
        weight.append(material.unit_weight)
    faces: list[int] = []
    face_constants: list[FloatArray] = []
    for name in mesh.interface_names:
        material = materials.get(name)
        if name not in active:
            faces.append(-1)
            continue
        if not isinstance(material, InterfaceMaterial):
            raise ValueError(f"interface {name!r} has no interface material; give it one or leave it inactive")
        faces.append(len(face_constants))
        face_constants.append(material.constants())
    own = np.array([*regions, -1], dtype=np.int64)[mesh.regions]
    interface_material = np.array([*faces, -1], dtype=np.int64)[mesh.interface_regions]
    living = np.zeros(mesh.nodes.shape[0], dtype=np.bool_)
    living[mesh.triangles[own >= 0]] = True
    interface_material[~living[mesh.interfaces].all(axis=1)] = -1
    return MaterialTables(
        own,
        SoilTable.of(soils),
        interface_material,
        np.array(face_constants).reshape(-1, INTERFACE_CONSTANTS),
        np.array([*weight, 0.0])[mesh.regions],
    )


def nodes_of(mesh: Mesh, where: str | tuple[int, ...]) -> IntArray:
    """Nodes of a boundary (sorted), of a point, or as they are given."""
    if not isinstance(where, str):
        return np.array(where, dtype=np.int64)
    if where in mesh.boundaries:
        return np.unique(mesh.boundaries[where]).astype(np.int64)
    if where in mesh.points:
        return np.array([mesh.points[where]], dtype=np.int64)
    known = ", ".join(sorted([*mesh.boundaries, *mesh.points])) or "none"
    raise ValueError(f"{where!r} is neither a boundary nor a point of the mesh; known: {known}")


def fixed_dofs(
    mesh: Mesh, fixities: tuple[Fixity, ...], material: IntArray, moving: bool
) -> tuple[BoolArray, FloatArray]:
    """Prescribed dofs (2 n,) and their changes during the phase (0 unless ``moving``); inactive nodes are held."""
    nodes = mesh.nodes.shape[0]
    living = np.zeros(nodes, dtype=np.bool_)
    living[mesh.triangles[material >= 0]] = True
    fixed = np.repeat(~living, 2)
    target = np.zeros(2 * nodes)
    for fixity in fixities:
        chosen = nodes_of(mesh, fixity.where)
        for axis, value in enumerate((fixity.x, fixity.y)):
            if value is not None:
                fixed[2 * chosen + axis] = True
                target[2 * chosen + axis] = value if moving else 0.0
    target[np.repeat(~living, 2)] = 0.0
    return fixed, target


def weights(mesh: Mesh, unit_weight: FloatArray, axisymmetric: bool) -> FloatArray:
    """Nodal forces (2 n,) of the weight on the mesh as it was given: mass does not change with its deformation."""
    corners = mesh.nodes[mesh.triangles]
    jacobian = np.einsum("pin,enj->epij", SLOPES, corners)
    volume = WEIGHT * (jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0])
    if axisymmetric:
        volume = volume * np.einsum("pn,en->ep", SHAPES, corners[..., 0])
    shares = np.einsum("ep,pn,e->en", volume, SHAPES, unit_weight)
    force = np.zeros(2 * mesh.nodes.shape[0])
    np.subtract.at(force, 2 * mesh.triangles.ravel().astype(np.int64) + 1, shares.ravel())
    return force


def load_table(
    mesh: Mesh, tractions: tuple[Traction, ...], material: IntArray, follower: bool
) -> tuple[IndexArray, FloatArray]:
    """Edges (q, 3) of active triangles and loads (q, LOAD_NUMBERS) of the tractions that follow, or do not."""
    edges, loads = [np.empty((0, 3), dtype=np.int32)], [np.empty((0, LOAD_NUMBERS))]
    for one in tractions:
        if one.boundary not in mesh.boundaries:
            known = ", ".join(sorted(mesh.boundaries)) or "none"
            raise ValueError(f"traction on {one.boundary!r}: no such boundary; known: {known}")
        if one.follower == follower:
            numbers = (one.normal, one.x, one.y, one.normal_slope, one.x_slope, one.y_slope, one.level)
            edges.append(mesh.boundaries[one.boundary].astype(np.int32))
            loads.append(np.tile(numbers, (edges[-1].shape[0], 1)))
    every, table = np.concatenate(edges), np.concatenate(loads)
    living = edge_owners(mesh, every)[0]
    loaded = material[living] >= 0
    return every[loaded], np.ascontiguousarray(table[loaded])


def edge_owners(mesh: Mesh, edges: IndexArray) -> tuple[IntArray, IntArray]:
    """Triangle (q,) that each edge (q, 3) belongs to, and the places (q, 3) of the edge's nodes in it."""
    if not edges.shape[0]:
        return np.empty(0, dtype=np.int64), np.empty((0, 3), dtype=np.int64)
    known = {int(mid) for mid in edges[:, 2]}
    sides: dict[tuple[int, int, int], int] = {}
    # A mid-side node inside the body belongs to two triangles; the edge's direction shows which one is meant.
    for e in np.flatnonzero(np.isin(mesh.triangles[:, 3:], edges[:, 2]).any(axis=1)).tolist():
        triangle = mesh.triangles[e]
        for a, b, m in ((0, 1, 3), (1, 2, 4), (2, 0, 5)):
            if int(triangle[m]) in known:
                sides[(int(triangle[a]), int(triangle[b]), int(triangle[m]))] = e
    owners = []
    for edge in edges:
        key = (int(edge[0]), int(edge[1]), int(edge[2]))
        if key not in sides:
            raise ValueError(f"the boundary edge {key} is not a side of a triangle with the body on its left")
        owners.append(sides[key])
    owner = np.array(owners, dtype=np.int64)
    places = np.array(
        [
            [int(np.flatnonzero(mesh.triangles[e] == node)[0]) for node in edge]
            for e, edge in zip(owner, edges, strict=True)
        ]
    )
    return owner, places


def dead_loads(
    mesh: Mesh, edges: IndexArray, loads: FloatArray, positions: FloatArray, axisymmetric: bool
) -> FloatArray:
    """Nodal forces (2 n,) of loads at given positions."""
    force = np.zeros(2 * mesh.nodes.shape[0])
    edge_forces(edges, loads, positions, axisymmetric, force)
    return force
