"""Whole problem files: the good ones are accepted and survive a round trip, each bad one gives exactly its messages."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.methods.monte_carlo import MonteCarloMethod
from geoswarm.solver.methods.particle_swarm import ParticleSwarmMethod
from geoswarm.solver.problem import FixedParameter, FreeParameter, LinkedParameter, load_problem, parse_problem

HERE = Path(__file__).parent
GOOD = sorted(path for path in (HERE / "good").iterdir() if path.suffix in (".yaml", ".json"))
BAD = sorted((HERE / "bad").glob("*.yaml"))
MARK = "# expect: "


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_good_file_survives_the_round_trip(path: Path) -> None:
    problem = load_problem(path)
    document = problem.document()
    again = parse_problem(document)
    assert again.document() == document
    assert again == problem
    assert pickle.loads(pickle.dumps(problem)) == problem  # noqa: S301
    assert hash(again) == hash(problem)
    for first, second in zip(problem.observations, again.observations, strict=True):
        np.testing.assert_array_equal(first.x, second.x)
        np.testing.assert_array_equal(first.y, second.y)
        np.testing.assert_array_equal(first.point_weights, second.point_weights)


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_bad_file_gives_its_messages(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    expected = [line.removeprefix(MARK) for line in lines if line.startswith(MARK)]
    assert expected
    with pytest.raises(ProblemError) as caught:
        load_problem(path)
    found = [str(issue).replace(f"{path.parent}/", "") for issue in caught.value.issues]
    assert found == expected
    assert str(caught.value) == "\n".join(str(issue) for issue in caught.value.issues)


def test_the_full_oedometer_is_understood_whole() -> None:
    problem = load_problem(HERE / "good" / "full_oedometer.yaml")
    assert problem.name == "oedometer-san-cassiano"
    assert problem.seed == 2008
    assert problem.forward_model.kind == "oedometer"
    assert list(problem.parameters) == ["lambda_star", "kappa_star", "c", "mu_star", "phi", "psi"]
    assert problem.parameters["lambda_star"] == FreeParameter("lambda_star", 0.002, 1.0, "log", 0.064)
    assert problem.parameters["mu_star"] == FixedParameter("mu_star", 1.46e-3)
    kappa = problem.parameters["kappa_star"]
    assert isinstance(kappa, LinkedParameter)
    assert kappa.expression.text == "0.5 * lambda_star"
    assert problem.free_names == ("lambda_star", "c")
    assert isinstance(problem.method, ParticleSwarmMethod)
    assert (problem.method.topology, problem.method.inertia_weight, problem.method.boundary) == ("ring", 0.7, "reflect")
    assert problem.stopping.target_objective == 5e-9
    settlement, void_ratio = problem.observations
    np.testing.assert_array_equal(settlement.x, [1 / 1440, 1.0, 3.0])
    np.testing.assert_array_equal(settlement.y, [0.01e-3, 0.11e-3, 0.29e-3])
    np.testing.assert_array_equal(settlement.point_weights, [1.0, 1.0, 0.5])
    assert settlement.points.x == [1.0, 1440.0, 4320.0]
    assert (settlement.x_unit, settlement.y_unit) == ("min", "mm")
    assert not settlement.x.flags.writeable
    assert void_ratio.weight == 1e-7
    np.testing.assert_array_equal(void_ratio.x, [1.0, 2.0])
    assert void_ratio.x_unit is None


def test_a_nameless_problem_is_named_after_its_file() -> None:
    problem = load_problem(HERE / "good" / "monte_carlo.yaml")
    assert problem.name == "monte_carlo"
    assert isinstance(problem.method, MonteCarloMethod)
    assert problem.seed is None
    assert "seed" not in problem.document()


def test_columns_of_other_names_and_units_of_parts() -> None:
    problem = load_problem(HERE / "good" / "combined.json")
    first, second = problem.observations
    np.testing.assert_array_equal(first.x, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(first.y, [0.0, 0.0015, 0.0025])
    np.testing.assert_array_equal(first.point_weights, [1.0, 1.0, 0.0])
    np.testing.assert_array_equal(second.y, [0.5, 1.0])
    document = problem.document()
    assert document["observations"][0]["points"]["x"] == [0.0, 24.0, 48.0]
    assert "file" not in document["observations"][0]


def test_a_missing_problem_file(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="no such file"):
        load_problem(tmp_path / "nowhere.yaml")
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(ProblemError, match="cannot be read: Is a directory"):
        load_problem(tmp_path / "folder.yaml")
    with pytest.raises(ProblemError, match=r"ends in \.yaml, \.yml or \.json"):
        load_problem(tmp_path / "problem.txt")
