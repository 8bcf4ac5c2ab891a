"""AGS 4 files are read as the format lays them down; what is wrong is told with line, group, heading and value."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.ags import reading
from geoswarm.solver.ags.reading import read_ags, read_ags_file
from geoswarm.solver.ags.tables import AgsError, AgsGroup
from tests.solver.ags.synthetic import content
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_measurements import workbook

HEAD = '"GROUP","LOAD"\r\n"HEADING","LOCA_ID","LOAD_P"\r\n"UNIT","","MPa"\r\n"TYPE","ID","2DP"\r\n'


def load(*cells: str, unit: str = "MPa") -> AgsGroup:
    rows = "".join(f'"DATA","BH1","{cell}"\r\n' for cell in cells)
    return read_ags((HEAD.replace("MPa", unit) + rows).encode(), "a.ags").groups["LOAD"]


def test_groups_have_headings_units_types_and_rows_with_their_lines() -> None:
    group = load("0.25")
    assert (group.headings, group.units, group.types) == (("LOCA_ID", "LOAD_P"), ("", "MPa"), ("ID", "2DP"))
    assert [row.line for row in group.rows] == [5]
    assert group.number(group.rows[0], "LOAD_P", "kPa") == 250.0
    assert group.text(group.rows[0], "LOAD_Q") == ""
    assert group.number(group.rows[0], "LOAD_Q", "kPa") is None


@pytest.mark.parametrize(
    ("unit", "cell", "base", "value"),
    [
        ("kN/m2", "12", "kPa", 12.0),
        ("%/hr", "1.5", "1/day", 0.36),
        ("mm", "19,25", "m", 0.01925),
        ("deg", "30", "degree", 30.0),
        ("%", "9.5", "", 0.095),
        ("", "9.5", "", 9.5),
    ],
)
def test_units_of_the_dictionary_are_known(unit: str, cell: str, base: str, value: float) -> None:
    group = load(cell, unit=unit)
    assert group.number(group.rows[0], "LOAD_P", base) == pytest.approx(value, rel=1e-14)


def test_quotes_are_doubled_and_commas_stand_inside() -> None:
    group = load('a ""b"", c')
    assert group.text(group.rows[0], "LOAD_P") == 'a "b", c'


def test_encodings() -> None:
    line = HEAD + '"DATA","BH1","5°"\r\n'
    for told in (line.encode("utf-8-sig"), line.encode(), line.encode("cp1252")):
        group = read_ags(told, "a.ags").groups["LOAD"]
        assert group.text(group.rows[0], "LOAD_P") == "5°"


@pytest.mark.parametrize(
    ("content_", "message"),
    [
        (b'"**PROJ"\r\n"*PROJ_ID"\r\n', r'a.ags line 1: "\*\*PROJ" is AGS 3; AGS 4 is accepted'),
        (b"", "a.ags contains no groups; give a file in the AGS 4 format"),
        (b"PK\x03\x04\0", "a.ags cannot be read as an XLSX or ODS workbook"),
        (b"stress,strain\n", "line 1 begins with 'stress'; GROUP, HEADING, UNIT, TYPE, DATA are accepted"),
        (b'"DATA","1"\r\n', "line 1: DATA comes before the first GROUP"),
        (b'"GROUP","A"\r\n"DATA","1"\r\n', "line 2: group A: DATA comes before HEADING"),
        (b'"GROUP","A"\r\n"HEADING","B","B"\r\n', "line 2: group A has the heading B twice"),
        (b'"GROUP","A"\r\n"HEADING","B"\r\n"HEADING","C"\r\n', "line 3: group A has a second row HEADING"),
        (b'"GROUP","A"\r\n"GROUP","A"\r\n', "line 2: group A is there already, in line 1"),
        (b'"GROUP"\r\n', "line 1: GROUP and one name is accepted"),
        (
            b'"GROUP","CONG"\r\n"HEADING","B"\r\n"DATA","1","2"\r\n',
            "line 3: group CONG: 2 cells of DATA under 1 headings",
        ),
        (b'"GROUP","CONG"\r\n"HEADING","B"\r\n"DATA","1\r\n', "line 3: .*cells in double quotes"),
    ],
)
def test_what_is_no_ags_4_is_reported(content_: bytes, message: str) -> None:
    with pytest.raises(AgsError, match=message):
        read_ags(content_, "a.ags")


@pytest.mark.parametrize(
    ("cell", "unit", "message"),
    [
        ("abc", "MPa", "a.ags line 5: group LOAD, heading LOAD_P: 'abc': a number above 0 kPa is accepted"),
        ("", "MPa", "heading LOAD_P: the empty cell: a number above 0 kPa is accepted"),
        ("1,600", "kPa", "'1,600': it can be 1.6 or 1600; write it with a decimal point, without a comma"),
        ("-1", "MPa", "'-1': a number above 0 kPa is accepted"),
        ("1e999", "MPa", "'1e999': a number above 0 kPa is accepted"),
        ("1", "m", "group LOAD, heading LOAD_P: unit 'm' cannot be converted to kPa"),
        ("1", "foo", "group LOAD, heading LOAD_P: .*foo"),
    ],
)
def test_a_bad_number_is_told_with_its_place(cell: str, unit: str, message: str) -> None:
    group = load(cell, unit=unit)
    with pytest.raises(AgsError, match=message):
        group.needed(group.rows[0], "LOAD_P", "kPa")


def test_sizes_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "MAX_ROWS", 2)
    with pytest.raises(AgsError, match="line 7: group LOAD has more than 2 rows"):
        load("1", "2", "3")
    with pytest.raises(AgsError, match="line 1 has 100013 characters; at most 100000"):
        read_ags(b'"GROUP","' + b"A" * 100_003 + b'"', "a.ags")
    with pytest.raises(AgsError, match="line 1 has a cell of 40000 characters"):
        read_ags(b'"GROUP","' + b"A" * 40_000 + b'"', "a.ags")
    monkeypatch.setattr(reading, "MAX_TABLE_BYTES", 2**20)
    with pytest.raises(AgsError, match="larger than 1 MiB"):
        read_ags(b" " * (2**20 + 1), "a.ags")


def test_files_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.ags"
    path.write_bytes(content())
    file = read_ags_file(path)
    assert (file.name, len(file.groups["CONS"].rows)) == ("a.ags", 19)
    with pytest.raises(AgsError, match=r"b\.ags: No such file"):
        read_ags_file(tmp_path / "b.ags")


def test_a_workbook_has_a_sheet_for_each_group() -> None:
    rows = sheet_rows(
        ("HEADING", "LOCA_ID", "LOAD_P"),
        ("UNIT", None, "MPa"),
        ("TYPE", "ID", "2DP"),
        ("DATA", "BH1", 0.25, "no heading"),
        ("note", "stray"),
        ("DATA", "BH2"),
    )
    group = read_ags(workbook(("Cover", sheet_rows(("a", 1))), ("LOAD", rows)), "a.xlsx").groups["LOAD"]
    assert (group.headings, group.units) == (("LOCA_ID", "LOAD_P"), ("", "MPa"))
    assert [(row.line, row.cells) for row in group.rows] == [(4, ("BH1", "0.25")), (6, ("BH2", ""))]
    assert group.number(group.rows[0], "LOAD_P", "kPa") == 250.0
    with pytest.raises(AgsError, match=r"a\.xlsx contains no groups; give a file in the AGS 4 format"):
        read_ags(workbook(("Cover", sheet_rows(("a", 1)))), "a.xlsx")
