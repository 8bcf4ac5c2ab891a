"""``geoswarm estimate``: from a problem with readings to a first section of parameters."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.problem import load_problem
from geoswarm.solver.problem.text.reading import read_document

EXAMPLES = Path(__file__).parents[3] / "examples"
BARE = """\
index_properties: {liquid_limit: 65, plastic_limit: 28, soil_class: inorganic_clay}
forward_model:
  kind: consolidation
  material: soft_soil_creep
  height: 0.02
  drainage: one_side
  initial_stress: 50
  initial_void_ratio: 1.4
  stages: [{stress: 100, duration: 1}, {stress: 200, duration: 1}, {stress: 100, duration: 1}]
observations:
  - {series: settlement, file: settlement.csv, x_unit: min, y_unit: mm}
"""


@pytest.fixture
def bare(tmp_path: Path) -> Path:
    """The consolidation example without parameters, method and stopping."""
    (tmp_path / "settlement.csv").write_bytes((EXAMPLES / "consolidation" / "settlement.csv").read_bytes())
    path = tmp_path / "problem.yaml"
    path.write_text(BARE, encoding="utf-8")
    return path


def test_a_problem_without_parameters_gets_a_section_that_makes_it_whole(
    bare: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["estimate", str(bare)]) == 0
    told = capsys.readouterr().out
    assert "root time" in told
    assert "Terzaghi & Peck" in told
    section = told[told.index("parameters:") :]
    assert set(read_document(section, "yaml")["parameters"]) == {
        "lambda_star",
        "kappa_star",
        "mu_star",
        "c",
        "phi",
        "k",
    }
    bare.write_text(f"{BARE}stopping: {{max_evaluations: 100}}\n{section}", encoding="utf-8")
    problem = load_problem(bare)
    assert problem.parameters["k"].lower < 4.0e-5 < problem.parameters["k"].upper  # type: ignore[union-attr]  # free; what the readings were made with
    assert problem.constraints[0].text == "lambda_star > kappa_star"


def test_the_same_as_json(bare: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["estimate", str(bare), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"name", "classical", "index_properties", "parameters", "constraints"} == set(found)
    c_v = [one for one in found["classical"] if one["symbol"] == "c_v" and one["stage"] == 1]
    assert {one["unit"] for one in c_v} == {"m²/day"}
    first = next(one for one in found["index_properties"] if one["equation"] == "0.009 (w_L - 10)")
    assert first["quantity_value"] == pytest.approx(0.495)
    assert first["parameter"] == "lambda_star"


def test_mistakes_are_told_as_ever(bare: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bare.write_text(BARE.replace("height: 0.02", "height: -1"), encoding="utf-8")
    assert main(["estimate", str(bare)]) == 2
    assert "forward_model.height" in capsys.readouterr().err


def test_a_formula_has_nothing_to_be_estimated(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["estimate", str(EXAMPLES / "formula" / "problem.yaml")]) == 0
    told = capsys.readouterr()
    assert "No classical evaluation is possible from these readings." in told.err
    assert "as given" in told.out
