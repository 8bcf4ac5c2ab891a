"""Tables: separators, headings, expressions, Fortran's numbers, and what is said about what cannot be read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.solver.external.outputs.reading import assert_bad, reader_of, series

POINTS = [(0.0, -1.0), (1.5, -2.5)]


@pytest.mark.parametrize(
    ("content", "section"),
    [
        ("time,uy_A\n0,-1\n1.5,-2.5\n", {"x": "time", "y": "uy_A"}),
        ("time;uy_A\r\n0;-1\r\n1.5;-2.5\r\n", {"x": "time", "y": "uy_A"}),
        ("time\tuy_A\n0\t-1\n1.5\t-2.5", {"x": "time", "y": "uy_A"}),
        ("  time   uy_A\n  0.0   -1.0\n  1.5   -2.5\n\n", {"x": "time", "y": "uy_A"}),
        ("0 -1\n1.5 -2.5\n", {"x": 1, "y": 2}),
        ("0 -1\n1.5 -2.5\n", {"x": "column1", "y": "2"}),
        ("0 1\n1.5 2.5\n", {"x": 1, "y": "-column2"}),
        ("time uy_A\n0 0.001\n1.5 0.0025\n", {"x": "time", "y": "-(uy_A) * 1000"}),
        ("# made by a program\n# time uy_A\n0 -1\n# half way\n1.5 -2.5\n", {"x": "time", "y": "uy_A"}),
        ("# time uy_A\n# [s] [m]\n0 -1\n1.5 -2.5\n", {"x": "time", "y": "uy_A"}),
        ("# made today\n0 -1\n1.5 -2.5\n", {"x": 1, "y": "column2"}),
        ("! note\n% note\n0 -1\n1.5 -2.5\n", {"x": 1, "y": 2, "comment": ["!", "%"]}),
        ("Time [day];uy-A (mm)\n0;-1\n1.5;-2.5\n", {"x": "Time [day]", "y": "uy-A (mm)"}),
        ('"time","uy, A"\n0,-1\n"1.5",-2.5\n', {"x": "time", "y": "uy, A"}),
        ("time uy_A\n[s] [m]\n0 -1\n1.5 -2.5\n", {"x": "time", "y": "uy_A"}),
        ("1 2\n9 9\n0 -1\n1.5 -2.5\n", {"x": "1", "y": 2, "header": 2}),
        ("0;-1,0\n1,5;-2,5\n", {"x": 1, "y": 2, "decimal": ","}),
        ("0 -1,0\n1,5 -2,5\n", {"x": 1, "y": 2, "decimal": ","}),
        ("0.0-1.0\n1.5-2.5\n", {"x": 1, "y": 2, "columns": [[1, 3], [4, 7]]}),
        ("t   y\n0.0-1.0\n1.5-2.5\n", {"x": "t", "y": "y", "columns": [[1, 3], [4, 7]]}),
        ("0 -1.0D+00\n1.5 -0.25d1\n", {"x": 1, "y": 2}),
        ("title\n7 7\n0 -1\n1.5 -2.5\n9 9\nEND\n", {"x": 1, "y": 2, "skip": 2, "rows": 2}),
        ("1 0 -1\n2 9 9\n1 1.5 -2.5\n", {"x": 2, "y": 3, "where": "column1 == 1"}),
        ("\n\n0 -1 clay\n1.5 -2.5 sand\n", {"x": 1, "y": 2}),
        ("a,b\n0,-1,\n1.5,-2.5,\n", {"x": "a", "y": 2}),
        ("time uy\n0,-1\n1.5,-2.5\n", {"x": "time", "y": "uy"}),
    ],
)
def test_tables_are_read(tmp_path: Path, content: str, section: dict[str, Any]) -> None:
    assert series(tmp_path, content, **section) == POINTS


def test_the_number_of_the_row_has_a_name(tmp_path: Path) -> None:
    assert series(tmp_path, "5\n6\n", x="row", y=1) == [(1.0, 5.0), (2.0, 6.0)]


@pytest.mark.parametrize(
    ("text", "value"),
    [("1.5D-03", 0.0015), ("1.5-103", 1.5e-103), ("-.5+100", -0.5e100), ("1.e2", 100.0), ("+3", 3.0), ("2.5Q1", 25.0)],
)
def test_numbers_of_fortran(tmp_path: Path, text: str, value: float) -> None:
    assert series(tmp_path, f"1 {text}\n", x=1, y=2) == [(1.0, value)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("********", "line 2: column2 (column 2): '********': the program had no room"),
        ("NaN", "'NaN' is not finite"),
        ("-Infinity", "'-Infinity' is not finite"),
        ("1e999", "'1e999' is not finite"),
        ("-1.#IND", "'-1.#IND' is not finite"),
        ("1_000", "'1_000' is not a number"),
        ("1.2.3", "'1.2.3' is not a number"),
        ("0x1F", "'0x1F' is not a number"),
        ("1.0E+00-2.0E+00", "is several numbers without a blank between; give fixed columns"),
        ("failed", "'failed' is not a number"),
        ("\x1b[31m", "'\\x1b[31m' is not a number"),
    ],
)
def test_bad_numbers_name_line_and_column(tmp_path: Path, text: str, message: str) -> None:
    assert_bad(tmp_path, f"0 1\n1 {text}\n", message, x=1, y=2)


def test_an_overflow_in_the_first_row_is_no_heading(tmp_path: Path) -> None:
    assert_bad(tmp_path, "**** ****\n1 2\n", "line 1: column1 (column 1): '****'", x=1, y=2)


def test_an_expression_without_a_value_is_not_finite(tmp_path: Path) -> None:
    assert_bad(tmp_path, "1 1\n0 1\n", "out.txt: line 2: y = inf is not finite in '0 1'", x=1, y="1 / column1")


@pytest.mark.parametrize(
    ("content", "message", "section"),
    [
        ("time,uy_A\n0,1\n", "line 1: no column load; there are time, uy_A, row", {"x": "time", "y": "load"}),
        ("time,uy_A\n0,1\n", "no column uy_a; did you mean uy_A?", {"x": "time", "y": "uy_a"}),
        ("0 1\n2\n", "line 2: found 1 columns, but column2 is column 2; the row may be truncated", {"x": 1, "y": 2}),
        ("time,uy_A\n", "line 1: the file ends after 0 rows; a row of numbers expected", {"x": 1, "y": 2}),
        ("0 1\n2 3\n", "line 2: the file ends after 2 rows; 3 rows expected", {"x": 1, "y": 2, "rows": 3}),
        ("# nothing\n\n", "the file ends after 0 rows", {"x": 1, "y": 2}),
        ("0,5;1,5\n", "has a comma; if it is the decimal sign, write decimal: ','", {"x": 1, "y": 2}),
        ("0.5;1,5\n", "has a point, but the decimal sign is set to a comma", {"x": 1, "y": 2, "decimal": ","}),
        ("a b\n0 1\n", "'a +' is neither a heading nor an expression", {"x": "a +", "y": 2}),
        ("a b\n0 1\n", "uses no column", {"x": "2 * 3", "y": 2}),
    ],
)
def test_mistakes_name_file_and_line(tmp_path: Path, content: str, message: str, section: dict[str, Any]) -> None:
    assert_bad(tmp_path, content, message, **section)


def test_lines_of_points_are_traced(tmp_path: Path) -> None:
    (tmp_path / "out.txt").write_text("t y\n\n0 1\n# note\n2 3\n", encoding="ascii")
    reader = reader_of({"file": "out.txt", "x": "t", "y": "y"})
    assert reader.traced(tmp_path) == [(3, "0 1"), (5, "2 3")]


CALCULIX = """
 displacements (vx,vy,vz) for set NTOP and time  0.1000000E+00

         1  0.000000E+00  0.000000E+00  0.000000E+00
         4  0.000000E+00  0.000000E+00 -1.000000E-03

 forces (fx,fy,fz) for set NTOP and time  0.1000000E+00

         1  9.0E+00  9.0E+00 9.0E+00

 displacements (vx,vy,vz) for set NTOP and time  0.2000000E+00

         1  0.000000E+00  0.000000E+00  0.000000E+00
         4  0.000000E+00  0.000000E+00 -2.000000E-03
"""
HEADING = r"displacements .* time +(?P<t>\S+)"


@pytest.mark.parametrize(
    "section",
    [
        {"row": 2, "x": "t", "y": "-column4"},
        {"where": "column1 == 4", "x": "t", "y": "-column4"},
        {"where": "row == 2", "x": "block / 10", "y": "-column4"},
    ],
)
def test_repeated_blocks(tmp_path: Path, section: dict[str, Any]) -> None:
    points = series(tmp_path, CALCULIX, each=HEADING, **section)
    assert points == [(0.1, 0.001), (0.2, 0.002)]


def test_all_rows_of_a_block_end_with_a_blank_line(tmp_path: Path) -> None:
    content = "profile\nnode uy\n1 0.5\n2 0.6\n\n3 0.7\n"
    assert series(tmp_path, content, each="^profile", x=1, y=2) == [(1.0, 0.5), (2.0, 0.6)]
    assert series(tmp_path, CALCULIX, each=HEADING, x="t", y="column1", rows=3) == [(0.1, 1.0), (0.1, 4.0), (0.2, 1.0)]


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ({"row": 5, "y": 4}, "line 2: the heading 'displacements (vx,vy,vz) for set NTOP and time  0.1000000E+00' has"),
        ({"row": 2, "y": 5}, "line 5: found 4 columns, but column5 is column 5"),
        ({"where": "column1 == 7", "y": 4}, "line 2: no row below the heading"),
        ({"row": 1, "y": 4, "rows": 3}, "the file ends after 2 points; 3 expected"),
    ],
)
def test_mistakes_in_blocks(tmp_path: Path, section: dict[str, Any], message: str) -> None:
    assert_bad(tmp_path, CALCULIX, message, each=HEADING, x="t", **section)


def test_a_block_that_never_comes(tmp_path: Path) -> None:
    assert_bad(
        tmp_path, "nothing\n", "line 1: the file ends, but no line matches each: heading", each="heading", x=1, y=2
    )
    assert_bad(tmp_path, "t = ***\n1 2\n", "line 1: group t of the heading: '***'", each=r"t = (?P<t>\S+)", x="t", y=2)
    assert_bad(tmp_path, "t = 1\n\n", "there is no row of numbers below", each=r"t = (?P<t>\S+)", x="t", y=2)
