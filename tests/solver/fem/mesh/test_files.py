"""Meshes read from files of other programs, and results written for ParaView and read back."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np
import pytest

from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.checks import mesh_faults
from geoswarm.solver.fem.mesh.layered import LayeredMesh
from geoswarm.solver.fem.mesh.reading import mesh_of_tables, read_mesh
from geoswarm.solver.fem.mesh.writing import Snapshot, write_pvd, write_vtu
from tests.solver.fem.mesh.sections import area_of, creeping_slope, profile

GMSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
5
0 9 "top_right"
1 4 "base"
1 5 "joint"
2 7 "clay"
2 8 "sand"
$EndPhysicalNames
$Nodes
7
1 0 0 0
2 2 0 0
3 2 1 0
4 0 1 0
5 2 2 0
6 0 2 0
7 5 5 0
$EndNodes
$Elements
8
1 15 2 9 1 5
2 1 2 4 1 2 1
3 1 2 5 2 4 3
4 2 2 7 1 1 2 3
5 2 2 7 1 1 4 3
6 2 2 8 2 4 3 5
7 2 2 8 2 4 5 6
8 15 2 9 1 5
$EndElements
"""


def gmsh(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    text = GMSH
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "body.msh"
    path.write_text(text, encoding="ascii")
    return path


def test_gmsh_names_regions_boundaries_and_points(tmp_path: Path) -> None:
    """Two layers of 2 m2 each; one triangle runs clockwise, node 7 is a construction point."""
    mesh = read_mesh(gmsh(tmp_path))
    assert mesh.region_names == ("clay", "sand")
    assert area_of(mesh, "clay") == pytest.approx(2.0, rel=1e-12)
    assert area_of(mesh, "sand") == pytest.approx(2.0, rel=1e-12)
    assert set(mesh.boundaries) == {"base"}
    start, end, mid = mesh.nodes[mesh.boundaries["base"][0]]
    assert (start.tolist(), end.tolist(), mid.tolist()) == ([0.0, 0.0], [2.0, 0.0], [1.0, 0.0])
    assert mesh.nodes[mesh.points["top_right"]].tolist() == [2.0, 2.0]
    assert mesh.nodes.shape == (15, 2)


def test_a_named_line_becomes_an_interface(tmp_path: Path) -> None:
    mesh = read_mesh(gmsh(tmp_path), interfaces=["joint"], scale=0.1)
    assert mesh.interface_names == ("joint",)
    assert mesh.interfaces.shape == (1, 6)
    assert mesh.nodes.shape == (18, 2)
    assert area_of(mesh) == pytest.approx(0.04, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ((("4 2 2 7 1 1 2 3", "4 3 2 7 1 1 2 3 4"),), "elements of type quad: only triangles of 3 or 6 nodes"),
        ((("5 2 2 0", "5 2 2 1"),), "do not lie in the plane"),
        ((("6 2 2 8 2 4 3 5", "6 2 2 0 2 4 3 5"),), "1 triangles belong to no named region"),
        ((("3 1 2 5 2 4 3", "3 1 2 4 2 1 5"),), "line base is not a side of the triangles"),
        ((("$EndMeshFormat", "$End"), ("2.2 0 8", "nonsense")), "cannot be read as a mesh"),
    ],
)
def test_files_that_are_no_such_mesh_are_refused(
    changes: tuple[tuple[str, str], ...], words: str, tmp_path: Path
) -> None:
    with pytest.raises(MeshError, match=rf"body\.msh: .*{words}"):
        read_mesh(gmsh(tmp_path, *changes))


def test_unknown_files_and_names_are_named(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"absent\.msh: no such file"):
        read_mesh(tmp_path / "absent.msh")
    with pytest.raises(MeshError, match="interface fault: no line has this name; named lines: base, joint"):
        read_mesh(gmsh(tmp_path), interfaces=["fault"])


def test_six_node_triangles_of_a_file_keep_their_curved_sides(tmp_path: Path) -> None:
    nodes = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, -0.1, 0], [1.05, 1.05, 0], [0, 1, 0]], dtype=np.float64)
    content = meshio.Mesh(nodes, [("triangle6", [[0, 1, 2, 3, 4, 5]])], cell_sets={"soil": [np.array([0])]})
    path = tmp_path / "curved.inp"
    content.write(path)
    mesh = read_mesh(path)
    assert mesh.region_names == ("soil",)
    assert mesh.nodes[mesh.triangles[0]].tolist() == nodes[:, :2].tolist()


def test_tables_make_the_same_mesh_as_the_file(tmp_path: Path) -> None:
    from_file = read_mesh(gmsh(tmp_path), interfaces=["joint"])
    made = mesh_of_tables(
        np.array([[0, 0], [2, 0], [2, 1], [0, 1], [2, 2], [0, 2]], dtype=np.float64),
        np.array([[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]]),
        ["clay", "clay", "sand", "sand"],
        {"base": [[1, 0]], "joint": [[3, 2]]},
        {"top_right": 4},
        ["joint"],
    )
    assert np.array_equal(made.nodes, from_file.nodes)
    assert np.array_equal(made.triangles, from_file.triangles)
    assert np.array_equal(made.interfaces, from_file.interfaces)
    assert np.array_equal(made.boundaries["base"], from_file.boundaries["base"])


def test_results_are_written_as_a_series_and_read_back(tmp_path: Path) -> None:
    mesh = LayeredMesh.plan(creeping_slope(), profile((0.0, 40.0))).nominal
    assert mesh_faults(mesh) == []
    displacement = 1e-3 * mesh.nodes
    strain = np.linspace(0.0, 1.0, len(mesh.triangles))
    snapshots = [Snapshot(t, {"displacement": t * displacement}, {"strain": strain}) for t in (0.0, 365.25)]
    files = write_pvd(tmp_path / "slope.pvd", mesh, snapshots)
    assert [file.name for file in files] == ["slope.pvd", "slope_0000.vtu", "slope_0001.vtu"]
    entries = ET.parse(files[0]).getroot().findall("Collection/DataSet")
    assert [(e.get("timestep"), e.get("file")) for e in entries] == [
        ("0", "slope_0000.vtu"),
        ("365.25", "slope_0001.vtu"),
    ]
    read = meshio.read(files[2])
    assert np.array_equal(read.cells_dict["triangle6"], mesh.triangles)
    assert np.allclose(read.point_data["displacement"][:, :2], 365.25 * displacement, rtol=1e-15, atol=0.0)
    assert np.array_equal(read.cell_data["strain"][0], strain)
    assert np.array_equal(read.cell_data["region"][0], mesh.regions)


def test_fields_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    mesh = LayeredMesh.plan(creeping_slope(), profile((0.0, 40.0))).nominal
    with pytest.raises(MeshError, match=r"field u has the shape \(3, 2\); one row for each of the \d+ nodes"):
        write_vtu(tmp_path / "a.vtu", mesh, Snapshot(0.0, {"u": np.zeros((3, 2))}))
    with pytest.raises(MeshError, match=r"a\.vtu: No such file"):
        write_vtu(tmp_path / "absent" / "a.vtu", mesh, Snapshot(0.0))
