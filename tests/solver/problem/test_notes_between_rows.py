"""Notes between the rows, remarks that contradict a heading, cells with units of their own, numbers for no reading."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import TableError, measured_points
from geoswarm.solver.problem.tables.columns import Columns, table_of
from geoswarm.solver.problem.tables.numerals import sentinels_in
from geoswarm.solver.problem.tables.quantities import quantities_of
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_measurements import workbook
from tests.solver.problem.test_units_beside_headings import metres

HEAD = "Zeit [min];Setzung [mm]"
CHANGES = "may change the unit, scale or zero of readings from there on"
LEAVE = {"incomplete": "leave_out"}


def with_note(note: str, place: str) -> str:
    row = {"first": f"{note};", "second": f";{note}", "third": f";;{note}", "comment": f"# {note}"}[place]
    return f"{HEAD};Bem.\n1;0,1;\n2;0,2;\n{row}\n4;40,5;\n5;50,5;\n"


NOTES = [
    "ab hier in 1/100 mm",
    "from here in mm",
    "ab hier in cm",
    "Bereich x10",
    "range changed",
    "Messbereich umgeschaltet",
    "Gauge reset",
    "re-zeroed",
    "Messuhr neu gestellt",
    "Messuhr ausgetauscht",
    "Nullabgleich",
    "neuer Nullpunkt",
    "new dial gauge",
    "units changed to inch",
    "Faktor 10",
    "Setzung in µm",
    "à partir d'ici en µm",
    "remise à zéro du comparateur",
    "changement d'échelle",
    "puesta a cero",
    "desde aquí en cm",
    "zerowanie czujnika",
    "zmiana zakresu",
    "nollställning",
    "härifrån i cm",
    "from now on times in h",
]


@pytest.mark.parametrize("place", ["first", "second", "third", "comment"])
@pytest.mark.parametrize("note", NOTES)
def test_a_note_that_may_change_what_follows_is_asked_for(note: str, place: str) -> None:
    """40.5 mm were read below ``ab hier in 1/100 mm``, where the row of the note was left out."""
    found = metres(with_note(note, place), **LEAVE)
    assert f"line 4: '{note}' {CHANGES}" in found
    assert "give x_column: A2:A3 and y_column: B2:B3 for those above it" in found


@pytest.mark.parametrize("note", [note for note in NOTES if note not in ("Faktor 10", "Setzung in µm")])
def test_a_note_beside_a_reading_is_asked_for(note: str) -> None:
    assert CHANGES in metres(f"{HEAD};Bem.\n1;0,1;\n2;0,2;\n4;40,5;{note}\n5;50,5;\n")


@pytest.mark.parametrize("place", ["first", "second", "third", "comment"])
@pytest.mark.parametrize(
    "note",
    [
        "Laststufe 2: 100 kPa",
        "Stage 2 (200 kN/m2)",
        "Entlastung auf 0 kPa",
        "Strom ausgefallen",
        "nach 24 h abgelesen",
        "unloading",
        "Tag 2",
        "out of range",
        "Temp. in °C",
        "zero lateral strain",
        "unit weight measured",
        "S. Meier: estimated from scarps to N and S",
        "5cm minimum based on crack edge offset",
        "Setzung [mm]",
    ],
)
def test_other_notes_are_passed_over(note: str, place: str) -> None:
    assert metres(with_note(note, place), **LEAVE) == [0.0001, 0.0002, 0.0405, 0.0505]


def test_a_note_above_the_rows_of_a_stage_counts_for_them() -> None:
    text = f"Stufe;{HEAD}\n1;1;0,1\n1;2;0,2\nab hier in 1/100 mm;;\n1;3;0,3\n2;1;40\n2;2;50\n"
    columns = {"x": "Zeit", "where": {"Stufe": 2.0}}
    with pytest.raises(TableError, match=CHANGES):
        table_of(text.encode(), "a", Columns(y="Setzung", **columns))


def test_cells_that_are_named_have_the_unit_of_the_note_above_them() -> None:
    text = with_note("ab hier in 1/100 mm", "second")
    table = table_of(text.encode(), "a", Columns(x="A5:A6", y="B5:B6"))
    assert (table.y, table.y_heading.unit) == ([40.5, 50.5], "0.01 mm")


@pytest.mark.parametrize(
    "line",
    ["Messuhr bei t = 3 min zurückgesetzt", "ab Zeile 4 in 1/100 mm", "gauge reset at 3 min", "from row 4 in cm"],
)
def test_a_note_outside_of_the_table_names_the_place_of_the_change(line: str) -> None:
    assert CHANGES in metres(f"{line};\n{HEAD}\n1;0,1\n2;0,2\n4;40,5\n")
    assert CHANGES in metres(f"# {line}\n{HEAD}\n1;0,1\n2;0,2\n4;40,5\n")
    assert CHANGES in metres(f"{HEAD}\n1;0,1\n2;0,2\n4;40,5\n{line}\n")


@pytest.mark.parametrize("cell", ["5 µm", "0,5 mm", "0.5mm", "50 1/100mm", "40 div", "2 h", "5 %"])
def test_a_reading_with_a_unit_of_its_own_is_not_left_out(cell: str) -> None:
    """Its row was left out, as if it held no reading."""
    for row, column in ((f"3;{cell}", "Setzung [mm]"), (f"{cell};0,3", "Zeit [min]")):
        found = metres(f"{HEAD}\n1;0,1\n2;0,2\n{row}\n4;0,4\n", **LEAVE)
        assert f"line 4, column {column}: '{cell}' is not a finite number: it has a unit" in found
    book = workbook(("s", sheet_rows(HEAD.split(";"), (1.0, 0.1), (2.0, 0.2), (3.0, cell), (4.0, 0.4))))
    assert "it has a unit of its own" in metres(book, **LEAVE)


REMARKS = ["in µm", "(µm)", "[µm]", "µm", "Werte in µm", "values in um", "en µm"]


@pytest.mark.parametrize("remark", REMARKS)
def test_a_remark_that_contradicts_the_heading_is_asked_for(remark: str) -> None:
    """The heading alone counted."""
    rows = "1;0,1\n2;0,2\n4;0,4\n"
    for text in (
        f"{HEAD};Bem.\n1;0,1;{remark}\n2;0,2;\n4;0,4;\n",
        f"{HEAD};{remark}\n1;0,1;\n2;0,2;\n4;0,4;\n",
        f"# {remark}\n{HEAD}\n{rows}",
        f"{remark};\n{HEAD}\n{rows}",
        f"Versuch 7;\n{remark};\n{HEAD}\n{rows}",
    ):
        assert "names several units, mm and um" in metres(text), text
    same = remark.replace("µm", "mm").replace("um", "mm")
    assert metres(f"{HEAD};Bem.\n1;0,1;{same}\n2;0,2;\n4;0,4;\n") == [0.0001, 0.0002, 0.0004]


def test_the_name_of_a_sheet_may_contradict_the_heading() -> None:
    rows = sheet_rows(HEAD.split(";"), (1.0, 0.1), (2.0, 0.2), (4.0, 0.4))
    assert "names several units, mm and um" in metres(workbook(("Werte in µm", rows)))
    assert metres(workbook(("Werte in mm", rows))) == [0.0001, 0.0002, 0.0004]


def test_a_unit_beside_the_readings_is_that_of_other_lengths() -> None:
    for remark in ("Tiefe in m", "Kraft in kN", "Stufe 1: 0,5 mm"):
        assert metres(f"{HEAD};Bem.\n1;0,1;{remark}\n2;0,2;\n") == [0.0001, 0.0002]


@pytest.mark.parametrize("code", ["-99", "-999", "-9999", "9999", "99999", "1e30", "-999.25", "-32768", "999.9"])
def test_a_number_for_no_reading_is_asked_for(code: str) -> None:
    """It was a reading."""
    text = f"{HEAD}\n1;0.1\n2;0.2\n3;{code}\n4;0.4\n"
    value = f"{float(code):.15g}"
    assert f"line 4, column Setzung [mm]: {value} is far from the other numbers" in metres(text)
    assert f"no_reading: [{value}]" in metres(text)
    assert metres(text, no_reading=(float(code),)) == [0.0001, 0.0002, 0.0004]
    assert len(metres(text, no_reading=())) == 4
    assert len(metres(text, gross=(3,))) == 4


def test_numbers_for_no_reading_in_other_columns_and_large_files() -> None:
    gauges = "Zeit [min];Setzung [mm];Rahmen [mm]\n1;0.1;0.01\n2;0.2;-999\n3;0.3;0.03\n4;9999;0.04\n"
    assert "9999, -999 are far from the other numbers" in metres(gauges, y_minus="Rahmen")
    many = "".join(f"{i},{i * 0.001:.3f}\n" for i in range(1, 20_000))
    assert "-999 is far" in metres(f"Zeit [min],Setzung [mm]\n{many}20000,-999\n")
    assert "column Zeit [min]: -99 is far" in metres(f"{HEAD}\n1;0.1\n2;0.2\n-99;0.3\n4;0.4\n")


@pytest.mark.parametrize(
    ("values", "codes"),
    [
        ([0.1, -1.0, 0.2, -1.0, 0.3], [-1.0]),
        ([200.0, -1.0, 210.0, -1.0, 220.0], [-1.0]),
        ([0.0, -1.0, 0.0, -1.0, 2.0], []),
        ([0.0, 200.0, -99.0, 400.0], [-99.0]),
        ([-200.0, -100.0, -99.0, 0.0], []),
        ([-1.0, -50.0, -99.0, -150.0], []),
        ([9.0, 99.0, 150.0, 200.0], []),
        ([0.0, 0.0, 0.0, -1.0], []),
        ([-5.0, -2.0, -999.0], [-999.0]),
        ([999.0, 999.0], []),
    ],
)
def test_real_data_are_no_codes(values: list[float], codes: list[float]) -> None:
    assert sentinels_in(values) == codes


def test_times_may_end_with_a_number_that_looks_like_a_code() -> None:
    assert len(metres(f"{HEAD}\n1;0.1\n10;0.2\n9999;0.4\n")) == 3


def test_an_observation_says_what_stands_for_no_reading() -> None:
    text = f"{HEAD}\n1;0.1\n2;-999\n4;0.4\n8;0.5\n".encode()
    asked = '{"series": "s", "x_column": "Zeit", "y_column": "Setzung"}'
    with pytest.raises(ProblemError, match=r"no_reading: \[-999\], which leaves such rows out"):
        measured_points(asked, text, "a.csv")
    points, _ = measured_points(asked.replace("}", ', "no_reading": [-999]}'), text, "a.csv")
    assert np.allclose(points.y, [0.1, 0.4, 0.5])
    assert points.notes == ("1 row of a.csv without a number in every column was left out",)


def test_a_first_row_with_a_remark_is_no_row_of_units() -> None:
    """``1;0,1;in mm`` became the units of the headings, and its reading was lost."""
    assert metres(f"{HEAD};Bem.\n1;0,1;in mm\n2;0,2;\n3;0,3;\n") == [0.0001, 0.0002, 0.0003]


ROWS = "1;0,1\n2;0,2\n4;0,4\n"


@pytest.mark.parametrize(
    "text",
    [
        f"Hinweis: Setzungen mit 100 multipliziert;\n{HEAD}\n{ROWS}",
        f"Dial constant = 0.002 mm/div\n{HEAD}\n{ROWS}",
        f"Gerätekonstante: 0,002\n{HEAD}\n{ROWS}",
        f"Constante del anillo: 0,01 mm/div\n{HEAD}\n{ROWS}",
        f"{HEAD} 1)\n{ROWS}1) values are tenths\n",
        f"Facteur d'échelle : 0,01\n{HEAD}\n{ROWS}",
        f"Mnożnik: 0,01\n{HEAD}\n{ROWS}",
        f"Skalfaktor: 0,01\n{HEAD}\n{ROWS}",
        f"1 działka = 0,01 mm\n{HEAD}\n{ROWS}",
        f"Exponent;0;-2\n{HEAD}\n{ROWS}",
        f"{HEAD};Nr\nmin;mm;-\n1;0,01;Faktor\n1;0,1;1\n2;0,2;2\n",
        f"{HEAD};Nr\n0,5;100;Gain\n1;0,1;1\n2;0,2;2\n",
        f"{HEAD};Nr\n0,5;100;Verstärkung\n1;0,1;1\n2;0,2;2\n",
        f"Zeit [min];Setzung (mm) milésimas\n{ROWS}",
        f"Zeit [min];Setzung [mm] w setnych\n{ROWS}",
        f"Zero;0;12,3\n{HEAD}\n{ROWS}",
        f"{HEAD};\n1;0,1;\n2;0,2;\n4;3;*\n8;4;*\n*: Messuhr zurückgestellt\n",
        f"{HEAD};\n1;0,1;\n2;0,2;\n4;3;a)\n8;4;a)\na) neue Messuhr\n",
        f"{HEAD}\n{ROWS}readings after 2 min were taken in inches\n",
        f"Unités : µm\n{HEAD}\n{ROWS}",
        f"Channel;Name;Unit\n1;Setzung;µm\n2;Kraft;N\n\n{HEAD}\n{ROWS}",
        f"# s = settlement, µm\n{HEAD}\n{ROWS}",
        f"# columns: t (min), s (µm)\n{HEAD}\n{ROWS}",
        f"# units: min, um\n{HEAD}\n{ROWS}",
        f"# t: min\n# s: um\n{HEAD}\n{ROWS}",
        f"t: min\ns: um\n{HEAD}\n{ROWS}",
        f"Zeit [min];Setzung_mm_per_m\n{ROWS}",
    ],
)
def test_further_places_of_units_scales_and_zeros_are_asked_for(text: str) -> None:
    """Each was read as the heading says."""
    found = metres(text, "B:B")
    assert isinstance(found, str)
    said = (CHANGES, "has a factor", "may have an offset", "several units", "may be in mm/m")
    assert any(words in found for words in said)


@pytest.mark.parametrize(
    "line",
    [
        "Höhe: 20 mm; Durchmesser: 71,4 mm",
        "# height in cm, settlement in mm",
        "Load ring constant (kN/div): 0.0025",
        "Ablesegenauigkeit 0,01 mm",
        "Entnahmetiefe ab 4,5 m",
        "# units: min, mm",
        "1;Kraft;kN",
        "Height;2;cm",
        "Probe bei 20 °C gelagert, Wassergehalt in %",
    ],
)
def test_lines_about_other_quantities_are_passed_over(line: str) -> None:
    assert metres(f"{line}\n{HEAD}\n{ROWS}") == [0.0001, 0.0002, 0.0004]


@pytest.mark.parametrize(
    ("heading", "meant"),
    [
        ("Obciążenie σ'", "axial_stress"),
        ("Osiadanie Δh", "settlement"),
        ("Wskaźnik porowatości e", "void_ratio"),
        ("Wysokość próbki", "height"),
        ("Tassement", "settlement"),
        ("Contrainte verticale", "axial_stress"),
        ("Déformation axiale", "axial_strain"),
        ("Temps", "time"),
        ("Asentamiento", "settlement"),
        ("Hinchamiento", "heave"),
        ("Esfuerzo desviador", "q"),
        ("Sättning", "settlement"),
        ("Tid", "time"),
    ],
)
def test_words_of_other_languages_are_understood(heading: str, meant: str) -> None:
    assert quantities_of(heading)[0] == meant


def test_a_polish_oedometer_that_begins_with_no_load_is_read_with_one_question() -> None:
    """Void ratios were proposed as loads, and the file was refused for its first row."""
    table = (
        "Laboratorium Geotechniki;;\nWysokość początkowa h0 [mm];20,00;\n"
        "Obciążenie σ' [kPa];Osiadanie Δh [mm];Wskaźnik porowatości e [-]\n"
        "0;0,000;0,812\n12,5;0,045;0,808\n25;0,102;0,803\n"
    ).encode()
    model = (
        '{"kind": "oedometer", "material": "soft_soil", "height": 0.02, "initial_stress": 5, '
        '"stages": [{"stress": 12.5, "duration": 1}, {"stress": 25, "duration": 1}]}'
    )
    with pytest.raises(ProblemError) as refused:
        measured_points('{"series": "stage_settlement"}', table, "edo.csv", model)
    lines = ("x_column: Obciążenie σ' [kPa]", "y_column: Osiadanie Δh [mm]", "x_from: 1")
    assert all(line in str(refused.value) for line in lines)
    answer = {"series": "stage_settlement", **dict(line.split(": ") for line in lines[:2]), "x_from": 1}
    points, units = measured_points(json.dumps(answer), table, "edo.csv", model)
    assert (points.x[-2:], points.y[-2:], units["y_unit"]) == ([1.0, 2.0], [0.045, 0.102], "mm")
