"""Opens a mesh along lines: nodes are doubled, and interfaces lie between the two sides.

A node is doubled as often as the lines through it divide the triangles around it. So the end of a line inside the body
stays one node (the tip), lines may meet or cross, and a line that reaches the boundary opens it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.mesh import EDGES, IndexArray, Mesh

__all__ = ["split_along"]


def split_along(mesh: Mesh, lines: Mapping[str, IndexArray]) -> tuple[Mesh, IndexArray]:
    """Open a mesh without interfaces along lines.

    Parameters
    ----------
    lines
        By the name of the interface: edges (m, 2), start and end corner, inside the body.

    Returns
    -------
    mesh
        With interfaces; nodes keep their numbers, doubled ones are appended.
    origin
        (n,): the node of the given mesh of which each node is a copy.

    Raises
    ------
    MeshError
        An edge is not one between two triangles, or a named point lies on a line that doubles it.
    """
    opening = _Opening(mesh)
    for name, edges in lines.items():
        opening.add(name, edges)
    triangles, origin = opening.double()
    doubled = set(origin[mesh.nodes.shape[0] :].tolist())
    for name, node in mesh.points.items():
        if node in doubled:
            raise MeshError(f"point {name} lies on an interface, where it would be two; move it to one side")
    interfaces = [opening.interface(triangles, key) for key in opening.cut]
    names = tuple(lines)
    owner = opening.owners
    boundaries = {
        name: np.array([_edge_of(triangles, *owner[_key(a, b)][0]) for a, b, _ in edges.tolist()], dtype=np.int32)
        for name, edges in mesh.boundaries.items()
    }
    opened = replace(
        mesh,
        nodes=mesh.nodes[origin],
        triangles=triangles,
        interfaces=np.array(interfaces, dtype=np.int32).reshape(-1, 6),
        interface_regions=np.array([names.index(name) for name in opening.cut.values()], dtype=np.int32),
        interface_names=names,
        boundaries=boundaries,
    )
    return opened, origin


def _key(a: int, b: int) -> tuple[int, int]:
    return (a, b) if a < b else (b, a)


def _edge_of(triangles: IndexArray, triangle: int, edge: int) -> list[int]:
    found: list[int] = triangles[triangle, list(EDGES[edge])].tolist()
    return found


class _Opening:
    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh
        self.owners: dict[tuple[int, int], list[tuple[int, int]]] = {}  # corners -> (triangle, edge) that have them
        for triangle, corners in enumerate(mesh.triangles[:, :3].tolist()):
            for edge, (a, b, _) in enumerate(EDGES):
                self.owners.setdefault(_key(corners[a], corners[b]), []).append((triangle, edge))
        self.cut: dict[tuple[int, int], str] = {}  # in the order of the lines
        self._direction: dict[tuple[int, int], tuple[int, int]] = {}

    def add(self, name: str, edges: IndexArray) -> None:
        for start, end in edges.tolist():
            key = _key(start, end)
            if len(self.owners.get(key, ())) != 2:
                (x, y), (z, w) = self._mesh.nodes[[start, end]].tolist()
                raise MeshError(
                    f"interface {name}: the line from ({x:.6g}, {y:.6g}) to ({z:.6g}, {w:.6g}) is not an edge between "
                    "two triangles; an interface lies inside the body, along edges"
                )
            if key in self.cut:
                raise MeshError(f"interfaces {self.cut[key]} and {name} lie on the same edge; one of them is accepted")
            self.cut[key] = name
            self._direction[key] = (start, end)

    def double(self) -> tuple[IndexArray, IndexArray]:
        """Renumber the triangles; the origin of every node, the new ones included."""
        triangles = self._mesh.triangles.copy()
        origin = list(range(self._mesh.nodes.shape[0]))
        corners = sorted({node for key in self.cut for node in key})
        around: dict[int, list[int]] = {node: [] for node in corners}
        for triangle, nodes in enumerate(self._mesh.triangles[:, :3].tolist()):
            for node in nodes:
                if node in around:
                    around[node].append(triangle)
        for node in corners:
            for group in self._groups(node, around[node])[1:]:
                for triangle in group:
                    triangles[triangle, self._mesh.triangles[triangle] == node] = len(origin)
                origin.append(node)
        for key in self.cut:
            (first, edge), (second, other) = sorted(self.owners[key])
            triangles[second, EDGES[other][2]] = len(origin)
            origin.append(int(self._mesh.triangles[first, EDGES[edge][2]]))
        return triangles, np.array(origin, dtype=np.int32)

    def _groups(self, node: int, triangles: list[int]) -> list[list[int]]:
        """Triangles around a node in groups that hang together without crossing a line, that of the first one first."""
        group = {triangle: triangle for triangle in triangles}

        def root(triangle: int) -> int:
            while group[triangle] != triangle:
                triangle = group[triangle]
            return triangle

        for triangle in triangles:
            for other in self._mesh.triangles[triangle, :3].tolist():
                key = _key(node, other)
                owners = self.owners.get(key, [])
                if other != node and key not in self.cut and len(owners) == 2:
                    low, high = sorted((root(owners[0][0]), root(owners[1][0])))
                    group[high] = low
        found: dict[int, list[int]] = {}
        for triangle in triangles:
            found.setdefault(root(triangle), []).append(triangle)
        return list(found.values())

    def interface(self, triangles: IndexArray, key: tuple[int, int]) -> list[int]:
        """Nodes of both sides; an edge of a triangle runs with the triangle on its left, which makes it side A."""
        start, _ = self._direction[key]
        sides = {}
        for triangle, edge in self.owners[key]:
            a, b, mid = EDGES[edge]
            runs_along = self._mesh.triangles[triangle, a] == start
            ends = (a, b) if runs_along else (b, a)
            sides["A" if runs_along else "B"] = triangles[triangle, [*ends, mid]].tolist()
        return [*sides["A"], *sides["B"]]
