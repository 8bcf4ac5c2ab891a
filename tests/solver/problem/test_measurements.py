"""Files of measurements: columns, numbers, units and dates, from CSV and from workbooks."""

from __future__ import annotations

import io
import tracemalloc
import zipfile

import pytest

from geoswarm.solver.problem import TableError, read_measurements
from geoswarm.solver.problem.tables.headings import guess_unit
from geoswarm.solver.problem.tables.workbooks import read_workbook

SHEET = "xl/worksheets/sheet{}.xml"
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
RELATIONS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"


def workbook(*sheets: tuple[str, str], strings: str = "", styles: str = "", **parts: str) -> bytes:
    """A workbook of sheets (name, rows as XML), as spreadsheet programs write it."""
    names = "".join(f'<sheet name="{n}" sheetId="{i}" r:id="r{i}"/>' for i, (n, _) in enumerate(sheets, 1))
    targets = "".join(
        f'<Relationship Id="r{i}" Type="worksheet" Target="worksheets/sheet{i}.xml"/>'
        for i in range(1, len(sheets) + 1)
    )
    head = '<?xml version="1.0" encoding="UTF-8"?>'
    content = {
        "xl/workbook.xml": f'{head}<workbook xmlns="{MAIN}" xmlns:r="{RELATIONS}"><sheets>{names}</sheets></workbook>',
        "xl/_rels/workbook.xml.rels": f"{head}<Relationships>{targets}</Relationships>",
        **{
            SHEET.format(i): f'{head}<worksheet xmlns="{MAIN}"><sheetData>{rows}</sheetData></worksheet>'
            for i, (_, rows) in enumerate(sheets, 1)
        },
        **({"xl/sharedStrings.xml": f'<sst xmlns="{MAIN}">{strings}</sst>'} if strings else {}),
        **({"xl/styles.xml": f'<styleSheet xmlns="{MAIN}">{styles}</styleSheet>'} if styles else {}),
        **parts,
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in content.items():
            archive.writestr(name, text)
    return packed.getvalue()


ROWS = (
    '<row r="1"><c r="A1" t="inlineStr"><is><t>Test 7, clay</t></is></c></row>'
    '<row r="3"><c r="A3" t="s"><v>0</v></c><c r="C3" t="s"><v>1</v></c></row>'
    '<row r="4"><c r="A4"><v>1.5</v></c><c r="C4"><v>0.25</v></c></row>'
    '<row r="5"><c r="A5"><v>3</v></c><c r="C5" t="e"><v>#N/A</v></c></row>'
    '<row r="6"><c r="A6"><v>4.5E1</v></c><c r="C6"><f>C4*2</f><v>0.5</v></c></row>'
)
STRINGS = "<si><t>time [min]</t></si><si><r><t>settlement </t></r><r><t>(mm)</t></r></si>"


@pytest.mark.parametrize(
    ("heading", "label", "unit", "base"),
    [
        ("settlement [mm]", "settlement", "mm", "m"),
        ("time (min)", "time", "min", "day"),
        ("t / hours", "t", "h", "day"),
        ("Zeit, d", "Zeit", "day", "day"),
        ("settlement_um", "settlement", "um", "m"),
        ("time in days", "time", "day", "day"),
        ("sigma [kN/m²]", "sigma", "kN/m^2", "kPa"),
        ("strain (%)", "strain", "%", "dimensionless"),
        ("phi [°]", "phi", "degree", "degree"),
        ("void ratio [-]", "void ratio", "dimensionless", "dimensionless"),
        ("date/time", "date/time", None, None),
        ("settlement (corrected)", "settlement (corrected)", None, None),
        ("temperature [degC]", "temperature [degC]", None, None),
        ("x", "x", None, None),
    ],
)
def test_units_are_found_in_headings(heading: str, label: str, unit: str | None, base: str | None) -> None:
    assert guess_unit(heading) == (label, unit, base)


def test_csv_with_units_gaps_and_bad_cells() -> None:
    text = b"time [min];settlement [mm];remark\n1;0,5;start\n2;;\n3;n/a;stop\n4;2,25;\n"
    found = read_measurements(text, "a.csv")
    assert (found.rows, found.sheets, found.sheet) == (4, (), None)
    time, settlement, remark = found.columns
    assert (time.label, time.unit, time.base, time.values) == ("time", "min", "day", (1.0, 2.0, 3.0, 4.0))
    assert (settlement.values, settlement.bad, settlement.kind) == ((0.5, None, None, 2.25), 1, "number")
    assert (remark.kind, remark.values, remark.bad) == ("text", (), 2)


def test_units_in_comments_and_a_file_without_heading() -> None:
    found = read_measurements(b"# x in min, y in mm\nx,y\n0.1,0.056\n", "a.csv")
    assert [(column.name, column.unit) for column in found.columns] == [("x", "min"), ("y", "mm")]
    bare = read_measurements(b"1,2\n3,4\n", "a.csv")
    assert [(column.name, column.values) for column in bare.columns] == [
        ("column 1", (1.0, 3.0)),
        ("column 2", (2.0, 4.0)),
    ]


@pytest.mark.parametrize(
    "dates",
    [
        ("2021-06-01 12:00", "2021-06-02 00:00", "2021-06-04T12:00:00Z"),
        ("01.06.2021 12:00", "02.06.2021 00:00", "04.06.2021 12:00:00"),
    ],
)
def test_dates_are_days_since_the_first(dates: tuple[str, str, str]) -> None:
    text = "date,settlement [cm]\n{},1\n{},2\n,3\n{},4\n".format(*dates)
    date = read_measurements(text.encode(), "a.csv").columns[0]
    assert (date.kind, date.unit, date.values) == ("time", "day", (0.0, 0.5, None, 3.0))


def test_a_sheet_is_read_below_its_title() -> None:
    found = read_measurements(workbook(("Readings", ROWS), ("Notes", ""), strings=STRINGS), "a.xlsx")
    assert (found.sheets, found.sheet, found.rows) == (("Readings", "Notes"), "Readings", 3)
    time, settlement = found.columns
    assert (time.label, time.unit, time.values) == ("time", "min", (1.5, 3.0, 45.0))
    assert (settlement.name, settlement.unit, settlement.values, settlement.bad) == (
        "settlement (mm)",
        "mm",
        (0.25, None, 0.5),
        1,
    )


def test_dates_of_a_sheet_follow_its_styles() -> None:
    rows = (
        '<row r="1"><c r="A1" t="inlineStr"><is><t>date</t></is></c>'
        '<c r="B1" t="inlineStr"><is><t>u [m]</t></is></c></row>'
        '<row r="2"><c r="A2" s="1"><v>44348</v></c><c r="B2"><v>1</v></c></row>'
        '<row r="3"><c r="A3" s="2"><v>44348.75</v></c><c r="B3"><v>2</v></c></row>'
    )
    styles = (
        '<numFmts><numFmt numFmtId="164" formatCode="yyyy\\-mm\\-dd hh:mm"/></numFmts>'
        '<cellXfs><xf numFmtId="0"/><xf numFmtId="14"/><xf numFmtId="164"/></cellXfs>'
    )
    _, _, cells = read_workbook(workbook(("s", rows), styles=styles), "a.xlsx")
    assert cells[1][0] == "2021-06-01 00:00:00"  # day 44348 after 1899-12-30
    date = read_measurements(workbook(("s", rows), styles=styles), "a.xlsx").columns[0]
    assert (date.kind, date.values) == ("time", (0.0, 0.75))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no column of numbers"),
        (b"a,b\n", "no column of numbers"),
        (b"just,words\nin,here\n", "no column of numbers"),
        (b"\xd0\xcf\x11\xe0rest", "old form"),
        (b"PK\x03\x04 broken", "cannot be read as an XLSX or ODS workbook"),
        (b"a\0b,c\n1,2\n", "neither text"),
        (b"x,y\n1,2\n3,1,234\n", "a.file line 3: 3 cells under 2 headings"),
        (workbook(("s", "<row><c><v>1</v></c></row>"), **{"xl/workbook.xml": "<no"}), "cannot be read"),
        (
            workbook(("s", ""), **{SHEET.format(1): '<!DOCTYPE a [<!ENTITY b "c">]><worksheet/>'}),
            "has a document type",
        ),
        (workbook(("s", '<row><c t="s"><v>7</v></c></row>')), "not a complete XLSX or ODS workbook"),
        (workbook(("s", ""), **{"content.xml": "<a/>"}), "a.file has no sheets with cells"),
    ],
)
def test_what_cannot_be_read_says_why(content: bytes, message: str) -> None:
    with pytest.raises(TableError, match=message):
        read_measurements(content, "a.file")


def test_a_part_that_says_it_is_small_is_not_unpacked_further() -> None:
    content = workbook(("s", " " * 200_000_000))
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        size = archive.getinfo(SHEET.format(1)).file_size
    lying = content.replace(size.to_bytes(4, "little"), (5000).to_bytes(4, "little"))
    tracemalloc.start()
    with pytest.raises(TableError, match="cannot be read as an XLSX or ODS workbook: Bad CRC"):
        read_measurements(lying, "a.xlsx")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 20e6


def test_one_cell_far_away_costs_no_table() -> None:
    rows = '<row r="1"><c r="A1"><v>1</v></c></row><row r="200000"><c r="AAA200000"><v>2</v></c></row>'
    tracemalloc.start()
    _, _, cells = read_workbook(workbook(("s", rows)), "a.xlsx")
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert (len(cells), sum(map(len, cells))) == (200_000, 1)
    assert peak < 200e6


def test_an_unknown_sheet_names_the_known_ones() -> None:
    with pytest.raises(TableError, match="no sheet 'Other'; its sheets: Readings, Notes"):
        read_measurements(workbook(("Readings", ROWS), ("Notes", ""), strings=STRINGS), "a.xlsx", "Other")


def test_a_force_is_named_as_such() -> None:
    """The form said that the column had no unit."""
    x, force, volume = read_measurements(b"eps [%];Kraft [N];V [cm3]\n0.1;10;3\n1;40;2\n", "a.csv").columns
    assert x.unclear is None
    assert force.unclear == "is in N, a force; for a stress in kPa the factor is 0.001 / A with the area A in m2"
    assert volume.unclear == "is in cm^3, which is not a length, time, stress, angle or number"
