"""What an import must never do silently: lose thousands, take a cover for the readings, skip what nobody calculated."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import TableError, measured_points, read_measurements
from geoswarm.solver.problem.readings.units import unit_of_data
from geoswarm.solver.problem.tables.columns import Columns, table_of
from geoswarm.solver.problem.tables.headings import heading_of
from geoswarm.solver.problem.tables.numerals import doubtful_cell, number_of
from geoswarm.solver.problem.tables.quantities import quantities_of
from geoswarm.solver.sentences import plain
from geoswarm.solver.units import convert
from tests.solver.problem.test_columns import mistakes, observed
from tests.solver.problem.test_laboratory_files import DAY, ods_cell, open_document, sheet_rows
from tests.solver.problem.test_measurements import workbook

THOUSANDS = b'x,y\n1,"1,000"\n2,"2,000"\n'


@pytest.mark.parametrize(
    ("cells", "doubtful"),
    [
        (["1,000", "2,000"], "1,000"),
        (["1", "1,000"], "1,000"),
        (["0.5", "1,000"], "1,000"),
        (["1.000.000"], "1.000.000"),
        (["1,000,000"], "1,000,000"),
        (["1'000"], "1'000"),
        (["1 000"], "1 000"),
        (["1.234,5"], "1.234,5"),
        (["0,125", "1,250"], None),  # a leading zero: decimals
        (["1,5", "1,000"], None),
        (["1.000", "2.000"], None),  # a point alone stands before decimals
        (["800", "1.600", "3.200"], "1.600"),  # behind all of them there would be decimals
        ([800.0, "1.600"], "1.600"),
        (["900", "1.235", "1.311"], "1.235"),  # as decimals, they would fall
        (["605.038", "605", "604.971"], None),
        (["0", "1.250", "2.500"], None),
        (["1234,567"], None),
        (["12", "1e3", "-7"], None),
    ],
)
def test_cells_with_two_readings_are_found(cells: list[str | float], doubtful: str | None) -> None:
    assert doubtful_cell(cells, cells) == doubtful


def test_the_rest_of_the_file_may_decide() -> None:
    assert doubtful_cell(["1,000"], ["1,000", "0,25"]) is None
    assert doubtful_cell(["1,000"], ["1,000", "0.25"]) == "1,000"
    assert doubtful_cell(["1.000"], ["1.000", "0,25"]) == "1.000"
    assert doubtful_cell(["1.000"], ["1.000", "0.25"]) is None


@pytest.mark.parametrize(
    ("cell", "comma", "point"),
    [
        ("1,000", 1.0, 1000.0),
        ("1.000", 1000.0, 1.0),
        ("-12.345,5", -12345.5, None),
        ("12,345.5", None, 12345.5),
        ("1'000,5", 1000.5, None),
        ("1\u202f000", 1000.0, 1000.0),
        ("0,25", 0.25, None),
        ("1e3", 1000.0, 1000.0),
        (2.5, 2.5, 2.5),
        ("12,34.5", None, None),
        ("", None, None),
    ],
)
def test_the_sign_before_decimals_decides(cell: str | float, comma: float | None, point: float | None) -> None:
    assert (number_of(cell, "comma"), number_of(cell, "point")) == (comma, point)


def test_thousands_in_quotes_are_never_ones(tmp_path: Path) -> None:
    asked = mistakes(tmp_path, "a.csv", THOUSANDS, **DAY)
    assert "line 2, column y: '1,000' may have thousands; say how it is written" in asked
    assert "decimal_sign: comma reads 1, decimal_sign: point reads 1000" in asked
    assert observed(tmp_path, "a.csv", THOUSANDS, decimal_sign="point", **DAY).points.y == [1000, 2000]
    assert observed(tmp_path, "a.csv", THOUSANDS, decimal_sign="comma", **DAY).points.y == [1, 2]


def test_a_look_at_a_file_tells_doubt_and_guesses_no_number() -> None:
    x, y = read_measurements(THOUSANDS, "a.csv").columns
    assert (x.doubt, x.values) == (None, (1.0, 2.0))
    assert (y.doubt, y.values, y.first) == ("1,000", (None, None), ("1,000", "2,000"))
    (dates, _) = read_measurements(b"date,y\n03/04/2024,1\n12/04/2024,2\n", "a.csv").columns
    assert (dates.kind, dates.doubt, dates.values) == ("time", "03/04/2024", (None, None))
    (dates, _) = read_measurements(b"date,y\n03/04/2024,1\n13/04/2024,2\n", "a.csv").columns
    assert (dates.kind, dates.doubt, dates.values) == ("time", None, (0.0, 10.0))


COVER = sheet_rows(("Laboratory report",), ("Client", "harbour"), ("Date", "2024-03-01"))
READINGS = sheet_rows(("Zeit [min]", "Setzung [mm]"), (1.0, 0.5), (2.0, 0.75))


PLACES = sheet_rows(("Probe 1",), ("Höhe:", 90.6, 90.0, "mm"), ("Masse:", 165.34, 164.79, "g"))
READ = sheet_rows(("Zeit [s]", "Kraft [N]"), (0, 1), (300, 2), (600, 3))


def test_the_only_sheet_with_the_columns_is_read_and_several_are_asked_for() -> None:
    wanted = Columns("Zeit", "Kraft")
    table = table_of(workbook(("Tabelle", PLACES), ("Versuch01", READ)), "a.xlsx", wanted)
    assert (table.x, table.y) == ([0, 300, 600], [1, 2, 3])
    several = workbook(("Tabelle", PLACES), ("Versuch01", READ), ("Versuch02", READ))
    with pytest.raises(TableError, match="several sheets have these columns, Versuch01, Versuch02; give sheet"):
        table_of(several, "a.xlsx", wanted)
    with pytest.raises(TableError, match="this is sheet 'Tabelle' of Tabelle, Versuch01, Versuch02"):
        table_of(several, "a.xlsx", Columns("Zeit", "Weg"))


def test_a_sheet_of_data_about_the_specimen_is_no_table_of_readings() -> None:
    constants = sheet_rows(("mT", "mR"), (2.24, 2.68))
    found = read_measurements(workbook(("Tabelle", PLACES), ("Parameter", constants), ("Versuch01", READ)), "a.xlsx")
    assert found.sheet == "Versuch01"


def test_the_cover_of_a_workbook_is_passed_over() -> None:
    found = read_measurements(workbook(("Cover", COVER), ("Readings", READINGS)), "a.xlsx")
    assert (found.sheets, found.sheet) == (("Cover", "Readings"), "Readings")
    assert [column.quantities[0] for column in found.columns] == ["time", "settlement"]


def test_sheets_with_the_same_headings_are_named() -> None:
    content = workbook(("Tabelle", PLACES), ("Versuch01", READ), ("Versuch02", READ.replace("Zeit", "ZEIT")))
    assert read_measurements(content, "a.xlsx").alike == ("Versuch01", "Versuch02")
    assert read_measurements(content, "a.xlsx", "Tabelle").alike == ()


def test_a_sheet_without_numbers_still_offers_the_others() -> None:
    content = workbook(("Cover", COVER), ("Notes", sheet_rows(("none",))))
    found = read_measurements(content, "a.xlsx", "Notes")
    assert (found.sheets, found.sheet) == (("Cover", "Notes"), "Notes")
    assert all(value is None for column in found.columns for value in column.values)
    with pytest.raises(TableError, match="no column of numbers"):
        read_measurements(workbook(("Cover", COVER)), "a.xlsx")


UNCALCULATED = (
    '<row r="1"><c r="A1" t="inlineStr"><is><t>x</t></is></c><c r="B1" t="inlineStr"><is><t>y</t></is></c></row>'
    '<row r="2"><c r="A2"><v>1</v></c><c r="B2"><v>5</v></c></row>'
    '<row r="3"><c r="A3"><v>2</v></c><c r="B3"><f>B2*2</f></c></row>'
    '<row r="4"><c r="A4"><v>3</v></c><c r="B4"><f>B3*2</f><v></v></c></row>'
)


@pytest.mark.parametrize("kept", [{}, {"incomplete_rows": "leave_out"}])
def test_formulas_without_stored_values_are_named(kept: dict[str, str], tmp_path: Path) -> None:
    content = workbook(("s", UNCALCULATED))
    found = read_measurements(content, "a.xlsx")
    assert found.formulas == ("B3 (=B2*2)", "B4 (=B3*2)")
    assert found.columns[1].values == (5.0, None, None)
    told = mistakes(tmp_path, "a.xlsx", content, **kept, **DAY)
    assert "a.xlsx line 3, column y: =B2*2 has no stored value; let a spreadsheet program calculate" in told
    assert "line 4" in told


def test_formulas_alone_are_named_in_both_kinds_of_workbook() -> None:
    only = UNCALCULATED.replace("<v>", "<!--").replace("</v>", "-->").replace('<c r="A2">', '<c r="A2"><f>1</f>')
    with pytest.raises(TableError, match=r"no column of numbers.*formulas without a stored value: A2 \(=1\)"):
        read_measurements(workbook(("s", only)), "a.xlsx")
    formula = '<table:table-cell table:formula="of:=[.A2]*2"/>'
    content = open_document(
        ods_cell("x", "string") + ods_cell("y", "string"), ods_cell(1.0) + formula, ods_cell(2.0) + ods_cell(3.0)
    )
    assert read_measurements(content, "a.ods").formulas == ("B2 (=[.A2]*2)",)


def test_rows_without_a_number_are_left_out_when_that_is_wished(tmp_path: Path) -> None:
    text = "x,y\n2024-03-01,n/a\n2024-03-02,1\n2024-03-03,\n2024-03-05,2\n"
    assert "'n/a' is not a finite number" in mistakes(tmp_path, "a.csv", text.encode(), y_unit="mm")
    found = observed(tmp_path, "a.csv", text.encode(), y_unit="mm", incomplete_rows="leave_out")
    assert (found.points.x, found.points.y) == ([0, 3], [1, 2])
    assert found.notes[-1] == "2 rows of a.csv without a number in every column were left out"
    nothing = mistakes(tmp_path, "a.csv", b"x,y\n1,a\n2,b\n", incomplete_rows="leave_out", **DAY)
    assert "no row has a number in every column" in nothing


def test_points_are_read_as_a_problem_file_reads_them() -> None:
    text = b"Probe;Zeit [min];links [mm];rechts [mm]\nS1;1;5;1\n;2;6;1\nS2;1;7;2\n;2;9;2,5\n"
    given = '{"series": "s", "x_column": "Zeit", "y_column": "links", "y_minus": "rechts", "where": {"Probe": "S2"}}'
    points, units = measured_points(given, text, "a.csv")
    assert (points.x, points.y) == ([1, 2], [5, 6.5])
    assert units == {"x_unit": "min", "y_unit": "mm"}
    assert points.notes == (
        "rows of a.csv with Probe = S2",
        "y is the difference of two columns: links [mm] less rechts",
    )


@pytest.mark.parametrize(
    ("text", "given", "x_unit", "y_unit"),
    [
        (b"x [min],y\n1,2\n", "", "min", "unstated"),
        (b"x [min],y [div]\n1,2\n", "", "min", "unstated"),
        (b"x [min],y [mm] [0.01 mm]\n1,2\n", "", "min", "unstated"),
        (b"x [min],y [1/100 mm]\n1,2\n", ', "x_unit": "h"', "h", "0.01 mm"),
        (b"x;y\n01.03.2024;2 mm\n02.03.2024;3 mm\n", "", "day", "mm"),
    ],
)
def test_points_come_with_the_units_that_were_said(text: bytes, given: str, x_unit: str, y_unit: str) -> None:
    _, units = measured_points(f'{{"series": "s", "x_column": "A:A", "y_column": "B:B"{given}}}', text, "a.csv")
    assert units == {"x_unit": x_unit, "y_unit": y_unit}


@pytest.mark.parametrize(
    ("given", "path", "message"),
    [
        ('{"series": "s", "x_columm": "x"}', "x_columm", "unknown key"),
        ('{"series": "s", "x_column": "z"}', "file", "there is no column 'z'"),
        ('{"series": "s", "y_zero": {"x": 9}}', "y_zero", "there is no reading at x = 9"),
        ("[1]", "", "mapping"),
    ],
)
def test_what_is_wrong_is_told_with_its_field(given: str, path: str, message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        measured_points(given, b"x,y\n1,2\n", "a.csv")
    issue = caught.value.issues[0]
    assert (issue.path, message in issue.message) == (path, True), issue


@pytest.mark.parametrize(
    ("heading", "meant"),
    [
        ("Setzung", "settlement"),
        ("settlement", "settlement"),
        ("Zeit", "time"),
        ("Versuchszeit", "time"),
        ("Elapsed time", "time"),
        ("Datum", "time"),
        ("Uhrzeit", "clock"),
        ("Probennummer", "specimen"),
        ("Specimen", "specimen"),
        ("Laststufe", "stage"),
        ("Stage", "stage"),
        ("Spannung", "axial_stress"),
        ("Vertikalspannung", "axial_stress"),
        ("Dehnung", "axial_strain"),
        ("axial strain", "axial_strain"),
        ("Axialstauchung", "axial_strain"),
        ("bezogene Setzung", "axial_strain"),
        ("Volumendehnung", "volumetric_strain"),
        ("volumetric strain", "volumetric_strain"),
        ("Porenwasserdruck", "pore_pressure"),
        ("Porenwasserüberdruck", "excess_pore_pressure"),
        ("pore water pressure", "pore_pressure"),
        ("u", "pore_pressure"),
        ("Porenzahl", "void_ratio"),
        ("void_ratio", "void_ratio"),
        ("Deviatorspannung", "q"),
        ("deviatoric stress", "q"),
        ("mittlere effektive Spannung", "p"),
        ("Scherspannung", "shear_stress"),
        ("shear_strain", "shear_strain"),
        ("Radialdehnung", "radial_strain"),
        ("radial displacement", "radial_displacement"),
        ("Seitendruck", "lateral_stress"),
        ("confining_pressure", "lateral_stress"),
        ("sigma3'", "lateral_stress"),
        ("sigma_r", "lateral_stress"),
        ("sigma_v", "axial_stress"),
        ("shearstrain", "shear_strain"),
        ("test_id", "specimen"),
        ("Radialspg.", "lateral_stress"),
        ("Axialspg.", "axial_stress"),
        ("Verformung", "settlement"),
        ("Bemerkung", "remark"),
    ],
)
def test_words_of_laboratories_are_understood(heading: str, meant: str) -> None:
    found = quantities_of(heading)
    assert found[0] == meant
    assert quantities_of(heading.upper()) == found


def test_words_that_are_written_together_are_understood() -> None:
    assert quantities_of("ShearStrain")[0] == "shear_strain"
    assert quantities_of("TimeSinceStartOfTest")[0] == "time"
    assert quantities_of("Specimen Air Volume") == ()


@pytest.mark.parametrize("heading", ["column 1", "x", "y", "temperature", "Wassergehalt", "Kanal 3", "Radialvol.", ""])
def test_what_is_not_known_is_not_guessed(heading: str) -> None:
    assert quantities_of(heading) == ()


def test_specimens_are_counted_with_the_empty_cells_below_them() -> None:
    rows: list[tuple[Any, ...]] = [("specimen", "x", "y"), ("S1", 1.0, 2.0), (None, 2.0, 3.0), ("S2", 1.0, 5.0)]
    (specimen, *_) = read_measurements(workbook(("s", sheet_rows(*rows))), "a.xlsx").columns
    assert (specimen.quantities, specimen.entries) == (("specimen",), {"S1": 2, "S2": 1})


@pytest.mark.parametrize(
    ("heading", "told"),
    [
        *((f"{one} [kPa]", one) for one in ("10q", "2q", "0.5 q", "½ q", "1/2 q", "2*tau", "0.5(s1-s3)", "q x 0,5")),
        *((f"{one} [kPa]", one) for one in ("Δq/q", "q/p'", "q/pref", "p'/p0'", "u/σ3", "q/2", "dq/dp", "σ1/σ3")),
        *((f"Spannung {one} [kPa]", one) for one in ("10-fach", "zehnfach", "q/p0", "q/2")),
        ("t=(σ1-σ3)/2 [kPa]", ")/2"),
        ("q (x 0,01) [kPa]", "x 0,01"),
        ("normalised q [kPa]", "normalised"),
        ("exp(q) in kPa", "exp"),
    ],
)
def test_a_factor_or_quotient_before_a_unit_is_asked_for(heading: str, told: str) -> None:
    named = heading_of(heading, {})
    unit, wrong = unit_of_data("y", None, "kPa", named, unitless=False)
    assert unit is None
    assert wrong is not None
    assert f"'{told[:1]}" in plain(wrong)
    assert "y_unit, which says what the numbers are in" in plain(wrong)
    assert unit_of_data("y", "kPa", "kPa", named, unitless=False) == ("kPa", None)


@pytest.mark.parametrize("heading", ["100 ε", "Dehnung x 100", "Dehnung*100", "10 ε [-]", "strain (x 1000)"])
def test_a_factor_before_a_strain_is_asked_for(heading: str) -> None:
    assert "factor" in str(unit_of_data("y", None, "dimensionless", heading_of(heading, {}), unitless=False)[1])


@pytest.mark.parametrize("heading", ["eps_1", "strain (abs)", "ε", "Stauchung"])
def test_a_strain_without_a_unit_is_asked_for(heading: str) -> None:
    named = replace(heading_of(heading, {}), first=(0.05, 0.1))
    unit, wrong = unit_of_data("x", None, "", named, unitless=False, needed=True)
    assert unit is None
    assert wrong is not None
    assert f"'{heading}' (0.05, 0.1, ...) has no unit; give x_unit: '%' or dimensionless" in plain(wrong)
    unstated = unit_of_data("y", "unstated", "", named, unitless=False, needed=True)[1]
    assert unstated is not None
    assert "give y_unit: '%' or" in plain(unstated)
    assert unit_of_data("x", None, "", named, unitless=False) == (None, None)  # a void ratio


@pytest.mark.parametrize("heading", ["eps1%", "%strain", "Strain% corr", "eps_v%", "‰Dehnung", "ε‰"])
def test_a_sign_of_per_cent_beside_a_letter_is_the_unit(heading: str) -> None:
    unit, wrong = unit_of_data("y", None, "", heading_of(heading, {}), unitless=False, needed=True)
    assert wrong is None
    assert unit == ("%" if "%" in heading else "permille")


@pytest.mark.parametrize(
    ("heading", "base", "factor"),
    [
        *((f"{one} [mm]", "m", 1e-3) for one in ("Setzung/Settlement", "Weg 1 / Weg 2", "Sensor 1/2", "2 Setzung")),
        *((f"{one} [mm]", "m", 1e-3) for one in ("Setzung bei 100 kPa", "100 kPa", "3. Weg", "(s1+s2)/2", "24 h")),
        *((f"{one} [kPa]", "kPa", 1.0) for one in ("Last/Stress", "p'=(σ1'+2σ3')/3", "q=σ1-σ3", "(3) q", "σ1'")),
        *((f"{one} [%]", "dimensionless", 0.01) for one in ("Δh/h0", "normalised settlement", "bezogene Setzung")),
        ("Zeit t/min", "day", 1 / 1440),
        ("Setzung s/mm", "m", 1e-3),
        ("Zeit [Tg]", "day", 1.0),
        ("Setzung [my]", "m", 1e-6),
        ("Dial [thou]", "m", 2.54e-5),
        ("Stress (lb/sq ft)", "kPa", 0.04788025898),
        ("Stress [kg/sq.cm]", "kPa", 98.0665),
        ("Strain [1e-6]", "dimensionless", 1e-6),
        ("strain (decimal)", "dimensionless", 1.0),
        ("q (daN/cm²)", "kPa", 100.0),
    ],
)
def test_words_beside_a_unit_are_no_factors(heading: str, base: str, factor: float) -> None:
    unit, wrong = unit_of_data("y", None, base, heading_of(heading, {}), unitless=False)
    assert wrong is None
    assert unit is not None
    assert float(convert(1.0, unit, base)) == pytest.approx(factor, rel=1e-8)


@pytest.mark.parametrize(
    ("heading", "heave"),
    [
        ("Hebung [mm]", True),
        ("Heave [mm]", True),
        ("heave_mm", True),
        ("Uplift (mm)", True),
        ("Quellung in mm", True),
        ("Sohlhebung [mm]", True),
        ("Swell [mm]", True),
        ("Setzung/Hebung [mm]", True),
        ("Gonflement [mm]", True),
        ("Tassement (mm, négatif vers le bas)", True),
        ("Setzung, Hebung neg. [mm]", False),
        ("Settlement (+) / heave (-) [mm]", False),
        ("Setzung [mm]", False),
        ("Erhebung der Setzung [mm]", False),
    ],
)
def test_a_heave_is_a_settlement_only_with_its_sign_said(heading: str, heave: bool) -> None:
    text = f"Zeit [min];{heading}\n0;1\n1;2\n3;4\n".encode()
    given = {"series": "settlement", "x_column": "A:A", "y_column": "B:B", "y_unit": "mm"}
    assert ("heave" in quantities_of(heading)) is heave
    if heave:
        with pytest.raises(ProblemError, match=r"is a heave, which settlement has with the other sign; .*y_factor: -1"):
            measured_points(json.dumps(given), text, "a.csv")
    else:
        assert measured_points(json.dumps(given), text, "a.csv")[0].y == [1.0, 2.0, 4.0]
    assert measured_points(json.dumps({**given, "y_factor": -1}), text, "a.csv")[0].y == [-1.0, -2.0, -4.0]
    other = {**given, "series": "heave"}
    assert measured_points(json.dumps(other), text, "a.csv")[0].y == [1.0, 2.0, 4.0]


def test_a_swelling_pressure_is_no_heave() -> None:
    assert "heave" not in quantities_of("swelling pressure [kPa]")
    assert "heave" not in quantities_of("Quelldruck [kPa]")
