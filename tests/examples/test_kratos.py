"""An embankment built in stages with Kratos Geomechanics, installed from PyPI: calibrated, and compared with ours."""

from __future__ import annotations

import os
import runpy
import shutil
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError
from geoswarm.solver.problem import load_problem
from tests.examples.engines import HERE, KRATOS, assert_same_readings, calibrated, copy_of, from_pypi

TRUTH = {"E_clay": 3000.0, "E_sand": 25_000.0}
SERIES = ("axis_uy", "middle_uy", "toe_ux", "toe_uy")
DAYS = np.arange(1.0, 4.0)

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]


@pytest.fixture
def problem(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PATH", str(from_pypi(*KRATOS)), prepend=os.pathsep)
    return copy_of("kratos", tmp_path / "example")


def moved(path: Path, dot: str) -> FloatArray:
    """Displacements of the four series after each lift, (4, 3), m."""
    names = [name.replace("_", dot) for name in SERIES]
    found = load_problem(path).model.prepare(dict.fromkeys(names, DAYS))(TRUTH)
    return np.array([found[name] for name in names])


def test_the_true_values_lie_in_the_intervals_and_ours_finds_the_same(
    problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = calibrated(problem, tmp_path / "theirs", capsys)
    own = calibrated(problem.with_name("own_elements.yaml"), tmp_path / "ours", capsys)
    assert found.keys() == own.keys() == TRUTH.keys()
    for name, value in TRUTH.items():
        assert found[name].lower < value < found[name].upper
        assert found[name].upper / found[name].lower < 1.5
        assert found[name].value == pytest.approx(own[name].value, rel=1e-4)


def test_each_lift_moves_our_own_elements_alike(problem: Path) -> None:
    theirs, ours = moved(problem, "_"), moved(problem.with_name("own_elements.yaml"), ".")
    assert theirs == pytest.approx(ours, abs=1e-6 * np.abs(ours).max())


def test_the_stages_matter(problem: Path) -> None:
    """A lift on a lift that is there settles less at the surface of the ground than its share of all at once."""
    own = problem.with_name("own_elements.yaml")
    ours = moved(own, ".")
    text = own.read_text(encoding="utf-8")
    own.write_text(
        text.replace("activate: [lift_1]}", "activate: [lift_1, lift_2, lift_3]}")
        .replace(", activate: [lift_2]", "")
        .replace(", activate: [lift_3]", ""),
        encoding="utf-8",
    )
    at_once = moved(own, ".")
    assert np.abs(at_once[:, -1] - ours[:, -1]).max() > 0.01 * np.abs(ours).max()


def test_a_mistake_is_told_with_what_was_printed(problem: Path) -> None:
    template = problem.with_name("materials.json.in")
    text = template.read_text(encoding="utf-8")
    template.write_text(text.replace("GeoLinearElasticPlaneStrain2DLaw", "GeoElasticLaw"), encoding="utf-8")
    with pytest.raises(ForwardError, match="GeoElasticLaw") as failed:
        moved(problem, "_")
    assert failed.value.reason == "program_failed"


def test_the_readings_are_those_of_the_program(problem: Path) -> None:
    runpy.run_path(str(problem.parent / "generate_data.py"), run_name="__main__")
    assert_same_readings("kratos", problem.parent, digit=0.1)


def test_both_problems_ask_for_the_same(problem: Path) -> None:
    one, other = load_problem(problem), load_problem(problem.with_name("own_elements.yaml"))
    for mine, yours in zip(one.observations, other.observations, strict=True):
        assert mine.series == yours.series.replace(".", "_")
        assert (mine.x.tolist(), mine.y.tolist(), mine.error) == (yours.x.tolist(), yours.y.tolist(), yours.error)
    for key in ("parameters", "method", "stopping", "seed"):
        assert one.document()[key] == other.document()[key]


def test_the_mesh_is_that_of_the_script(tmp_path: Path) -> None:
    for name in ("make_model.py", "own_elements.yaml", *(f"{series}.csv" for series in SERIES)):
        shutil.copy(HERE / "kratos" / name, tmp_path)
    runpy.run_path(str(tmp_path / "make_model.py"), run_name="__main__")
    made = (tmp_path / "embankment.mdpa").read_text(encoding="utf-8")
    assert made == (HERE / "kratos" / "embankment.mdpa").read_text(encoding="utf-8")
