"""Meshes of layered sections: areas, names, openings, and how they follow their geometry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.checks import mesh_faults
from geoswarm.solver.fem.mesh.cross_section import Cut, Layer, SectionGeometry, SurfacePoint
from geoswarm.solver.fem.mesh.layered import LayeredMesh
from geoswarm.solver.fem.mesh.mesh import Mesh, boundary_edges
from tests.solver.fem.mesh.sections import area_of, creeping_slope, embankment, profile

TEN_METRES = profile((0.0, 10.0))
LENGTH = 1080.0


@pytest.fixture(scope="module")
def slope() -> LayeredMesh:
    return LayeredMesh.plan(creeping_slope(), TEN_METRES)


def test_regions_have_the_areas_of_their_layers(slope: LayeredMesh) -> None:
    mesh = slope.nominal
    assert mesh_faults(mesh) == []
    assert area_of(mesh, "bedrock") == pytest.approx(20.0 * LENGTH, rel=1e-9)
    assert area_of(mesh, "stable") + area_of(mesh, "shear_zone") == pytest.approx(2.0 * LENGTH, rel=1e-9)
    assert area_of(mesh, "stable") == pytest.approx(2.0 * 120.0, rel=1e-9)
    cover = 0.5 * (20.0 + 30.0) * 400.0 + 30.0 * 500.0 + 0.5 * (30.0 + 25.0) * 180.0
    band = area_of(mesh, "secondary_zone")
    assert band == pytest.approx(2.0 * 26.0, rel=0.03)
    assert area_of(mesh, "cover") + band == pytest.approx(cover, rel=1e-3)


def test_boundaries_close_around_the_body(slope: LayeredMesh) -> None:
    """Sum of the outward normals is zero, and what the four sides leave out are the open sides of the cuts."""
    mesh = slope.nominal
    sides = np.concatenate([mesh.boundaries[name] for name in ("surface", "bottom", "left", "right")])
    steps = mesh.nodes[sides[:, 1]] - mesh.nodes[sides[:, 0]]
    assert np.abs(steps.sum(axis=0)).max() < 1e-9 * LENGTH
    outer = {tuple(edge) for edge in boundary_edges(mesh.triangles).tolist()}
    assert {tuple(edge) for edge in sides.tolist()} <= outer
    assert len(outer) - len(sides) == 2 * len(mesh.interfaces)
    right = np.concatenate([mesh.boundaries[f"right.{name}"] for name in ("cover", "shear_zone", "bedrock")])
    assert sorted(right.tolist()) == sorted(mesh.boundaries["right"].tolist())


def test_sides_of_an_interface_face_one_another(slope: LayeredMesh) -> None:
    """Side A lies on the left of the direction: here downhill of the cut, which runs from the surface down."""
    mesh = slope.nominal
    assert mesh.interface_names == ("crack", "secondary")
    assert np.bincount(mesh.interface_regions).tolist() == [2, 4]
    assert np.array_equal(mesh.nodes[mesh.interfaces[:, :3]], mesh.nodes[mesh.interfaces[:, 3:]])
    crack = mesh.interfaces[mesh.interface_regions == 0]
    for nodes, side in ((crack[:, 2], 1.0), (crack[:, 5], -1.0)):
        for node in nodes:
            (triangle,) = np.flatnonzero((mesh.triangles == node).any(axis=1))
            assert side * (mesh.nodes[mesh.triangles[triangle, :3], 0].mean() - 120.0) > 0.0
    tip = int(np.argmin(mesh.nodes[crack[:, 1], 1]))
    assert crack[tip, 1] == crack[tip, 4]
    assert crack[0, 0] != crack[0, 3]


def test_points_are_where_they_are_said_to_be(slope: LayeredMesh) -> None:
    mesh = slope.nominal
    assert mesh.nodes[mesh.points["A"], 0] == pytest.approx(215.0, abs=1e-9)
    geometry = creeping_slope()
    for name, depth in (("B", 0.0), ("base_of_B", 0.0)):
        x, y = mesh.nodes[mesh.points[name]]
        surface = float(geometry.surface.at(np.array([x]))[0])
        if name == "base_of_B":
            cover = geometry.layers[0].thickness
            assert cover is not None
            depth = float(cover.at(np.array([x]))[0]) + 2.0
        assert y == pytest.approx(surface - depth, abs=1e-9)
    assert mesh.nodes[mesh.points["B"], 0] == mesh.nodes[mesh.points["base_of_B"], 0] == pytest.approx(330.0, abs=1e-9)


def test_a_mesh_moves_smoothly_with_depth_thickness_and_angle(slope: LayeredMesh) -> None:
    """Central differences over two step widths agree to second order: no jump, no kink, the same numbers."""

    def nodes(shift: float) -> np.ndarray:
        moved = slope.mesh(creeping_slope(31.0 + shift, 1.5 + 0.1 * shift, 11.0 + 0.2 * shift))
        assert np.array_equal(moved.triangles, slope.nominal.triangles)
        assert mesh_faults(moved) == []
        return moved.nodes

    coarse = (nodes(0.2) - nodes(-0.2)) / 0.4
    fine = (nodes(0.1) - nodes(-0.1)) / 0.2
    assert 0.5 < np.abs(fine).max() < 10.0
    assert np.abs(coarse - fine).max() < 5e-3 * np.abs(fine).max()


def test_the_same_geometry_gives_the_planned_mesh(slope: LayeredMesh) -> None:
    assert np.array_equal(slope.mesh(creeping_slope()).nodes, slope.nominal.nodes)


def test_what_the_mesh_cannot_follow_is_refused(slope: LayeredMesh) -> None:
    with pytest.raises(MeshError, match=r"region stable .* has no area or runs clockwise"):
        slope.mesh(creeping_slope(thickness=-1.0))
    geometry = creeping_slope()
    passed = replace(geometry, points=(SurfacePoint("A", 310.0), *geometry.points[1:]))
    with pytest.raises(MeshError, match=r"point A at x = 310 m is not left of point 2 of the surface at x = 300 m"):
        slope.mesh(passed)


def test_marks_that_were_planned_as_one_must_not_part(slope: LayeredMesh) -> None:
    geometry = creeping_slope()
    parted = replace(geometry, zones=(replace(geometry.zones[0], end=125.0),))
    with pytest.raises(
        MeshError, match=r"end of zone stable at x = 125 m and cut crack at x = 120 m were at one place"
    ):
        slope.mesh(parted)


def test_lifts_end_where_they_meet_the_slope_of_the_embankment() -> None:
    planned = LayeredMesh.plan(embankment(), profile((0.0, 2.0)))
    mesh = planned.nominal
    assert area_of(mesh, "upper_lift") == pytest.approx(0.5 * (10.0 + 20.0) * 2.5, rel=1e-9)
    assert area_of(mesh, "lower_lift") == pytest.approx(0.5 * (20.0 + 30.0) * 2.5, rel=1e-9)
    assert area_of(mesh, "clay") == pytest.approx(60.0 * 6.0, rel=1e-9)
    road = mesh.nodes[mesh.boundaries["road"]]
    assert road[:, 0, 0].max() == pytest.approx(4.0, abs=1e-9)
    assert (road[:, 0, 0] > road[:, 1, 0]).all()
    textile = mesh.nodes[mesh.interfaces[:, :2]]
    assert np.abs(textile[..., 1]).max() < 1e-9
    assert (textile[:, 1, 0] - textile[:, 0, 0]).sum() == pytest.approx(22.0, rel=1e-9)
    moved = planned.mesh(embankment(3.0))
    assert area_of(moved, "upper_lift") == pytest.approx(0.5 * (10.0 + 18.0) * 2.0, rel=1e-9)


def test_rows_grow_with_depth_by_their_grading() -> None:
    mesh = LayeredMesh.plan(embankment(), profile((0.0, 2.0))).nominal
    left = mesh.nodes[mesh.boundaries["left.clay"]]
    heights = np.sort(np.abs(left[:, 0, 1] - left[:, 1, 1]))
    assert heights[2] / heights[0] == pytest.approx(2.0, rel=1e-9)
    assert heights.sum() == pytest.approx(6.0, rel=1e-9)


def specimen(**changes: object) -> SectionGeometry:
    layers = (Layer("soil", 1, thickness=profile((0.0, 2.0))), Layer("rock", 1, thickness=profile((0.0, 1.0))))
    return replace(SectionGeometry(profile((0.0, 0.0), (4.0, 0.0)), layers), **changes)  # type: ignore[arg-type]


def test_one_column_and_one_row_are_two_triangles() -> None:
    geometry = SectionGeometry(profile((0.0, 2.0), (1.0, 2.0)), (Layer("soil", 1, thickness=profile((0.0, 2.0))),))
    mesh: Mesh = LayeredMesh.plan(geometry, profile((0.0, 1.0))).nominal
    assert mesh.triangles.shape == (2, 6)
    assert mesh.nodes.shape == (9, 2)


@pytest.mark.parametrize(
    ("geometry", "words"),
    [
        (specimen(points=(SurfacePoint("P", 5.0),)), "point P at x = 5 m lies outside the surface, from 0 to 4 m"),
        (specimen(cuts=(Cut("c", 1.0, 3.0, "soil"), Cut("d", 2.0, 2.0, "soil"))), "cross one another"),
        (specimen(layers=(Layer("soil", 1, thickness=profile((0.0, 0.0))),)), "soil has no thickness anywhere"),
        (specimen(layers=(Layer("soil", 1, thickness=profile((0.0, 0.001))),)), "is a sliver"),
        (specimen(cuts=(Cut("c", 1.0, 1.0, "soil"),), points=(SurfacePoint("P", 1.0),)), "point P lies on an interf"),
    ],
)
def test_wrong_geometries_are_refused_with_the_place(geometry: SectionGeometry, words: str) -> None:
    with pytest.raises(MeshError, match=words):
        LayeredMesh.plan(geometry, profile((0.0, 1.0)))
