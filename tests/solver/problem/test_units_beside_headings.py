"""Units that stand beside the headings: in merged cells, in titles above the table, in a column of their own."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.problem import TableError, read_measurements
from geoswarm.solver.problem.issues import validated
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.points import points_of_file
from geoswarm.solver.problem.readings.units import unit_of_data
from geoswarm.solver.problem.tables.columns import Columns, table_of
from geoswarm.solver.problem.tables.headings import heading_of, unclear_unit
from geoswarm.solver.problem.tables.quantities import quantities_of
from geoswarm.solver.sentences import plain
from geoswarm.solver.units import convert
from tests.solver.problem.test_laboratory_files import ods_cell, open_document, sheet_rows
from tests.solver.problem.test_measurements import workbook

ASKED = "has no unit"
NUMBERS = "1;1\n2;2\n4;3\n"


def metres(content: bytes | str, y: str = "Setzung", **keys: Any) -> list[float] | str:
    """Readings in m as the file says, or why it does not."""
    content = content.encode() if isinstance(content, str) else content
    try:
        table = table_of(content, "a", Columns(x="A:A", y=y, **keys))
    except TableError as error:
        return str(error)
    unit, wrong = unit_of_data("y", None, "m", table.y_heading, unitless=False)
    if wrong is not None:
        return plain(wrong)
    return [round(value, 12) for value in convert(np.array(table.y), unit or "m", "m").tolist()]


def merged(*rows: tuple[Any, ...], cells: str) -> bytes:
    ranges = "".join(f'<mergeCell ref="{one}"/>' for one in cells.split())
    end = f"</sheetData><mergeCells>{ranges}</mergeCells><sheetData>"
    return workbook(("s", sheet_rows(*rows) + end))


STAGES = (
    ("Zeit [min]", "Setzung [mm]", None, None),
    ("", "Stufe 1", "Stufe 2", "Stufe 3 [cm]"),
    (1.0, 1.0, 4.0, 7.0),
    (2.0, 2.0, 5.0, 8.0),
)


def test_a_merged_heading_has_the_unit_of_all_columns_that_it_spans() -> None:
    content = merged(*STAGES, cells="B1:D1")
    assert metres(content, "B:B") == [0.001, 0.002]
    assert metres(content, "C:C") == [0.004, 0.005]
    assert "names several units, cm and mm" in metres(content, "D:D")
    assert ASKED in metres(merged(*STAGES, cells="A1:B1"), "C:C")
    assert ASKED in metres(merged(*STAGES, cells="A1:B1 B1:C1"), "C:C")  # none overlap in a sheet
    units = [column.unit for column in read_measurements(content, "a").columns]
    assert units == ["min", "mm", "mm", None]


def test_a_merged_unit_below_the_names_and_in_an_open_document() -> None:
    rows = ("Zeit", "Probe 1", "Probe 2"), ("min", "mm", None), (1.0, 1.0, 4.0), (2.0, 2.0, 5.0)
    assert metres(merged(*rows, cells="B2:C2"), "C:C") == [0.004, 0.005]
    cell = ods_cell("Setzung [mm]", "string")
    spanning = cell.replace("<table:table-cell", '<table:table-cell table:number-columns-spanned="2"')
    content = open_document(
        ods_cell("Zeit [min]", "string") + spanning + "<table:covered-table-cell/>",
        "<table:table-cell/>" + ods_cell("Probe 1", "string") + ods_cell("Probe 2", "string"),
        ods_cell(1.0) + ods_cell(1.0) + ods_cell(4.0),
        ods_cell(2.0) + ods_cell(2.0) + ods_cell(5.0),
    )
    assert metres(content, "C:C") == [0.004, 0.005]


def test_a_merged_name_of_a_column_stays_a_name() -> None:
    rows = ("Zeit [min]", "Setzung [mm]", None), (1.0, 1.0, 4.0), (2.0, 2.0, 5.0)
    assert metres(merged(*rows, cells="B1:C1")) == [0.001, 0.002]


@pytest.mark.parametrize(
    ("titles", "heading", "expected"),
    [
        ("Messwerte in mm", "Setzung", 1e-3),
        ("Setzungen in mm", "Setzung", 1e-3),
        ("Setzungen in 1/100 mm", "Setzung", 1e-5),
        ("All values in mm", "settlement", 1e-3),
        ("Setzung [mm]", "Setzung", 1e-3),
        ("Setzungen in mm\nZeiten in min", "Setzung", 1e-3),
        ("Einheit: mm", "Setzung", 1e-3),
        ("Probe 1 in cm", "Setzung", ASKED),
        ("Spannungen in kPa", "Setzung", ASKED),
        ("Messwerte in kPa", "Setzung", ASKED),
        ("Setzungen in mm", "Messwert", ASKED),
        ("Setzungen in mm\nSetzungen in cm", "Setzung", "names several units"),
        ("Setzungen in cm", "Setzung [mm]", "names several units"),
        ("Setzungen in mm", "Setzung [Skt]", "not a known unit"),
        ("Setzungen in mm x 0,1", "Setzung", "has a factor"),
    ],
)
def test_a_title_line_says_the_unit_of_its_quantity(titles: str, heading: str, expected: float | str) -> None:
    found = metres(f"{titles}\nZeit [min];{heading}\n{NUMBERS}", "B:B")
    if isinstance(expected, str):
        assert expected in found
    else:
        assert found == [round(value * expected, 12) for value in (1, 2, 3)]


def test_a_title_counts_for_its_own_table_only() -> None:
    content = "Setzungen in mm\nZeit [min];Setzung\n1;1\n2;2\nLast [kPa];Setzung 2\n1;4\n2;5\n"
    assert ASKED in metres(content, "Setzung 2")


LONG = "Zeit [min];Größe;Wert;Einheit\n1;Setzung;1;mm\n1;Last;100;kPa\n2;Setzung;2;mm\n2;Last;100;kPa\n"


@pytest.mark.parametrize(
    ("text", "y", "where", "expected"),
    [
        ("Zeit [min];Setzung;Einheit\n1;1;mm\n2;2;mm\n", "Setzung", {}, [0.001, 0.002]),
        ("Zeit;Einheit;Setzung;Einheit\n1;min;1;[mm]\n2;min;2;[mm]\n", "Setzung", {}, [0.001, 0.002]),
        (LONG, "Wert", {"Größe": "Setzung"}, [0.001, 0.002]),
        (LONG, "Wert", {}, "column 'Wert' is in mm and kPa; choose the rows of one unit"),
        ("nr;quantity;unit;value\n1;s;mm;1\n2;s;mm;2\n", "value", {}, [0.001, 0.002]),
        ("Zeit [min];Setzung;Unit\n1;1;mm\n2;2;cm\n", "Setzung", {}, "is in mm and cm"),
        ("Zeit [min];Setzung;Unit\n1;1;mm\n2;2;\n", "Setzung", {}, "is in mm and none"),
        ("Zeit [min];Setzung [cm];Einheit\n1;1;mm\n2;2;mm\n", "Setzung", {}, "names several units, cm and mm"),
        ("Zeit [min];Höhe;Einheit;Setzung\n1;20;mm;1\n2;20;mm;2\n", "Setzung", {}, ASKED),
        ("Zeit [min];Setzung [mm];Unit\n1;1;A\n2;2;B\n", "Setzung", {}, [0.001, 0.002]),
    ],
)
def test_a_column_of_units(text: str, y: str, where: dict[str, str | float], expected: list[float] | str) -> None:
    found = metres(text, y, where=where)
    assert found == expected if isinstance(expected, list) else expected in found


def test_a_first_reading_of_one_is_no_row_of_units() -> None:
    """``1;1;%`` below the names was taken for a row of units, and its reading was lost."""
    found = table_of(b"Nr;Dehnung;Einheit\n1;1;%\n2;1;%\n3;2;%\n", "a", Columns(x="Nr", y="Dehnung"))
    assert found.y == [1.0, 1.0, 2.0]
    assert found.y_heading.unit == "%"
    columns = {one.name: one for one in read_measurements(b"Nr;Dehnung;Einheit\n1;1;%\n2;1;mm\n", "a").columns}
    assert columns["Dehnung"].unclear == "is in % and mm"


@pytest.mark.parametrize(
    ("dates", "expected"),
    [
        (("24.11.10", "24.11.11", "24.11.13"), "'24.11.10' is a date whose day or year may be first"),
        (("10.11.24", "11.11.24", "13.11.24"), [0.0, 1.0, 3.0]),
        (("24.11.2010", "24.11.2011", "24.11.2012"), [0.0, 365.0, 731.0]),
        (("03.01.2024", "03.13.2024", "03.14.2024"), "'03.13.2024' is a date whose day or month may be first"),
    ],
)
def test_dates_with_points(dates: tuple[str, str, str], expected: list[float] | str) -> None:
    content = "".join(["Datum;Setzung [mm]\n", *(f"{date};{y}\n" for y, date in enumerate(dates))]).encode()
    if isinstance(expected, list):
        assert table_of(content, "a", Columns(x="Datum", y="Setzung")).x == expected
        return
    with pytest.raises(TableError, match=expected):
        table_of(content, "a", Columns(x="Datum", y="Setzung", incomplete="leave_out"))
    assert read_measurements(content, "a").columns[0].doubt in dates
    form = "year_first" if dates[0].startswith("24") else "month_first"
    days = table_of(content, "a", Columns(x="Datum", y="Setzung", dates=form)).x
    assert days == ([0.0, 1.0, 3.0] if form == "year_first" else [0.0, 12.0, 13.0])


@pytest.mark.parametrize("heading", ["Setzung mm bzw. cm", "Setzung mm / cm", "Setzung mm cm"])
def test_two_units_outside_of_brackets_are_asked_for(heading: str) -> None:
    _, wrong = unit_of_data("y", None, "m", heading_of(heading, {}), unitless=False)
    assert wrong is not None
    assert "names several units" in plain(wrong)


@pytest.mark.parametrize(("unit", "kilopascals"), [("kg/cm2", 98.0665), ("psf", 0.04788), ("kPa", 1.0), ("mPa", 1e-6)])
def test_the_problem_takes_the_units_that_refusals_name(unit: str, kilopascals: float) -> None:
    """``y_unit: kg/cm2``, as the refusal of a column without a unit says, was an unknown unit."""
    section, issues = validated(ObservationSection, {"series": "q", "file": "a.csv", "y_unit": unit}, "")
    assert section is not None, issues
    assert section.y_unit is not None
    assert np.isclose(float(convert(1.0, section.y_unit, "kPa")), kilopascals, rtol=1e-4)


def test_an_abbreviated_pore_pressure() -> None:
    assert quantities_of("Porenwass.") == ("pore_pressure",)


@pytest.mark.parametrize(
    "line",
    [
        "Faktor: 0,01",
        "Umrechnungsfaktor Setzung = 1/100",
        "# factor 0.01",
        "Skalierung: 0,01",
        "Werte x 0,01",
        "Setzungen in mm x 0,1",
        "multiply by 0.01",
        "values divided by 10",
        "Messwerte in 1/100",
        "scale 1:10",
    ],
)
def test_a_factor_above_or_below_the_table_is_asked_for(line: str) -> None:
    table = f"Zeit [min];Setzung [mm]\n{NUMBERS}"
    for content in (f"{line}\n{table}", f"{table}\n{line}\n"):
        found = metres(content)
        assert "has a factor" in found, content
        assert line.lstrip("# ").replace(";", " ") in found
        assert "give y_factor, which multiplies, or y_unit, which says what the numbers are in" in found
        columns = read_measurements(content.encode(), "a").columns
        assert columns[1].unit is None
        assert "has a factor" in (columns[1].unclear or "")


@pytest.mark.parametrize(
    "line",
    [
        "Faktor: 1,0",
        "Safety factor 1.5",
        "Faktor Last 0,5",
        "Probe 5 x 10",
        "Werte in mm",
        "Scale 1",
        "Faktor Zeit: 60",
    ],
)
def test_lines_that_do_not_scale_the_column_are_passed_over(line: str) -> None:
    assert metres(f"{line}\nZeit [min];Setzung [mm]\n{NUMBERS}") == [0.001, 0.002, 0.003]


def test_a_factor_alone_or_in_the_cell_behind_its_name_is_asked_for() -> None:
    assert "'line 1: x 10^-2', beside mm" in metres(f"x 10^-2\nZeit [min];Setzung [mm]\n{NUMBERS}")
    assert "'line 1: Faktor 0,01', beside mm" in metres(f"Faktor;0,01\nZeit [min];Setzung [mm]\n{NUMBERS}")


def test_a_unit_that_is_given_settles_a_factor_beside_the_table() -> None:
    table = table_of(f"Faktor: 0,01\nZeit [min];Setzung [mm]\n{NUMBERS}".encode(), "a", Columns(x="A:A", y="B:B"))
    assert unit_of_data("y", "0.01 mm", "m", table.y_heading, unitless=False) == ("0.01 mm", None)


@pytest.mark.parametrize(
    ("headings", "base", "said", "remedy"),
    [
        (
            ("p0+10 [kPa]", "p0 + 10 [kPa]", "σ1+σ3 [kPa]", "sigma_1+sigma_3 [kPa]", "σ·A [kPa]"),
            "kPa",
            "is a sum or a product, '",
            "; give the quantity itself, or y_unit, which says what the numbers are in",
        ),
        (("100-ε [%]", "100 - eps [%]"), "", "is a sum or a product, '", "; give the quantity itself, or y_unit"),
        (
            (
                "u kPa abs",
                "abs. pressure [kPa]",
                "u absolute [kPa]",
                "Absolutdruck [kPa]",
                "u [kPa(a)]",
                "u (kPa abs.)",
            ),
            "kPa",
            "is an absolute pressure, '",
            "; subtract that of the atmosphere (y_minus takes a column of it) and give y_unit: kPa",
        ),
        (("u bar abs", "u [bar(a)]", "u in bar a", "u bara"), "kPa", "is an absolute pressure, 'abs'", "y_unit: bar"),
        (("u psia", "u [psia]", "u (psi a)"), "kPa", "is an absolute pressure, 'abs', beside psi", "y_unit: psi"),
        (
            ("Strain % of full scale", "Strain % FS", "Strain [%] FS", "Dehnung [% v. E.]", "Dehnung % vom Endwert"),
            "",
            "is a share of full scale, 'FS', beside %",
            "; give the unit of the gauge and its range, such as y_unit: dimensionless and y_factor: full scale / 100",
        ),
        (("u [% FS]", "u % FS", "u (% of full scale)"), "kPa", "is a share of full scale, 'FS'", "y_unit: kPa and y_f"),
    ],
)
def test_what_is_not_in_the_unit_beside_it_is_named(
    headings: tuple[str, ...], base: str, said: str, remedy: str
) -> None:
    """All were called a factor or a function; ``kPa(a)`` and ``psia`` were unknown, ``(a)`` a year."""
    for heading in headings:
        unit, wrong = unit_of_data("y", None, base, heading_of(heading, {}), unitless=False, needed=not base)
        assert unit is None, heading
        assert said in plain(wrong or ()), heading
        assert remedy in plain(wrong or ()), heading


@pytest.mark.parametrize(
    ("heading", "unit"), [("u [psig]", "psi"), ("u barg", "bar"), ("u [kPa g]", "kPa"), ("u (kPa(g))", "kPa")]
)
def test_a_pressure_of_a_gauge_is_in_its_unit(heading: str, unit: str) -> None:
    assert unit_of_data("y", None, "kPa", heading_of(heading, {}), unitless=False) == (unit, None)


def settled(content: str, **keys: Any) -> list[float] | str:
    """Readings in m of a problem's observation, or why not."""
    given = {"series": "settlement", "file": "a", "x_column": "A:A", "y_column": "Setzung", **keys}
    section, issues = validated(ObservationSection, given, "")
    assert section is not None, issues
    points, issues = points_of_file(section, "", content.encode(), "a")
    assert points is not None, issues
    unit, wrong = unit_of_data("y", section.y_unit, "m", points.y_heading, unitless=False)
    return plain(wrong) if wrong is not None else [round(y, 12) for y in convert(np.array(points.y), unit or "m", "m")]


@pytest.mark.parametrize(
    "table",
    [
        f"Faktor: 0,01\nZeit [min];Setzung [mm]\n{NUMBERS}",
        "Zeit [min];Setzung [mm];Faktor\n1;1;0,01\n2;2;0,01\n4;3;0,01\n",
    ],
)
def test_one_answer_settles_a_factor(table: str) -> None:
    """``y_factor`` alone did not; a factor in a column went unnoticed."""
    found = settled(table)
    assert "has a factor, '" in found
    assert "beside mm; give y_factor, which multiplies, or y_unit" in found
    assert settled(table, y_factor=0.01) == [1e-5, 2e-5, 3e-5]
    assert settled(table, y_factor=1) == [1e-3, 2e-3, 3e-3]
    assert settled(table, y_unit="0.01 mm") == [1e-5, 2e-5, 3e-5]


def test_a_factor_settles_no_root() -> None:
    section, _ = validated(
        ObservationSection, {"series": "s", "file": "a", "x_column": "A:A", "y_column": "B:B", "x_factor": 2}, ""
    )
    assert section is not None
    points, _ = points_of_file(section, "", "√t [min];Setzung [mm]\n1;1\n2;2\n".encode(), "a")
    assert points is not None
    assert "has a function" in plain(unit_of_data("x", None, "day", points.x_heading, unitless=False)[1] or ())


@pytest.mark.parametrize(
    ("header", "first", "asked"),
    [
        ("Zeit [min];Setzung [mm];Multiplikator", "1;1;0,1", True),
        ("Zeit [min];Setzung [mm];factor", "1;1;10", True),
        ("Zeit [min];Setzung [mm];Umrechnungsfaktor Setzung", "1;1;0,01", True),
        ("Zeit [min];Setzung [mm];Skalierung", "1;1;0,01", True),
        ("Zeit [min];Setzung [mm];Faktor", "1;1;1,0", False),
        ("Zeit [min];Setzung [mm];Faktor Last", "1;1;10", False),
        ("Zeit [min];Setzung [mm];Sicherheitsfaktor", "1;1;1,5", False),
        ("Zeit [min];Setzung [mm];time factor", "1;1;0,2", False),
        ("Zeit [min];Setzung [mm];Gewichtungsfaktor", "1;1;0,5", False),
    ],
)
def test_a_column_of_factors(header: str, first: str, asked: bool) -> None:
    content = f"{header}\n{first}\n2;2;{first.rpartition(';')[2]}\n4;3;{first.rpartition(';')[2]}\n"
    found = settled(content)
    assert ("has a factor" in found) if asked else (found == [1e-3, 2e-3, 3e-3])
    assert ("has a factor" in (read_measurements(content.encode(), "a").columns[1].unclear or "")) == asked


@pytest.mark.parametrize(
    "heading",
    [
        *("σ1-σ3 [kPa]", "σ1 - σ3 [kPa]", "sigma_1-sigma_3 [kPa]", "u-u0 [kPa]", "Δh [mm]", "in-situ stress [kPa]"),
        *("p' = (σ1+σ2+σ3)/3 [kPa]", "Zeit-Setzung [mm]", "OE-2 Setzung [mm]", "Probe 1-A [mm]", "Absenkung [mm]"),
        *("fs [kPa]", "absolute Setzung [mm]", "Stufe 1 - Setzung [mm]", "c+ [kPa]"),
    ],
)
def test_differences_names_and_words_keep_their_unit(heading: str) -> None:
    assert unclear_unit(heading_of(heading, {}).named) is None
