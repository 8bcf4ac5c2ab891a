"""What can be wrong with a mesh, found before anything is calculated on it."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.mesh import EDGES, IndexArray, Mesh

__all__ = ["SHARPEST", "check_mesh", "corner_angles", "jacobians", "mesh_faults"]

SHARPEST = 0.5
"""Smallest corner angle that is accepted, degree: thin layers are flat on purpose, still flatter ones a mistake."""

_OFF_CENTRE = 0.2
"""How far a mid-side node may lie from the middle of its edge, in lengths of the edge; a quarter is singular."""

_SHOWN = 3

_CORNER_DERIVATIVES = np.array(
    # d/dr and d/ds of the six shape functions at the corners and the mid-sides
    [
        [[4.0 * r + 4.0 * s - 3.0, 4.0 * r - 1.0, 0.0, 4.0 - 8.0 * r - 4.0 * s, 4.0 * s, -4.0 * s],
         [4.0 * r + 4.0 * s - 3.0, 0.0, 4.0 * s - 1.0, -4.0 * r, 4.0 * r, 4.0 - 4.0 * r - 8.0 * s]]
        for r, s in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5))
    ]
)  # fmt: skip


def jacobians(nodes: FloatArray, triangles: IndexArray) -> FloatArray:
    """Determinant of the Jacobian at the six nodes of each triangle, (e, 6); all positive in a sound mesh."""
    derivatives = np.einsum("pdk,ekx->epdx", _CORNER_DERIVATIVES, nodes[triangles])
    found: FloatArray = np.linalg.det(derivatives)
    return found


def corner_angles(nodes: FloatArray, triangles: IndexArray) -> FloatArray:
    """Angles at the corners between straight sides, degree, (e, 3)."""
    corners = nodes[triangles[:, :3]]
    to_next = np.roll(corners, -1, axis=1) - corners
    to_last = np.roll(corners, 1, axis=1) - corners
    cross = to_next[..., 0] * to_last[..., 1] - to_next[..., 1] * to_last[..., 0]
    found: FloatArray = np.degrees(np.arctan2(cross, np.sum(to_next * to_last, axis=2)))
    return found


def check_mesh(mesh: Mesh) -> None:
    """Refuse an unsound mesh.

    Raises
    ------
    MeshError
        Names every fault of :func:`mesh_faults`.
    """
    faults = mesh_faults(mesh)
    if faults:
        raise MeshError("; ".join(faults))


def mesh_faults(mesh: Mesh) -> list[str]:
    """Find clockwise or folded triangles, slivers, mid-side nodes off their place, unconnected and doubled nodes.

    Also boundaries that are no edges of the body, and interfaces whose sides do not lie on one another.
    """
    if mesh.triangles.size == 0:
        return ["the mesh has no triangle"]
    count = mesh.nodes.shape[0]
    for name, table in (("triangle", mesh.triangles), ("interface", mesh.interfaces), *_edges_of(mesh)):
        if table.size and (table.min() < 0 or table.max() >= count):
            wrong = int(table.max() if table.max() >= count else table.min())
            return [f"{name}: node {wrong} does not exist; nodes 0 to {count - 1} do"]
    if not np.isfinite(mesh.nodes).all():
        return [f"node {int(np.argmin(np.isfinite(mesh.nodes).all(axis=1)))} has a coordinate that is not finite"]
    return [
        *_shape_faults(mesh),
        *_node_faults(mesh),
        *_interface_faults(mesh),
        *_boundary_faults(mesh),
        *_name_faults(mesh),
    ]


def _edges_of(mesh: Mesh) -> list[tuple[str, IndexArray]]:
    return [(f"boundary {name}", edges) for name, edges in mesh.boundaries.items()]


def _where(mesh: Mesh, triangle: int) -> str:
    x, y = mesh.nodes[mesh.triangles[triangle, :3]].mean(axis=0)
    return f"triangle {triangle} in region {mesh.region_names[mesh.regions[triangle]]} near ({x:.5g}, {y:.5g})"


def _listed(numbers: IntArray) -> str:
    shown = ", ".join(str(int(number)) for number in numbers[:_SHOWN])
    return shown if len(numbers) <= _SHOWN else f"{shown} ... ({len(numbers)} in all)"


def _shape_faults(mesh: Mesh) -> list[str]:
    angles = corner_angles(mesh.nodes, mesh.triangles)
    clockwise = np.flatnonzero(angles.min(axis=1) <= 0.0)
    if clockwise.size:
        return [
            f"{_where(mesh, int(clockwise[0]))} has no area or runs clockwise "
            f"({clockwise.size} of {len(angles)}); corners counter-clockwise are accepted"
        ]
    faults = []
    sharpest = angles.min(axis=1)
    if sharpest.min() < SHARPEST:
        worst = int(np.argmin(sharpest))
        faults.append(
            f"{_where(mesh, worst)} is a sliver: its smallest angle is {sharpest[worst]:.2g} degree; "
            f"{SHARPEST:g} degree or more is accepted"
        )
    for start, end, mid in EDGES:
        ends = mesh.nodes[mesh.triangles[:, start]], mesh.nodes[mesh.triangles[:, end]]
        off = np.linalg.norm(mesh.nodes[mesh.triangles[:, mid]] - 0.5 * (ends[0] + ends[1]), axis=1)
        length = np.linalg.norm(ends[1] - ends[0], axis=1)  # 0 where it is too small for its square
        off = np.divide(off, length, out=np.where(off > 0.0, np.inf, 0.0), where=length > 0.0)
        if off.max() > _OFF_CENTRE:
            worst = int(np.argmax(off))
            faults.append(
                f"{_where(mesh, worst)}: mid-side node {mesh.triangles[worst, mid]} lies {off[worst]:.2g} lengths of "
                f"its edge from the middle; at most {_OFF_CENTRE:g} is accepted"
            )
            break
    folded = np.flatnonzero(jacobians(mesh.nodes, mesh.triangles).min(axis=1) <= 0.0)
    if folded.size and not faults:
        faults.append(f"{_where(mesh, int(folded[0]))} is folded: its curved sides cross")
    return faults


def _node_faults(mesh: Mesh) -> list[str]:
    faults = []
    used = np.zeros(mesh.nodes.shape[0], dtype=np.bool_)
    used[mesh.triangles.ravel()] = True
    if not used.all():
        faults.append(f"nodes {_listed(np.flatnonzero(~used).astype(np.int64))} belong to no triangle")
    size = float(np.ptp(mesh.nodes, axis=0).max())
    grid = np.round(mesh.nodes / (1e-9 * size)).astype(np.int64)
    _, place, times = np.unique(grid, axis=0, return_inverse=True, return_counts=True)
    doubled = times[place.ravel()] > 1
    doubled[mesh.interfaces.ravel()] = False
    if doubled.any():
        faults.append(
            f"nodes {_listed(np.flatnonzero(doubled).astype(np.int64))} lie on other nodes without an "
            "interface between them: merge them, or name the line between them as an interface"
        )
    return faults


def _interface_faults(mesh: Mesh) -> list[str]:
    if not mesh.interfaces.size:
        return []
    apart = np.abs(mesh.nodes[mesh.interfaces[:, :3]] - mesh.nodes[mesh.interfaces[:, 3:]]).max(axis=(1, 2))
    wrong = np.flatnonzero(apart > 1e-9 * np.ptp(mesh.nodes, axis=0).max())
    if not wrong.size:
        return []
    first = int(wrong[0])
    name = mesh.interface_names[mesh.interface_regions[first]]
    return [f"interface {name}: its sides lie {apart[first]:.3g} m apart; sides that lie on one another are accepted"]


def _boundary_faults(mesh: Mesh) -> list[str]:
    edges = np.concatenate([mesh.triangles[:, list(edge)] for edge in EDGES])
    known = {(int(a), int(b), int(c)) for a, b, c in edges}
    return [
        f"boundary {name}: nodes {start}, {end}, {mid} are not an edge of a triangle on its left"
        for name, table in mesh.boundaries.items()
        for start, end, mid in table.tolist()
        if (start, end, mid) not in known
    ][:_SHOWN]


def _name_faults(mesh: Mesh) -> list[str]:
    names = (*mesh.region_names, *mesh.interface_names)
    twice = sorted({name for name in names if names.count(name) > 1})
    return [f"the name {name} is given to two regions or interfaces" for name in twice]
