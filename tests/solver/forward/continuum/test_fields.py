"""Strains of prescribed displacements, and fields of bodies whose displacements are known."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.forward.continuum.fields import body_of, displacement_fields, parts_with_body, shear_strain
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runner.evaluator import evaluate_fields
from tests.solver.forward.continuum.bodies import OEDOMETER, creeping, ground, spec

VALUES = {"depth": 6.0, "E_rock": 1.0e5, "q": 50.0}


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return spec(ground()).build().nominal


@pytest.mark.parametrize(
    ("ux", "uy", "expected"),
    [
        ((0.0, 0.03), (0.0, 0.0), 0.03),  # simple shear
        ((0.0, -0.01), (0.01, 0.0), 0.0),  # a small rotation
        ((0.02, 0.0), (0.0, -0.02), 0.04),  # pure shear
        ((0.02, 0.0), (0.0, 0.02), 0.0),  # swelling alike in both directions
        ((0.01, 0.03), (0.01, -0.02), 0.05),  # hypot(0.01 + 0.02, 0.03 + 0.01)
    ],
)
def test_uniform_strains_are_exact(
    mesh: Mesh, ux: tuple[float, float], uy: tuple[float, float], expected: float
) -> None:
    displacement = mesh.nodes @ np.array([ux, uy]).T + 5.0
    assert shear_strain(mesh, displacement) == pytest.approx(expected, abs=1e-12)


def test_a_quadratic_displacement_gives_its_linear_strain(mesh: Mesh) -> None:
    """Bending: ux = k x y, uy = -k x^2 / 2 has ex = k y and no shear, ux = k y^2 / 2 has gxy = k y."""
    x, y = mesh.nodes.T
    bent = np.stack([0.01 * x * y, -0.005 * x**2], axis=1)
    assert shear_strain(mesh, bent) == pytest.approx(np.abs(0.01 * y[mesh.triangles]), abs=1e-12)
    sheared = np.stack([0.005 * y**2, np.zeros_like(y)], axis=1)
    assert shear_strain(mesh, sheared) == pytest.approx(np.abs(0.01 * y[mesh.triangles]), abs=1e-12)


def test_strains_jump_only_between_regions(mesh: Mesh) -> None:
    top = mesh.regions[:, None] == mesh.region_names.index("sand")
    y = mesh.nodes[:, 1]
    kinked = np.stack([np.zeros_like(y), -0.01 * np.maximum(y - 4.0, 0.0)], axis=1)  # the sand is above 4 m
    found = shear_strain(mesh, kinked)
    assert found == pytest.approx(np.where(top, 0.01, 0.0) * np.ones((1, 6)), abs=1e-12)


def test_fields_of_level_ground_are_those_of_one_dimensional_compression() -> None:
    model = spec(ground()).build()
    fields = displacement_fields(model, VALUES)
    assert list(fields) == ["weight", "loading"]
    y = model.nominal.nodes[:, 1]
    rock = 50.0 / (10.0 * OEDOMETER)
    settled = -rock * np.minimum(y, 4.0) - 50.0 / OEDOMETER * np.maximum(y - 4.0, 0.0)
    moved = fields["loading"] - fields["weight"]
    assert moved[:, 1] == pytest.approx(settled, rel=1e-6, abs=1e-9)
    strain = shear_strain(model.nominal, moved)
    in_sand = model.nominal.regions == model.nominal.region_names.index("sand")
    assert strain[in_sand] == pytest.approx(50.0 / OEDOMETER, rel=1e-5)
    assert strain[~in_sand] == pytest.approx(rock, rel=1e-5)


def test_phases_have_ends_in_time() -> None:
    model = spec(creeping()).build()
    assert model.phase_ends == {"weight": 0.0, "creep": 1000.0}
    assert model.phase_before_zero == "weight"
    first = spec(creeping(zero_at_phase="weight")).build()
    assert first.phase_before_zero is None


def test_parts_of_a_combination_that_have_a_body_are_found() -> None:
    line = {"kind": "formula", "series": {"y": {"expression": "E_rock * x"}}}
    model = parse_spec({"kind": "combined", "parts": {"line": line, "slope": ground()}}).build()
    assert parts_with_body(model) == ("slope",)
    found = body_of(model, "slope", {"depth": 6.0, "E_rock": 1e5, "slope.E_rock": 2e5, "q": 1.0})
    assert found is not None
    assert found[1]["E_rock"] == 2e5
    assert body_of(model, "line", VALUES) is None
    assert parts_with_body(parse_spec(line).build()) == ()


def problem_of(section: dict[str, object]) -> Calibration:
    document = {
        "name": "ground",
        "forward_model": section,
        "parameters": {
            "depth": {"lower": 2, "upper": 9},
            "E_rock": {"value": 1e5},
            "q": {"value": 50},
        },
        "observations": [{"series": "A.uy", "points": {"x": [0], "y": [-0.02]}}],
        "method": {"kind": "monte_carlo", "samples": 2},
    }
    return Calibration(parse_problem(document), 1)


def test_fields_are_those_of_the_evaluation() -> None:
    calibration = problem_of(ground())
    made = evaluate_fields(calibration, np.array([6.0]), "")
    assert made.reason is None
    response = calibration.evaluate(np.array([6.0])).responses["A.uy"][0]
    node = spec(ground()).build().nominal.points["A"]
    moved = (made.responses["loading"] - made.responses["weight"]).reshape(-1, 2)
    assert moved[node, 1] == pytest.approx(response, rel=1e-12)


def test_a_failure_is_in_the_evaluation() -> None:
    missing = evaluate_fields(problem_of(ground()), np.array([6.0]), "nobody")
    assert (missing.reason, missing.responses) == ("diverged", {})
    assert "nobody" in (missing.message or "")
