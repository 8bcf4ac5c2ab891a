"""Synthetic readings: written from the model, with the stated noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import load_problem
from geoswarm.solver.runs.synthetic import write_readings

PROBLEM = """
forward_model:
  kind: formula
  series: {line: {expression: slope * x + level, x_unit: day, y_unit: m}, other: {expression: slope * x}}
parameters: {slope: {lower: 0, upper: 1}, level: {value: 3}}
observations:
  - {series: line, file: line.csv, x_unit: h, y_unit: mm, error: 5}
  - {series: other, file: other.csv, error: 0.25}
stopping: {max_evaluations: 10}
"""


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    path = tmp_path / "problem.yaml"
    path.write_text(PROBLEM)
    for name in ("line", "other"):
        (tmp_path / f"{name}.csv").write_text("x,y\n" + "".join(f"{x},0\n" for x in range(1, 401)))
    return path


def test_they_are_the_model_with_the_stated_errors(problem: Path, tmp_path: Path) -> None:
    written = write_readings(problem, {"slope": 0.24}, 7, "a line", decimals=4)
    assert written == [tmp_path / "line.csv", tmp_path / "other.csv"]
    lines = written[0].read_text().splitlines()
    assert lines[0] == "# synthetic: not measured; a line at slope 0.24, normal noise of 5 mm, seed 7"
    assert lines[1:3] == ["# x in h, y in mm", "x,y"]
    loaded = load_problem(problem)
    line, other = loaded.observations
    assert line.x.tolist() == pytest.approx([hour / 24.0 for hour in range(1, 401)], rel=1e-9)
    noise = 1000.0 * (line.y - 0.24 * line.x - 3.0)
    assert np.std(noise) == pytest.approx(5.0, rel=0.15)
    assert abs(np.mean(noise)) < 4.0 * 5.0 / np.sqrt(400)
    assert np.std(other.y - 0.24 * other.x) == pytest.approx(0.25, rel=0.15)


def test_the_same_seed_gives_the_same_files_elsewhere(problem: Path, tmp_path: Path) -> None:
    (tmp_path / "new").mkdir()
    first = [path.read_text() for path in write_readings(problem, {"slope": 0.24}, 7, "a line", tmp_path / "new")]
    again = [path.read_text() for path in write_readings(problem, {"slope": 0.24}, 7, "a line")]
    other = [path.read_text() for path in write_readings(problem, {"slope": 0.24}, 8, "a line")]
    assert first == again
    assert again != other


def test_what_is_missing_is_named(problem: Path) -> None:
    problem.write_text(PROBLEM.replace(", error: 0.25", ""))
    with pytest.raises(ProblemError, match=r"observations\[1\].error: is missing; synthetic readings need it"):
        write_readings(problem, {"slope": 0.24}, 7, "a line")
