"""Units that a file names, in headings, rows of units, formats of cells: used, or refused with a true reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import load_problem, parse_problem, problem_yaml
from geoswarm.solver.problem.draft import inlined_document
from geoswarm.solver.problem.observations import Observation
from geoswarm.solver.problem.tables.columns import Columns
from geoswarm.solver.problem.tables.headings import guess_unit
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.units import convert
from tests.solver.problem.test_laboratory_files import ods_cell, open_document, sheet_rows
from tests.solver.problem.test_measurements import workbook
from tests.solver.problem.test_tables import read_table

FORMATS = '<numFmts><numFmt numFmtId="170" formatCode="0.0&quot; MPa&quot;"/></numFmts>'
PERCENT = f'{FORMATS}<cellXfs><xf numFmtId="0"/><xf numFmtId="10"/><xf numFmtId="170"/><xf numFmtId="46"/></cellXfs>'


def triaxial(folder: Path, name: str, content: bytes | str, **keys: Any) -> Observation:
    """Deviator stress over axial strain of a file."""
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    (folder / "problem.yaml").write_text(problem_yaml(document(name, **keys)), encoding="utf-8")
    return load_problem(folder / "problem.yaml").observations[0]


def document(name: str, **keys: Any) -> dict[str, Any]:
    return {
        "name": "t",
        "forward_model": {
            "kind": "triaxial",
            "material": "modified_cam_clay",
            "initial_stress": 500.0,
            "drainage": "undrained",
            "shearing": [{"kind": "monotonic", "axial_strain": 0.21}],
        },
        "parameters": {
            **{name: {"value": value} for name, value in {"lambda": 0.1, "kappa": 0.01, "nu": 0.3, "e0": 0.8}.items()},
            "M": {"lower": 0.3, "upper": 2.0},
        },
        "observations": [{"series": "q", "file": name, **keys}],
        "method": {"kind": "particle_swarm"},
        "stopping": {"max_evaluations": 100},
        "seed": 1,
    }


def refused(folder: Path, name: str, content: bytes | str, **keys: Any) -> str:
    with pytest.raises(ProblemError) as caught:
        triaxial(folder, name, content, **keys)
    return str(caught.value)


@pytest.mark.parametrize(
    "keys", [{"x": "A:A", "y": "B:B"}, {"x": "Dehnung", "y": "Deviator"}, {"x": "A3:A5", "y": "B3:B5"}]
)
def test_a_row_of_units_in_a_workbook(keys: dict[str, str], tmp_path: Path) -> None:
    rows = sheet_rows(("Dehnung", "Deviator"), ("[-]", "[MPa]"), (0.001, 0.05), (0.01, 0.3), (0.2, 0.46))
    found = triaxial(tmp_path, "q.xlsx", workbook(("s", rows)), x_column=keys["x"], y_column=keys["y"])
    assert found.x.tolist() == [0.001, 0.01, 0.2]
    assert found.y.tolist() == [50.0, 300.0, 460.0]


def test_cells_have_the_unit_of_the_heading_above_them(tmp_path: Path) -> None:
    rows = sheet_rows(("eps [%]", "q [MPa]"), (0.1, 0.05), (0.5, 0.3), (1.0, 0.42))
    found = triaxial(tmp_path, "q.xlsx", workbook(("s", rows)), x_column="A2:A4", y_column="B2:B4")
    assert np.allclose(found.x, [0.001, 0.005, 0.01], rtol=1e-15)
    assert found.y.tolist() == [50.0, 300.0, 420.0]


def test_a_row_of_units_is_no_incomplete_row(tmp_path: Path) -> None:
    text = "eps;q\n[%];[kPa]\n0,01;10\n0,05;40\n0,1;60\n"
    found = triaxial(tmp_path, "q.csv", text, x_column="eps", y_column="q", incomplete_rows="leave_out")
    assert np.allclose(found.x, [0.0001, 0.0005, 0.001], rtol=1e-15)
    assert found.notes == ()
    strange = text.replace("[%];[kPa]", "Volt;Volt")
    message = refused(tmp_path, "q.csv", strange, x_column="eps", y_column="q", incomplete_rows="leave_out")
    assert "line 2: 'Volt, Volt' stands between the names and the first row of numbers" in message


def test_cells_formatted_as_per_cent_are_what_a_person_sees(tmp_path: Path) -> None:
    cells = sheet_rows(("eps [%]", "q"))
    for line, (strain, stress) in enumerate(((0.001, 0.01), (0.015, 0.04), (0.1, 0.06)), 2):
        cells += (
            f'<row r="{line}"><c r="A{line}" s="1"><v>{strain}</v></c><c r="B{line}" s="2"><v>{stress}</v></c></row>'
        )
    content = workbook(("s", cells), styles=PERCENT)
    found = triaxial(tmp_path, "q.xlsx", content, x_column="eps", y_column="q")
    assert np.allclose(found.x, [0.001, 0.015, 0.1], rtol=1e-15)
    assert np.allclose(found.y, [10.0, 40.0, 60.0], rtol=1e-15)
    message = refused(tmp_path, "q.xlsx", content, x_column="eps", y_column="q", y_unit="kPa")
    assert "the cells of column 'q' are in MPa: leave y_unit out, not kPa" in message
    document = open_document(
        ods_cell("eps [%]", "string") + ods_cell("q [kPa]", "string"),
        *(ods_cell(strain, "percentage") + ods_cell(stress) for strain, stress in ((0.001, 10.0), (0.015, 40.0))),
    )
    assert np.allclose(triaxial(tmp_path, "q.ods", document, x_column="eps", y_column="q").x, [0.001, 0.015])


def test_a_table_below_the_lines_of_a_machine(tmp_path: Path) -> None:
    text = (
        '"Test Name:","CU 100"\n"Sample Height (mm):","200.0"\n\n'
        '"Stage Number","Time since start of test (s)","Axial Strain (%)","Deviator Stress (kPa)"\n'
        "3,0,0.0,0.5\n3,60,0.02,8.1\n3,120,0.05,15.2\n"
    )
    found = triaxial(tmp_path, "gds.csv", text, x_column="Axial Strain", y_column="Deviator Stress")
    assert np.allclose(found.x, [0.0, 0.0002, 0.0005])
    assert found.y.tolist() == [0.5, 8.1, 15.2]


@pytest.mark.parametrize(
    ("text", "x"),
    [
        ("eps% q_kPa\n0.1 10.0\n1  40.0\n10   60.0\n", [0.001, 0.01, 0.1]),
        ("eps [%] q [kPa]\n0.1 10.0\n1  40.0\n10   60.0\n", [0.001, 0.01, 0.1]),
        ("eps   q   Void ratio\n[%]    [kPa]    [-]\n\n0.1\t10\t1.03\n1\t40\t1.02\n10\t60\t1.01\n", [0.001, 0.01, 0.1]),
        ("sigma3'   eps   q\n[kPa]    [%]     [kPa]\n\n5\t0.1\t10\n5\t1\t40\n5\t10\t60\n", [0.001, 0.01, 0.1]),
        ("Versuch 7 vom 3. Mai\neps\tq\n%\tkPa\n0,1\t10\n1\t40\n10\t60\n", [0.001, 0.01, 0.1]),
        ("eps / % q in kPa\n0.1 10\n1 40\n10 60\n", [0.001, 0.01, 0.1]),
        ("Versuch 7\n[%]eps [kPa]q\n0.1 10\n1 40\n10 60\n", [0.001, 0.01, 0.1]),
        ('"eps\n[%]";"q\n[kPa]"\n0,1;10\n1;40\n10;60\n', [0.001, 0.01, 0.1]),
        ("Pruefung 4;;\neps [%];q [kPa];\n0,1;10;\n1;40;\n10;60;\n", [0.001, 0.01, 0.1]),
    ],
)
def test_separators_and_titles(text: str, x: list[float], tmp_path: Path) -> None:
    found = triaxial(tmp_path, "q.txt", text, x_column="eps", y_column="q")
    assert np.allclose(found.x, x)
    assert found.y.tolist() == [10.0, 40.0, 60.0]


def test_an_empty_cell_between_blanks_is_refused(tmp_path: Path) -> None:
    assert "the header has: eps m q" in refused(
        tmp_path, "q.txt", "eps m q\n0.001 10\n0.01 40\n", x_column="eps", y_column="q"
    )
    text = "n eps q\n1 0.001 10\n2 0.01 40\n3 60\n"
    assert "line 4: 2 cells under 3 headings (3, 60); where cells are empty" in refused(
        tmp_path, "q.txt", text, x_column="eps", y_column="q"
    )


@pytest.mark.parametrize(
    ("heading", "kilopascal"),
    [
        ("Deviator stress [kg/cm2]", 98.0665),
        *((f"q [{unit}]", 98.0665) for unit in ("kgf/cm2", "kp/cm²", "kg/cm^2", "ksc")),
        *((f"q [{unit}]", 9.80665) for unit in ("t/m²", "tf/m2", "Mp/m²")),
        ("q (psf)", 0.04788025898),
        ("q (ksf)", 47.88025898),
        ("q (tsf)", 95.76051796),
        *((heading, 1000.0) for heading in ("q [MPa] (korr.)", "q in MPa", "q MPa korr.", "q / N/mm²", "q_MPa")),
        *((heading, 1.0) for heading in ("q [kN/m²]", "kPa Deviator", "q (korr.) [kPa]", "q <kPa>", "q=kPa")),
        *((heading, 1.0) for heading in ("q/kN/m²", "q_kN/m^2", "q [kN / m²]", "q [kN m⁻²]", "q [kN/qm]", "σ_3 kPa")),
    ],
)
def test_stresses_in_any_spelling(heading: str, kilopascal: float, tmp_path: Path) -> None:
    text = f"eps [-];{heading}\n0.001;0.5\n0.01;3\n0.1;4.2\n"
    found = triaxial(tmp_path, "q.csv", text, x_column="eps", y_column=heading)
    assert np.allclose(found.y, np.array([0.5, 3.0, 4.2]) * kilopascal, rtol=1e-9)


@pytest.mark.parametrize(
    ("heading", "base", "factor"),
    [
        *(
            (f"s {unit}", "m", 1e-5)
            for unit in (
                "[1/100 mm]",
                "1/100 mm",
                "[Hundertstel mm]",
                "(x 0,01 mm)",
                "[0.01 mm]",
                "[0,01mm]",
                "[10^-2 mm]",
                "[10⁻² mm]",
                "[100stel mm]",
                "100ths of mm",
                "hundredths of a mm",
                ".01 mm",
                "1⁄100 mm",
            )
        ),
        *((heading, "m", 1e-6) for heading in ("s [Mikrometer]", "s µm", "s_um", "s_1/1000_mm", "s [x 10^-3 mm]")),
        ("s micro m", "m", 1e-6),
        ("Setzung in Millimeter", "m", 1e-3),
        ("Setzung 1/1000 inch", "m", 2.54e-5),
        *(
            (heading, "day", 1 / 1440)
            for heading in ("Zeit in Minuten", "Zeit [Minuten]", "Minuten", "t/min", "time (mins)")
        ),
        *((heading, "day", 1 / 24) for heading in ("Zeit (Std)", "Zeit [Std.]", "Stunden")),
        *((heading, "day", 1 / 86400) for heading in ("t [Sek]", "Zeit s", "Time since start (s)")),
        *(
            (heading, "dimensionless", 0.01)
            for heading in ("eps %", "Dehnung Prozent", "eps [Vol.-%]", "strain_percent")
        ),
        *((heading, "dimensionless", 0.001) for heading in ("eps [‰]", "eps [10^-3]", "eps [mm/m]")),
        ("eps [µm/m]", "dimensionless", 1e-6),
    ],
)
def test_units_of_headings(heading: str, base: str, factor: float) -> None:
    _, unit, found = guess_unit(heading)
    assert unit is not None
    assert found == base
    assert float(convert(1.0, unit, base)) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    "heading",
    [
        "Setzung in 5 m Tiefe",
        "sigma1'",
        "load step",
        "void ratio",
        "Versuch (2)",
        "p (t)",
        "Sensor 1",
        "x_1",
        "delta_h",
        "d_h",
        "Delta h",
        "sigma_h",
        "sigma_min",
        "s1",
        "eps [10^-9]",
    ],
)
def test_words_that_are_no_units(heading: str) -> None:
    assert guess_unit(heading)[1] is None


@pytest.mark.parametrize(
    ("heading", "message"),
    [
        ("q [div]", "column 'q [div]' names 'div', which is not a known unit; y_unit says what the numbers are in"),
        ("q in Skalenteilen", "names 'Skalenteilen', which is not a known unit"),
        ("q [mPa]", "names 'mPa', which is not a known unit"),
        (
            "q [N]",
            "column 'q [N]' is in N, a force, but the series needs a stress; name a column of stresses, or give "
            "y_unit: kPa and y_factor: 0.001 / A with the area A in m2 of the specimen",
        ),
        ("q in Sekunden", "is in s, but the series has kPa"),
        *(
            (f"{heading} {unit}", f", '{told}', beside kPa; give ")
            for heading, told in (("√q", "√q"), ("q x 100", "x 100"), ("log q", "log"), ("1/q", "1/q"), ("q²", "²"))
            for unit in ("[kPa]", "(kPa)")
        ),
        *(
            (heading, ", beside kPa; give ")
            for heading in (
                "q [kPa] x 10^-2",
                "q kPa x 10",
                "q (x10) [kPa]",
                "q [kPa] (factor 10)",
                "q E3 kPa",
                "lg(q [kPa])",
                "Wurzel q in kPa",
                "q/10 [kPa]",
                "q in kPa^(1/2)",
                "q 1/100 [kPa]",
                "q [kPa] .01",
                "q 1.0E-2 kPa",
                "q kPa hundertstel",
                "q (100:1) [kPa]",
            )
        ),
        ("q [100 kPa]", "names '100 kPa', which is not a known unit"),
        *((heading, "has no unit") for heading in ("q in 10 kPa", "q hundert kPa", "q bei 100 kPa")),
        ("q [kPa] (psi)", "column 'q [kPa] (psi)' names several units, kPa and psi; y_unit says which holds"),
    ],
)
def test_units_that_are_refused(heading: str, message: str, tmp_path: Path) -> None:
    text = f"eps [-];{heading}\n0.001;0.5\n0.01;3\n0.1;4.2\n"
    assert message in refused(tmp_path, "q.csv", text, x_column="eps", y_column=heading)
    assert triaxial(tmp_path, "q.csv", text, x_column="eps", y_column=heading, y_unit="kPa").y.tolist() == [
        0.5,
        3.0,
        4.2,
    ]


def test_a_column_without_a_unit_is_asked_for(tmp_path: Path) -> None:
    text = "eps q\n0.001 10.0\n0.01  40.0\n0.1   60.0\n0.2 61\n"
    assert refused(tmp_path, "q.txt", text, x_column="eps", y_column="q") == (
        "observations[0].x_column: column 'eps' (0.001, 0.01, 0.1, ...) has no unit; give x_unit: '%' or "
        "dimensionless, or write it in brackets behind the name in the file\n"
        "observations[0].y_column: column 'q' (10, 40, 60, ...) has no unit; give y_unit: kPa, MPa or kg/cm2, or write "
        "it in brackets behind the name in the file"
    )
    units = {"x_unit": "dimensionless", "y_unit": "MPa"}
    assert triaxial(tmp_path, "q.txt", text, x_column="eps", y_column="q", **units).y[0] == 10_000.0


@pytest.mark.parametrize(
    ("heading", "column", "factor"),
    [
        ("Load (N)", "Load", 1e-3),
        ("Load (kN)", "Load", 1.0),
        ("Load_(N)", "Load", 1e-3),
        ("Normalkraft (N) [kN]", "Normalkraft (N) [kN]", 1.0),  # the symbol, and the unit
    ],
)
def test_a_unit_of_one_letter_in_round_brackets_is_used_where_it_fits(
    heading: str, column: str, factor: float, tmp_path: Path
) -> None:
    formula = {"kind": "formula", "series": {"F": {"expression": "M * x", "y_unit": "kN"}}}
    text = f"eps,{heading}\n0.1,7.2\n0.2,6.4\n"
    table = {"series": "F", "file": "F.csv", "x_column": "eps", "y_column": column}
    (tmp_path / "F.csv").write_text(text, encoding="utf-8")
    written = document("F.csv") | {"forward_model": formula, "parameters": {"M": {"lower": 0.0, "upper": 9.0}}}
    (tmp_path / "problem.yaml").write_text(problem_yaml(written | {"observations": [table]}), encoding="utf-8")
    assert load_problem(tmp_path / "problem.yaml").observations[0].y == pytest.approx([7.2 * factor, 6.4 * factor])


def test_a_unit_of_one_letter_that_does_not_fit_is_no_unit_to_write_another_one_beside(tmp_path: Path) -> None:
    text = "eps [-];Test (A)\n0.001;10\n0.01;40\n"
    assert refused(tmp_path, "q.csv", text, x_column="eps", y_column="Test (A)") == (
        "observations[0].y_column: column 'Test (A)' (10, 40, ...) may be in A, but the series has kPa; name another "
        "column, or give y_unit: kPa, MPa or kg/cm2"
    )


def test_the_letters_of_a_column_are_no_unit(tmp_path: Path) -> None:
    rows = "\n".join(f"0.{number};0;0;0;0;0;0;{number}" for number in range(1, 4))
    (tmp_path / "a.csv").write_text(rows, encoding="utf-8")
    assert read_table(tmp_path / "a.csv", Columns(x="H:H", y="D:D")).x_heading.unit is None


def test_cells_that_contradict_their_heading_are_refused(tmp_path: Path) -> None:
    message = refused(tmp_path, "q.csv", "eps [-];q [MPa]\n0,1;1 kPa\n0,2;2 kPa\n", x_column="eps", y_column="q")
    assert "column 'q [MPa]' names several units, kPa and MPa" in message


def test_cells_shown_in_thousands_are_what_a_person_sees(tmp_path: Path) -> None:
    styles = (
        FORMATS.replace("0.0&quot; MPa&quot;", "#,##0.0,\\ \\M\\P\\a")
        + '<cellXfs><xf numFmtId="0"/><xf numFmtId="170"/></cellXfs>'
    )
    cells = sheet_rows(("eps [-]", "q"), (0.001, 10_000.0), (0.01, 40_000.0)).replace('<c r="B', '<c s="1" r="B')
    found = triaxial(tmp_path, "q.xlsx", workbook(("s", cells), styles=styles), x_column="eps", y_column="q")
    assert found.y.tolist() == [10_000.0, 40_000.0]


def test_headings_once_more_are_passed_over_and_other_headings_refused(tmp_path: Path) -> None:
    page = "eps;q\n[%];[kPa]\n0,1;10\n1;40\n"
    found = triaxial(tmp_path, "q.csv", f"{page}{page.replace('0,1', '2')}Schluss;\n", x_column="eps", y_column="q")
    assert found.x.tolist() == [0.001, 0.01, 0.02, 0.01]
    other = page.replace("kPa", "MPa")
    message = refused(tmp_path, "q.csv", page + other, x_column="eps", y_column="q", incomplete_rows="leave_out")
    assert "line 6: '[%], [MPa]' are other headings or units than above" in message
    kept = page + "n/a;-\n10;60\n"
    found = triaxial(tmp_path, "q.csv", kept, x_column="eps", y_column="q", incomplete_rows="leave_out")
    assert found.y.tolist() == [10.0, 40.0, 60.0]


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_quotes_above_the_table_and_text_without_a_byte_order_mark(encoding: str, tmp_path: Path) -> None:
    text = '"Hoehe (mm)","20"\n"Probe\n20;71,4\n"eps\nnach Umbau\n[%]";q [kPa]\n0,1;10\n1;\u221240\n'
    found = triaxial(tmp_path, "q.csv", text.encode(encoding), x_column="eps nach Umbau", y_column="q")
    assert found.y.tolist() == [10.0, -40.0]


def test_loads_may_be_headings(tmp_path: Path) -> None:
    rows = sheet_rows(("q in kPa, by cell pressure",), ("eps [-]", 25.0, 50.0), (0.001, 5.0, 10.0), (0.01, 20.0, 40.0))
    keys = {"x_column": "eps", "y_column": "50", "y_unit": "kPa"}
    assert triaxial(tmp_path, "q.xlsx", workbook(("s", rows)), **keys).y.tolist() == [10.0, 40.0]
    text = "by cell pressure\neps [-];25;50\n0,001;5;10\n0,01;20;40\n"
    assert triaxial(tmp_path, "q.csv", text, **keys).y.tolist() == [10.0, 40.0]


def test_units_of_cells_are_asked_for_as_such(tmp_path: Path) -> None:
    text = "eps [-];\n0.001;10\n0.01;40\n0.1;50\n"
    message = refused(tmp_path, "q.csv", text, x_column="A2:A4", y_column="B2:B4")
    assert message.endswith("column 'B2:B4' (10, 40, 50, ...) has no unit; give y_unit: kPa, MPa or kg/cm2")


def test_elapsed_times_beyond_a_day(tmp_path: Path) -> None:
    cells = sheet_rows(("t", "s [mm]"))
    for line, (time, settlement) in enumerate(((0.25, 1.0), (1.0625, 2.0)), 2):
        cells += f'<row r="{line}"><c r="A{line}" s="3"><v>{time}</v></c><c r="B{line}"><v>{settlement}</v></c></row>'
    (tmp_path / "a.xlsx").write_bytes(workbook(("s", cells), styles=PERCENT))
    (tmp_path / "a.csv").write_text("t,s [mm]\n06:00:00,1\n25:30:00,2\n", encoding="utf-8")
    for name in ("a.xlsx", "a.csv"):
        table = read_table(tmp_path / name, Columns("t", "s"))
        assert (table.x, table.x_heading.unit) == ([0.25, 1.0625], "day")


def test_a_second_gauge_in_another_unit_is_refused(tmp_path: Path) -> None:
    text = "eps [-];q [kPa];u [MPa]\n0.001;5;1\n0.01;9;2\n"
    message = refused(tmp_path, "q.csv", text, x_column="eps", y_column="q", y_minus="u")
    assert "column 'q [kPa]' is in kPa and y_minus, 'u [MPa]', in MPa; give them one unit" in message


def test_an_empty_cell_among_elapsed_times_is_no_zero(tmp_path: Path) -> None:
    text = "t,s [mm]\n00:00:00,0\n,1\n25:30:00,2\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    with pytest.raises(TableError, match="line 3, column t"):
        read_table(tmp_path / "a.csv", Columns(x="t", y="s"))
    found = read_table(tmp_path / "a.csv", Columns(x="t", y="s", incomplete="leave_out"))
    assert found.x == [0.0, 25.5 / 24.0]


@pytest.mark.parametrize("unit", ["", "furlongs"])
def test_a_problem_sent_to_a_service_does_not_lose_that_a_unit_is_missing(unit: str, tmp_path: Path) -> None:
    (tmp_path / "q.csv").write_text(f"eps [-];q {unit and f'[{unit}]'}\n0.001;10\n0.01;40\n", encoding="utf-8")
    (tmp_path / "problem.yaml").write_text(problem_yaml(document("q.csv", x_column="eps", y_column="q")), "utf-8")
    sent = inlined_document(tmp_path / "problem.yaml")
    with pytest.raises(ProblemError, match=r"observations\[0\].y_unit: the file names no known unit; give y_unit: kPa"):
        parse_problem(sent)
    sent["forward_model"] = {"kind": "formula", "series": {"q": "M * x"}}
    sent["parameters"] = {"M": {"lower": 0.3, "upper": 2.0}}
    assert parse_problem(sent).observations[0].y.tolist() == [10.0, 40.0]
