"""CSV files of measured points."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.problem.tables.cells import read_cells
from geoswarm.solver.problem.tables.columns import Columns, Table, table_of
from geoswarm.solver.problem.tables.reading import MAX_TABLE_BYTES, TableError, file_content


def read_table(path: Path, columns: Columns | None = None) -> Table:
    return table_of(file_content(path), path.name, columns or Columns())


def _write(folder: Path, content: str | bytes) -> Path:
    path = folder / "data.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize(
    ("content", "table"),
    [
        ("x,y\n1,2\n3,4\n", Table([1.0, 3.0], [2.0, 4.0], None)),
        ("x,y,weight\n1,2,0.5\n", Table([1.0], [2.0], [0.5])),
        ("X ; Y\n1,5 ; 2,25e-3\n", Table([1.5], [0.00225], None)),
        ("x;y\n1.5;-2\n", Table([1.5], [-2.0], None)),
        ("x\ty\n1\t2\n", Table([1.0], [2.0], None)),
        ("# a comment\n\ny,x\n# another\n1,2\n\n,\n3,4\n", Table([2.0, 4.0], [1.0, 3.0], None)),
        ("\ufeffx,y\r\n1,2\r\n", Table([1.0], [2.0], None)),
        ('x,y\n"1,5","2"\n', Table([1.5], [2.0], None)),
        ("x,y,note\n1,2,good\n3,4\n", Table([1.0, 3.0], [2.0, 4.0], None)),
        ("x,y\n1,2\n".encode("utf-16"), Table([1.0], [2.0], None)),
        ("x,y,Höhe\n1,2,3\n".encode("latin-1"), Table([1.0], [2.0], None)),
    ],
)
def test_accepted(tmp_path: Path, content: str | bytes, table: Table) -> None:
    found = read_table(_write(tmp_path, content))
    assert (found.x, found.y, found.weight) == (table.x, table.y, table.weight)


def test_columns_by_name(tmp_path: Path) -> None:
    path = _write(tmp_path, "Time [min];Weg;Gewicht\n1;2;3\n")
    for heading in ("time [min]", "time", "TIME"):
        table = read_table(path, Columns(heading, "weg"))
        assert (table.x, table.y, table.weight) == ([1.0], [2.0], None)
        assert (table.x_heading.unit, table.x_heading.certain, table.y_heading.unit) == ("min", True, None)
    assert read_table(path, Columns("time [min]", "weg", "gewicht")).weight == [3.0]


@pytest.mark.parametrize(
    ("content", "messages"),
    [
        ("", ["data.csv is empty; a header line x,y is expected"]),
        ("# only a comment\n", ["data.csv is empty; a header line x,y is expected"]),
        ("x,y\n", ["data.csv has a header but no points"]),
        (
            "time,y\n1,2\n",
            ["data.csv line 1: there is no column 'x'; the header has: time, y; say which it is: x_column: time"],
        ),
        (
            "x,y,X\n1,2,3\n",
            [
                "data.csv line 1: there are several columns 'x'; the header has: x, y, X; "
                "name the cells of one: A2:A2 or C2:C2"
            ],
        ),
        (
            "x,y\n1,\nnan,2\n\n3,inf\n1e999,0\n5\n1_0,１\n",
            [
                "data.csv line 2, column y: the cell is empty",
                "data.csv line 3, column x: 'nan' is not a finite number; "
                "incomplete_rows: leave_out passes over such rows",
                "data.csv line 5, column y: 'inf' is not a finite number",
                "data.csv line 6, column x: '1e999' is not a finite number",
                "data.csv line 7, column y: the cell is empty",
                "data.csv line 8, column x: '1_0' is not a finite number",
                "data.csv line 8, column y: '１' is not a finite number",
            ],
        ),
        (
            "x;y\n1.234,5;2\n",
            [
                "data.csv line 2, column x: '1.234,5' may have thousands; say how it is written: "
                "decimal_sign: comma reads 1234.5"
            ],
        ),
        (
            "x,y\n1,2\n3,1,234\n\n4,5,\n",
            [
                "data.csv line 3: 3 cells under 2 headings (3, 1, 234); a comma inside a number (1,234) splits it: "
                "leave it out, or separate the columns by semicolons"
            ],
        ),
        ("x;y\n1;2;3\n", ["data.csv line 2: 3 cells under 2 headings (1, 2, 3); give every column a heading"]),
        (
            "1,2\n3,4\n",
            [
                f"data.csv line 1: there is no column '{axis}'; there is no line of headings; say which it is: "
                f"{axis}_column: column {place}"
                for place, axis in enumerate("xy", 1)
            ],
        ),
        ('x,y\n"1,2\n', ["data.csv line 2: unexpected end of data"]),
    ],
)
def test_refused(tmp_path: Path, content: str, messages: list[str]) -> None:
    with pytest.raises(TableError) as caught:
        read_table(_write(tmp_path, content))
    assert list(caught.value.messages) == messages


def test_only_the_first_bad_cells_are_named(tmp_path: Path) -> None:
    with pytest.raises(TableError) as caught:
        read_table(_write(tmp_path, "x,y\n" + "a,1\n" * 25))
    assert len(caught.value.messages) == 11
    assert caught.value.messages[-1] == "data.csv: 15 more bad cells"


def test_missing_and_too_large_files(tmp_path: Path) -> None:
    with pytest.raises(TableError, match="no such file"):
        read_table(tmp_path / "data.csv")
    with pytest.raises(TableError, match="cannot be read"):
        read_table(tmp_path)
    with (tmp_path / "large.csv").open("wb") as file:
        file.truncate(MAX_TABLE_BYTES + 1)
    with pytest.raises(TableError, match="larger than"):
        read_table(tmp_path / "large.csv")


@pytest.mark.parametrize(
    ("below", "found"),
    [
        ("[min];Uhr 1;Uhr 2;kPa", ["Zeit [min]", "Setzung [mm]", "Uhr 2", "Last [kPa]"]),
        ("[min];Uhr 1 [mm];Uhr 2 [cm];[kPa]", ["Zeit [min]", "Setzung [mm] [mm]", "Uhr 2 [cm]", "Last [kPa]"]),
        (";Uhr 1;Uhr 2;\nmin;mm;mm;kPa", ["Zeit [min]", "Setzung [mm] [mm]", "Uhr 2 [mm]", "Last [kPa]"]),
        ("min;furlongs;mm;kPa", ["Zeit [min]", "Setzung [mm] [furlongs]", "[mm]", "Last [kPa]"]),
    ],
)
def test_names_in_a_second_row_are_no_units(below: str, found: list[str]) -> None:
    text = f"Zeit;Setzung [mm];;Last\n{below}\n0;0;0;5\n1;2;3;5\n"
    assert read_cells(text.encode(), "a.csv").header == found


@pytest.mark.parametrize(
    ("text", "header"),
    [
        ("Nr Zeit h Setzung 1/100 mm\n1 7,5 74\n2 14 330,6\n", ["Nr", "Zeit h", "Setzung 1/100 mm"]),
        ("Labor;Nord\nHoehe:;20,0\nNr time d settlement m\n1 1 2\n2 6 4\n", ["Nr", "time d", "settlement m"]),
        ("No   time   A1   L1\n0    0,0    2,5  3,5\n     1,0    2,6  3,6\n", ["No", "time", "A1", "L1"]),
        ("t  s  q\n1  2  3\n4  5  6\n", ["t", "s", "q"]),
    ],
)
def test_letters_and_empty_cells_between_blanks(text: str, header: list[str]) -> None:
    found = read_cells(text.encode(), "a.txt")
    assert found.header == header
    last = text.splitlines()[-1]
    assert found.rows[-1][1] == [""] * (last[0] == " ") + last.split()


def test_a_cell_that_is_missing_behind_is_not_taken_for_the_first() -> None:
    with pytest.raises(TableError, match="2 cells under 3 headings"):
        read_cells(b"x     y   z\n10.5  1   2\n 9.5  3\n", "a.txt")
