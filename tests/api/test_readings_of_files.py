"""Files as laboratories deliver them give one value each in problem files, from clients, uploaded and in the form."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.cli import main
from geoswarm.solver.ags.contents import contents_of, entries
from geoswarm.solver.ags.reading import read_ags
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem import Problem, load_problem, problem_yaml
from geoswarm.solver.problem.draft import inlined_document
from geoswarm.solver.units import convert
from tests.api.conftest import API, App
from tests.solver.ags.synthetic import content, groups
from tests.solver.ags.test_contents import compression
from tests.solver.problem.test_found_units import PERCENT, document
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_measurements import workbook

UNITS_ROW = sheet_rows(("Dehnung", "Deviator"), ("[-]", "[MPa]"), (0.001, 0.01), (0.01, 0.04), (0.1, 0.06))
SHOWN = "".join(
    f'<row r="{line}"><c r="A{line}" s="1"><v>{strain}</v></c><c r="B{line}"><v>{stress}</v></c></row>'
    for line, (strain, stress) in enumerate(((0.001, 10), (0.01, 40), (0.1, 60)), 2)
)
CASES: dict[str, tuple[str, bytes | str, dict[str, Any]]] = {
    "a row of units in a workbook": ("q.xlsx", workbook(("s", UNITS_ROW)), {"x_column": "A:A", "y_column": "B:B"}),
    "cells below a heading with its unit": (
        "q.xlsx",
        workbook(("s", sheet_rows(("eps [%]", "q [MPa]"), (0.1, 0.01), (1, 0.04), (10, 0.06)))),
        {"x_column": "A2:A4", "y_column": "B2:B4"},
    ),
    "a row of units in text": (
        "q.csv",
        "eps;q\n[%];[kPa]\n0,1;10\n1,0;40\n10,0;60\n",
        {"x_column": "eps", "y_column": "q", "incomplete_rows": "leave_out"},
    ),
    "cells shown as per cent": (
        "q.xlsx",
        workbook(("s", sheet_rows(("eps [%]", "q [kPa]")) + SHOWN), styles=PERCENT),
        {"x_column": "eps", "y_column": "q"},
    ),
    "lines of a machine": (
        "gds.csv",
        '"Test Name:","CU 100"\n"Sample Height (mm):","200.0"\n\n'
        '"Stage Number","Axial Strain (%)","Deviator Stress (kPa)"\n'
        "3,0.1,10\n3,1,40\n3,10,60\n",
        {"x_column": "Axial Strain (%)", "y_column": "Deviator Stress (kPa)"},
    ),
    "blanks": (
        "MT1.dat",
        "eps1   sigma3   q\n[%]    [kPa]    [kPa]\n\n0.1 605.038 10\n1 605.005 40\n10 604.971 60\n",
        {"x_column": "eps1", "y_column": "q"},
    ),
    "kg/cm2": (
        "ksc.csv",
        f"Axial strain [%],Deviator stress [kg/cm2]\n0.1,{10 / 98.0665}\n1,{40 / 98.0665}\n10,{60 / 98.0665}\n",
        {"x_column": "Axial strain", "y_column": "Deviator stress"},
    ),
}


def in_base_units(app: App, problem: dict[str, Any]) -> tuple[list[float], list[float]]:
    """x and y of a problem that a service was given."""
    answer = app.post(f"{API}/problems/read", json=problem).json()
    assert answer["issues"] == []
    (found,), points = answer["observations"], problem["observations"][0]["points"]
    return [value * found["x_factor"] for value in points["x"]], [value * found["y_factor"] for value in points["y"]]


def checked(problem: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any]:
    """x and y of the problem that ``geoswarm check`` tries."""
    seen: list[Problem] = []

    def told(found: Problem) -> None:
        seen.append(found)
        raise ProblemError([Issue("", "seen")])

    monkeypatch.setattr("geoswarm.solver.runs.check.check_problem", told)
    assert main(["check", str(problem)]) == 2
    (read,) = seen[0].observations
    return read.x, read.y


@pytest.mark.parametrize("case", CASES)
def test_every_way_gives_the_right_value(case: str, app: App, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name, text, keys = CASES[case]
    content = text.encode() if isinstance(text, str) else text
    (tmp_path / name).write_bytes(content)
    (tmp_path / "p.yaml").write_text(problem_yaml(document(name, **keys)))
    found: dict[str, tuple[Any, Any]] = {}
    (read,) = load_problem(tmp_path / "p.yaml").observations
    found["problem file"] = read.x, read.y
    found["command line"] = checked(tmp_path / "p.yaml", monkeypatch)
    found["client"] = in_base_units(app, inlined_document(tmp_path / "p.yaml"))
    query = {"name": name, "observation": json.dumps({"series": "q", **keys})}
    points = app.post(f"{API}/measurements/points", params=query, content=content).json()
    uploaded = {"series": "q", "points": {axis: points[axis] for axis in ("x", "y")}}
    uploaded |= {unit: points[unit] for unit in ("x_unit", "y_unit")}
    found["upload"] = in_base_units(app, document(name) | {"observations": [uploaded]})
    columns = app.post(f"{API}/measurements", params={"name": name}, content=content).json()["columns"]
    strain, stress = columns[-2 if name != "MT1.dat" else 0], columns[-1]
    found["form"] = tuple(
        convert([value for value in one["values"] if value is not None], one["unit"], base)
        for one, base in ((strain, "1"), (stress, "kPa"))
    )
    for way, (x, y) in found.items():
        np.testing.assert_allclose(x, [0.001, 0.01, 0.1], rtol=1e-12, err_msg=way)
        np.testing.assert_allclose(y, [10, 40, 60], rtol=1e-12, err_msg=way)


QUICK = '"DATA","BH2","9.00","7","U","","3","9.10",'
REMARK = b'"GROUP","GEOL"\r\n"HEADING","LOCA_ID","GEOL_DESC"\r\n"DATA","BH1","CLAY.\r\nRootlets"\r\n\r\n'
ROUNDED = compression([["1", 0.366, 50.0, 0.36], ["2", 0.359, 98.0, 0.35], ["3", 0.346, 198.0, 0.33]])
ROUNDED["CONS"] = ROUNDED["CONS"].replace('"0DP","3DP"', '"0DP","2DP"')
AGS: dict[str, tuple[bytes, str, str, list[float]]] = {
    "a row without a cell of its own": (
        content(TRIT=groups()["TRIT"].replace(QUICK, f'{QUICK}"","","",""\r\n{QUICK}')),
        "BH2/7/3/9.10",
        "1 specimen at failure; undrained shear strength 60 kPa",
        [],
    ),
    "a line break in a remark": (REMARK + content(), "GEOL", "the row of group GEOL is mended", []),
    "void ratios with two decimals": (content(**ROUNDED), "BH1/3/1/4.60", "3 increments", [0.359, 0.346, 0.33]),
}


@pytest.mark.parametrize("case", AGS)
def test_every_way_reads_the_same_of_an_ags_file(
    case: str, app: App, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, specimen, said, y = AGS[case]
    file = tmp_path / "a.ags"
    file.write_bytes(text)
    assert main(["import", "ags", str(file), "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert app.post(f"{API}/measurements/ags", params={"name": "a.ags"}, content=text).json()["items"] == listed
    assert [asdict(entry) for entry in entries(contents_of(read_ags(text, "a.ags")))] == listed
    assert any(one["id"] == specimen and said in one["what"] for one in listed)
    if not y:
        return
    query = {"name": "a.ags", "specimen": specimen}
    made = app.post(f"{API}/measurements/ags/problem", params=query, content=text).json()["problem"]
    assert made["observations"][0]["points"]["y"] == y
    assert main(["import", "ags", str(file), "--output", str(tmp_path / "out"), "--specimen", specimen]) == 0
    assert load_problem(tmp_path / "out" / "problem.yaml").observations[0].points.y == y
