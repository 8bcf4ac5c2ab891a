"""Constructions of a classical evaluation are drawn, and their numbers are those of the evaluation."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.parameter_estimates.classical import calculated_problem, classical_evaluation, classical_values
from geoswarm.solver.parameter_estimates.index import estimates_of
from geoswarm.solver.report.document.laboratory import calculated_values, laboratory_tables
from geoswarm.solver.report.document.laboratory_table import Beside, laboratory_table
from geoswarm.solver.report.figures.construction_plot import (
    chosen_constructions,
    construction_figure,
    construction_rows,
)
from geoswarm.solver.report.figures.style import png_of
from geoswarm.solver.report.terms import values_in_terms
from tests.solver.parameter_estimates import test_consolidation, test_index, test_shear


def test_one_construction_of_each_kind_is_drawn_that_of_the_largest_load() -> None:
    found = classical_evaluation(test_consolidation.problem("two_sides")).constructions
    assert [one.name for one in found] == ["root_time_1", "log_time_1", "root_time_2", "log_time_2"]
    chosen = chosen_constructions(found)
    assert [one.name for one in chosen] == ["root_time_2", "log_time_2"]
    figure = construction_figure("clay", chosen)
    assert [axes.get_title().partition(",")[0] for axes in figure.axes] == ["Root of time", "Logarithm of time"]
    assert all(axes.yaxis_inverted() for axes in figure.axes)
    assert png_of(figure).startswith(b"\x89PNG")
    header, rows = construction_rows(chosen)
    assert header == ["construction", "test", "kind", "label", "x", "x_unit", "y", "y_unit"]
    assert {row[2] for row in rows} == {"measured", "line", "point"}


def test_mohr_circles_are_round() -> None:
    one = test_shear.problem({"a": test_shear.part(100.0)}, {"a.q": test_shear.hyperbola(100.0)})
    (drawn,) = classical_evaluation(one).constructions
    figure = construction_figure("sand", [drawn])
    assert figure.axes[0].get_aspect() == 1.0
    assert png_of(figure).startswith(b"\x89PNG")
    _, rows = construction_rows([drawn])
    circle = [row for row in rows if row[2] == "circle"]
    assert [row[4] for row in circle] == pytest.approx([100.0, 100.0 + test_shear.strength(100.0)])


def test_the_calculated_curve_goes_through_the_same_ruler() -> None:
    """Mohr-Coulomb, linear below its strength: the ruler finds its own parameters on the calculated curve."""
    radii = {"a": 50.0, "b": 100.0, "c": 200.0}
    parts = {name: test_shear.part(radial) for name, radial in radii.items()}
    one = test_shear.problem(parts, {f"{name}.q": test_shear.hyperbola(radial) for name, radial in radii.items()})
    truth = {"E": 2.5e4, "nu": 0.3, "c": 12.0, "phi": 29.0}
    calculated = {(v.part, v.symbol): v.value for v in calculated_values(one, truth, None)}
    assert calculated["", "φ"] == pytest.approx(29.0, rel=1e-4)
    assert calculated["", "c"] == pytest.approx(12.0, rel=1e-3)
    assert calculated["a", "E₅₀"] == pytest.approx(2.5e4, rel=0.01)
    tables = laboratory_tables(one, truth, None, None, "")
    rows = {row[0]: row for row in tables[0].rows}
    columns = tables[0].columns
    at = columns.index("from the calculated curve")
    assert rows["φ"][2] == "29"
    assert rows["φ"][at - 1].startswith("32 (Mohr circles, 3 specimens)")  # of the readings
    assert rows["φ"][at] == "29"
    assert len([row for row in tables[0].rows if row[0] == "φ"]) == 1  # one soil, however many specimens
    assert tables[0].classical


def test_readings_in_place_of_calculated_values_give_the_same() -> None:
    one = test_consolidation.problem("two_sides")
    same = calculated_problem(one, {o.series: np.array(o.y) for o in one.observations})
    assert classical_values(same) == classical_values(one)


def test_index_properties_stand_beside_identified_values_in_the_same_terms() -> None:
    """I_P = 40 %, G_s = 2.7: Cc = 0.54 by the critical state, 0.46 by lambda* = I_P/500 with e_0 = 1.5."""
    one = test_index.problem("soft_soil_creep", test_index.SOFT, test_index.PROPERTIES, initial_void_ratio=1.5)
    index = estimates_of(one)
    values = one.values([0.08, 0.02, 25.0])
    found = values_in_terms(one, values, None, {estimate.quantity for estimate in index})
    table = laboratory_table(found, "", Beside(index=index))
    rows = {row[0]: row for row in table.rows}
    at = table.columns.index("by index properties")
    assert rows["Cc"][at] == "0.46 … 0.54"
    assert rows["φ"][2] == "25"
    assert rows["φ"][at] == "27"
    assert "from the readings" not in table.columns


def test_what_does_not_hold_is_told_below_the_table() -> None:
    one = test_index.problem("soft_soil_creep", test_index.SOFT, {}, initial_void_ratio=1.5)
    table = laboratory_table(values_in_terms(one, one.values([0.08, 0.02, 25.0]), None), " (it does not hold)")
    assert table.note.endswith(" * (it does not hold).")
