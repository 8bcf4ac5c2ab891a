"""A file whose columns nobody named: one question asks for all that is missing, with lines to copy."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import TableError, load_problem, problem_yaml, read_measurements
from tests.solver.problem.test_columns import OEDOMETER, mistakes
from tests.solver.problem.test_found_units import document, refused, triaxial
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_measurements import workbook

LOGGER = "0.1;10\n1;40\n10;60\n"


def answered(folder: Path, name: str, content: bytes | str, **other: Any) -> tuple[dict[str, Any], list[float]]:
    """The lines that the question suggests, with another answer where it was no more than an example; y then."""
    asked = refused(folder, name, content)
    lines = textwrap.dedent("\n".join(line for line in asked.splitlines() if line.startswith("    ")))
    keys = yaml.safe_load(lines)
    return keys, triaxial(folder, name, content, **{**keys, **other}).y.tolist()


def test_a_file_without_headings_needs_one_answer(tmp_path: Path) -> None:
    """Columns were asked for, then their units."""
    asked = refused(tmp_path, "a.csv", LOGGER)
    assert asked.startswith(
        "observations[0].file: a.csv: which columns hold x (axial strain) and y (q), and in what unit? Add, for "
        "example,\n    x_column: A:A  # 0.1, 1, 10\n    x_unit: '%'  # or dimensionless\n    y_column: B:B"
    )
    assert asked.endswith("\n  columns: A:A (0.1, 1, 10); B:B (10, 40, 60)")
    keys, y = answered(tmp_path, "a.csv", LOGGER, y_unit="MPa")
    assert keys == {"x_column": "A:A", "x_unit": "%", "y_column": "B:B", "y_unit": "kPa"}
    assert y == [1e4, 4e4, 6e4]


def test_columns_are_suggested_by_their_words_and_units(tmp_path: Path) -> None:
    """The first two columns of an exported file, its row and its stage, were suggested."""
    content = (
        "SourceRow,StageNumber,Time_s,AxialStrainRate_pct_min,AxialStrain_pct,q_kPa\n1,9,0,1,0.1,10\n2,9,1,1,1,40\n"
    )
    assert answered(tmp_path, "a.csv", content) == ({"x_column": "AxialStrain_pct", "y_column": "q_kPa"}, [10, 40])


@pytest.mark.parametrize("heading", ["# q: 1 [kPa]", "'q' [kPa]", "q: Deviator [kPa]"])
def test_headings_are_quoted_where_yaml_needs_it(heading: str, tmp_path: Path) -> None:
    content = workbook(("s", sheet_rows(("eps [%]", heading), (0.1, 10), (1, 40))))
    assert answered(tmp_path, "a.xlsx", content) == ({"x_column": "eps [%]", "y_column": heading}, [10, 40])


def test_thousands_and_specimens_belong_to_the_question(tmp_path: Path) -> None:
    content = "Probe;eps [%];q [kPa]\nA: 1;1;1,000\nA: 1;2;2,000\nB;1;1,500\nB;2;2,500\n"
    keys, y = answered(tmp_path, "a.csv", content)
    assert (keys["decimal_sign"], keys["where"]) == ("point", {"Probe": "A: 1"})
    assert y == [1000, 2000]
    assert answered(tmp_path, "a.csv", content, where={"Probe": "B"}, decimal_sign="comma")[1] == [1.5, 2.5]


def test_dates_that_may_be_read_in_two_ways_belong_to_the_question(tmp_path: Path) -> None:
    series = {"expression": "a * x", "x_unit": "day", "y_unit": "m"}
    problem = document("a.csv") | {
        "forward_model": {"kind": "formula", "series": {"settlement": series}},
        "parameters": {"a": {"lower": 0, "upper": 1}},
        "observations": [{"series": "settlement", "file": "a.csv"}],
    }
    (tmp_path / "a.csv").write_text("Datum;Setzung\n03/04/2024;1\n05/04/2024;2\n", encoding="utf-8")
    (tmp_path / "p.yaml").write_text(problem_yaml(problem), encoding="utf-8")
    with pytest.raises(ProblemError) as caught:
        load_problem(tmp_path / "p.yaml")
    keys = yaml.safe_load("\n".join(line[4:] for line in str(caught.value).splitlines() if line.startswith("    ")))
    assert keys == {"x_column": "Datum", "x_dates": "day_first", "y_column": "Setzung", "y_unit": "mm"}
    problem["observations"][0] |= keys
    (tmp_path / "p.yaml").write_text(problem_yaml(problem), encoding="utf-8")
    read = load_problem(tmp_path / "p.yaml").observations[0]
    np.testing.assert_allclose(read.y, [1e-3, 2e-3])


def test_what_is_given_is_not_asked_for(tmp_path: Path) -> None:
    asked = refused(tmp_path, "a.csv", LOGGER, x_column="A:A", x_unit="%", y_unit="kPa")
    assert "which column holds y (q)? Add" in asked
    assert "x_column" not in asked
    assert "y_unit" not in asked


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"pcf\n* control data\nrestart estimation\n2 3 1 0 1\n", "control"),
        (b"\xef\xbb\xbfPCF version=2\r\n* control data keyword\r\n", "control"),
        (b"ptf ~\n~a         ~\n~b         ~\n", "template or instruction"),
        (b"pif @\nl1 w !y_1!\nl1 w !y_2!\n", "template or instruction"),
    ],
)
def test_files_of_pest_are_named(content: bytes, kind: str) -> None:
    """They were tables without numbers."""
    with pytest.raises(TableError, match=f"m.pst is a {kind} file of PEST; geoswarm import pest .*.pst --output DIR"):
        read_measurements(content, "m.pst")


def test_a_heading_may_begin_as_a_file_of_pest() -> None:
    assert [one.name for one in read_measurements(b"pcf,q\n1,2\n3,4\n", "a.csv").columns] == ["pcf", "q"]


def test_one_of_several_sheets_alike_belongs_to_the_question(tmp_path: Path) -> None:
    rows = sheet_rows(("eps [%]", "q [kPa]"), (0.1, 10), (1, 40))
    keys, y = answered(tmp_path, "a.xlsx", workbook(("1", rows), ("2", rows)))
    assert (keys["sheet"], y) == ("1", [10, 40])


@pytest.mark.parametrize(
    ("content", "keys"),
    [
        ("0.1;10;A\n1;40;A\n10;60;B\n", {"x_column": "A:A", "y_column": "B:B"}),
        ("TMD2;0.1;10\nTMD2;1;40\nTMD22;10;60\n", {"x_column": "B:B", "y_column": "C:C"}),
        ("0.1 10 MAZA\n1 40 MOCH\n10 60 BLAG\n", {"x_column": "A:A", "y_column": "B:B"}),
    ],
)
def test_the_first_row_of_a_table_without_headings_may_have_texts(
    content: str, keys: dict[str, str], tmp_path: Path
) -> None:
    """It was taken as the headings, and its reading was lost without a word."""
    read = triaxial(tmp_path, "a.csv", content, **keys, x_unit="%", y_unit="kPa")
    assert read.x.tolist() == pytest.approx([0.001, 0.01, 0.1])
    assert read.y.tolist() == [10, 40, 60]
    assert f"x_column: {keys['x_column']}  # 0.1, 1, 10" in refused(tmp_path, "a.csv", content)


def test_loads_may_be_headings(tmp_path: Path) -> None:
    read = triaxial(
        tmp_path, "a.csv", "Probe;50;100\nA;1;40\nB;10;60\n", x_column="B:B", x_unit="%", y_column="C:C", y_unit="kPa"
    )
    assert read.y.tolist() == [40, 60]


@pytest.mark.parametrize(
    ("content", "lines"),
    [
        (  # a cell pressure, a pore pressure, a force and a stroke: nothing is a strain or a deviator yet
            "Zeit [s];Radialspg. [kPa];Porenwass. [kPa];Kraft [N];Stauchung [mm]\n"
            "0;450;405;3;0.01\n30;450;407;7;0.02\n",
            "x_column: Stauchung [mm]  # 0.01, 0.02\nx_unit: dimensionless\n"
            "x_factor: 0.001 / H  # the height H [m] of the specimen\ny_column: Kraft [N]  # 3, 7\n"
            "y_unit: kPa\ny_factor: 0.001 / A  # the area A [m2] of the specimen",
        ),
        (  # the change of the pore pressure was proposed
            "Deform_axial;Delta_U_(kPa);Sigma_d_(kPa);Sigma_3_(kPa)\n0;0;0;50\n0.2;2.2;52.9;50\n",
            "x_column: Deform_axial  # 0, 0.2\nx_unit: dimensionless  # or %\ny_column: Sigma_d_(kPa)  # 0, 52.9",
        ),
        (  # noise before the test
            "Axial Strain;Deviator Stress\n-0.02;1\n0;1.5\n0;1.6\n20;9\n",
            "x_column: Axial Strain  # -0.02, 0, 0\nx_unit: '%'  # or dimensionless\n"
            "y_column: Deviator Stress  # 1, 1.5, 1.6\ny_unit: kPa  # or MPa, kg/cm2\nx_from: 0  # x begins at -0.02",
        ),
        (  # a stress that rises, a compression that is negative
            "0\t0\t-99.7\n11\t-0.001\t-102\n277\t-0.2\t-300\n",
            "x_column: B:B  # 0, -0.001, -0.2\nx_unit: dimensionless  # or %\n"
            "y_column: A:A  # 0, 11, 277; or C:C: no heading says so\ny_unit: kPa  # or MPa, kg/cm2\n"
            "x_factor: -1  # no x is above 0",
        ),
        (  # the stage that was sheared
            "Stage Number;Axial Strain [%];q [kPa]\n1;0;0\n1;0.5;2\n2;0;0\n2;9;60\n",
            "x_column: Axial Strain [%]  # 0, 0.5, 0\ny_column: q [kPa]  # 0, 2, 0\nwhere: {Stage Number: 2}  # or 1",
        ),
        (
            "eps [%];q [kPa]\n0;0\n1;\n2;9\n",
            "x_column: eps [%]  # 0, 1, 2\ny_column: q [kPa]  # 0, 9\n"
            "incomplete_rows: leave_out  # 1 row has no number in one of the columns",
        ),
    ],
)
def test_one_question_holds_all_that_a_file_leaves_open(content: str, lines: str, tmp_path: Path) -> None:
    """A second refusal followed, or a column of another quantity was proposed."""
    asked = refused(tmp_path, "a.csv", content)
    assert "\n".join(line[4:] for line in asked.splitlines() if line.startswith("    ")) == lines
    if "/ H" not in lines:
        answered(tmp_path, "a.csv", content)


def test_columns_of_the_wrong_quantity_are_not_passed_off_as_the_right_one(tmp_path: Path) -> None:
    asked = refused(tmp_path, "a.csv", "eps1 [%];u [kPa]\n0;0\n1;5\n")
    assert "y_column: u [kPa]  # 0, 5; no heading says q" in asked


def test_the_question_names_headings_of_columns_that_letters_name(tmp_path: Path) -> None:
    rows = sheet_rows(("eps [%]", "q [kPa]", "eps [%]", "q [kPa]"), (0.1, 10, 0.2, 20), (1, 40, 2, 50))
    other = sheet_rows(("a", "b", "c", "d"), (1, 2, 3, 4), (2, 3, 4, 5))
    content = workbook(("1", rows), ("2", other))
    assert "x_column: A:A  # eps [%]: 0.1, 1\n" in refused(tmp_path, "a.xlsx", content)
    keys, y = answered(tmp_path, "a.xlsx", content)
    assert (keys["sheet"], y) == ("1", [10, 40])


def test_times_that_fall_or_repeat_belong_to_the_question(tmp_path: Path) -> None:
    asked = mistakes(tmp_path, "a.csv", "Zeit [min];Setzung [mm]\n4;0.3\n1;0.1\n1;0.2\n")
    assert "sort: true  # x does not always rise\n" in asked
    assert "repeated_x: average  # or shift: several rows have the same x\n" in asked


def test_doubts_and_units_of_columns_that_are_given_are_asked_together(tmp_path: Path) -> None:
    """One was asked after the other."""
    keys = {"x_column": "t", "y_column": "s"}
    asked = refused(tmp_path, "a.csv", "t;s\n1;1,000\n2;2,000\n", **keys)
    assert "x_unit: '%' or dimensionless" in asked
    dates = mistakes(tmp_path, "a.csv", "t;s\n03/04/2024;1,000\n05/04/2024;2,000\n", **keys)
    assert "x_dates: day_first" in dates
    for one in (asked, dates):
        assert "decimal_sign: comma reads 1" in one
        assert "y_unit: " in one


@pytest.mark.parametrize("heading", ["Force (N)", "Last (N)", "load_(N)"])
def test_newtons_of_a_force_are_no_symbol(heading: str, tmp_path: Path) -> None:
    """The unit of the series was offered: it made kPa of the newtons."""
    told = refused(tmp_path, "q.csv", f"eps [-];{heading}\n0.001;10\n0.01;40\n", x_column="eps", y_column=heading)
    assert "is in N, a force, but the series needs a stress" in told


@pytest.mark.parametrize(
    ("content", "line"),
    [
        ("Last [kPa];Porenzahl\n0;1\n9;0,9\n13;0,8\n", "x_from: 1  # x begins at 0, before the first stage"),
        ("Last [MPa];Porenzahl\n0,005;1\n0,009;0,9\n0,013;0,8\n", "x_from: 1  # x begins at 0.005, before the"),
        ("Stufe;Porenzahl\n0;1\n1;0,9\n2;0,8\n", "x_from: 1  # x begins at 0, before the first stage"),
        ("Last [kPa];Porenzahl\n9,04;0,9\n13;0,8\n", ""),
        ("Stufe;Porenzahl\n1;0,9\n2;0,8\n", ""),
    ],
)
def test_the_state_before_the_first_stage_belongs_to_the_question(content: str, line: str, tmp_path: Path) -> None:
    """The answer was refused for it: a table of an oedometer test usually begins with the void ratio at first."""
    (tmp_path / "a.csv").write_text(content, encoding="utf-8")
    problem = yaml.safe_load(OEDOMETER) | {"observations": [{"series": "stage_void_ratio", "file": "a.csv"}]}
    problem["forward_model"]["initial_void_ratio"] = 1.0
    (tmp_path / "p.yaml").write_text(problem_yaml(problem), encoding="utf-8")
    with pytest.raises(ProblemError) as caught:
        load_problem(tmp_path / "p.yaml")
    asked = str(caught.value)
    assert line in asked if line else "x_from" not in asked
    lines = "\n".join(line[4:] for line in asked.splitlines() if line.startswith("    "))
    problem["observations"][0] |= yaml.safe_load(lines)
    (tmp_path / "p.yaml").write_text(problem_yaml(problem), encoding="utf-8")
    read = load_problem(tmp_path / "p.yaml").observations[0]
    assert (read.x.tolist(), read.y.tolist()) == ([1, 2], [0.9, 0.8])


def test_another_strain_is_named_as_such(tmp_path: Path) -> None:
    """A shear strain was suggested as the axial strain without a word."""
    asked = refused(tmp_path, "a.csv", "ShearStrain_pct,q_kPa\n0.1,10\n1,40\n")
    assert "x_column: ShearStrain_pct  # 0.1, 1; its heading says shear strain\n" in asked
    assert "its heading says" not in refused(tmp_path, "a.csv", "eps1_pct,q_kPa\n0.1,10\n1,40\n")


@pytest.mark.parametrize(
    ("content", "units", "lines", "x", "y"),
    [
        (  # gradings
            "Siebdurchgang [%];Korndurchmesser [mm]\n10;0,063\n90;2\n",
            ("m", ""),
            {"x_column": "Korndurchmesser [mm]", "y_column": "Siebdurchgang [%]"},
            [6.3e-5, 2e-3],
            [0.1, 0.9],
        ),
        (
            "Sieve size,Percent finer\n0.063,10\n2,90\n",
            ("m", ""),
            {"x_column": "Sieve size", "x_unit": "mm", "y_column": "Percent finer"},
            [6.3e-5, 2e-3],
            [0.1, 0.9],
        ),
        (  # retention curves
            "vol. water content (-),soil suction (kPa)\n0.40,1\n0.20,100\n",
            ("kPa", ""),
            {"x_column": "soil suction (kPa)", "y_column": "vol. water content (-)"},
            [1, 100],
            [0.4, 0.2],
        ),
        (
            "psi [hPa];theta [cm3/cm3];T [°C]\n10;0,4;20\n1000;0,2;20\n",
            ("kPa", ""),
            {"x_column": "psi [hPa]", "y_column": "theta [cm3/cm3]"},
            [1, 100],
            [0.4, 0.2],
        ),
    ],
)
def test_gradings_and_retention_curves_need_one_answer(
    content: str, units: tuple[str, str], lines: dict[str, str], x: list[float], y: list[float], tmp_path: Path
) -> None:
    (tmp_path / "a.csv").write_text(content, encoding="utf-8")
    series = {"expression": "a * x", "x_unit": units[0], "y_unit": units[1]}
    problem = document("a.csv") | {
        "forward_model": {"kind": "formula", "series": {"curve": series}},
        "parameters": {"a": {"lower": -1, "upper": 1}},
        "observations": [{"series": "curve", "file": "a.csv"}],
    }
    (tmp_path / "p.yaml").write_text(problem_yaml(problem), encoding="utf-8")
    with pytest.raises(ProblemError) as caught:
        load_problem(tmp_path / "p.yaml")
    keys = yaml.safe_load("\n".join(line[4:] for line in str(caught.value).splitlines() if line.startswith("    ")))
    assert keys == lines
    problem["observations"][0] |= keys
    (tmp_path / "p.yaml").write_text(problem_yaml(problem), encoding="utf-8")
    read = load_problem(tmp_path / "p.yaml").observations[0]
    np.testing.assert_allclose(read.x, x)
    np.testing.assert_allclose(read.y, y)


def test_a_unit_that_a_heading_leaves_open_is_said_in_the_question(tmp_path: Path) -> None:
    """An example was given for it as for a column without a unit."""
    asked = refused(tmp_path, "a.csv", "eps [%];q [kPa] in bar\n0,1;10\n1;40\n")
    assert "y_unit: kPa  # its heading names several units, kPa and bar\n" in asked


def test_a_deviator_stress_is_suggested_as_a_difference(tmp_path: Path) -> None:
    """The radial stress was suggested."""
    content = "eps_a[%],sigma_r[kPa],sigma_v[kPa]\n0.1,100,110\n1,100,140\n"
    keys, y = answered(tmp_path, "a.csv", content)
    assert keys == {"x_column": "eps_a[%]", "y_column": "sigma_v[kPa]", "y_minus": "sigma_r[kPa]"}
    assert y == [10, 40]
    assert "y_minus" not in refused(tmp_path, "a.csv", content.replace("sigma_v", "q"))
