"""Results on meshes, written by meshio and sampled at points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.mesh import snapshots
from tests.solver.external.outputs.reading import assert_bad, assert_points, reader_of, series

NODES = np.array([[0.0, 0, 0], [4, 0, 0], [4, 2, 0], [0, 2, 0], [8, 0, 0], [8, 2, 0]])
QUAD, TRIANGLES = [[0, 1, 2, 3]], [[1, 4, 5], [1, 5, 2]]
U = {"field": "u", "component": "y"}


def body(time: float = 1.0, nodes: Any = NODES) -> Any:
    """A quadrilateral and two triangles with a linear field."""
    x, y = nodes[:, 0], nodes[:, 1]
    displacement = time * np.stack([x, 2 * x - 3 * y + 1, 0 * x], axis=1)
    return meshio.Mesh(
        nodes,
        [("quad", QUAD), ("triangle", TRIANGLES)],
        point_data={"u": displacement, "p": time * (x + y)},
        cell_data={"eps": [np.array([0.1 * time]), np.array([0.2, 0.3]) * time]},
    )


def moved(distance: float) -> Any:
    return NODES + np.array([distance, 0.0, 0.0])


def write_pvd(folder: Path, times: list[float], entries: str = "") -> None:
    (folder / "steps").mkdir(exist_ok=True)
    for number, time in enumerate(times):
        body(time).write(folder / "steps" / f"r_{number}.vtu", binary=number % 2 == 0)
        entries += f'<DataSet timestep="{time}" group="" part="0" file="steps/r_{number}.vtu"/>\n'
    text = f'<?xml version="1.0"?>\n<VTKFile type="Collection"><Collection>\n{entries}</Collection></VTKFile>\n'
    (folder / "r.pvd").write_text(text, encoding="utf-8")


def test_a_point_over_time(tmp_path: Path) -> None:
    write_pvd(tmp_path, [0.0, 1.0, 2.5])
    at = {"file": "r.pvd", "point": [5.0, 1.0]}
    assert_points(series(tmp_path, **at, **U), [(0.0, 0.0), (1.0, 8.0), (2.5, 20.0)])
    assert series(tmp_path, **at, field="u", component=1, y_factor=-1.0)[1] == pytest.approx((1.0, -5.0))
    assert series(tmp_path, **at, field="p")[1] == pytest.approx((1.0, 6.0))
    assert series(tmp_path, **at, field="eps")[1] == pytest.approx((1.0, 0.3))
    assert series(tmp_path, **at, field="u", component="magnitude")[1][1] == pytest.approx(np.hypot(5.0, 8.0))
    trace = reader_of(at | {"field": "p"}).traced(tmp_path)
    assert trace[1][0] == 0
    assert trace[1][1].startswith("element 1 (triangle) of steps/r_1.vtu at time 1: p = ")


@pytest.mark.parametrize("point", [[0.0, 0.0], [4.0, 2.0], [4.0, 1.0], [8.0, 2.0], [2.0, 2.0], [8.0000001, 1.0]])
def test_points_on_edges_belong_to_the_body(tmp_path: Path, point: list[float]) -> None:
    body().write(tmp_path / "r.vtu")
    ((_, value),) = series(tmp_path, file="r.vtu", point=point, **U)
    assert value == pytest.approx(2 * point[0] - 3 * point[1] + 1, abs=1e-5)


def test_points_along_a_line(tmp_path: Path) -> None:
    write_pvd(tmp_path, [1.0, 2.0])
    at = {"file": "r.pvd", "points": [[1.0, 1.0], [4.0, 1.0], [7.0, 1.0]], **U}
    assert_points(series(tmp_path, **at), [(0.0, 0.0), (3.0, 12.0), (6.0, 24.0)])
    assert_points(series(tmp_path, **at, time=1.0, along="x"), [(1.0, 0.0), (4.0, 6.0), (7.0, 12.0)])
    assert_bad(tmp_path, None, "r.pvd: no results at time 1.4; the nearest are at 1, 2", **at, time=1.4)


def test_a_mesh_that_moves_is_searched_again(tmp_path: Path) -> None:
    write_pvd(tmp_path, [1.0, 2.0])
    body(2.0, moved(3.0)).write(tmp_path / "steps" / "r_1.vtu")
    points = series(tmp_path, file="r.pvd", point=[5.0, 0.5], **U)
    assert_points(points, [(1.0, 9.5), (2.0, 19.0)])


def test_pieces_of_several_processes(tmp_path: Path) -> None:
    write_pvd(tmp_path, [1.0], '<DataSet timestep="1.0" part="1" file="far.vtu"/>\n')
    body(1.0, moved(100.0)).write(tmp_path / "far.vtu")
    assert_points(series(tmp_path, file="r.pvd", point=[5.0, 0.5], **U), [(1.0, 9.5)])
    assert_points(series(tmp_path, file="r.pvd", point=[105.0, 0.5], **U), [(1.0, 209.5)])
    pieces = (
        '<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid><Piece Source="far.vtu"/></PUnstructuredGrid></VTKFile>'
    )
    (tmp_path / "all.pvtu").write_text(pieces, encoding="utf-8")
    assert_points(series(tmp_path, file="all.pvtu", point=[105.0, 0.5], **U), [(0.0, 209.5)])


def test_volumes_and_surfaces_in_space(tmp_path: Path) -> None:
    cube = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))])
    surface = ("quad", [[0, 1, 2, 3]])
    field = {"u": cube @ [1.0, 2.0, 3.0]}
    meshio.Mesh(cube, [surface, ("hexahedron", [list(range(8))])], point_data=field).write(tmp_path / "r.vtu")
    assert_points(series(tmp_path, file="r.vtu", point=[0.5, 0.25, 0.5], field="u"), [(0.0, 2.5)])
    assert_bad(tmp_path, None, "the mesh has volumes; point needs three", file="r.vtu", point=[0.5, 0.5], field="u")
    upright = cube[:, [0, 2, 1]]
    meshio.Mesh(upright, [surface], point_data=field).write(tmp_path / "r.vtu")
    assert_points(series(tmp_path, file="r.vtu", point=[0.5, 0.0, 0.5], field="u"), [(0.0, 1.5)])
    assert_bad(tmp_path, None, "does not lie in the plane of x and y", file="r.vtu", point=[0.5, 0.5], field="u")


@pytest.mark.parametrize("data", ["XML", "HDF"])
def test_xdmf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: str) -> None:
    monkeypatch.chdir(tmp_path)  # meshio writes the HDF5 file there
    name = f"{data}.xdmf".lower()
    mesh = body()
    with meshio.xdmf.TimeSeriesWriter(tmp_path / name, data_format=data) as writer:
        writer.write_points_cells(mesh.points, mesh.cells)
        for time in (0.5, 1.0):
            writer.write_data(time, point_data=body(time).point_data, cell_data=body(time).cell_data)
    points = series(tmp_path, file=name, point=[5.0, 0.5], **U)
    assert_points(points, [(0.5, 4.75), (1.0, 9.5)])
    meshio.xdmf.write(tmp_path / "one.xdmf", mesh, data_format="XML")
    assert_points(series(tmp_path, file="one.xdmf", point=[5.0, 0.5], field="p"), [(0.0, 5.5)])
    text = (tmp_path / "one.xdmf").read_text(encoding="utf-8")
    assert_bad(tmp_path, text[:900], "one.xdmf: line 23: ", file="one.xdmf", point=[5.0, 0.5], field="p")
    assert_bad(
        tmp_path, text.replace("XYZ", "QQ"), "cannot be read as XDMF", file="one.xdmf", point=[5.0, 0.5], field="p"
    )


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"point": [9.0, 1.0]}, "r.vtu: no element holds the point (9, 1); the nearest node is (8, 0), 1.414 away"),
        ({"field": "v"}, "r.vtu: no field v; there are u, p, eps"),
        ({"field": "u", "component": None}, "field u has 3 components; write component"),
        ({"field": "p", "component": "y"}, "field p has 1 components; y does not exist"),
        ({"component": 4}, "field u has 3 components; 4 does not exist"),
    ],
)
def test_mistakes_say_what_there_is(tmp_path: Path, section: dict[str, Any], message: str) -> None:
    body().write(tmp_path / "r.vtu")
    assert_bad(tmp_path, None, message, **({"file": "r.vtu", "point": [5.0, 1.0]} | U | section))


def test_files_that_are_missing_or_cut_off(tmp_path: Path) -> None:
    at = {"point": [5.0, 1.0], **U}
    assert_bad(tmp_path, None, "r.pvd: the run wrote no such file", "no_output", file="r.pvd", **at)
    write_pvd(tmp_path, [1.0])
    whole = (tmp_path / "steps" / "r_0.vtu").read_bytes()
    for part in (len(whole) // 3, len(whole) - 40):
        (tmp_path / "steps" / "r_0.vtu").write_bytes(whole[:part])
        assert_bad(tmp_path, None, "steps/r_0.vtu: the file is truncated or not VTU", file="r.pvd", **at)
    (tmp_path / "steps" / "r_0.vtu").write_bytes(whole.replace(b"UnstructuredGrid>", b"Nothing>"))
    assert_bad(tmp_path, None, "steps/r_0.vtu: cannot be read as VTU", file="r.pvd", **at)
    packed = whole.replace(b"vtkZLibDataCompressor", b"vtkLZ4DataCompressor")
    assert packed != whole
    (tmp_path / "steps" / "r_0.vtu").write_bytes(packed)
    assert_bad(tmp_path, None, "is compressed with LZ4; zlib, LZMA or none is expected", file="r.pvd", **at)
    (tmp_path / "steps" / "r_0.vtu").unlink()
    assert_bad(tmp_path, None, "steps/r_0.vtu: the run wrote no such file", "no_output", file="r.pvd", **at)
    text = (tmp_path / "r.pvd").read_text(encoding="utf-8")
    assert_bad(tmp_path, text[:-20], "r.pvd: line 4: ", file="r.pvd", **at)
    assert_bad(tmp_path, "<VTKFile/>", "r.pvd: names no files", file="r.pvd", **at)
    assert_bad(tmp_path, text.replace("1.0", "soon"), "timestep 'soon' is not a number", file="r.pvd", **at)
    assert_bad(tmp_path, text.replace("steps/", "../"), "names another file that cannot be read", file="r.pvd", **at)


def test_results_that_are_not_finite(tmp_path: Path) -> None:
    mesh = body()
    mesh.point_data["p"][5] = np.nan
    mesh.write(tmp_path / "r.vtu")
    assert_bad(tmp_path, None, "y = nan is not finite in 'element 0", file="r.vtu", point=[7.0, 0.5], field="p")


def test_without_meshio_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    body().write(tmp_path / "r.vtu")
    reader = reader_of({"file": "r.vtu", "point": [1.0, 1.0], **U})
    assert reader.lacks is None

    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(snapshots, "has", lambda _: False)
    monkeypatch.setattr(snapshots.importlib, "import_module", missing)
    assert "geoswarm[mesh]" in str(reader.lacks)
    with pytest.raises(OutputError, match=r"geoswarm\[mesh\]"):
        reader.read(tmp_path)
