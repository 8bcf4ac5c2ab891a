"""The creeping slope: size, rates and vectors of the published parameter sets on the synthetic look-alike."""

from __future__ import annotations

import json

import numpy as np
import pytest

from examples.generate_reference_data import HERE
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.cross_section import SectionModel
from geoswarm.solver.problem import Problem, load_problem, parse_problem

LABORATORY = [0.064, 0.035, 0.00146, 10.0, 5560.0]
IDENTIFIED = [1.42, 0.60, 0.145, 10.7, 5160.0]
POINTS = ("A", "B", "C", "D", "E", "F")
YEAR = 365.25


@pytest.fixture(scope="module")
def problem() -> Problem:
    return load_problem(HERE / "slope" / "problem.yaml")


def paths(problem: Problem, values: list[float], years: list[float]) -> FloatArray:
    """Displacements of the six points, (6, 2, t), m, after years of creep."""
    times = YEAR * np.array(years)
    wanted = {f"{point}.{axis}": times for point in POINTS for axis in ("ux", "uy")}
    found = problem.model.prepare(wanted)(problem.values(values))
    return np.array([[found[f"{point}.{axis}"] for axis in ("ux", "uy")] for point in POINTS])


def test_the_section_is_as_described(problem: Problem) -> None:
    model = problem.model
    assert isinstance(model, SectionModel)
    mesh = model.nominal
    assert np.ptp(mesh.nodes[:, 0]) == 1080.0
    assert len(mesh.triangles) == 1070
    assert {"cover", "shear_zone", "bedrock"} <= set(mesh.region_names)
    assert mesh.interface_names == ("crack", "secondary")
    cover = [y for _, y in model.spec.layers[0].thickness]
    assert min(cover) >= 20.0
    assert max(cover) <= 40.0
    assert tuple(mesh.points) == POINTS
    assert [phase.updated_mesh for phase in model.spec.phases] == [False, False, False, False, True]
    assert model.end == pytest.approx(33.0 * YEAR, rel=1e-12)


@pytest.mark.slow
def test_laboratory_values_give_millimetres(problem: Problem) -> None:
    moved = paths(problem, LABORATORY, [30.0, 33.0])
    lengths = np.linalg.norm(moved[:, :, 1] - moved[:, :, 0], axis=1)
    assert 0.5e-3 < lengths.max() < 10.0e-3
    assert lengths.min() > 0.1e-3


def test_the_identified_set_gives_centimetres_at_a_steady_rate(problem: Problem) -> None:
    """Creep slows down as 1/t: over three years after thirty the rate falls by a tenth at most."""
    moved = paths(problem, IDENTIFIED, [30.0, 31.0, 32.0, 33.0])
    steps = np.diff(moved, axis=2)
    lengths = np.linalg.norm(steps.sum(axis=2), axis=1)
    assert lengths.min() > 0.02
    assert lengths.max() < 0.5
    rates = np.linalg.norm(steps, axis=1).mean(axis=0)
    assert 0.85 < rates[2] / rates[0] < 1.0
    measured = np.stack([o.y for o in problem.observations], axis=1)
    apart = steps.sum(axis=2) - measured
    assert np.abs(apart).max() < 4.0 * 5.0e-3


@pytest.mark.slow
@pytest.mark.parametrize("values", [LABORATORY, IDENTIFIED])
def test_half_the_time_steps_change_vectors_by_less_than_one_per_cent(problem: Problem, values: list[float]) -> None:
    document = json.loads(json.dumps(problem.document()))
    control = document["forward_model"]["control"]
    control["creep_step"] *= 0.5
    control["time_tolerance"] *= 0.25  # the error of a step grows with the square of its length
    halved = parse_problem(document)
    vectors = []
    for one in (problem, halved):
        moved = paths(one, values, [30.0, 33.0])
        vectors.append(moved[:, :, 1] - moved[:, :, 0])
    change = np.linalg.norm(vectors[1] - vectors[0], axis=1) / np.linalg.norm(vectors[0], axis=1)
    assert change.max() < 0.01
