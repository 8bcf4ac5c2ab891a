"""The user routine in Fortran: compiled, compared with its closed form, and calibrated."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.problem import load_problem
from tests.examples.engines import assert_same_readings, calibrated, copy_of, find_engine

TRUTH = {"E_ref": 4000.0, "m": 0.6, "ratio": 5.0}


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    """A copy of the example with its library."""
    found = copy_of("umat", tmp_path / "example")
    compiler = find_engine("gfortran", "gfortran")
    assert main(["model", "build-umat", str(found.parent / "ohde.f"), "--compiler", str(compiler)]) == 0
    return found


def strain(first: float, last: float) -> float:
    """Of a confined specimen from one vertical stress to another, kPa, on first loading, K0 = nu/(1 - nu)."""
    m, nu = TRUTH["m"], 0.3
    confined = TRUTH["E_ref"] * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
    mean = (1.0 + 2.0 * nu / (1.0 - nu)) / 3.0
    scale = confined * (mean / 100.0) ** m * (1.0 - m)
    return (last ** (1.0 - m) - first ** (1.0 - m)) / scale


def test_the_routine_gives_the_closed_form(problem: Path) -> None:
    loaded = load_problem(problem)
    (observed,) = loaded.observations
    found = loaded.model.prepare({observed.series: observed.x})({**TRUTH, "nu": 0.3})[observed.series]
    expected = [strain(12.5, load) for load in (25.0, 50.0, 100.0, 200.0)]
    for load in (50.0, 12.5, 200.0):
        expected.append(expected[3] - strain(load, 200.0) / TRUTH["ratio"])
    expected += [expected[3] + strain(200.0, load) for load in (400.0, 800.0)]
    assert found == pytest.approx(expected, abs=5.0e-5)


@pytest.mark.slow
def test_the_true_values_lie_in_the_intervals(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = calibrated(problem, tmp_path / "out", capsys)
    assert found.keys() == TRUTH.keys()
    for name, value in TRUTH.items():
        assert found[name].lower < value < found[name].upper
        assert found[name].upper / found[name].lower < 1.2


def test_the_readings_are_those_of_the_routine(problem: Path) -> None:
    runpy.run_path(str(problem.parent / "generate_data.py"), run_name="__main__")
    assert_same_readings("umat", problem.parent, digit=0.001)


def test_the_missing_library_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem = copy_of("umat", tmp_path / "example")
    (problem.parent / "libohde.so").unlink(missing_ok=True)
    assert main(["check", str(problem)]) == 2
    assert f"forward_model.material.library: libohde.so is not in {problem.parent}" in capsys.readouterr().err
