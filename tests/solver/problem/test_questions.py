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
