"""A spreadsheet that LibreOffice calculates: compared with its formula, calibrated, and errors in cells told."""

from __future__ import annotations

import json
import math
import runpy
import shutil
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.problem import load_problem
from tests.examples.engines import HERE, assert_identified, assert_same_readings, copy_of, find_engine

TRUTH = {"Cc": 0.45, "sigma_p": 75.0}

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    find_engine("soffice", "libreoffice-calc")
    return copy_of("python_spreadsheet", tmp_path / "example")


def test_the_true_values_lie_in_the_intervals(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert_identified(problem, tmp_path / "out", capsys, TRUTH, ratio=1.05)


def test_the_readings_are_those_of_the_program(problem: Path) -> None:
    runpy.run_path(str(problem.parent / "generate_data.py"), run_name="__main__")
    assert_same_readings("python_spreadsheet", problem.parent, digit=0.1)


def test_it_calculates_its_formula(problem: Path) -> None:
    loaded = load_problem(problem)
    loads = loaded.observations[0].x
    found = loaded.model.prepare({"settlement": loads})(TRUTH)["settlement"]
    for load, settlement in zip(loads.tolist(), found.tolist(), strict=True):
        stress = 40.0 + load
        again = 0.05 * math.log10(min(stress, 75.0) / 40.0) + 0.45 * math.log10(max(stress, 75.0) / 75.0)
        assert settlement == pytest.approx(4.0 / 2.1 * again, rel=1e-12)


def test_an_error_in_a_cell_is_reported(problem: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sheet = problem.with_name("settlement.fods.in")
    sheet.write_text(sheet.read_text(encoding="utf-8").replace("LOG10(MIN", "LOG10(-MIN"), encoding="utf-8")
    assert main(["model", "try", str(problem), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    shutil.rmtree(document["runs"][0]["folder"])
    assert document["reason"] == "infeasible"
    assert "ERROR IN A CELL of settlement.csv" in document["runs"][0]["failure"]


def test_the_sheet_is_that_of_the_script() -> None:
    script = runpy.run_path(str(HERE / "python_spreadsheet" / "make_sheet.py"))
    there = (HERE / "python_spreadsheet" / "settlement.fods.in").read_text(encoding="utf-8")
    assert script["sheet"]() == there
