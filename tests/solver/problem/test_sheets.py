"""Sheets of workbooks: readings in rows, letters in several sheets, groups in the AGS format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from geoswarm.solver.problem import measured_points, read_measurements
from tests.solver.problem.test_columns import OEDOMETER, mistakes, observed
from tests.solver.problem.test_laboratory_files import ods_cell, open_document, sheet_rows
from tests.solver.problem.test_measurements import workbook
from tests.solver.problem.test_units_beside_headings import metres

LYING = sheet_rows(
    ("Korndichte:", 2.65, "g/cm^3"),
    ("Belastung",),
    ("Last:", 0.25, 0.75, "kg"),
    ("Spannung:", 7.3, 20, "kPa"),
    ("Zeit:", 1440, 2880, "min"),
    ("Setzung:", 0.05, 0.08, "mm"),
    ("Entlastung",),
    ("Zeit:", 4320, 5760, "min"),
    ("Setzung:", 0.07, 0.06, "mm"),
)


def test_readings_in_rows_have_the_unit_behind_them_and_their_cells_are_named(tmp_path: Path) -> None:
    content = workbook(("s", LYING))
    one = observed(tmp_path, "a.xlsx", content, x_column="B5:C5", y_column="B6:C6")
    assert (one.x_unit, one.y_unit, one.points.y) == ("min", "mm", [0.05, 0.08])
    part = sheet_rows(("Zeit:", 1, 2, 3, "min"), ("Setzung:", 0.1, 0.2, 0.3, "mm"))
    one = observed(tmp_path, "a.xlsx", workbook(("s", part)), x_column="B1:C1", y_column="B2:C2")
    assert (one.x_unit, one.y_unit, one.points.y) == ("min", "mm", [0.1, 0.2])
    wrong = mistakes(tmp_path, "a.xlsx", content, x_column="zeit", y_column="Setzung")
    assert "there is no column 'zeit', but rows begin with it; name the cells of one: B5:C5 or B8:C8" in wrong
    assert "'Setzung', but rows begin with it; name the cells of one: B6:C6 or B9:C9" in wrong


def test_a_look_at_a_sheet_whose_readings_lie_in_rows() -> None:
    columns = read_measurements(workbook(("s", LYING)), "a.xlsx").columns
    assert [one.letters for one in columns] == ["B3:C3", "B4:C4", "B5:C5", "B6:C6", "B8:C8", "B9:C9"]
    settlement = columns[3]
    assert (settlement.unit, settlement.quantities[0], settlement.values) == ("mm", "settlement", (0.05, 0.08))


def test_loads_in_place_of_the_numbers_of_stages(tmp_path: Path) -> None:
    """A table of loads and settlements, the usual result of an oedometer test, had no x."""
    text = "Last [MPa];Setzung [mm]\n0;0\n0,009;0,05\n0,01301;0,08\n"
    end = {"series": "stage_settlement", "x_column": "Last", "y_column": "Setzung"}
    wrong = mistakes(tmp_path, "a.csv", text, **end)
    assert "x = 0 kPa (point 1) is the load of no stage of the forward model (9, 13); give the cells" in wrong
    assert wrong.endswith("or leave out what is before them: x_from: 1")
    begun = observed(tmp_path, "a.csv", text, **end, x_from=1)
    assert (begun.x.tolist(), begun.points.y) == ([1, 2], [0, 0.05, 0.08])
    one = observed(tmp_path, "a.csv", text.replace("0;0\n", ""), **end)
    assert (one.x.tolist(), one.x_unit, one.y_unit, one.points.y) == ([1, 2], None, "mm", [0.05, 0.08])
    assert one.notes == ("x is the number of the stage with the load of column Last [MPa]",)
    model = json.dumps(yaml.safe_load(OEDOMETER)["forward_model"])
    asked = json.dumps(end | {"x_column": "L", "x_unit": "kPa"})
    points, units = measured_points(asked, b"L;Setzung [mm]\n9;0,05\n13;0,08\n", "a.csv", model)
    assert (points.x, units) == ([1, 2], {"x_unit": "dimensionless", "y_unit": "mm"})
    back = text.replace("0;0\n", "").replace("0,009", "0,02")
    assert "x = 20 kPa (point 1) is the load of no stage" in mistakes(tmp_path, "a.csv", back, **end)


@pytest.mark.parametrize("loads", [("9", "13"), ("9,5", "13")])
def test_loads_without_a_unit_are_taken_for_numbers_of_stages_and_asked_for(
    tmp_path: Path, loads: tuple[str, str]
) -> None:
    text = f"Last;Setzung [mm]\n{loads[0]};0,05\n{loads[1]};0,08\n"
    wrong = mistakes(tmp_path, "a.csv", text, series="stage_settlement", x_column="Last", y_column="Setzung")
    assert wrong.endswith("; for loads instead of numbers of stages give x_unit: kPa")


def test_letters_of_several_sheets_are_asked_for(tmp_path: Path) -> None:
    """The first sheet with cells was read."""
    block = sheet_rows(("t [min]", "s [mm]"), (1, 0.5), (2, 0.75))
    notes = sheet_rows(("Probe", "S1"), ("Tiefe", "4.5"))
    letters = {"x_column": "A:A", "y_column": "B:B"}
    assert observed(tmp_path, "a.xlsx", workbook(("Notes", notes), ("one", block)), **letters).points.y == [0.5, 0.75]
    two = workbook(("Notes", notes), ("one", block), ("two", block))
    for keys in (letters, {"x_column": "A2:A3", "y_column": "B2:B3"}):
        assert "several sheets have these columns, one, two; give sheet: one" in mistakes(
            tmp_path, "a.xlsx", two, **keys
        )
    assert observed(tmp_path, "a.xlsx", two, sheet="two", **letters).points.x == [1, 2]


def test_a_sheet_with_a_group_in_the_ags_format_has_its_units_and_data(tmp_path: Path) -> None:
    """Units are in the second row, kinds of data in the third."""
    group = sheet_rows(
        ("HEADING", "READ_TIME", "READ_DISP"),
        ("UNIT", "min", "mm"),
        ("TYPE", "0DP", "2DP"),
        ("DATA", "1", "0.25"),
        ("DATA", 2, 0.5),
        ("note", "stray", "stray"),
    )
    columns = {"x_column": "READ_TIME", "y_column": "READ_DISP"}
    one = observed(tmp_path, "a.xlsx", workbook(("READ", group)), **columns, where="{READ_TIME: 1}")
    assert (one.x_unit, one.y_unit, one.points.x, one.points.y) == ("min", "mm", [1], [0.25])
    assert one.notes == ("rows of a.xlsx with READ_TIME = 1",)


def test_columns_that_are_not_there_are_told_at_once(tmp_path: Path) -> None:
    wrong = mistakes(tmp_path, "a.csv", "0,0,60\n1,0.25,59\n")
    assert "which columns hold x (time) and y (settlement), and in what unit?" in wrong
    assert "x_column: A:A  # 0, 1; or C:C: no heading says so\n" in wrong
    assert "columns: A:A (0, 1); B:B (0, 0.25); C:C (60, 59)" in wrong


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("0.0\\ [$cm]", "names several units, cm and mm"),
        ("[&gt;100]0.0&quot; mm&quot;;0.0&quot; cm&quot;", "'5 (in several units)' is not a finite number"),
        ("[Red][&gt;100]0.0&quot; mm&quot;;0.0&quot; mm&quot;", [0.005, 0.007]),
        ("[$-407]0.0", [0.005, 0.007]),
    ],
)
def test_the_unit_of_a_format_counts_wherever_it_is(code: str, said: str | list[float]) -> None:
    """Centimetres under ``Setzung [mm]`` were millimetres."""
    formats = f'<numFmts><numFmt numFmtId="170" formatCode="{code}"/></numFmts>'
    styles = f'{formats}<cellXfs><xf numFmtId="0"/><xf numFmtId="170"/></cellXfs>'
    rows = "".join(
        f'<row r="{line}"><c r="A{line}"><v>{line}</v></c><c r="B{line}" s="1"><v>{value}</v></c></row>'
        for line, value in ((2, 5), (3, 7))
    )
    content = workbook(("s", sheet_rows(("Zeit [min]", "Setzung [mm]")) + rows), styles=styles)
    found = metres(content)
    assert said in found if isinstance(said, str) else found == said


@pytest.mark.parametrize(
    ("shown", "said"),
    [
        ("{} µm", [5e-6, 7e-6]),
        ("{},0 cm", [0.05, 0.07]),
        ("{}.00E+00", "has no unit"),
        ("{} mm/s", "'5 mm/s' is not a finite number"),
    ],
)
def test_the_unit_that_an_open_document_shows_counts(shown: str, said: str | list[float]) -> None:
    """It was passed over."""
    cells = [
        f'<table:table-cell office:value-type="float" office:value="{value}"><text:p>{shown.format(value)}</text:p>'
        "</table:table-cell>"
        for value in (5, 7)
    ]
    names = ods_cell("Zeit [min]", "string") + ods_cell("Setzung", "string")
    found = metres(open_document(names, *(ods_cell(float(line)) + cell for line, cell in enumerate(cells, 1))))
    assert said in found if isinstance(said, str) else found == said
