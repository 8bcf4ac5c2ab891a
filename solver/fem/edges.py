"""Surface tractions as nodal forces: on the mesh as it is, or following it."""

from __future__ import annotations

from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.fem.body import Body
from geoswarm.solver.fem.mesh.mesh import IndexArray
from geoswarm.solver.kernels.jit import kernel

__all__ = ["LOAD_NUMBERS", "assemble_edges", "edge_forces"]

LOAD_NUMBERS: Final = 7
"""Numbers of a load on an edge: normal, x, y, their slopes over the height, and the level where they hold."""

_POINTS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)])
_WEIGHTS: Final = np.array([5 / 9, 8 / 9, 5 / 9])
_SHAPES: Final = np.column_stack([_POINTS * (_POINTS - 1) / 2, _POINTS * (_POINTS + 1) / 2, 1 - _POINTS**2])
_SLOPES: Final = np.column_stack([_POINTS - 0.5, _POINTS + 0.5, -2 * _POINTS])


@kernel
def edge_forces(
    edges: IndexArray, loads: FloatArray, positions: FloatArray, axisymmetric: bool, force: FloatArray
) -> None:
    """Add the nodal forces (2 n,) of loads (q, LOAD_NUMBERS) on edges (q, 3) at node positions (n, 2).

    Axial symmetry: kN/rad.
    """
    for e in range(edges.shape[0]):
        for point in range(3):
            px, py, tx, ty = 0.0, 0.0, 0.0, 0.0
            for n in range(3):
                node = edges[e, n]
                px += _SHAPES[point, n] * positions[node, 0]
                py += _SHAPES[point, n] * positions[node, 1]
                tx += _SLOPES[point, n] * positions[node, 0]
                ty += _SLOPES[point, n] * positions[node, 1]
            height = py - loads[e, 6]
            normal = loads[e, 0] + loads[e, 3] * height
            length = np.sqrt(tx * tx + ty * ty)
            # The body is on the left: (ty, -tx) points outward and carries the length.
            fx = normal * ty + (loads[e, 1] + loads[e, 4] * height) * length
            fy = -normal * tx + (loads[e, 2] + loads[e, 5] * height) * length
            weight = _WEIGHTS[point] * (px if axisymmetric else 1.0)
            for n in range(3):
                force[2 * edges[e, n]] += weight * _SHAPES[point, n] * fx
                force[2 * edges[e, n] + 1] += weight * _SHAPES[point, n] * fy


@kernel
def assemble_edges(
    body: Body,
    loads: FloatArray,
    positions: FloatArray,
    fixed: BoolArray,
    tangents: FloatArray,
) -> None:
    """Subtract the derivative of follower loads (q, LOAD_NUMBERS) by the positions (n, 2) from the tangents."""
    K = np.empty((6, 6))
    for e in range(body.edges.shape[0]):
        K[:, :] = 0.0
        for point in range(3):
            px, py, tx, ty = 0.0, 0.0, 0.0, 0.0
            for n in range(3):
                node = body.edges[e, n]
                px += _SHAPES[point, n] * positions[node, 0]
                py += _SHAPES[point, n] * positions[node, 1]
                tx += _SLOPES[point, n] * positions[node, 0]
                ty += _SLOPES[point, n] * positions[node, 1]
            height = py - loads[e, 6]
            normal = loads[e, 0] + loads[e, 3] * height
            along_x = loads[e, 1] + loads[e, 4] * height
            along_y = loads[e, 2] + loads[e, 5] * height
            length = np.sqrt(tx * tx + ty * ty)
            fx, fy = normal * ty + along_x * length, -normal * tx + along_y * length
            radius = px if body.axisymmetric else 1.0
            for k in range(3):
                shape, slope = _SHAPES[point, k], _SLOPES[point, k]
                for i in range(2):
                    dfx, dfy = 0.0, 0.0
                    if i == 0:
                        stretch = slope * tx / length
                        dfx = radius * along_x * stretch
                        dfy = radius * (along_y * stretch - normal * slope)
                        if body.axisymmetric:
                            dfx += shape * fx
                            dfy += shape * fy
                    else:
                        stretch = slope * ty / length
                        dfx = radius * (along_x * stretch + normal * slope)
                        dfy = radius * along_y * stretch
                        dfx += radius * shape * (loads[e, 3] * ty + loads[e, 4] * length)
                        dfy += radius * shape * (loads[e, 5] * length - loads[e, 3] * tx)
                    for n in range(3):
                        weight = _WEIGHTS[point] * _SHAPES[point, n]
                        K[2 * n, 2 * k + i] += weight * dfx
                        K[2 * n + 1, 2 * k + i] += weight * dfy
        tangent, place = tangents[body.edge_elements[e]], body.edge_places[e]
        for a in range(3):
            for i in range(2):
                if fixed[2 * body.edges[e, a] + i]:
                    continue
                for b in range(3):
                    for j in range(2):
                        tangent[2 * place[a] + i, 2 * place[b] + j] -= K[2 * a + i, 2 * b + j]
