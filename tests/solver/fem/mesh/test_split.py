"""Opening a mesh along lines: which nodes are doubled, and how often."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.checks import mesh_faults
from geoswarm.solver.fem.mesh.mesh import IndexArray, Mesh, boundary_edges, midpoints, six_node_triangles
from geoswarm.solver.fem.mesh.split import split_along


def square(n: int = 4) -> Mesh:
    """A square of side n; corner (i, j) is number j (n + 1) + i."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    corners = np.stack([x.ravel(), y.ravel()], axis=1)
    cells = []
    for j in range(n):
        for i in range(n):
            a, b = j * (n + 1) + i, (j + 1) * (n + 1) + i
            cells += [(a, a + 1, b + 1), (a, b + 1, b)]
    triangles, ends = six_node_triangles(np.array(cells, dtype=np.int32), len(corners))
    nodes = np.concatenate([corners, midpoints(corners, ends)])
    regions = np.zeros(len(cells), dtype=np.int32)
    mesh = Mesh(nodes, triangles, regions, ("soil",), boundaries={"all": boundary_edges(triangles)})
    assert mesh_faults(mesh) == []
    return mesh


def line(*corners: int) -> IndexArray:
    return np.array([corners[:-1], corners[1:]], dtype=np.int32).T


def test_a_line_inside_has_two_tips_that_stay_one_node() -> None:
    mesh = square()
    opened, origin = split_along(mesh, {"crack": line(11, 12, 13)})
    assert mesh_faults(opened) == []
    assert sorted(origin[len(mesh.nodes) :].tolist())[0] == 12
    assert len(opened.nodes) == len(mesh.nodes) + 3
    first, second = opened.interfaces
    assert first[0] == first[3] == 11
    assert second[1] == second[4] == 13
    assert first[1] == second[0]
    assert first[4] == second[3] != first[1]


def test_side_a_is_on_the_left() -> None:
    opened, _ = split_along(square(), {"crack": line(10, 11, 12, 13, 14)})
    for side, above in ((opened.interfaces[:, :3], True), (opened.interfaces[:, 3:], False)):
        triangles = opened.triangles[np.isin(opened.triangles, side[:, 2]).any(axis=1)]
        heights = opened.nodes[triangles[:, :3], 1].mean(axis=1)
        assert len(triangles) == 4
        assert ((heights > 2.0) == above).all()


def test_a_line_from_side_to_side_divides_the_body() -> None:
    mesh = square()
    opened, _ = split_along(mesh, {"joint": line(10, 11, 12, 13, 14)})
    upper = opened.nodes[opened.triangles[:, :3], 1].mean(axis=1) > 2.0
    assert not set(opened.triangles[upper].ravel().tolist()) & set(opened.triangles[~upper].ravel().tolist())
    edges = {tuple(edge) for edge in boundary_edges(opened.triangles).tolist()}
    assert {tuple(edge) for edge in opened.boundaries["all"].tolist()} <= edges


def test_where_lines_cross_or_meet_a_node_is_doubled_for_each_part() -> None:
    mesh = square()
    crossing, origin = split_along(mesh, {"h": line(10, 11, 12, 13, 14), "v": line(2, 7, 12, 17, 22)})
    assert mesh_faults(crossing) == []
    assert np.count_nonzero(origin == 12) == 4
    meeting, origin = split_along(mesh, {"h": line(10, 11, 12, 13, 14), "v": line(12, 17, 22)})
    assert mesh_faults(meeting) == []
    assert np.count_nonzero(origin == 12) == 3
    assert meeting.interface_names == ("h", "v")


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ({"crack": line(0, 1)}, "interface crack: the line from .0, 0. to .1, 0. is not an edge between two"),
        ({"crack": line(0, 12)}, "is not an edge between two"),
        ({"one": line(11, 12), "two": line(12, 11)}, "one and two lie on the same edge"),
    ],
)
def test_lines_that_are_no_inner_edges_are_refused(lines: dict[str, IndexArray], words: str) -> None:
    with pytest.raises(MeshError, match=words):
        split_along(square(), lines)
