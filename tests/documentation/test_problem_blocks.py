"""Problems that pages show are accepted: whole ones as they stand, parts of one in the smallest problem."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

import geoswarm as gs
from geoswarm.cli import main
from geoswarm.solver.problem.draft import inlined_document
from geoswarm.solver.problem.observation_section import ObservationSection
from tests.contracts.repository import ROOT
from tests.documentation.pages import block

EXAMPLE = ROOT / "examples" / "oedometer" / "problem.yaml"
FILE = "docs/problem-file.md"
ELEMENTS = "docs/finite-elements.md"
STATIC: dict[str, Any] = {
    "soil": {"law": "elastic", "E": "E", "nu": 0.3, "unit_weight": 18},
    "rock": {"law": "elastic", "E": 1e6, "nu": 0.25, "unit_weight": 22},
    "joint": {"law": "interface", "normal_stiffness": 5e4, "shear_stiffness": 5e3, "c": 10, "phi": 30},
    "clay": {
        **{"law": "soft_soil_creep", "lambda_star": 0.06, "kappa_star": 0.03, "mu_star": 1e-3, "c": 5, "phi": 25},
        **{"psi": 0, "unit_weight": 20},
    },
}
BODY = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
1 1 "base"
1 2 "sides"
1 3 "fault"
2 4 "ground"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 25 0 0
3 25 15 0
4 0 15 0
5 25 30 0
6 0 30 0
$EndNodes
$Elements
10
1 1 2 1 1 1 2
2 1 2 2 2 1 4
3 1 2 2 2 4 6
4 1 2 2 2 2 3
5 1 2 2 2 3 5
6 1 2 3 3 4 3
7 2 2 4 1 1 2 3
8 2 2 4 1 1 3 4
9 2 2 4 1 4 3 5
10 2 2 4 1 4 5 6
$EndElements
"""


def part(page: str, key: str) -> dict[str, Any]:
    return dict(YAML(typ="safe", pure=True).load(block(page, key).text))


def whole(model: dict[str, Any], free: str, series: str, x: float, **fixed: float) -> dict[str, Any]:
    """The smallest problem with a forward model: one free parameter, one reading."""
    value = fixed.pop(free)
    return {
        "name": "part",
        "forward_model": model,
        "parameters": {free: {"lower": 0.5 * value, "upper": 2.0 * value, "initial": value}}
        | {name: {"value": number} for name, number in fixed.items()},
        "observations": [{"series": series, "points": {"x": [x], "y": [0.0]}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }


def calculated(document: dict[str, Any], folder: Path) -> float:
    """Objective of one forward run of a problem."""
    (folder / "problem.json").write_text(json.dumps(document), encoding="utf-8")
    found = gs.evaluate(gs.load_problem(folder / "problem.json"))
    assert found.objective is not None, found
    return found.objective


def test_the_problem_of_the_readme_is_valid(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "problem.yaml").write_text(block("README.md", "name: oedometer-san-cassiano").text, encoding="utf-8")
    (tmp_path / "settlement.csv").write_text("x,y\n1,0.01\n2879,0.1\n4319,0.2\n", encoding="utf-8")
    assert main(["check", str(tmp_path / "problem.yaml")]) == 0
    assert "oedometer-san-cassiano: valid" in capsys.readouterr().out


def test_the_first_problem_of_the_reference_is_the_example() -> None:
    assert block(FILE, "name: oedometer-san-cassiano").text == EXAMPLE.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("page", "key"),
    [
        (FILE, "answer: {max"),
        (FILE, "limits: {seconds"),
        (FILE, "failures:"),
        (FILE, "index_properties: {"),
        ("docs/index-properties.md", "index_properties:\n"),
    ],
)
def test_a_section_is_accepted(page: str, key: str) -> None:
    problem = gs.problem(gs.load_problem(EXAMPLE).document() | part(page, key))
    (name,) = part(page, key)
    assert problem.document()[name]


CAM_CLAY = {"M": 1.0, "lambda": 0.16, "kappa": 0.03, "nu": 0.25, "e0": 1.2}


@pytest.mark.parametrize(
    ("key", "free", "series", "x", "values"),
    [
        ("kind: crs_oedometer", "lambda", "axial_stress", 0.1, CAM_CLAY | {"k": 1e-4}),
        ("kind: consolidation", "lambda", "settlement", 1.5, CAM_CLAY | {"k": 1e-4}),
        ("kind: triaxial", "E", "q", 0.05, {"E": 2e4, "nu": 0.3, "c": 5.0, "phi": 30.0}),
        ("kind: direct_simple_shear", "lambda", "shear_stress", 0.1, CAM_CLAY),
    ],
)
def test_a_laboratory_test_of_the_reference_is_calculated(
    key: str, free: str, series: str, x: float, values: dict[str, float], tmp_path: Path
) -> None:
    document = whole(part(FILE, f"  {key}\n  material")["forward_model"], free, series, x, **values)
    assert calculated(document, tmp_path) > 0.0


def test_a_specimen_of_finite_elements_is_calculated(tmp_path: Path) -> None:
    soil = {"lambda_star": 0.08, "kappa_star": 0.02, "mu_star": 1e-3, "c": 5.0, "phi": 25.0, "psi": 0.0}
    model = part(ELEMENTS, "two axisymmetric triangles")["forward_model"]
    assert calculated(whole(model, "lambda_star", "settlement", 2.5, **soil), tmp_path) > 0.0


def test_the_section_with_its_phases_is_calculated(tmp_path: Path) -> None:
    """Both parts belong together: materials are named in the phases."""
    model = part(ELEMENTS, "kind: section")["forward_model"]
    assert model["materials"] == model["phases"] == "..."
    model |= {"materials": STATIC, **part(ELEMENTS, "- name: weight")}
    assert calculated(whole(model, "depth", "A.ux", 10000.0, depth=4.0, E=2e4), tmp_path) > 0.0


def test_a_mesh_of_ones_own_is_calculated(tmp_path: Path) -> None:
    (tmp_path / "slope.msh").write_text(BODY, encoding="ascii")
    model = part(ELEMENTS, "kind: finite_element")["forward_model"]
    assert model["materials"] == model["phases"] == "..."
    materials = {name: STATIC[name] for name in ("soil", "joint")}
    phases = [
        {"name": "weight", "kind": "gravity", "materials": {"ground": "soil", "fault": "joint"}},
        {"name": "load", "kind": "creep", "duration": 1.0},
    ]
    document = whole(model | {"materials": materials, "phases": phases}, "E", "A.uy", 1.0, E=2e4)
    assert calculated(document, tmp_path) == pytest.approx(0.0, abs=1e-12)  # elastic ground does not creep


def test_a_function_in_a_problem_file_is_calculated(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text(
        "def settlement(s):\n    return {'settlement': ([0.0, 1.0, 2.0], [0.0, s, 2 * s])}\n"
    )
    document = whole(part("docs/python.md", "kind: python")["forward_model"], "s", "settlement", 2.0, s=1.0)
    document["observations"][0] |= {"x_unit": "day", "y_unit": "mm"}
    assert calculated(document, tmp_path) == pytest.approx(4.0e-6, rel=1e-9)


@pytest.mark.parametrize("block", ["sheet: Oedometer 1", "blocks:"])
def test_keys_of_a_file_of_a_laboratory_are_those_of_an_observation(block: str) -> None:
    (observation,) = part("docs/laboratory-files.md", block)["observations"]
    given = ObservationSection.model_validate(observation)
    assert given.model_dump(exclude_unset=True).keys() == observation.keys()


def test_the_table_of_tests_is_read(tmp_path: Path) -> None:
    page = "docs/laboratory-files.md"
    (tmp_path / "problem.yaml").write_text(block(page, "name: karlsruhe-sand").text, encoding="utf-8")
    (tmp_path / "tests.csv").write_text(block(page, "name;  file;").text, encoding="utf-8")
    (tmp_path / "oe1.csv").write_text("stress [kPa],void ratio\n10,0.9\n100,0.88\n50,0.881\n", encoding="utf-8")
    (tmp_path / "tmd1.csv").write_text("axial strain [%],q [kPa],volumetric strain [%]\n2,150,0.1\n", encoding="utf-8")
    (tmp_path / "tmu1.csv").write_text("axial strain [%],q [kPa],pore pressure [kPa]\n2,90,120\n", encoding="utf-8")
    problem = gs.load_problem(tmp_path / "problem.yaml")
    assert [o.series for o in problem.observations] == [
        *("OE1.stage_void_ratio", "TMD1.q", "TMD1.volumetric_strain", "TMU1.q", "TMU1.pore_pressure"),
    ]
    further = block("docs/prediction.md", "name: twenty further tests").text
    (tmp_path / "further.yaml").write_text(further.replace("further.csv", "tests.csv"), encoding="utf-8")
    assert list(inlined_document(tmp_path / "further.yaml")["forward_model"]["parts"]) == ["OE1", "TMD1", "TMU1"]
