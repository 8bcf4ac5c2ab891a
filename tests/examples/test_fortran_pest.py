"""The Fortran program with files of PEST: compiled, run and calibrated."""

from __future__ import annotations

import json
import math
import runpy
import subprocess
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.problem import load_problem
from tests.examples.engines import assert_identified, assert_same_readings, copy_of, find_engine

TRUTH = {"E_oed": 1800.0, "k": 2.0e-4}


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    """A copy of the example with its program."""
    found = copy_of("fortran_pest", tmp_path / "example")
    compiler = find_engine("gfortran", "gfortran")
    source, program = found.parent / "consolidation.f90", found.parent / "consolidation"
    subprocess.run([compiler, "-O2", "-o", program, source], check=True, capture_output=True)
    return found


@pytest.mark.slow
def test_the_true_values_lie_in_the_intervals(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert_identified(problem, tmp_path / "out", capsys, TRUTH, ratio=1.05)


def test_the_readings_are_those_of_the_program(problem: Path) -> None:
    runpy.run_path(str(problem.parent / "generate_data.py"), run_name="__main__")
    assert_same_readings("fortran_pest", problem.parent, digit=0.01)


def test_the_program_gives_the_closed_form(problem: Path) -> None:
    """Terzaghi: s = q h / E_oed U, u = sum of 2 q / m (-1)^j exp(-m^2 T)."""
    loaded = load_problem(problem)
    days = {one.series: one.x for one in loaded.observations}
    found = loaded.model.prepare(days)(TRUTH)
    rate = TRUTH["E_oed"] * TRUTH["k"] / 9.81 / 4.0**2
    for index, day in enumerate(days["settlement"] / 1.0):
        roots = [(j, 0.5 * math.pi * (2 * j + 1)) for j in range(200)]
        degree = 1.0 - sum(2.0 / m**2 * math.exp(-(m**2) * rate * day) for _, m in roots)
        excess = sum(2.0 * 50.0 / m * (-1) ** j * math.exp(-(m**2) * rate * day) for j, m in roots)
        assert found["settlement"][index] == pytest.approx(50.0 * 4.0 / TRUTH["E_oed"] * degree, abs=1e-8)
        assert found["pore_pressure"][index] == pytest.approx(excess, abs=1e-5)


def test_an_input_error_is_told_though_the_exit_status_is_0(problem: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = problem.read_text(encoding="utf-8").replace(
        "lower: 200, upper: 20000, scale: log", "lower: -200, upper: 20000"
    )
    problem.write_text(text, encoding="utf-8")
    assert main(["model", "try", str(problem), "--set", "E_oed=-100", "--json"]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out)["reason"] == "infeasible"
    assert "*** INPUT ERROR: STIFFNESS AND PERMEABILITY MUST BE POSITIVE" in printed.err


def test_the_missing_program_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    problem = copy_of("fortran_pest", tmp_path / "example")
    (problem.parent / "consolidation").unlink(missing_ok=True)
    assert main(["check", str(problem)]) == 2
    assert f"forward_model.files[0]: consolidation is not in {problem.parent}" in capsys.readouterr().err
