"""Several tests in one diagram, and another set of parameters beside the result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.compared import compared_with, read_set
from geoswarm.solver.report.document.series_table import comparison_table, series_table
from geoswarm.solver.report.figures.figure_set import FigureSet
from geoswarm.solver.report.record import RunRecord
from geoswarm.solver.words import number

CLAY = {"lambda": 0.2, "kappa": 0.04, "nu": 0.3, "e0": 1.2}
STRAINS = [1, 3, 6, 10]


def clay(pressures: list[int]) -> Problem:
    """Drained tests of Cam clay at several pressures, the last one read in MPa, and its compression."""
    parts: dict[str, Any] = {
        f"p{pressure}": {
            "kind": "triaxial",
            "material": "modified_cam_clay",
            "initial_stress": pressure,
            "shearing": [{"kind": "monotonic", "axial_strain": 0.12}],
        }
        for pressure in pressures
    }
    observations: list[dict[str, Any]] = [
        {
            "series": f"{name}.q",
            "points": {"x": STRAINS, "y": [0.3, 0.6, 0.8, 0.9] if name == f"p{pressures[-1]}" else [30, 60, 80, 90]},
            "x_unit": "%",
            "y_unit": "MPa" if name == f"p{pressures[-1]}" else "kPa",
        }
        for name in parts
    ]
    return parse_problem(
        {
            "name": "clay",
            "forward_model": {"kind": "combined", "parts": parts},
            "parameters": {name: {"value": value} for name, value in CLAY.items()}
            | {"M": {"lower": 0.5, "upper": 1.5}, "OCR": {"expression": "0.8 + 0.2 * M"}},
            "observations": observations,
            "weighting": "by_test",
            "stopping": {"max_evaluations": 10},
        }
    )


def figures(problem: Problem, given: dict[str, Any] | None = None) -> FigureSet:
    best = compared_with(problem, "best", {"M": 1.0}).fit
    record = RunRecord(None, "finished", (), None, 1, 0, 1, {}, 1.0, 1, best, ())
    other = None if given is None else compared_with(problem, "book", given)
    return FigureSet(problem, record, None, None, compared=other)


def numbers(found: FigureSet, diagram: str, test: str, kind: str) -> tuple[np.ndarray, np.ndarray]:
    header, rows = found.rows("tests")
    assert header == ["diagram", "test", "kind", "x", "x_unit", "y", "y_unit"]
    x, y = zip(*((row[3], row[5]) for row in rows if row[:3] == [diagram, test, kind]), strict=True)
    return np.array(x), np.array(y)


def test_diagrams_of_several_tests_have_a_colour_a_test_and_one_unit() -> None:
    found = figures(clay([100, 200]), {"M": 1.2, "OCR": 1.0})
    drawn = found.draw("tests")
    assert [axes.get_ylabel() for axes in drawn.axes] == ["q [kPa]", "q [kPa]"]
    assert [axes.get_xlabel() for axes in drawn.axes] == ["axial strain [%]", "p' [kPa]"]
    assert [text.get_text() for text in drawn.legends[0].get_texts()] == [
        *("p100", "p200", "measured", "calculated", "book"),
    ]
    colours = {line.get_color() for line in drawn.axes[0].lines}
    assert len(colours) == 2
    assert numbers(found, "q", "p200", "measured")[1] == pytest.approx([300, 600, 800, 900])  # kPa, read in MPa
    q, other = (numbers(found, "q", "p200", kind)[1][-1] for kind in ("calculated", "compared"))
    p, path = numbers(found, "stress_path", "p100", "compared")
    assert p == pytest.approx(100 + path / 3, rel=1e-5)
    assert other > 1.1 * q  # M is a fifth larger


def test_figures_of_single_tests_are_left_out_of_a_report_where_many_are_in_one() -> None:
    few, many = figures(clay([100, 200])), figures(clay([50, 100, 200, 400]))
    assert "stress_path.p100" in few.shown
    assert few.shown == few.names
    assert "stress_path.p100" not in many.shown
    assert "stress_path.p100" in many.names
    assert "tests" in many.shown


def test_a_single_test_has_no_figure_of_several() -> None:
    assert "tests" not in figures(clay([100])).names


def test_the_table_has_the_largest_residual_and_the_other_set() -> None:
    problem = clay([100, 200])
    best, other = (compared_with(problem, "book", {"M": m, "OCR": 1.0}) for m in (1.0, 1.2))
    table = series_table(problem, best.fit)
    assert table.columns[-2:] == ("root mean square", "largest")
    residuals = best.fit.responses["p200.q"] - problem.observations[1].y
    shown = float(table.rows[1][6].removesuffix(" MPa").replace("−", "-"))
    assert shown == pytest.approx(residuals[np.argmax(np.abs(residuals))] / 1000, rel=0.01)
    beside = comparison_table(problem, best.fit, other)
    assert beside.columns[-3:] == ("book: share", "book: root mean square", "book: largest")
    assert beside.rows[1][3] == table.rows[1][6] != beside.rows[1][6]
    assert f"{number(other.fit.objective)} kPa² of book (lambda 0.2, kappa 0.04, " in beside.note


def test_linked_parameters_are_as_the_set_says_or_follow() -> None:
    problem = clay([100, 200])
    assert compared_with(problem, "a", {"M": 1.0}).fit.parameters["OCR"] == 1.0
    assert compared_with(problem, "a", {"M": {"value": 1.0}, "OCR": 1.5}).fit.parameters["OCR"] == 1.5


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"m": 1.0, "M": 1.0}, "m: the problem has no such parameter; did you mean nu?; it has lambda, kappa"),
        ({"lambda": 0.1}, "the set must give every free parameter; M is missing"),
        ({"M": "large"}, "M: must be a number, got text 'large'"),
        ({"M": 1.0, "kappa": 0.3}, "the calculation with this set failed: "),
    ],
)
def test_a_set_with_mistakes_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        compared_with(clay([100, 200]), "book", given)
    assert message.replace("; did you mean nu?", "") in str(caught.value).replace("; did you mean M?", "")


def test_sets_are_read_from_yaml(tmp_path: Path) -> None:
    (tmp_path / "book.yaml").write_text("M: 1.2\nOCR: 1.0\n", encoding="utf-8")
    assert read_set(tmp_path / "book.yaml") == ("book", {"M": 1.2, "OCR": 1.0})
    (tmp_path / "book.yaml").write_text("name: Roscoe\nparameters: {M: 1.2}\n", encoding="utf-8")
    assert read_set(tmp_path / "book.yaml") == ("Roscoe", {"M": 1.2})
