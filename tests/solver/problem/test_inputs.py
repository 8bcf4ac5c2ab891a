"""Columns beside x that a formula uses."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.runs.local import calibrate

X, T = [1.0, 2.0, 3.0, 3.0, 1.0], [10.0, 0.0, 20.0, 5.0, -5.0]


def document(**changes: Any) -> dict[str, Any]:
    """A strength that grows with x and falls with temperature: y = 2 x - 0.1 T, exact."""
    y = [2.0 * x - 0.1 * t for x, t in zip(X, T, strict=True)]
    return {
        "name": "strength",
        "forward_model": {"kind": "formula", "series": {"y": "a * x - b * T"}},
        "parameters": {"a": {"lower": 0.0, "upper": 5.0}, "b": {"lower": 0.0, "upper": 1.0}},
        "observations": [{"series": "y", "points": {"x": X, "y": y, "inputs": {"T": T}}}],
        "stopping": {"max_evaluations": 120},
        "seed": 5,
    } | changes


def mistakes(problem: dict[str, Any]) -> str:
    with pytest.raises(ProblemError) as caught:
        parse_problem(problem)
    return str(caught.value)


def test_a_formula_uses_what_was_measured_beside_x() -> None:
    problem = parse_problem(document())
    assert [p.name for p in problem.model.parameters] == ["a", "b"]
    run = problem.model.prepare({"y": problem.observations[0].x})
    np.testing.assert_array_equal(run({"a": 2.0, "b": 0.1})["y"], problem.observations[0].y)
    result = calibrate(problem)
    assert result.parameters == pytest.approx({"a": 2.0, "b": 0.1}, abs=1e-3)
    assert parse_problem(problem.document()) == problem
    assert pickle.loads(pickle.dumps(problem)) == problem  # noqa: S301
    between = problem.model.prepare({"y": np.array([1.5])})
    assert between({"a": 0.0, "b": -1.0})["y"] == pytest.approx([(-5.0 + 0.0) / 2])


def test_they_come_from_the_columns_of_a_file(tmp_path: Path) -> None:
    rows = "".join(f"{x},{2 * x - 0.1 * t},{t}\n" for x, t in zip(X, T, strict=True))
    (tmp_path / "a.csv").write_text("x,y,temperature [degC]\n" + rows, encoding="utf-8")

    def load(inputs: dict[str, str]) -> Problem:
        observation = {"series": "y", "file": "a.csv", "inputs": inputs}
        (tmp_path / "p.json").write_text(json.dumps(document(observations=[observation])), encoding="utf-8")
        return load_problem(tmp_path / "p.json")

    loaded = load({"T": "temperature [degC]"})
    np.testing.assert_array_equal(loaded.observations[0].inputs["T"], T)
    assert loaded.document()["observations"][0]["points"]["inputs"] == {"T": T}
    assert loaded.observations[0].points.notes == (
        "T is in degC, as its column says: the formula takes its numbers unchanged",
    )
    with pytest.raises(ProblemError, match=r"no column 'pressure'; the header has: x, y, temperature \[degC\]"):
        load({"T": "pressure"})


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"T": T[:4]}, "observations[0].points.inputs.T: has 4 values, but x has 5"),
        ({"T": T, "p": T}, "observations: input p is not used in 'a * x - b * T' of series 'y'"),
        ({"b": T}, "parameters.b: is an input of an observation; a name can only be one of the two"),
        ({"x": T}, "input x is not used"),
    ],
)
def test_inputs_that_cannot_be(inputs: dict[str, list[float]], message: str) -> None:
    points = document()["observations"][0]["points"] | {"inputs": inputs}
    parameters = {name: {"lower": 0.0, "upper": 5.0} for name in ("a", "b", "T") if name not in inputs or name == "b"}
    assert message in mistakes(document(observations=[{"series": "y", "points": points}], parameters=parameters))


def test_other_models_use_none() -> None:
    model = {"kind": "combined", "parts": {"one": {"kind": "formula", "series": {"y": "a * x - b"}}}}
    observation = document()["observations"][0] | {"series": "one.y"}
    assert "inputs are for kind: formula; a model of kind combined uses none" in mistakes(
        document(forward_model=model, observations=[observation])
    )
