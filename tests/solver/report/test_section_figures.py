"""Figures of bodies: what is drawn, to which scale, and the numbers behind it."""

from __future__ import annotations

import re

import numpy as np
import pytest

from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.layered import LayeredMesh
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.report.figures.cross_section_plot import deformed_figure, mesh_figure, vectors_figure, vectors_rows
from geoswarm.solver.report.figures.profile_plot import depth_profile, profile_figure, profile_rows
from geoswarm.solver.report.figures.style import svg_of
from tests.solver.fem.mesh.sections import creeping_slope, profile


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return LayeredMesh.plan(creeping_slope(), profile((0.0, 20.0))).nominal


def test_the_mesh_is_drawn_whole_and_enlarged_with_its_names(mesh: Mesh) -> None:
    figure = mesh_figure("Mesh", mesh, window=(100.0, 260.0, 110.0, 190.0))
    whole, piece = figure.axes
    assert whole.get_xlim()[0] < 0.0
    assert whole.get_xlim()[1] > 1080.0
    assert 95.0 < piece.get_xlim()[0] < 100.0
    assert len(whole.collections[0].get_paths()) == len(mesh.triangles)
    text = svg_of(figure).decode()
    for name in (*mesh.region_names, "interfaces (6)", "A", "B"):
        assert name in text


def test_the_deformed_mesh_tells_its_factor(mesh: Mesh) -> None:
    displacement = np.zeros_like(mesh.nodes)
    displacement[:, 0] = 0.02
    figure = deformed_figure("Three years", mesh, displacement)
    factor = float(re.search(r"× ([\d.e+]+)", figure.get_suptitle())[1])  # type: ignore[index]
    assert 0.01 * 1080.0 < factor * 0.02 <= 0.025 * 1080.0
    drawn = figure.axes[0].collections[0].get_paths()[0].vertices
    assert drawn[:, 0].min() - mesh.nodes[mesh.triangles[0], 0].min() == pytest.approx(0.02 * factor, rel=1e-9)
    assert deformed_figure("Given", mesh, displacement, 3.0).get_suptitle().endswith("× 3")


def test_vectors_share_one_scale_and_are_written_as_numbers(mesh: Mesh) -> None:
    vectors = {"measured": np.array([[0.1, -0.02], [0.2, -0.04]]), "calculated": np.array([[0.12, -0.02], [0.1, 0.0]])}
    figure = vectors_figure("Vectors", mesh, ["A", "B"], vectors)
    upper, lower = figure.axes
    arrows = [artist for artist in upper.collections if hasattr(artist, "U")]
    assert len(arrows) == 2
    scales = [np.asarray(a.U) / v[:, 0] for a, v in zip(arrows, vectors.values(), strict=True)]
    assert np.ptp(np.concatenate(scales)) == pytest.approx(0.0, abs=1e-6)
    assert len(lower.patches) == 4
    assert lower.patches[0].get_height() == pytest.approx(float(np.hypot(0.1, 0.02)), rel=1e-9)
    assert "0.2 m" in svg_of(figure).decode()
    header, rows = vectors_rows(["A", "B"], vectors)
    assert header == ["point", "measured ux", "measured uy", "calculated ux", "calculated uy", "unit"]
    assert rows[1] == ["B", 0.2, -0.04, 0.1, 0.0, "m"]


def test_a_profile_follows_the_column_below_its_point(mesh: Mesh) -> None:
    displacement = np.stack([mesh.nodes[:, 1], np.zeros(len(mesh.nodes))], axis=1)
    found = depth_profile(mesh, displacement, "B", "shear_zone")
    assert (np.diff(found.depth) > 0.0).all()
    assert found.depth[0] == 0.0
    assert found.band[1] - found.band[0] == pytest.approx(2.0, abs=1e-9)
    height = mesh.nodes[mesh.points["B"], 1]
    assert found.displacement == pytest.approx(height - found.depth, abs=1e-9)
    figure = profile_figure("Profile", {"B": found}, unit="mm")
    (axes,) = figure.axes
    assert axes.yaxis_inverted()
    assert axes.lines[-1].get_xdata()[0] == pytest.approx(1000.0 * height, rel=1e-12)
    header, rows = profile_rows({"B": found})
    assert header[0] == "point"
    assert len(rows) == len(found.depth)
    with pytest.raises(MeshError, match="no column of region stable stands below it"):
        depth_profile(mesh, displacement, "B", "stable")
