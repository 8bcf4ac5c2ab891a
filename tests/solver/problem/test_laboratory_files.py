"""Files as laboratories deliver them: cells, names, specimens, dates, zero readings, differences, gross errors."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.problem import parse_problem, read_measurements
from geoswarm.solver.problem.tables.dates import moment_in, time_of_day
from tests.solver.problem.test_columns import mistakes, observed
from tests.solver.problem.test_measurements import MAIN, RELATIONS, workbook
from tests.solver.problems import decay_document

COLUMN = {"y_column": "Setzung"}
DAY = {"x_unit": "day", "y_unit": "mm"}


def sheet_rows(*rows: tuple[Any, ...]) -> str:
    """Rows of a sheet as XML; None for an empty cell."""
    found = []
    for line, row in enumerate(rows, 1):
        cells = []
        for place, value in enumerate(row):
            at = f"{chr(65 + place)}{line}"
            if isinstance(value, str):
                cells.append(f'<c r="{at}" t="inlineStr"><is><t>{value}</t></is></c>')
            elif value is not None:
                cells.append(f'<c r="{at}"><v>{value}</v></c>')
        found.append(f'<row r="{line}">{"".join(cells)}</row>')
    return "".join(found)


SIDE_BY_SIDE = (
    ("Specimen 1", None, None, "Specimen 2", None),
    ("t", "s", None, "t", "s"),
    (0.5, 1.0, None, 0.25, 7.0),
    (1.5, 2.0, None, 0.75, 8.0),
    (2.5, 3.0),
)


def named(**names: str) -> bytes:
    """A workbook with blocks side by side and names for cells."""
    defined = "".join(f'<definedName name="{name}">{cells}</definedName>' for name, cells in names.items())
    head = f'<workbook xmlns="{MAIN}" xmlns:r="{RELATIONS}"><sheets><sheet name="Notes" sheetId="1" r:id="r1"/>'
    head += '<sheet name="My &apos;Data&apos;" sheetId="2" r:id="r2"/></sheets>'
    book = f"{head}<definedNames>{defined}</definedNames></workbook>"
    return workbook(("Notes", sheet_rows((1, 2))), ("x", sheet_rows(*SIDE_BY_SIDE)), **{"xl/workbook.xml": book})


@pytest.mark.parametrize(
    ("keys", "x", "y"),
    [
        ({"x_column": "A:A", "y_column": "B:B"}, [0.5, 1.5, 2.5], [1, 2, 3]),
        ({"x_column": "D:D", "y_column": "E:E"}, [0.25, 0.75], [7, 8]),  # the shorter block ends sooner
        ({"x_column": "D3:D4", "y_column": "E3:E4"}, [0.25, 0.75], [7, 8]),
        ({"x_column": "$A$4:$A$5", "y_column": "b4:b5"}, [1.5, 2.5], [2, 3]),
        ({"x_column": "D3:E3", "y_column": "D4:E4", "x_unit": "h"}, [0.25, 7.0], [0.75, 8.0]),  # cells in a row
    ],
)
def test_columns_by_their_cells(keys: dict[str, str], x: list[float], y: list[float], tmp_path: Path) -> None:
    found = observed(tmp_path, "a.xlsx", workbook(("s", sheet_rows(*SIDE_BY_SIDE))), **{**DAY, **keys})
    assert (found.points.x, found.points.y) == (x, y)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"x_column": "t", "y_column": "s"}, "there are several columns 't'"),
        ({"x_column": "A3:A4", "y_column": "B3:B5"}, "B3:B5 has 3 cells, A3:A4 has 2; where one column is a range"),
        ({"x_column": "A3:B4", "y_column": "B3:B4"}, "cells A3:B4 are neither a column such as B5:B30 nor a row"),
        ({"x_column": "A3:A9", "y_column": "B3:B9"}, "cells A3:A9 reach beyond the sheet, whose last row is 5"),
        ({"x_column": "A2:A4", "y_column": "B2:B4"}, "line 2, column A2:A4: 't' is not a finite number"),
    ],
)
def test_cells_that_cannot_be(keys: dict[str, str], message: str, tmp_path: Path) -> None:
    assert message in mistakes(tmp_path, "a.xlsx", workbook(("s", sheet_rows(*SIDE_BY_SIDE))), **keys)


def test_cells_by_the_names_that_a_workbook_has(tmp_path: Path) -> None:
    content = named(time="'My ''Data'''!$A$3:$A$5", gauge="'My ''Data'''!$B$3:$B$5", height="Notes!$A$1")
    keys = {"x_column": "time", "y_column": "gauge", **DAY}
    found = observed(tmp_path, "a.xlsx", content, **keys)
    assert (found.points.x, found.points.y) == ([0.5, 1.5, 2.5], [1, 2, 3])
    single = mistakes(tmp_path, "a.xlsx", content, **{**keys, "x_column": "height"})
    assert "name 'height' stands for Notes!$A$1; a column such as B5:B30 is expected" in single
    wrong = mistakes(tmp_path, "a.xlsx", content, **{**keys, "sheet": "Notes"})
    assert "the named cells are on several sheets: My 'Data', Notes" in wrong


def open_document(*cells: str, names: str = "") -> bytes:
    """An OpenDocument workbook of one row of XML cells a line, below a heading."""
    spaces = " ".join(
        f'xmlns:{short}="urn:oasis:names:tc:opendocument:xmlns:{short}:1.0"' for short in ("office", "table", "text")
    )
    rows = "".join(f"<table:table-row>{row}</table:table-row>" for row in cells)
    blank = '<table:table-row table:number-rows-repeated="1048000"><table:table-cell/></table:table-row>'
    table = f'<table:table table:name="Sheet1">{rows}{blank}</table:table>'
    body = f"<office:body><office:spreadsheet>{table}{names}</office:spreadsheet></office:body>"
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", f"<office:document-content {spaces}>{body}</office:document-content>")
    return packed.getvalue()


def ods_cell(value: str | float, kind: str = "float") -> str:
    if isinstance(value, float):
        return f'<table:table-cell office:value-type="{kind}" office:value="{value}"/>'
    if kind == "date":
        return f'<table:table-cell office:value-type="date" office:date-value="{value}"/>'
    return f'<table:table-cell office:value-type="string"><text:p>{value}</text:p></table:table-cell>'


def test_an_open_document_workbook(tmp_path: Path) -> None:
    gap = '<table:table-cell table:number-columns-repeated="2"/>'
    content = open_document(
        ods_cell("date", "string") + gap + ods_cell("settlement [mm]", "string"),
        ods_cell("2024-03-01T06:00:00", "date") + gap + ods_cell(1.5),
        "<table:table-cell/>",
        ods_cell("2024-03-02", "date") + gap + ods_cell(2.5),
        names='<table:named-expressions><table:named-range table:name="gauge" '
        'table:cell-range-address="$Sheet1.$D$2:.$D$4"/></table:named-expressions>',
    )
    found = observed(tmp_path, "a.ods", content, x_column="date", y_column="settlement")
    assert (found.points.x, found.points.y, found.y_unit) == ([0.0, 0.75], [1.5, 2.5], "mm")
    by_cells = observed(tmp_path, "a.ods", content, x_column="D2:D4", y_column="gauge", **DAY)
    assert by_cells.points.y == [1.5, 2.5]
    assert "no sheet 'B'; its sheets: Sheet1" in mistakes(tmp_path, "a.ods", content, sheet="B")


def test_cells_that_an_open_document_repeats_cost_no_table(tmp_path: Path) -> None:
    many = '<table:table-cell table:number-columns-repeated="16384" office:value-type="float" office:value="1"/>'
    wide = open_document(ods_cell("x", "string") + ods_cell("y", "string"), ods_cell(0.5) + many)
    assert observed(tmp_path, "a.ods", wide, **DAY).points.y == [1.0]
    repeated = f'</table:table-row><table:table-row table:number-rows-repeated="9000000">{ods_cell(1.0)}'
    tall = open_document(ods_cell("x", "string") + repeated)
    assert "a.ods has more than 2000000 cells" in mistakes(tmp_path, "a.ods", tall)


SPECIMENS = "specimen;t [day];s [mm]\nS1;0,5;1\n;1,5;2\nS2;0,25;7\n2;0,75;8\nS2;1,5;9\n"


def test_several_specimens_in_one_sheet(tmp_path: Path) -> None:
    keys = {"x_column": "t", "y_column": "s"}
    first = observed(tmp_path, "a.csv", SPECIMENS, where="{specimen: s1}", **keys)  # the empty cell means S1, too
    assert (first.points.x, first.points.y) == ([0.5, 1.5], [1, 2])
    assert first.notes == ("rows of a.csv with specimen = s1",)
    assert observed(tmp_path, "a.csv", SPECIMENS, where="{specimen: S2}", **keys).points.y == [7, 9]
    assert observed(tmp_path, "a.csv", SPECIMENS, where="{specimen: 2}", **keys).points.y == [8]
    unknown = mistakes(tmp_path, "a.csv", SPECIMENS, where="{specimen: S9}", **keys)
    assert "a.csv: no row has specimen = S9; there are: S1, S2, 2" in unknown
    assert "there is no column 'probe'" in mistakes(tmp_path, "a.csv", SPECIMENS, where="{probe: S1}", **keys)


@pytest.mark.parametrize(
    ("form", "first", "second"),
    [
        (None, "31.12.24 23:00", "01.01.25 11:00"),
        (None, "2024-12-31T23:00", "2025-01-01 11:00:00"),
        ("day_first", "31/12/2024 23:00", "1/1/25 11:00"),
        ("month_first", "12/31/2024 11:00 PM", "1/1/2025 11:00 AM"),
        ("month_first", "12-31-24 23:00:00.5", "1-1-25 11:00:00.5"),
        ("serial", "45657.958333333336", "45658.458333333336"),  # 2024-12-31 is day 45657 of spreadsheets
    ],
)
def test_dates_as_they_are_written(form: str | None, first: str, second: str, tmp_path: Path) -> None:
    keys = {"x_column": "date", "y_column": "y"} | ({} if form is None else {"x_dates": form})
    text = f"date;y [m]\n{first};1\n{second};2\n"
    found = observed(tmp_path, "a.csv", text, **keys)
    assert found.points.x == pytest.approx([0.0, 0.5], abs=1e-8)
    assert found.notes == ("x counts from 2024-12-31 23:00:00",)
    since = observed(tmp_path, "a.csv", text, x_origin='"2024-12-31"', **keys)
    assert since.points.x == pytest.approx([23 / 24, 35 / 24], abs=1e-8)


def test_dates_that_can_be_read_in_two_ways_are_asked_for(tmp_path: Path) -> None:
    keys = {"x_column": "date", "y_column": "y"}
    text = "date;y [m]\n03/04/2024;1\n05/04/2024;2\n"
    asked = (
        "column date: '03/04/2024' is a date whose day or month may be first; give x_dates: day_first, month_first "
        "or year_first"
    )
    assert asked in mistakes(tmp_path, "a.csv", text, **keys)
    assert observed(tmp_path, "a.csv", text, x_dates="day_first", **keys).points.x == [0, 2]
    # March 4 to May 4 is longer than the test
    assert "x = 61 day (point 2) is outside" in mistakes(tmp_path, "a.csv", text, x_dates="month_first", **keys)
    wrong = mistakes(tmp_path, "a.csv", "date;y\n3/4/2024;1\n13/13/2024;2\n", x_dates="day_first", **keys)
    assert "line 3, column date: '13/13/2024' is not a date, such as 31/12/2024 08:30 or 2024-03-01 08:30" in wrong


def test_dates_that_may_begin_with_the_year_are_asked_for(tmp_path: Path) -> None:
    """24-11-10 and 24-11-11 were the 24th of November of 2010 and of 2011, in silence."""
    keys = {"x_column": "date", "y_column": "y"}
    text = "date;y [m]\n24-11-10;1\n24-11-11;2\n24-11-12;3\n"
    assert "give x_dates: day_first, month_first or year_first" in mistakes(tmp_path, "a.csv", text, **keys)
    assert observed(tmp_path, "a.csv", text, x_dates="year_first", **keys).points.x == [0.0, 1.0, 2.0]
    assert observed(tmp_path, "a.csv", text.replace("24-", "98-"), **keys).points.x == [0.0, 1.0, 2.0]
    days = "date;y [m]\n24-11-10;1\n25-11-10;2\n"
    assert observed(tmp_path, "a.csv", days, **keys).points.x == [0.0, 1.0]


@pytest.mark.parametrize("clock", ["", " 10:00", " 10:00:30", " 10:00:30 AM"])
def test_seconds_do_not_say_whether_the_day_is_first(clock: str, tmp_path: Path) -> None:
    keys = {"x_column": "date", "y_column": "y"}
    text = f"date;y [m]\n11/11/2024{clock};1\n11/12/2024{clock};2\n"
    assert f"'11/11/2024{clock}' is a date whose day or month may be first" in mistakes(tmp_path, "a.csv", text, **keys)
    assert observed(tmp_path, "a.csv", text, x_dates="month_first", **keys).points.x == [0.0, 1.0]
    settled = text + f"11/13/2024{clock};3\n"
    assert observed(tmp_path, "a.csv", settled, **keys).points.x == [0.0, 1.0, 2.0]
    other = f"date;y [m]\n12/11/2024{clock};1\n13/11/2024{clock};3\n"
    assert observed(tmp_path, "a.csv", other, **keys).points.x == [0.0, 1.0]


def test_a_column_of_times_of_day_alone_is_named(tmp_path: Path) -> None:
    text = "Datum;Uhrzeit;y [m]\n01.03.2024;22:00;1\n02.03.2024;4:00:00;2\n"
    message = mistakes(tmp_path, "a.csv", text, x_column="Uhrzeit", y_column="y")
    assert (
        "column Uhrzeit: '22:00' is a time of day; x_column is the column of the dates, x_time_column this" in message
    )


def test_time_of_day_in_a_column_of_its_own(tmp_path: Path) -> None:
    keys = {"x_column": "Datum", "x_time_column": "Uhrzeit", "y_column": "y"}
    found = observed(tmp_path, "a.csv", "Datum;Uhrzeit;y [m]\n01.03.2024;22:00;1\n02.03.2024;4:00:00;2\n", **keys)
    assert found.points.x == [0.0, 0.25]
    bad = mistakes(tmp_path, "a.csv", "Datum;Uhrzeit;y [m]\n01.03.2024;25:00;1\n", **keys)
    assert "line 2, column Uhrzeit: '25:00' is not a time of day" in bad
    assert (time_of_day(0.25), time_of_day("12:00 AM")) == (time_of_day("6:00"), time_of_day("0:00"))
    assert moment_in("31.02.2024") is None


def test_parts_of_one_time_in_two_columns_are_refused(tmp_path: Path) -> None:
    rows = "".join(f"{i // 60},{i % 60},{i}\n" for i in range(20000))
    for head, end in (("Zeit,,y\nh,min,m\n", 200), ("Zeit [h],Zeit [min],y [m]\n", len(rows))):
        message = mistakes(tmp_path, "a.csv", head + rows[:end], x_column="A:A", y_column="y", repeated_x="average")
        assert "min]' are parts of one time; put the whole time, in one unit, into one" in message
    both = observed(tmp_path, "a.csv", "t [h],t [min],y [m]\n0,0,1\n1,60,2\n", x_column="A:A", y_column="y")
    assert both.points.x == [0.0, 1.0]


GAUGE = "t [day],left [mm],right [mm],remark\n0.5,12,2,\n1,10,3,\n1.5,99,3,knocked\n2.5,8,4,0\n"


def test_zero_reading_difference_and_sign(tmp_path: Path) -> None:
    keys = {"x_column": "t", "y_column": "left", "gross_error_column": "remark"}
    first = observed(tmp_path, "a.csv", GAUGE, y_zero="first", y_factor=-1, **keys)
    assert first.y * 1e3 == pytest.approx([0, 2, 4])
    assert first.gross_y * 1e3 == pytest.approx([-87])
    assert first.notes == ("the first reading, 12, was subtracted as the zero reading", "y was multiplied by -1")
    between = observed(tmp_path, "a.csv", GAUGE, y_zero="{x: 1.75}", y_factor=-1, **keys)  # 9 between 10 and 8
    assert between.y * 1e3 == pytest.approx([-3, -1, 1])
    assert "at x = 1.75, between its neighbours, 9, was" in between.notes[0]
    known = observed(tmp_path, "a.csv", GAUGE, y_zero="{y: 13}", y_minus="right", **keys)
    assert known.y * 1e3 == pytest.approx([-3, -6, -9])
    assert known.notes[0] == "y is the difference of two columns: left [mm] less right"
    outside = mistakes(tmp_path, "a.csv", GAUGE, y_zero="{x: 9}", **keys)
    assert "y_zero: there is no reading at x = 9: the readings reach from x = 0.5 to 2.5" in outside
    assert "give first, or either x or y" in mistakes(tmp_path, "a.csv", GAUGE, y_zero="{x: 1, y: 2}", **keys)
    assert "must not be 0" in mistakes(tmp_path, "a.csv", GAUGE, y_factor=0, **keys)


def test_a_factor_for_x(tmp_path: Path) -> None:
    keys = {"x_column": "t", "y_column": "y"}
    text = "t [day],y [m]\n0,1\n-0.5,2\n-2,4\n"
    refused = mistakes(tmp_path, "a.csv", text, **keys)
    assert "x = -0.5 day (point 2) is outside series 'settlement', which has time from 0 to 3 day" in refused
    assert refused.endswith("; 2 points are, -2 to -0.5 day; x_factor: -1 turns the sign")
    found = observed(tmp_path, "a.csv", text, x_factor=-1, y_zero="{x: 0.5}", **keys)
    assert found.points.x == [0.0, 0.5, 2.0]
    assert found.y.tolist() == [-1.0, 0.0, 2.0]
    assert found.notes[0] == "x was multiplied by -1"
    assert "x_factor: must not be 0" in mistakes(tmp_path, "a.csv", text, x_factor=0, **keys)


def given(x: list[float], y: list[float], **keys: Any) -> Any:
    problem = parse_problem(decay_document(observations=[{"series": "y", "points": {"x": x, "y": y}, **keys}]))
    again = parse_problem(problem.document())
    assert again == problem
    assert again.document() == problem.document()
    return problem.observations[0]


def test_gross_errors_stay_in_the_problem_and_do_not_count() -> None:
    found = given([1.0, 2.0, 3.0], [5.0, 900.0, 7.0], gross_errors=[2])
    assert (found.x.tolist(), found.y.tolist()) == ([1, 3], [5, 7])
    assert (found.gross_x.tolist(), found.gross_y.tolist()) == ([2], [900])
    assert (found.left_out, found.points.y) == (1, [5, 900, 7])
    assert found.document()["gross_errors"] == [2]


def test_gross_errors_take_no_part_in_means_and_follow_the_order() -> None:
    x, y = [4.0, 1.0, 2.0, 3.0, 5.0], [40.0, 10.0, 999.0, 30.0, 50.0]
    found = given(x, y, gross_errors=[3], sort=True, resample={"every": 2})
    assert (found.x.tolist(), found.y.tolist()) == ([2, 4.5], [20, 45])  # means of 1, 3 and of 4, 5
    assert (found.gross_x.tolist(), found.gross_y.tolist()) == ([2], [999])
    assert found.points.gross_errors == (1,)  # among its first two neighbours
    assert found.notes == (
        "the readings were sorted by x",
        "every 2 readings in a row were replaced by their mean: 2 points of 4 readings",
    )


def test_gross_errors_that_cannot_be(tmp_path: Path) -> None:
    text = "x [day],y [m]\n0.5,1\n1,2\n"
    assert "gross_errors: there is no reading 3; there are 2" in mistakes(tmp_path, "a.csv", text, gross_errors="[3]")
    assert "no point is left of 2: the others are gross errors" in mistakes(
        tmp_path, "a.csv", text, gross_errors="[1, 2]"
    )


def test_the_rule_of_thinning_is_reported() -> None:
    x = np.geomspace(0.01, 10.0, 301)
    found = given(x.tolist(), x.tolist(), resample={"per_decade": 5}, notes=["DIN EN ISO 17892-5, specimen 3"])
    assert found.notes[0] == "DIN EN ISO 17892-5, specimen 3"
    rule = "neighbouring readings were replaced by their means, at most 5 to a decade of x"
    assert found.notes[1] == f"{rule}: {len(found.x)} points of 301 readings"


@pytest.mark.parametrize(
    "cell",
    [
        *("1. März 2024", "01-Mar-2024", "1 March 2024", "1.Mrz.24", "March 1, 2024", "1st Mar. 2024", "01MAR2024"),
        *("Fr 01.03.2024", "Friday, 1 March 2024", "2024/03/01", "1. 3. 2024", "01.03.2024 0:00 Uhr"),
    ],
)
def test_dates_with_the_names_of_months(cell: str, tmp_path: Path) -> None:
    assert moment_in(cell) == moment_in("2024-03-01")
    found = observed(
        tmp_path, "a.csv", f"Datum;Setzung [mm]\n{cell};0\n3. März 2024 12:00;2\n", x_column="Datum", **COLUMN
    )
    assert found.points.x == [0.0, 2.5]


def test_words_that_are_no_dates() -> None:
    assert not [one for one in ("1 Foo 2024", "Sep 2024", "Mai 12", "31. Apr 2024", "Sensor 1 2024") if moment_in(one)]


@pytest.mark.parametrize(
    ("heading", "cells", "seconds", "keys"),
    [
        ("Zeit [mm:ss]", ("0:15", "100:30,5"), (15.0, 6030.5), {}),
        ("Zeit [hh:mm]", ("0:00", "1:15"), (0.0, 4500.0), {}),
        ("Zeit (hh:mm:ss)", ("00:00:15", "00:01:00"), (15.0, 60.0), {}),
        ("elapsed time", ("02:00:15", "02:01:00"), (7215.0, 7260.0), {}),
        ("Dauer [Std:Min]", ("8:30", "8:45"), (30600.0, 31500.0), {}),
        ("t [d:hh:mm]", ("0:00:15", "1:00:00"), (900.0, 86400.0), {}),
        ("Zeit", ("0:15", "0:30"), (15.0, 30.0), {"x_dates": "'mm:ss'"}),
        ("Zeit", ("0:15", "0:30"), (900.0, 1800.0), {"x_dates": "'hh:mm'"}),
        ("Zeit", ("15 s", "1 min"), (15.0, 60.0), {}),
    ],
)
def test_elapsed_time_as_the_heading_says(
    heading: str, cells: tuple[str, str], seconds: tuple[float, float], keys: dict[str, str], tmp_path: Path
) -> None:
    text = f"{heading};Setzung [mm]\n{cells[0]};1\n{cells[1]};2\n"
    found = observed(
        tmp_path, "a.csv", text, x_column=heading.split(" ")[0] if keys else f'"{heading}"', **keys, **COLUMN
    )
    assert [86400 * x for x in found.points.x] == pytest.approx(seconds, rel=1e-12)
    if not keys:
        assert read_measurements(text.encode(), "a.csv").columns[0].kind == "number"


def test_elapsed_time_that_nobody_explains_is_asked_for(tmp_path: Path) -> None:
    text = "Zeit;Setzung [mm]\n0:00;0\n0:15;1\n"
    assert "give x_dates: hh:mm or mm:ss" in mistakes(tmp_path, "a.csv", text, x_column="Zeit", **COLUMN)
    message = mistakes(tmp_path, "a.csv", text, x_column="Zeit", x_dates="'hh:mm:ss'", **COLUMN)
    assert "'0:00' is not written as hh:mm:ss, as x_dates says" in message


@pytest.mark.parametrize("last", ["Mittelwert;0,47", "Summe:;4\nMax;3", "Mean;;", "24 h;"])
def test_lines_that_sum_up_are_no_readings(last: str, tmp_path: Path) -> None:
    text = f"Zeit;Setzung\nt [d];s [mm]\n0;0\n1;2\n{last}\n"
    keys = {"incomplete_rows": "leave_out"} if last.startswith("24") else {}
    assert observed(tmp_path, "a.csv", text, x_column="Zeit", **keys, **COLUMN).points.y == [0.0, 2.0]


def test_min_in_a_column_of_units_sums_nothing_up(tmp_path: Path) -> None:
    text = "Zeit;Einheit;Setzung [mm]\n0;min;0\n1;min;2\nMittel;;1\n"
    assert observed(tmp_path, "a.csv", text, x_column="Zeit", x_unit="min", **COLUMN).points.y == [0.0, 2.0]


def test_a_word_in_place_of_a_reading_says_what_to_do(tmp_path: Path) -> None:
    message = mistakes(tmp_path, "a.csv", "Zeit [d];Setzung [mm]\n0;0\nEnde;2\n", x_column="Zeit", **COLUMN)
    assert "'Ende' is not a finite number; incomplete_rows: leave_out passes over such rows" in message
