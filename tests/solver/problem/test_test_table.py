"""A table of tests becomes parts and observations of a combined problem; a mistake is one of its row."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.parameter_estimates.proposal import with_parameters
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.problem.draft import inlined_document

_OEDOMETER = "sigma_v [MPa],e [-]\n0.01,1.0\n0.1,0.97\n0.4,0.94\n0.1,0.945\n"
_DRAINED = "eps_1 [%],q [kPa],eps_v [%],remark\n1,80,0.4,\n5,200,-1.0,\n10,190,-3.0,end\n"
_UNDRAINED = "eps_1 [%],eps_3 [%],q [kPa],u [kPa]\n1,-0.5,60,20\n4,-2,110,45\n"
_TABLE = (
    "test;file;type;cell pressure [MPa];e0;back pressure [kPa];q_error\n"
    "OE-1;oe.csv;Oedometer;;;;\n"
    "TMD;cd.csv;CD;0.1;0.75;;2\n"
    "TMU;cu.csv;triaxial undrained;0.2;0.85;300;\n"
)
_SAND = {"phi_c": 33, "n": 0.3, "e_d0": 0.68, "e_c0": 1.05, "e_i0": 1.2, "alpha": 0.14, "beta": 2.5}
_REST: dict[str, Any] = {
    "name": "sand",
    "parameters": {"h_s": {"lower": 1e5, "upper": 1e7, "scale": "log"}} | {k: {"value": v} for k, v in _SAND.items()},
    "stopping": {"max_evaluations": 50},
}


def _written(folder: Path, tests: Any = None, table: str = _TABLE, **rest: Any) -> Path:
    files = {"oe.csv": _OEDOMETER, "cd.csv": _DRAINED, "cu.csv": _UNDRAINED, "tests.csv": table}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    tests = {"table": "tests.csv", "material": "hypoplastic_sand"} if tests is None else tests
    path = folder / "problem.json"
    path.write_text(json.dumps({**_REST, "tests": tests, **rest}), encoding="utf-8")
    return path


def _issues(path: Path) -> list[str]:
    with pytest.raises(ProblemError) as caught:
        load_problem(path)
    return [str(issue) for issue in caught.value.issues]


def test_a_table_is_the_combined_problem_that_one_would_write(tmp_path: Path) -> None:
    problem = load_problem(_written(tmp_path))
    sand = {"material": "hypoplastic_sand"}
    by_hand = {
        **_REST,
        "weighting": "by_test",
        "forward_model": {
            "kind": "combined",
            "parts": {
                "OE_1": {
                    **sand,
                    "kind": "oedometer",
                    "height": 0.02,
                    "initial_stress": 10,
                    "initial_void_ratio": 1,
                    "stages": [{"stress": stress, "duration": 1} for stress in (100, 400, 100)],
                },
                "TMD": {
                    **sand,
                    "kind": "triaxial",
                    "initial_stress": 100,
                    "initial_void_ratio": 0.75,
                    "shearing": [{"kind": "monotonic", "axial_strain": 0.1}],
                },
                "TMU": {
                    **sand,
                    "kind": "triaxial",
                    "initial_stress": 200,
                    "initial_void_ratio": 0.85,
                    "drainage": "undrained",
                    "back_pressure": 300,
                    "shearing": [{"kind": "monotonic", "axial_strain": 0.04}],
                },
            },
        },
        "observations": [
            {
                "series": "OE_1.stage_void_ratio",
                "points": {"x": [1, 2, 3], "y": [0.97, 0.94, 0.945]},
                "y_unit": "dimensionless",
            },
            *(
                {"series": series, "points": {"x": x, "y": y}, "x_unit": "%", "y_unit": unit, **more}
                for series, x, y, unit, more in (
                    ("TMD.q", [1, 5, 10], [80, 200, 190], "kPa", {"error": 2}),
                    ("TMD.volumetric_strain", [1, 5, 10], [0.4, -1, -3], "%", {}),
                    ("TMU.q", [1, 4], [60, 110], "kPa", {}),
                    ("TMU.pore_pressure", [1, 4], [20, 45], "kPa", {}),
                )
            ),
        ],
    }

    def without_notes(document: dict[str, Any]) -> dict[str, Any]:
        for one in document["observations"]:
            one.pop("notes", None)
        return document

    expected = parse_problem(by_hand).document()
    assert without_notes(problem.document()) == without_notes(expected)
    assert parse_problem(inlined_document(tmp_path / "problem.json")).document() == problem.document()


def test_rows_may_be_a_list_with_columns_by_name_beside_parts_written_out(tmp_path: Path) -> None:
    row = {"name": "slow", "kind": "oedometer", "file": "oe.csv", "x": "sigma_v", "void_ratio": "e"}
    row |= {"initial_stress": 5, "initial_void_ratio": 1.01, "material": "hypoplastic_sand", "void_ratio_error": 0.002}
    part = {"kind": "triaxial", "material": "hypoplastic_sand", "initial_stress": 50, "initial_void_ratio": 0.8}
    part["shearing"] = [{"kind": "monotonic", "axial_strain": 0.1}]
    model = {"kind": "combined", "parts": {"other": part}}
    given = [{"series": "other.q", "points": {"x": [0.05], "y": [90]}, "error": 1}]
    path = _written(tmp_path, [row], forward_model=model, observations=given, weighting="by_error")
    problem = load_problem(path)
    assert [o.series for o in problem.observations] == ["other.q", "slow.stage_void_ratio"]
    assert problem.observations[1].x.tolist() == [1, 2, 3, 4]
    assert problem.observations[1].error == 0.002
    assert problem.weighting == "by_error"


_LINE = "tests: tests.csv line 2"


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("a;cd.csv;CD;0.1;loose;;", f"{_LINE}, column 'e0': must be a number, got text 'loose'"),
        ("a;cd.csv;CD;0.1;-0.7;;", f"{_LINE}, column 'e0': must be above 0, got -0.7"),
        ("a;cd.csv;CD;;0.7;;", f"{_LINE}, column 'cell pressure [MPa]': is missing; a stress above 0 kPa is accepted"),
        (
            "a;cd.csv;shear box;0.1;0.7;;",
            f"{_LINE}, column 'type': must be 'oedometer', 'isotropic_compression' or 'triaxial', got text 'shear box'",
        ),
        ("a;no.csv;CD;0.1;0.7;;", f"{_LINE}, column 'file': no such file"),
        ("a;cd.csv;CD;0.1;0.7;-3;", f"{_LINE}, column 'back pressure [kPa]': must be at least 0, got -3"),
        ("a;oe.csv;oedometer;0.1;;;", f"{_LINE}, column 'cell pressure [MPa]': is for kind: triaxial"),
        ("a;oe.csv;CD;0.1;0.7;;", f"{_LINE}, x: no heading of the file means the axial strain (headings: sigma_v"),
        ("a;cd.csv;CD;0.1;0.7;;0", f"{_LINE}, column 'q_error': must be above 0, got 0"),
        ("a;cd.csv;CD;0.1;;;", f"{_LINE}, column 'e0': is missing: material hypoplastic_sand needs it; the void ratio"),
        (
            "a;cd.csv;CD;0.1;0.7;;\na;cu.csv;CU;0.1;0.7;;",
            "tests: tests.csv line 3, column 'test': is 'a', which another",
        ),
    ],
)
def test_a_bad_row_is_told_by_its_line_and_column(tmp_path: Path, row: str, message: str) -> None:
    table = f"{_TABLE.splitlines()[0]}\n{row}\n"
    found = _issues(_written(tmp_path, table=table))
    assert any(one.startswith(message) for one in found), found


def test_a_mistake_that_rows_share_is_said_once(tmp_path: Path) -> None:
    heading = _TABLE.splitlines()[0]
    table = "".join(f"t{number};cd.csv;CD;0.1;;;\n" for number in range(8))
    (found,) = _issues(_written(tmp_path, table=f"{heading}\n{table}"))
    assert found.startswith("tests: tests.csv lines 2, 3, 4, 5, 6 and 3 others, column 'e0': is missing: material")
    row = {"kind": "CD", "file": "cd.csv", "material": "hypoplastic_sand", "initial_void_ratio": 0.7}
    rows = [{**row, "name": name, "cell_pressure": -1} for name in ("a", "b", "c")]
    assert _issues(_written(tmp_path, rows)) == [
        "tests[0].cell_pressure: must be above 0, got -1 (also tests[1] and tests[2])"
    ]


def test_a_column_of_stresses_names_its_unit(tmp_path: Path) -> None:
    path = _written(tmp_path, table=_TABLE.replace("cell pressure [MPa]", "cell pressure"))
    assert _issues(path)[0] == (
        "tests: tests.csv line 3, column 'cell pressure': has no unit; name it in the heading, such as "
        "cell_pressure [kPa]"
    )


def test_mistakes_of_a_list_have_their_place(tmp_path: Path) -> None:
    row = {"kind": "triaxial", "file": "cd.csv", "material": "hypoplastic_sand", "cell_pressure": 100, "voids": 0.7}
    found = _issues(_written(tmp_path, [row]))
    assert found[0].startswith("tests[0].voids: unknown key; accepted: name, kind, file")
    found = _issues(_written(tmp_path, [row | {"voids": None, "kind": "CD", "drainage": "undrained"}]))
    assert found == ["tests[0].drainage: is text 'undrained', but kind is 'CD'; give one"]
    found = _issues(_written(tmp_path, {"material": "hypoplastic_sand"}))
    assert found == ["tests: give either table (a file) or rows (a list of tests); neither is given"]
    found = _issues(_written(tmp_path, forward_model={"kind": "oedometer"}))
    assert found[0].startswith("forward_model: with tests only kind: combined is accepted")


def test_loads_of_laws_of_time_need_a_duration(tmp_path: Path) -> None:
    tests = [{"kind": "oedometer", "file": "oe.csv", "material": "soft_soil_creep"}]
    assert _issues(_written(tmp_path, tests))[0].startswith("tests[0].stage_duration: is missing: time has an effect")


def test_files_of_a_table_are_not_read_for_the_network() -> None:
    with pytest.raises(ProblemError, match="files can only be read beside a problem file; geoswarm inline PROBLEM"):
        parse_problem({**_REST, "tests": "tests.csv"})
    row = {"kind": "oedometer", "file": "/etc/passwd", "material": "hypoplastic_sand"}
    with pytest.raises(ProblemError, match=r"tests\[0\]\.file: files can only be read beside a problem file"):
        parse_problem({**_REST, "tests": [row]})


def test_readings_without_stress_are_left_out_wherever_they_are(tmp_path: Path) -> None:
    """A specimen as published: placed under no stress, unloaded to none, and loaded again."""
    path = _written(tmp_path)
    stresses, voids = [0, 0.001, 0.05, 0.4, 0.05, 0, 0.05], [1.02, 1.0, 0.98, 0.94, 0.945, 0.96, 0.95]
    rows = "".join(f"{stress},{e}\n" for stress, e in zip(stresses, voids, strict=True))
    (tmp_path / "oe.csv").write_text(f"sigma_v [MPa],e [-]\n{rows}", encoding="utf-8")
    problem = load_problem(path)
    part = problem.document()["forward_model"]["parts"]["OE_1"]
    assert (part["initial_stress"], part["initial_void_ratio"]) == (1, 1.0)
    assert [stage["stress"] for stage in part["stages"]] == [50, 400, 50, 50]
    assert problem.observations[0].points.y == [0.98, 0.94, 0.945, 0.95]
    assert problem.observations[0].notes[-1] == "2 readings without stress left out"


def test_the_deviatoric_strain_is_no_axial_strain(tmp_path: Path) -> None:
    path = _written(tmp_path)
    text = _DRAINED.replace("eps_1 [%],", "eps1 [%],epsq [%],").replace("\n1,", "\n1,0.9,").replace("\n5,", "\n5,4,")
    (tmp_path / "cd.csv").write_text(text.replace("\n10,", "\n10,8,"), encoding="utf-8")
    shearing = load_problem(path).document()["forward_model"]["parts"]["TMD"]["shearing"]
    assert [one["axial_strain"] for one in shearing] == [0.1]


def test_parameters_are_proposed_for_the_tests_of_a_table(tmp_path: Path) -> None:
    path = _written(tmp_path)
    document = {key: value for key, value in json.loads(path.read_text()).items() if key != "parameters"}
    path.write_text(json.dumps(document), encoding="utf-8")
    assert {"h_s", "n", "e_c0"} <= {*load_problem(path, with_parameters).free_names}


def test_readings_of_shearing_before_its_beginning_can_be_left_out(tmp_path: Path) -> None:
    table = "file;type;cell pressure [kPa];e0;x_from;x_to\ncd.csv;CD;100;0.75;0;7\noe.csv;oedometer;;;;\n"
    path = _written(tmp_path, table=table)
    (tmp_path / "cd.csv").write_text("eps_1 [%],q [kPa]\n-0.01,0\n1,80\n5,200\n10,190\n", encoding="utf-8")
    sheared = next(one for one in load_problem(path).observations if one.series == "cd.q")
    assert sheared.x == pytest.approx([0.01, 0.05])
    (tmp_path / "tests.csv").write_text(table.replace("oedometer;;;;", "oedometer;;;1;"), encoding="utf-8")
    assert "tests.csv line 3, column 'x_from': unknown key" in _issues(path)[0]
