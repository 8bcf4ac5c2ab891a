"""Problem files read measurements as the form does: workbooks, dates, units from headings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Observation, load_problem, read_measurements
from tests.solver.problem.test_measurements import ROWS, STRINGS, workbook

OEDOMETER = """
forward_model:
  kind: oedometer
  material: soft_soil_creep
  height: 0.02
  initial_stress: 5
  stages: [{stress: 9, duration: 2}, {stress: 13, duration: 1}]
parameters:
  lambda_star: {lower: 0.002, upper: 1.0, scale: log}
  kappa_star: {value: 0.001}
  mu_star: {value: 1.46e-3}
  c: {value: 5}
  phi: {value: 20}
  psi: {value: 0}
stopping: {max_evaluations: 100}
observations:
- series: settlement
"""


def observed(folder: Path, name: str, content: str | bytes, series: str = "settlement", **keys: Any) -> Observation:
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    lines = "".join(f"  {key}: {value}\n" for key, value in {"file": name, **keys}.items())
    document = OEDOMETER.replace("series: settlement", f"series: {series}") + lines
    (folder / "problem.yaml").write_text(document, encoding="utf-8")
    problem = load_problem(folder / "problem.yaml")
    assert problem.document()["observations"][0]["points"]["x"] == problem.observations[0].points.x
    return problem.observations[0]


def mistakes(folder: Path, name: str, content: str | bytes, **keys: Any) -> str:
    with pytest.raises(ProblemError) as caught:
        observed(folder, name, content, **keys)
    return str(caught.value)


def test_an_ags_file_is_no_table(tmp_path: Path) -> None:
    text = '"GROUP","PROJ"\n"HEADING","PROJ_ID"\n"DATA","1"\n'
    message = mistakes(tmp_path, "a.ags", text, x_column="time", y_column="settlement")
    assert message.endswith(
        "a.ags is an AGS file, which is not a table; geoswarm import ags a.ags makes a problem of it"
    )


def test_units_of_headings_hold_where_none_are_given(tmp_path: Path) -> None:
    text = "time [min],settlement (mm)\n144,0.5\n1440,1\n"
    found = observed(tmp_path, "a.csv", text, x_column="time", y_column="settlement")
    assert found.x.tolist() == [0.1, 1.0]
    assert found.y.tolist() == [0.0005, 0.001]
    assert (found.x_unit, found.y_unit) == ("min", "mm")  # the problem with its points inside says so, too
    given = observed(tmp_path, "a.csv", text, x_column="time", y_column="settlement", x_unit="s", error="0.1")
    assert given.x.tolist() == [144 / 86400, 1440 / 86400]
    assert given.error == 0.0001


def test_a_comment_may_name_units(tmp_path: Path) -> None:
    found = observed(tmp_path, "a.csv", "# x in h, y in mm\nx,y\n12,1\n")
    assert (found.x.tolist(), found.y.tolist()) == ([0.5], [0.001])


def test_a_heading_with_a_unit_that_does_not_fit(tmp_path: Path) -> None:
    text = "x [day],force [kPa]\n1,2\n"
    said = mistakes(tmp_path, "a.csv", text, y_column="force")
    assert said == (
        "observations[0].y_column: column 'force [kPa]' is in kPa, but the series has m; name another, or give y_unit"
    )


def test_true_and_false_in_a_workbook_are_no_numbers(tmp_path: Path) -> None:
    rows = ROWS.replace('<c r="C5" t="e"><v>#N/A</v></c>', '<c r="C5" t="b"><v>1</v></c>')
    content = workbook(("Readings", rows), strings=STRINGS)
    assert "'TRUE' is not a finite number" in mistakes(
        tmp_path, "a.xlsx", content, x_column="time", y_column="settlement"
    )


def test_a_sheet_of_a_workbook(tmp_path: Path) -> None:
    rows = ROWS.replace('<c r="C5" t="e"><v>#N/A</v></c>', '<c r="C5"><v>0.375</v></c>')
    content = workbook(("Notes", ""), ("Readings", rows), strings=STRINGS)
    keys = {"x_column": "time", "y_column": "settlement", "sheet": "Readings"}
    found = observed(tmp_path, "a.xlsx", content, **keys)
    assert found.points.x == [1.5, 3.0, 45.0]
    assert found.points.y == [0.25, 0.375, 0.5]
    assert (found.x_unit, found.y_unit) == ("min", "mm")
    form = read_measurements(content, "a.xlsx", "Readings")
    assert [list(column.values) for column in form.columns] == [found.points.x, found.points.y]
    assert "no sheet 'Other'; its sheets: Notes, Readings" in mistakes(
        tmp_path, "a.xlsx", content, **{**keys, "sheet": "Other"}
    )
    bad = mistakes(tmp_path, "a.xlsx", workbook(("s", ROWS), strings=STRINGS), x_column="time", y_column="settlement")
    assert bad == (
        "observations[0].file: a.xlsx line 5, column settlement (mm): '#N/A' is not a finite number; "
        "incomplete_rows: leave_out passes over such rows"
    )
    assert "not a workbook, so it has no sheet 's'" in mistakes(tmp_path, "a.csv", "x,y\n1,2\n", sheet="s")


@pytest.mark.parametrize(
    ("dates", "keys", "days"),
    [
        (("2021-06-01 12:00", "2021-06-02 00:00", "2021-06-03T12:00Z"), {}, [0.0, 0.5, 2.0]),
        (("01.06.2021 12:00", "02.06.2021 00:00", "03.06.2021 12:00"), {"x_unit": "day"}, [0.0, 0.5, 2.0]),
        (
            ("2021-06-01 12:00", "2021-06-02 00:00", "2021-06-03 12:00"),
            {"x_origin": '"2021-06-01 06:00"'},
            [0.25, 0.75, 2.25],
        ),
    ],
)
def test_dates_are_days(dates: tuple[str, ...], keys: dict[str, str], days: list[float], tmp_path: Path) -> None:
    text = "date,settlement [mm]\n" + "".join(f"{date},1\n" for date in dates)
    found = observed(tmp_path, "a.csv", text, x_column="date", y_column="settlement", **keys)
    assert found.x.tolist() == days
    assert found.x_unit == "day"


def test_dates_that_cannot_be(tmp_path: Path) -> None:
    names = {"x_column": "date", "y_column": "y"}
    text = "date,y [m]\n2021-06-01,1\n2021-06-02,2\n2021-06-31,3\n"
    assert "a.csv line 4, column date: '2021-06-31' is not a date, such as" in mistakes(
        tmp_path, "a.csv", text, **names
    )
    good = "date,y [m]\n2021-06-01,1\n2021-06-02,2\n"
    assert "leave x_unit out, not h" in mistakes(tmp_path, "a.csv", good, x_unit="h", **names)
    assert "must be a date" in mistakes(tmp_path, "a.csv", good, x_origin="Tuesday", **names)
    assert "holds no dates" in mistakes(tmp_path, "a.csv", "x,y\n1,2\n", x_origin='"2021-06-01"')
    assert "outside series" in mistakes(tmp_path, "a.csv", good, x_origin='"2021-06-02"', **names)


def test_keys_of_files_need_a_file(tmp_path: Path) -> None:
    (tmp_path / "problem.yaml").write_text(OEDOMETER + "  points: {x: [1], y: [2]}\n  sheet: a\n", encoding="utf-8")
    with pytest.raises(ProblemError, match="sheet can only be given with file"):
        load_problem(tmp_path / "problem.yaml")
