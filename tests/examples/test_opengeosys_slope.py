"""A plastic slope with OpenGeoSys and with finite elements of our own: the same displacements, the same parameters."""

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
from tests.examples.engines import HERE, OPENGEOSYS, assert_same_readings, calibrated, copy_of, from_pypi

TRUTH = {"E": 20_000.0, "c": 6.0, "phi": 20.0}
SERIES = ("crest_uy", "behind_uy", "face_ux", "toe_ux")
DAYS = np.arange(1.0, 9.0)

pytestmark = [pytest.mark.slow, pytest.mark.timeout(2400)]


@pytest.fixture
def problem(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PATH", str(from_pypi(*OPENGEOSYS)), prepend=os.pathsep)
    return copy_of("opengeosys_slope", tmp_path / "example")


def theirs(problem: Path, values: dict[str, float]) -> FloatArray:
    """Displacements of the four series on eight days, (4, 8), mm, by OpenGeoSys."""
    found = load_problem(problem).model.prepare(dict.fromkeys(SERIES, DAYS))(values)
    return 1000.0 * np.array([found[name] for name in SERIES])


def ours(problem: Path, values: dict[str, float]) -> FloatArray:
    """The same by our own finite elements."""
    names = [name.replace("_", ".") for name in SERIES]
    found = load_problem(problem.with_name("own_elements.yaml")).model.prepare(dict.fromkeys(names, DAYS))(values)
    return 1000.0 * np.array([found[name] for name in names])


def replace(path: Path, *changes: tuple[str, str]) -> None:
    """Replace texts in a file; each must be there."""
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def rounded(problem: Path, poisson: str, transition: str, apex: str) -> None:
    """Change Poisson's ratio of both models, and how much the limit of OpenGeoSys is rounded."""
    replace(problem.with_name("own_elements.yaml"), ("nu: 0.35", f"nu: {poisson}"))
    replace(
        problem.with_name("slope.prj.in"),
        ("<value>0.35<", f"<value>{poisson}<"),
        ("<value>29<", f"<value>{transition}<"),
        ("<value>0.1<", f"<value>{apex}<"),
    )


@pytest.mark.parametrize(
    "values",
    [
        TRUTH,
        {"E": 20_000.0, "c": 8.0, "phi": 20.0},
        {"E": 8_000.0, "c": 5.0, "phi": 23.0},
        {"E": 60_000.0, "c": 12.0, "phi": 14.5},
    ],
    ids=lambda values: "-".join(f"{value:g}" for value in values.values()),
)
def test_both_move_alike(problem: Path, values: dict[str, float]) -> None:
    """Within a thousandth of the settlement; much of the slope yields."""
    found, expected = theirs(problem, values), ours(problem, values)
    assert found == pytest.approx(expected, abs=1.0e-3 * np.abs(expected).max())
    elastic = expected[:, :1] * DAYS
    assert np.abs(expected - elastic).max() > 0.005 * np.abs(expected).max()


def test_both_move_alike_on_a_finer_mesh(problem: Path) -> None:
    """More triangles move both by the same: the agreement is none of one mesh, and the mesh is fine enough."""
    coarse = ours(problem, TRUTH)
    own = problem.with_name("own_elements.yaml")
    replace(own, ("rows: 6", "rows: 8"), ("element_length: 2.5\n", "element_length: 2\n"))
    runpy.run_path(str(problem.with_name("mesh.py")), run_name="__main__")
    fine = ours(problem, TRUTH)
    assert theirs(problem, TRUTH) == pytest.approx(fine, abs=0.02)
    change = np.abs(fine - coarse).max(axis=1)
    assert np.all(change > 0.02)
    assert np.all(change < 0.02 * np.abs(coarse[:, -1]))


def test_the_rounded_limit_does_not_matter_here(problem: Path) -> None:
    """Corners rounded from 25 degree on and an apex of 1 kPa change nothing above 0.02 mm."""
    sharp = theirs(problem, TRUTH)
    rounded(problem, "0.35", "25", "1")
    assert theirs(problem, TRUTH) == pytest.approx(sharp, abs=0.02)


def test_where_ground_yields_at_rest_the_rounded_limit_matters(problem: Path) -> None:
    """With nu 0.3 level ground yields with equal horizontal stresses, at a corner: 0.3 % apart, rounded more 1.5 %."""
    rounded(problem, "0.3", "29", "0.1")
    expected = ours(problem, TRUTH)
    sharp = np.abs(theirs(problem, TRUTH) - expected).max()
    replace(problem.with_name("slope.prj.in"), ("<value>29<", "<value>25<"), ("<value>0.1<", "<value>1<"))
    blunt = np.abs(theirs(problem, TRUTH) - expected).max()
    largest = np.abs(expected).max()
    assert 0.001 * largest < sharp < 0.005 * largest
    assert 0.008 * largest < blunt < 0.025 * largest


def test_both_identify_the_same_parameters(problem: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = calibrated(problem, tmp_path / "theirs", capsys)
    own = calibrated(problem.with_name("own_elements.yaml"), tmp_path / "ours", capsys)
    assert found.keys() == own.keys() == TRUTH.keys()
    for name, value in TRUTH.items():
        assert found[name].value == pytest.approx(own[name].value, rel=0.01)
        for one in (found[name], own[name]):
            assert one.lower < value < one.upper
            assert one.upper / one.lower < 1.25


def test_without_an_equilibrium_both_diverge(problem: Path) -> None:
    weak = TRUTH | {"c": 2.0, "phi": 12.0}
    for calculate in (theirs, ours):
        with pytest.raises(ForwardError) as failed:
            calculate(problem, weak)
        assert failed.value.reason == "diverged"


def test_the_readings_are_those_of_the_program(problem: Path) -> None:
    runpy.run_path(str(problem.parent / "generate_data.py"), run_name="__main__")
    assert_same_readings("opengeosys_slope", problem.parent, digit=0.01)


def test_both_problems_ask_for_the_same(problem: Path) -> None:
    one, other = load_problem(problem), load_problem(problem.with_name("own_elements.yaml"))
    for mine, yours in zip(one.observations, other.observations, strict=True):
        assert mine.series == yours.series.replace(".", "_")
        assert (mine.x.tolist(), mine.y.tolist(), mine.error) == (yours.x.tolist(), yours.y.tolist(), yours.error)
    documents = (one.document(), other.document())
    for key in ("parameters", "method", "stopping", "seed"):
        assert documents[0][key] == documents[1][key]


def test_the_meshes_are_those_of_the_script(tmp_path: Path) -> None:
    for name in ("mesh.py", "own_elements.yaml", *(f"{series}.csv" for series in SERIES)):
        shutil.copy(HERE / "opengeosys_slope" / name, tmp_path)
    runpy.run_path(str(tmp_path / "mesh.py"), run_name="__main__")
    made = {path.name: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.vtu")}
    there = {path.name: path.read_text(encoding="utf-8") for path in (HERE / "opengeosys_slope").glob("*.vtu")}
    assert made == there
    assert len(made) == 4
