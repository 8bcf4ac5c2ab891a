"""Simple bodies of finite elements."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.mesh.mesh import Mesh, boundary_edges, midpoints, six_node_triangles

__all__ = ["block", "embankment", "graded", "moved", "node_at", "slope", "stacked"]


def graded(start: float, end: float, count: int, ratio: float = 1.0) -> FloatArray:
    """``count`` intervals from start to end, each ``ratio`` times as long as the one before."""
    lengths = ratio ** np.arange(count)
    return start + (end - start) * np.concatenate([[0.0], np.cumsum(lengths) / lengths.sum()])


def block(x: FloatArray, y: FloatArray, *, distortion: float = 0.0, name: str = "soil") -> Mesh:
    """Rectangle over lines x and y with two triangles a cell; inner corners moved by up to ``distortion`` of a cell."""
    grid_x, grid_y = np.meshgrid(x, y, indexing="ij")
    corners = np.column_stack([grid_x.ravel(), grid_y.ravel()])
    if distortion:
        inside = (grid_x > x[0]) & (grid_x < x[-1]) & (grid_y > y[0]) & (grid_y < y[-1])
        cell = np.array([np.diff(x).min(), np.diff(y).min()])
        change = np.random.default_rng(2).uniform(-distortion, distortion, corners.shape) * cell
        corners = corners + np.where(inside.ravel()[:, np.newaxis], change, 0.0)
    number = np.arange(corners.shape[0]).reshape(x.size, y.size)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    cells = np.concatenate(
        [np.column_stack([a.ravel(), b.ravel(), c.ravel()]), np.column_stack([a.ravel(), c.ravel(), d.ravel()])]
    ).astype(np.int32)
    triangles, ends = six_node_triangles(cells, corners.shape[0])
    nodes = np.concatenate([corners, midpoints(corners, ends)])
    edges = boundary_edges(triangles)
    at = nodes[edges[:, 2]]
    small = 1.0e-9 * max(x[-1] - x[0], y[-1] - y[0])
    boundaries = {
        "left": edges[at[:, 0] < x[0] + small],
        "right": edges[at[:, 0] > x[-1] - small],
        "bottom": edges[at[:, 1] < y[0] + small],
        "top": edges[at[:, 1] > y[-1] - small],
        "around": edges,
    }
    return Mesh(nodes, triangles, np.zeros(triangles.shape[0], dtype=np.int32), (name,), boundaries=boundaries)


def moved(mesh: Mesh, change: Callable[[FloatArray], FloatArray]) -> Mesh:
    """The mesh with other node positions: ``change`` maps (n, 2) to (n, 2)."""
    return Mesh(
        change(mesh.nodes),
        mesh.triangles,
        mesh.regions,
        mesh.region_names,
        mesh.interfaces,
        mesh.interface_regions,
        mesh.interface_names,
        mesh.boundaries,
        mesh.points,
    )


def stacked(lower: Mesh, upper: Mesh) -> Mesh:
    """``upper`` on ``lower`` with the interface "joint" between them; boundaries of the lower one have a prefix."""
    shift = lower.nodes.shape[0]
    bottom = {tuple(np.round(lower.nodes[node], 9)): node for node in np.unique(lower.boundaries["top"])}
    joint = []
    for start, end, mid in upper.boundaries["bottom"]:
        below = [bottom[tuple(np.round(upper.nodes[node], 9))] for node in (start, end, mid)]
        joint.append([start + shift, end + shift, mid + shift, *below])
    boundaries = {name: edges + shift for name, edges in upper.boundaries.items()}
    boundaries |= {f"lower {name}": edges for name, edges in lower.boundaries.items()}
    return Mesh(
        np.concatenate([lower.nodes, upper.nodes]),
        np.concatenate([lower.triangles, upper.triangles + shift]).astype(np.int32),
        np.concatenate([lower.regions, upper.regions + 1]).astype(np.int32),
        (*lower.region_names, *upper.region_names),
        np.array(joint, dtype=np.int32),
        np.zeros(len(joint), dtype=np.int32),
        ("joint",),
        {name: edges.astype(np.int32) for name, edges in boundaries.items()},
    )


def slope(crest: float, toe: float, below: float, columns: tuple[int, int, int], rows: int) -> Mesh:
    """Slope 2:1, 10 m high, between a level crest and a level toe, ``below`` metres of ground under the toe."""
    x = np.concatenate(
        [
            np.linspace(0.0, crest, columns[0] + 1),
            np.linspace(crest, crest + 20.0, columns[1] + 1)[1:],
            np.linspace(crest + 20.0, crest + 20.0 + toe, columns[2] + 1)[1:],
        ]
    )
    unit = block(np.arange(x.size, dtype=np.float64), np.linspace(0.0, 1.0, rows + 1))

    def change(nodes: FloatArray) -> FloatArray:
        across = np.interp(nodes[:, 0], np.arange(x.size), x)
        top = np.interp(across, [crest, crest + 20.0], [below + 10.0, below])
        return np.column_stack([across, nodes[:, 1] * top])

    return moved(unit, change)


def embankment(crest: float, columns: int, rows: int) -> Mesh:
    """Slope 2:1, 10 m high, on a rigid base at the level of its toe; "right" is its face."""
    unit = block(np.linspace(0.0, 1.0, columns + 1), np.linspace(0.0, 10.0, rows + 1))
    return moved(
        unit,
        lambda nodes: np.column_stack([nodes[:, 0] * (crest + 2.0 * (10.0 - nodes[:, 1])), nodes[:, 1]]),
    )


def node_at(mesh: Mesh, x: float, y: float) -> int:
    """Node at a place."""
    return int(np.argmin(np.hypot(mesh.nodes[:, 0] - x, mesh.nodes[:, 1] - y)))
