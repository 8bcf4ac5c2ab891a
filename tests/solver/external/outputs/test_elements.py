"""Shape functions and the place of a point in an element; vtk_cases.json was made by compare_with_vtk.py."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.external.outputs.mesh.elements import ELEMENTS, Element, element

QUADRATIC = ("line3", "triangle6", "quad8", "quad9", "tetra10", "hexahedron20", "hexahedron27", "wedge15")
VTK: dict[str, Any] = json.loads(Path(__file__).parents[1].joinpath("vtk_cases.json").read_text(encoding="utf-8"))
INSIDE = {1: [0.3], 2: [0.2, 0.5], 3: [0.2, 0.15, 0.3]}


def known(name: str) -> Element:
    found = element(name)
    assert found is not None
    return found


@pytest.mark.parametrize("name", ELEMENTS)
def test_each_shape_function_is_one_in_its_own_node(name: str) -> None:
    one = known(name)
    values = np.stack([one.shape(node) for node in one.nodes])
    np.testing.assert_allclose(values, np.eye(len(one.nodes)), atol=1e-12)
    assert element("polyhedron") is None


@pytest.mark.parametrize("name", ELEMENTS)
def test_gradients_are_those_of_the_shape_functions(name: str) -> None:
    one, step = known(name), 1e-6
    at = np.array(INSIDE[one.dimension])
    for axis in range(one.dimension):
        shift = step * np.eye(one.dimension)[axis]
        difference = (one.shape(at + shift) - one.shape(at - shift)) / (2 * step)
        np.testing.assert_allclose(one.gradient(at)[axis], difference, atol=1e-8)


@pytest.mark.parametrize("name", ELEMENTS)
def test_fields_are_reproduced_in_oblique_elements(name: str) -> None:
    one = known(name)
    skew = np.array([[2.0, 0.3, 0.1], [-0.4, 1.5, 0.2], [0.2, -0.1, 3.0]])[: one.dimension, : one.dimension]
    corners = one.nodes @ skew.T + 5.0
    point = np.array(INSIDE[one.dimension]) @ skew.T + 5.0
    weights, outside = one.locate(corners, point)
    assert outside < 0.0
    np.testing.assert_allclose(weights @ corners, point, rtol=1e-12)
    if name in QUADRATIC:
        np.testing.assert_allclose(weights @ (corners**2), point**2, rtol=1e-12)
        np.testing.assert_allclose(weights @ (corners[:, 0] * corners[:, -1]), point[0] * point[-1], rtol=1e-12)


@pytest.mark.parametrize("name", ELEMENTS)
def test_points_outside_are_reported(name: str) -> None:
    one = known(name)
    assert one.locate(one.nodes, one.nodes.mean(axis=0))[1] < 0.0
    for axis in range(one.dimension):
        beyond = one.nodes.mean(axis=0)
        beyond[axis] += 2.5
        assert one.locate(one.nodes, beyond)[1] > 0.3


def test_a_curved_element_is_inverted() -> None:
    one = known("quad8")
    corners = one.nodes.copy()
    corners[4, 1] -= 0.3  # the lower edge bulges
    at = np.array([0.1, -0.9])
    weights, outside = one.locate(corners, one.shape(at) @ corners)
    np.testing.assert_allclose(weights, one.shape(at), atol=1e-10)
    assert outside == pytest.approx(-0.1, abs=1e-9)


def test_a_surface_in_space_holds_points_of_its_plane_only() -> None:
    one = known("triangle")
    corners = np.array([[0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 2.0]])  # in the plane y = 1
    weights, outside = one.locate(corners, np.array([0.5, 1.0, 0.5]))
    np.testing.assert_allclose(weights, [0.5, 0.25, 0.25], atol=1e-12)
    assert outside < 0.0
    assert one.locate(corners, np.array([0.5, 1.1, 0.5]))[1] == pytest.approx(0.05, abs=1e-9)
    assert one.locate(np.ones((3, 3)), np.ones(3))[1] == np.inf


@pytest.mark.parametrize("name", VTK)
def test_values_are_those_of_vtk(name: str) -> None:
    case = {key: np.array(numbers) for key, numbers in VTK[name].items()}
    for point, value in zip(case["points"], case["values"], strict=True):
        weights, outside = known(name).locate(case["nodes"], point)
        assert outside < 0.0
        assert weights @ case["field"] == pytest.approx(value, rel=1e-10, abs=1e-12)
