"""One set of parameters has one set of residuals: in sentence, tables, figure and JSON, whatever weighs the series."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geoswarm as gs
from geoswarm.solver.identifiability import Samples, reweight
from geoswarm.solver.identifiability.weighting import BY_SPREAD
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.problem.weighting import WEIGHTINGS
from geoswarm.solver.runs.local import calibrate
from tests.variants import variants

V, U = np.linspace(0.1, 3.0, 30), np.linspace(0.1, 3.0, 8)
NOISE = np.random.default_rng(45)
Q = 50.0 * V + 12.0 * V**2 + 2.0 * NOISE.standard_normal(30)
P = 0.2 + 0.9 * U + 0.01 * NOISE.standard_normal(8)


def bent_readings(**more: Any) -> dict[str, Any]:
    """A line through readings of a parabola, beside a second series that shares its slope."""
    return {
        "name": "bent",
        "forward_model": {
            "kind": "formula",
            "series": {
                "q": {"expression": "a * x", "x_unit": "%", "y_unit": "kPa"},
                "p": {"expression": "b + a * x / 100", "x_unit": "%"},
            },
        },
        "parameters": {"a": {"lower": 0, "upper": 200}, "b": {"lower": -5, "upper": 5}},
        "observations": [
            {"series": "q", "points": {"x": V.tolist(), "y": Q.tolist()}, "error": 2.0},
            {"series": "p", "points": {"x": U.tolist(), "y": P.tolist()}, "error": 0.01},
        ],
        "stopping": {"max_evaluations": 100},
        "seed": 1,
    } | more


@pytest.mark.parametrize("weighting", variants([None, *WEIGHTINGS, BY_SPREAD], {None, BY_SPREAD}))
@pytest.mark.usefixtures("blank_figures")
def test_every_output_has_the_residuals_of_the_result(weighting: str | None, tmp_path: Path) -> None:
    scheme = {} if weighting in (None, BY_SPREAD) else {"weighting": weighting}
    problem = parse_problem(bent_readings(**scheme))
    if weighting == BY_SPREAD:
        problem = reweight(problem, Samples.from_result(problem, calibrate(problem)), weighting=BY_SPREAD).problem
    result = gs.calibrate(problem)
    a, b = result.parameters["a"], result.parameters["b"]
    residuals = {"q": a * V - Q, "p": b + a * U / 100.0 - P}
    statistics = result.statistics()
    result.report(tmp_path)

    with (tmp_path / "fit.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["residual"]]
    stored = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    shown = re.findall(r'data-label="root mean square" class="n">([\d.e-]+)', page)
    for place, o in enumerate(problem.observations):
        found = residuals[o.series]
        size = np.sqrt(np.sum(o.point_weights * found**2) / np.sum(o.point_weights))
        worst = int(np.argmax(np.abs(found)))
        in_figure = [float(row["residual"]) for row in rows if row["series"] == o.series]
        np.testing.assert_allclose(in_figure, found, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(statistics.residuals[place].residuals, found, rtol=1e-9, atol=1e-12)
        assert stored["best"]["misfits"][o.series] == pytest.approx(size**2, rel=1e-9)
        assert float(shown[place]) == pytest.approx(size, rel=5e-3)
        misfits = {one.reason: one for one in statistics.fit.misfits if one.series == o.series}
        pattern, exceeded = misfits["pattern"], misfits["stated_error"]
        assert (pattern.deviation, pattern.largest) == pytest.approx((size, found[worst]), rel=1e-9)
        assert pattern.x == (V, U)[place][worst]
        side = "above" if found[worst] > 0 else "below"
        far = f"{abs(found[worst]):.2g}{' kPa' * (1 - place)} (calculated {side} measured, near {pattern.x:.4g} %)"
        assert f"{o.series} by up to {far}, root mean square {size:.2g}" in statistics.fit.sentence
        # of the errors that the residuals of a right model leave: two parameters take up to two readings
        assert exceeded.ratio is not None
        assert exceeded.deviation == pattern.deviation
        few = np.sqrt(1.0 - 2.0 / len(found))
        assert size / (2.0, 0.01)[place] <= exceeded.ratio <= size / (2.0, 0.01)[place] / few * 1.02
