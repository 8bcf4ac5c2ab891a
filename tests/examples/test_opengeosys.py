"""Consolidation with OpenGeoSys, installed from PyPI: calibrated, and compared with Terzaghi's closed form."""

from __future__ import annotations

import math
import os
import runpy
import shutil
from pathlib import Path

import pytest

from geoswarm.solver.errors import ForwardError
from geoswarm.solver.problem import load_problem
from tests.examples.engines import HERE, OPENGEOSYS, assert_identified, assert_same_readings, copy_of, from_pypi

TRUTH = {"E_oed": 1800.0, "k": 2.0e-4}
LOAD, HEIGHT = 50.0, 5.0

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]


@pytest.fixture
def problem(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PATH", str(from_pypi(*OPENGEOSYS)), prepend=os.pathsep)
    return copy_of("opengeosys", tmp_path / "example")


def test_the_true_values_lie_in_the_intervals(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert_identified(problem, tmp_path / "out", capsys, TRUTH, ratio=1.05)


def test_the_readings_are_those_of_the_program(problem: Path) -> None:
    runpy.run_path(str(problem.parent / "generate_data.py"), run_name="__main__")
    assert_same_readings("opengeosys", problem.parent, digit=0.01)


def test_it_consolidates_as_terzaghi_says(problem: Path) -> None:
    """Settlement within 0.25 %, pore pressure within 0.15 kPa of 50 kPa: implicit time steps of 1/30 to 4 days."""
    loaded = load_problem(problem)
    days = {one.series: one.x for one in loaded.observations}
    found = loaded.model.prepare(days)(TRUTH | {"nu": 0.3})
    rate = TRUTH["E_oed"] * TRUTH["k"] / 9.81 / HEIGHT**2
    roots = [(j, 0.5 * math.pi * (2 * j + 1)) for j in range(400)]
    for index, day in enumerate(days["settlement"].tolist()):
        degree = 1.0 - sum(2.0 / m**2 * math.exp(-(m**2) * rate * day) for _, m in roots)
        excess = sum(2.0 * LOAD / m * (-1) ** j * math.exp(-(m**2) * rate * day) for j, m in roots)
        assert found["settlement"][index] == pytest.approx(LOAD * HEIGHT / TRUTH["E_oed"] * degree, rel=2.5e-3)
        assert found["pore_pressure"][index] == pytest.approx(excess, abs=0.15)


def test_a_mistake_in_the_project_is_told_with_what_was_printed(problem: Path) -> None:
    template = problem.with_name("column.prj.in")
    text = template.read_text(encoding="utf-8")
    template.write_text(text.replace("<type>HYDRO_MECHANICS</type>", "<type>HYDRO_MECHANIC</type>"), encoding="utf-8")
    loaded = load_problem(problem)
    run = loaded.model.prepare({one.series: one.x for one in loaded.observations})
    with pytest.raises(ForwardError, match="HYDRO_MECHANIC") as failed:
        run(TRUTH | {"nu": 0.3})
    assert failed.value.reason == "program_failed"


def test_the_meshes_are_those_of_the_script(tmp_path: Path) -> None:
    shutil.copy(HERE / "opengeosys" / "mesh.py", tmp_path)
    runpy.run_path(str(tmp_path / "mesh.py"), run_name="__main__")
    made = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.vtu")}
    there = {path.name: path.read_text(encoding="utf-8") for path in (HERE / "opengeosys").glob("*.vtu")}
    assert made == there
    assert len(made) == 5
