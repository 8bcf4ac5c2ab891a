"""Reads meshes of triangles that other programs made, through meshio. Needs the extra ``mesh``.

Regions, boundaries, interfaces and points are found by their physical names (gmsh) or by the names of sets (Abaqus and
others): of triangles, lines, lines again, and vertices.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.checks import check_mesh
from geoswarm.solver.fem.mesh.mesh import EDGES, IndexArray, Mesh, midpoints, six_node_triangles
from geoswarm.solver.fem.mesh.split import split_along
from geoswarm.solver.system.extras import needs_extra

__all__ = ["load_meshio", "mesh_of_tables", "read_mesh"]

_PHYSICAL = "gmsh:physical"
_DIMENSION = {"triangle": 2, "triangle6": 2, "line": 1, "line3": 1, "vertex": 0}


def load_meshio(purpose: str) -> Any:
    """Import meshio.

    Raises
    ------
    MeshError
        It is not installed; the message says how to.
    """
    try:
        return importlib.import_module("meshio")
    except ImportError as error:
        raise MeshError(needs_extra(purpose, "meshio")) from error


def read_mesh(path: Path, interfaces: Sequence[str] = (), scale: float = 1.0, *, keep_lines: bool = False) -> Mesh:
    """Read a mesh of triangles.

    Three-node triangles get mid-side nodes halfway along their straight edges; clockwise ones are turned round.

    Parameters
    ----------
    interfaces
        Names of lines inside the body along which it is opened. Other lines inside the body are left out.
    scale
        Length of the file's unit, m.
    keep_lines
        Whether lines inside the body stay among the boundaries, for those who open the mesh later.

    Raises
    ------
    MeshError
        The file cannot be read, has other elements than triangles, has no name for some triangles, or is not sound.
    """
    meshio = load_meshio(f"{path}: reading a mesh")
    if not path.is_file():
        raise MeshError(f"{path}: no such file")
    errors = (meshio.ReadError, OSError, ValueError, KeyError, IndexError, AssertionError, SystemExit)
    try:
        content = meshio.read(path)
    except errors as error:
        reason = str(error) or type(error).__name__
        raise MeshError(f"{path}: cannot be read as a mesh: {reason}") from error
    try:
        return _assembled(_Content.of(content), tuple(interfaces), scale, keep_lines)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def mesh_of_tables(
    nodes: FloatArray,
    triangles: IntArray,
    regions: Sequence[str],
    lines: Mapping[str, Sequence[Sequence[int]]],
    points: Mapping[str, int],
    interfaces: Sequence[str] = (),
) -> Mesh:
    """Make a mesh from tables, as a problem file carries them.

    Parameters
    ----------
    nodes
        (n, 2), m.
    triangles
        (e, 3) or (e, 6) nodes of each triangle.
    regions
        Name of the region of each triangle.
    lines
        By name, corners (start, end) of edges; those named in ``interfaces`` open the body.
    points
        Named nodes.

    Raises
    ------
    MeshError
        The mesh is not sound.
    """
    tables = {
        "triangles": triangles,
        **{f"line {name}": np.array(edges) for name, edges in lines.items()},
        **{f"point {name}": np.array([node]) for name, node in points.items()},
    }
    for what, table in tables.items():
        wrong = table[(table < 0) | (table >= len(nodes))]
        if wrong.size:
            raise MeshError(f"{what}: node {wrong[0]} does not exist; nodes 0 to {len(nodes) - 1} do")
    content = _Content(
        nodes,
        triangles,
        list(regions),
        {name: np.array([line[:2] for line in edges], dtype=np.int64).reshape(-1, 2) for name, edges in lines.items()},
        dict(points),
    )
    return _assembled(content, tuple(interfaces), 1.0, False)


@dataclass
class _Content:
    """What a file holds: nodes (n, 2), triangles (e, 3) or (e, 6), a name each, lines (m, 2) and points by name."""

    nodes: FloatArray
    triangles: IntArray
    regions: list[str]
    lines: dict[str, IntArray] = field(default_factory=dict)
    points: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of(cls, content: Any) -> _Content:
        others = sorted({block.type for block in content.cells} - _DIMENSION.keys())
        if others:
            raise MeshError(f"elements of type {', '.join(others)}: only triangles of 3 or 6 nodes are accepted")
        kinds = sorted({block.type for block in content.cells if _DIMENSION[block.type] == 2})
        if len(kinds) != 1:
            raise MeshError(
                "triangles of 3 and of 6 nodes are mixed; one kind is accepted" if kinds else "there are no triangles"
            )
        points = np.asarray(content.points, dtype=np.float64)
        if points.shape[1] > 2 and np.ptp(points[:, 2]) > 1e-9 * max(np.ptp(points[:, :2], axis=0)):
            raise MeshError("the nodes do not lie in the plane of x and y; z must be the same everywhere")
        found = cls(points[:, :2].copy(), np.empty((0, 0), dtype=np.int64), [])
        triangles = []
        for number, block in enumerate(content.cells):
            names = _names(content, number, block)
            data = np.asarray(block.data, dtype=np.int64)
            if _DIMENSION[block.type] == 2:
                if not all(names):
                    raise MeshError(
                        f"{sum(not name for name in names)} triangles belong to no named region (physical surface)"
                    )
                triangles.append(data)
                found.regions += [str(name) for name in names]
            else:
                found._collect(data, names)
        found.triangles = np.concatenate(triangles)
        return found

    def _collect(self, data: IntArray, names: Sequence[str | None]) -> None:
        for nodes, name in zip(data.tolist(), names, strict=True):
            if name is None:
                continue
            if len(nodes) == 1:
                self.points[name] = nodes[0]
            else:
                known = self.lines.get(name, np.empty((0, 2), dtype=np.int64))
                self.lines[name] = np.concatenate([known, [nodes[:2]]])


def _names(content: Any, number: int, block: Any) -> list[str | None]:
    """Name of the group of each element of a block."""
    names: list[str | None] = [None] * len(block.data)
    tags = content.cell_data.get(_PHYSICAL)
    if tags is not None:
        dimension = _DIMENSION[block.type]
        known = {
            int(values[0]): name
            for name, values in content.field_data.items()
            if len(values) == 2 and int(values[1]) == dimension
        }
        return [known.get(int(tag), f"group_{int(tag)}") if tag else None for tag in tags[number]]
    for name, sets in content.cell_sets.items():
        if number < len(sets) and sets[number] is not None:
            for element in np.asarray(sets[number]).ravel().tolist():
                names[int(element)] = name
    return names


def _assembled(content: _Content, interfaces: tuple[str, ...], scale: float, keep_lines: bool) -> Mesh:
    unknown = [name for name in interfaces if name not in content.lines]
    if unknown:
        known = ", ".join(content.lines) or "none"
        raise MeshError(f"interface {unknown[0]}: no line has this name; named lines: {known}")
    nodes, triangles = _six_node(content.nodes * scale, _turned(content.nodes, content.triangles))
    nodes, triangles, kept = _without_unused(nodes, triangles)
    names = tuple(dict.fromkeys(content.regions))
    sides = _sides(triangles)
    lines = {
        name: [(int(kept[a]), int(kept[b])) for a, b in edges.tolist() if kept[a] >= 0 and kept[b] >= 0]
        for name, edges in content.lines.items()
    }
    mesh = Mesh(
        nodes=nodes,
        triangles=triangles,
        regions=np.array([names.index(name) for name in content.regions], dtype=np.int32),
        region_names=names,
        boundaries=_boundaries(
            {name: edges for name, edges in lines.items() if name not in interfaces}, sides, keep_lines
        ),
        points={name: int(kept[node]) for name, node in content.points.items() if kept[node] >= 0},
    )
    if interfaces:
        cuts = {name: np.array(lines[name], dtype=np.int32).reshape(-1, 2) for name in interfaces}
        mesh, _ = split_along(mesh, cuts)
    check_mesh(mesh)
    return mesh


def _turned(nodes: FloatArray, triangles: IntArray) -> IntArray:
    """All triangles counter-clockwise."""
    a, b, c = (nodes[triangles[:, n]] for n in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    order = [0, 2, 1] if triangles.shape[1] == 3 else [0, 2, 1, 5, 4, 3]
    return np.where((area < 0.0)[:, None], triangles[:, order], triangles)


def _six_node(nodes: FloatArray, triangles: IntArray) -> tuple[FloatArray, IndexArray]:
    if triangles.shape[1] == 6:
        return nodes, triangles.astype(np.int32)
    full, ends = six_node_triangles(triangles.astype(np.int32), nodes.shape[0])
    return np.concatenate([nodes, midpoints(nodes, ends)]), full


def _without_unused(nodes: FloatArray, triangles: IndexArray) -> tuple[FloatArray, IndexArray, IntArray]:
    """Leave out nodes of no triangle (centres of circles and other construction points of gmsh)."""
    used = np.unique(triangles)
    kept = np.full(nodes.shape[0], -1, dtype=np.int64)
    kept[used] = np.arange(used.size)
    return nodes[used], kept[triangles].astype(np.int32), kept


def _sides(triangles: IndexArray) -> dict[frozenset[int], list[tuple[int, int, int]]]:
    """Edges by their two corners, as the triangles on their left see them."""
    found: dict[frozenset[int], list[tuple[int, int, int]]] = {}
    for a, b, c in EDGES:
        for start, end, mid in triangles[:, [a, b, c]].tolist():
            found.setdefault(frozenset((start, end)), []).append((start, end, mid))
    return found


def _boundaries(
    lines: Mapping[str, list[tuple[int, int]]],
    sides: Mapping[frozenset[int], list[tuple[int, int, int]]],
    keep_lines: bool,
) -> dict[str, IndexArray]:
    boundaries = {}
    for name, edges in lines.items():
        owners = [sides.get(frozenset(edge), []) for edge in edges]
        if not all(owners):
            raise MeshError(f"line {name} is not a side of the triangles; interfaces must lie along their edges")
        outer = [owner[0] for owner in owners if len(owner) == 1 or keep_lines]
        if outer:
            boundaries[name] = np.array(outer, dtype=np.int32)
    return boundaries
