"""Notes, columns and headings by which numbers are not in the unit beside them, and spellings that are nothing such."""

from __future__ import annotations

import json
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import measured_points
from geoswarm.solver.problem.readings.units import unit_of_data
from geoswarm.solver.problem.tables.columns import Columns, table_of
from geoswarm.solver.problem.tables.headings import guess_unit, heading_of, unclear_unit, units_of
from geoswarm.solver.problem.tables.quantities import is_heave, quantities_of
from geoswarm.solver.sentences import plain
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_measurements import workbook
from tests.solver.problem.test_units_beside_headings import NUMBERS, metres, settled


@pytest.mark.parametrize(
    "line",
    [
        "1 div = 0.01 mm",
        "1 Skt. = 0,01 mm",
        "Angaben in Hundertstel",
        "Alle Werte mal 10 nehmen",
        "values are × 0.1",
        "*) Werte in 1/100 mm",
    ],
)
def test_a_note_below_the_table_that_scales_is_asked_for(line: str) -> None:
    """Readings in steps of a dial gauge below ``Ablesung [mm]`` were millimetres."""
    assert f"has a factor, 'line 5: {line}'" in metres(f"Zeit [min];Setzung [mm]\n{NUMBERS}{line}\n")


@pytest.mark.parametrize(
    "line", ["1 Stufe: 25 kPa", "1 bar = 100 kPa", "Werte in mm", "Probe 1 mal 2", "Werte korrigiert"]
)
def test_a_note_below_the_table_that_does_not_scale_is_passed_over(line: str) -> None:
    assert metres(f"Zeit [min];Setzung [mm]\n{NUMBERS}{line}\n") == [0.001, 0.002, 0.003]


@pytest.mark.parametrize("name", ["Exponent", "Zehnerpotenz", "10^", "Massstab", "Maßstab"])
def test_a_column_of_powers_or_scales_is_asked_for(name: str) -> None:
    assert "has a factor, 'column" in metres(f"Zeit [min];Setzung [mm];{name}\n1;1;-2\n2;2;-2\n")


def test_a_column_of_factors_is_no_matter_of_a_time() -> None:
    found = table_of(b"t [min];s [mm];Faktor\n1;1;10\n2;2;10\n", "a", Columns(x="A:A", y="B:B"))
    assert unit_of_data("x", None, "day", found.x_heading, unitless=False) == ("min", None)


def test_one_plus_the_void_ratio_is_no_void_ratio() -> None:
    _, wrong = unit_of_data("y", None, "", heading_of("1+e", {}), unitless=False)
    assert "is a sum or a product, '1+e'" in plain(wrong or ())


@pytest.mark.parametrize(
    "heading", ["Setzung (- nach unten) [mm]", "settlement (down = neg) [mm]", "displacement (+ up) [mm]"]
)
def test_a_settlement_that_is_negative_downwards_is_asked_for(heading: str) -> None:
    assert is_heave(heading)
    assert not is_heave(heading.replace("-", "+").replace("neg", "pos").replace("up", "down"))


def test_exponents_of_fortran_and_a_product_in_a_cell() -> None:
    content = "Zeit [min];Setzung [m]\n1.0D+00;1.5D-03\n2.0D+00;2.5d-03\n"
    assert metres(content) == [0.0015, 0.0025]
    assert "'1,5*10^-3' is not a finite number" in metres("Zeit [min];Setzung [m]\n1;1,5*10^-3\n2;2,5*10^-3\n")


@pytest.mark.parametrize(
    ("heading", "base", "unit"),
    [
        ("Setzung (gesamt, mm)", "m", "mm"),
        ("strain (%, corrected)", "", "%"),
        ("q [kPa; korr.]", "kPa", "kPa"),
        ("q (tonf/ft2)", "kPa", "force_ton/ft^2"),
        ("q [ton/m2]", "kPa", "tf/m^2"),
        ("Setzung (mm, cm)", "m", None),
        ("Setzung (mm, x10)", "m", None),
        ("Setzung (25,1 mm)", "m", None),
    ],
)
def test_a_unit_among_words_in_brackets(heading: str, base: str, unit: str | None) -> None:
    assert unit_of_data("y", None, base, heading_of(heading, {}), unitless=False, needed=not base)[0] == unit


@pytest.mark.parametrize("heading", ["Axial strain rate [%/min]", "Setzungsgeschwindigkeit", "AxialStrainRate_pct_min"])
def test_a_rate_is_no_strain_and_no_settlement(heading: str) -> None:
    assert quantities_of(heading) == ()


@pytest.mark.parametrize(
    ("note", "unit"),
    [("Setzungen in 1/100 mm", "0.01 mm"), ("Setzung [1/100 mm]", "0.01 mm"), ("settlement in cm", "cm")],
)
def test_a_note_that_names_another_unit_of_the_quantity_is_asked_for(note: str, unit: str) -> None:
    """Notes below the table and comments were passed over."""
    table = f"Zeit [min];Setzung [mm]\n{NUMBERS}"
    for content in (f"{table}{note}\n", f"# {note}\n{table}"):
        assert f"names several units, mm and {unit}" in metres(content), content
        assert metres(content.replace("Setzung [mm]", f"Setzung [{unit}]"))[0] in (1e-5, 0.01)


@pytest.mark.parametrize("note", ["Setzung der Probe in 5 m Tiefe", "Setzungsgeschwindigkeit in mm/min", "Last in kPa"])
def test_a_note_on_something_else_is_passed_over(note: str) -> None:
    assert metres(f"# {note}\nZeit [min];Setzung [mm]\n{NUMBERS}{note}\n") == [0.001, 0.002, 0.003]


@pytest.mark.parametrize("note", ["Zeiten in 1/10 s", "Faktor Zeit: 60", "Zeit in Std"])
def test_notes_on_the_time_count_for_the_time(note: str) -> None:
    found = table_of(f"Zeit [s];Setzung [mm]\n{NUMBERS}{note}\n".encode(), "a", Columns(x="A:A", y="B:B"))
    assert unit_of_data("x", None, "day", found.x_heading, unitless=False)[0] is None
    assert unit_of_data("y", None, "m", found.y_heading, unitless=False) == ("mm", None)


def test_factors_of_several_channels_and_of_a_calibration() -> None:
    assert "has a factor" in metres(f"Kanal;1;2\nFaktor;1,0;0,01\nZeit [min];Setzung [mm]\n{NUMBERS}")
    assert "has a factor" in metres(f"Kalibrierung: 0,01\nZeit [min];Setzung [mm]\n{NUMBERS}")
    assert metres(f"Faktor 1,0 bei 20 °C\nZeit [min];Setzung [mm]\n{NUMBERS}") == [0.001, 0.002, 0.003]


@pytest.mark.parametrize(
    "heading",
    [
        *("Setzung [mm] /2", "1/2 Setzung [mm]", "halbe Setzung [mm]", "double amplitude [mm]", "Setzung x 60 [mm]"),
        *("Setzung [mm] (x2)", "Setzung (2,5x) [mm]", "Setzung [mm] (halbiert)", "γ/2 [%]", "Setzung, skaliert [mm]"),
        *("settlement (model, 1:50) [mm]", "settlement [mm], prototype scale", "Tassement en centièmes de mm"),
        *("cedimento, centesimi di mm", "setning hundredels mm"),
    ],
)
def test_halves_doubles_and_multiples_are_asked_for(heading: str) -> None:
    """They were millimetres without a word."""
    assert unclear_unit(units_of(heading)) is not None


def test_two_units_behind_in_are_asked_for() -> None:
    """The first one was taken."""
    assert unclear_unit(units_of("Zeit in h und min")) == "names several units, h and min"


@pytest.mark.parametrize("heading", ["settlement in thousandths of an inch", "settlement in hundredths of a mm"])
def test_english_parts_of_units_are_no_seconds(heading: str) -> None:
    """A refusal said that the column was in 0.001 s."""
    assert guess_unit(heading)[2] == "m"


@pytest.mark.parametrize(
    "heading",
    [
        *("Setzung [mm] 1)", "Setzung Probe 1/2 [mm]", "Setzungen in mm und Zeiten", "Setzung [mm] 1:1", "s/H [%]"),
        *("LVDT (x1) [mm]", "settlement of plate [mm]", "Zusammendrückung der Probe in mm", "Tassement en mm"),
    ],
)
def test_notes_and_names_of_specimens_are_no_factors(heading: str) -> None:
    assert unclear_unit(units_of(heading)) is None


@pytest.mark.parametrize(
    "heading",
    ["-Setzung [mm]", "− s [mm]", "Setzung [mm] negativ", "Setzung (neg.) [mm]", "negative settlement (mm)"],
)
def test_a_sign_is_asked_for(heading: str) -> None:
    assert "has a sign, " in (said := metres(f"Zeit [min];{heading}\n{NUMBERS}", "B:B"))
    assert "give y_factor: -1, or 1 where" in said
    assert settlements(heading, y_factor=-1) == [-1.0, -2.0, -3.0]


@pytest.mark.parametrize("heading", ["Setzung, Hebung neg. [mm]", "Settlement (-) [mm]", "Setzung - korr. [mm]"])
def test_what_is_said_of_a_heave_is_no_sign(heading: str) -> None:
    assert metres(f"Zeit [min];{heading}\n{NUMBERS}", "B:B") == [0.001, 0.002, 0.003]


@pytest.mark.parametrize("heading", ["d(s)/dt [mm]", "ds/dt in mm", "Δs/Δt [mm]"])
def test_a_derivative_is_asked_for(heading: str) -> None:
    assert "has a function, 'd" in metres(f"Zeit [min];{heading}\n{NUMBERS}", "B:B").replace("Δ", "d")


@pytest.mark.parametrize(
    ("heading", "said"),
    [
        ("Setzungszuwachs [mm]", "is a step, 'Setzungszuwachs'"),
        ("incremental settlement (mm)", "is a step, 'incremental'"),
        ("settlement [mm] per cycle", "has a function, 'per cycle'"),
        ("settlement mm per 100 kPa", "has a function, 'per 100'"),
        ("settlement+0.3 [mm]", "is a sum or a product, '+0.3'"),
        ("Setzung [mm] in cm", "names several units, mm and cm"),
        ("Setzung [m] mm", "names several units, m and mm"),
    ],
)
def test_steps_and_sums_of_settlements_are_asked_for(heading: str, said: str) -> None:
    """They were read as they stand."""
    assert said in metres(f"Zeit [min];{heading}\n{NUMBERS}", "B:B")


def test_a_strain_in_two_units_is_asked_for() -> None:
    assert unclear_unit(units_of("strain [-] in %")) == "names several units, dimensionless and %"


@pytest.mark.parametrize("remark", ["Werte x 0,01", "Skala: 0.01", "scale factor 10"])
def test_a_remark_beside_the_readings_that_scales_is_asked_for(remark: str) -> None:
    """Texts in the rows of the readings and over empty columns were passed over."""
    for content in (
        f"Zeit [min];Setzung [mm];Bemerkung\n1;1;{remark}\n2;2;\n".encode(),
        f"Zeit [min];Setzung [mm];{remark}\n1;1;\n2;2;\n".encode(),
        workbook(("s", sheet_rows(("Zeit [min]", "Setzung [mm]", "", remark), (1, 1.0), (2, 2.0)))),
    ):
        assert f"has a factor, 'remark: {remark}'" in metres(content)


@pytest.mark.parametrize("line", ["Offset;5", "Nullablesung [mm]: 12,31", "zero reading = 5 mm", "# Tara 0,5"])
def test_an_offset_beside_the_table_is_asked_for(line: str) -> None:
    """It was passed over."""
    content = f"{line}\nZeit [min];Setzung [mm]\n{NUMBERS}"
    assert "may have an offset, " in (said := metres(content))
    assert "give y_zero, which is subtracted, or y_unit, which says that none is" in said
    assert settled(content, y_zero={"y": 0.5}) == [0.0005, 0.0015, 0.0025]
    assert settled(content, y_unit="mm") == [0.001, 0.002, 0.003]


@pytest.mark.parametrize("line", ["Offset;0", "Offset Kraft;5", "Nullpunkt abgezogen: nein", "Offset Zeit;5"])
def test_no_offset_and_one_of_something_else_are_passed_over(line: str) -> None:
    assert metres(f"{line}\nZeit [min];Setzung [mm]\n{NUMBERS}") == [0.001, 0.002, 0.003]


def test_a_remark_that_does_not_scale_is_passed_over() -> None:
    content = "Zeit [min];Setzung [mm];Bemerkung\n1;1;Probe 1 mal 2\n2;2;Faktor Sicherheit 1,5\n"
    assert metres(content) == [0.001, 0.002]


@pytest.mark.parametrize("heading", ["Zeitschritt [min]", "time step (s)", "Zeitintervall in min"])
def test_steps_of_time_are_asked_for(heading: str) -> None:
    _, wrong = unit_of_data("x", None, "day", heading_of(heading, {}), unitless=False)
    assert "is a step, " in plain(wrong or ())


def test_a_height_is_a_settlement_only_with_its_zero() -> None:
    with pytest.raises(ProblemError, match=r"'Höhe \[mm\]' is a height, and settlement is the loss .* y_factor: -1"):
        settlements("Höhe [mm]")
    assert settlements("Höhe [mm]", y_factor=-1, y_zero="first") == [0.0, -1.0, -2.0]


def settlements(heading: str, **keys: Any) -> list[float]:
    """Readings in mm, as a problem with these keys has them."""
    given = {"series": "settlement", "x_column": "A:A", "y_column": "B:B", **keys}
    return measured_points(json.dumps(given), f"Zeit [min];{heading}\n{NUMBERS}".encode(), "a.csv")[0].y
