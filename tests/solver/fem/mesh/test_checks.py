"""Every fault that a mesh can have is found and named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.checks import check_mesh, corner_angles, jacobians, mesh_faults
from geoswarm.solver.fem.mesh.mesh import Mesh

NODES = np.array([[0, 0], [4, 0], [4, 3], [0, 3], [2, 0], [4, 1.5], [2, 1.5], [2, 3], [0, 1.5]], dtype=np.float64)
TRIANGLES = np.array([[0, 1, 2, 4, 5, 6], [0, 2, 3, 6, 7, 8]], dtype=np.int32)


def two_triangles() -> Mesh:
    return Mesh(
        NODES.copy(),
        TRIANGLES.copy(),
        np.array([0, 1], dtype=np.int32),
        ("lower", "upper"),
        boundaries={"bottom": np.array([[0, 1, 4]], dtype=np.int32)},
    )


def with_node(number: int, x: float, y: float) -> Mesh:
    mesh = two_triangles()
    mesh.nodes[number] = x, y
    return mesh


def turned() -> Mesh:
    mesh = two_triangles()
    mesh.triangles[1] = mesh.triangles[1][[0, 2, 1, 5, 4, 3]]
    return mesh


def with_spare_node() -> Mesh:
    mesh = two_triangles()
    return replace(mesh, nodes=np.concatenate([mesh.nodes, [[9.0, 9.0]]]))


def with_doubled_nodes() -> Mesh:
    """The second triangle hangs on copies of nodes 0, 2 and 6."""
    mesh = two_triangles()
    mesh.triangles[1] = [9, 10, 3, 11, 7, 8]
    return replace(mesh, nodes=np.concatenate([mesh.nodes, mesh.nodes[[0, 2, 6]]]))


def with_interface(shift: float) -> Mesh:
    mesh = with_doubled_nodes()
    mesh.nodes[9:] += shift
    return replace(
        mesh,
        interfaces=np.array([[9, 10, 11, 0, 2, 6]], dtype=np.int32),
        interface_regions=np.zeros(1, dtype=np.int32),
        interface_names=("joint",),
    )


def test_a_sound_mesh_has_no_fault() -> None:
    assert mesh_faults(two_triangles()) == []
    assert mesh_faults(with_interface(0.0)) == []
    check_mesh(two_triangles())


def test_shapes_are_measured_as_they_are() -> None:
    """A triangle with the sides 3, 4, 5: twice the area is 12 everywhere, the angles are known."""
    mesh = two_triangles()
    assert jacobians(mesh.nodes, mesh.triangles) == pytest.approx(12.0, rel=1e-12)
    expected = np.degrees([np.arctan2(3.0, 4.0), np.pi / 2.0, np.arctan2(4.0, 3.0)])
    assert corner_angles(mesh.nodes, mesh.triangles)[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("faulty", "words"),
    [
        (turned, "triangle 1 in region upper near .* runs clockwise"),
        (
            lambda: replace(two_triangles(), nodes=NODES * [1.0, 0.01]),
            "triangle 0 in region lower .* is a sliver: its smallest angle is 0.43",
        ),
        (lambda: with_node(4, 1.0, 0.0), "mid-side node 4 lies 0.25 lengths of its edge from the middle"),
        (lambda: with_node(8, 0.0, np.nan), "node 8 has a coordinate that is not finite"),
        (with_spare_node, "nodes 9 belong to no triangle"),
        (with_doubled_nodes, r"nodes 0, 2, 6 ... \(6 in all\) lie on other nodes without an interface"),
        (lambda: with_interface(0.01), "interface joint: its sides lie 0.01 m apart"),
        (
            lambda: replace(two_triangles(), boundaries={"wall": np.array([[1, 0, 4]], dtype=np.int32)}),
            "boundary wall: nodes 1, 0, 4 are not an edge of a triangle on its left",
        ),
        (
            lambda: replace(two_triangles(), boundaries={"wall": np.array([[1, 0, 40]], dtype=np.int32)}),
            "boundary wall: node 40 does not exist; nodes 0 to 8 do",
        ),
        (lambda: replace(two_triangles(), region_names=("clay", "clay")), "the name clay is given to two"),
        (lambda: replace(two_triangles(), triangles=np.empty((0, 6), dtype=np.int32)), "the mesh has no triangle"),
    ],
)
def test_every_fault_is_named(faulty: Callable[[], Mesh], words: str) -> None:
    with pytest.raises(MeshError, match=words):
        check_mesh(faulty())


def test_a_folded_triangle_is_found() -> None:
    """Each mid-side node is near enough to its place, yet the curved sides cross."""
    mesh = two_triangles()
    mesh.nodes[6] += [-0.6, 0.75]
    mesh.nodes[8] += [0.55, 0.0]
    assert any("is folded" in fault for fault in mesh_faults(mesh))
