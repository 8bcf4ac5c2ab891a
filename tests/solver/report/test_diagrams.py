"""Stress paths and compression curves: against closed forms and the series themselves; where readings allow none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.forward.registry import find_spec
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.compression import compression_curves
from geoswarm.solver.report.diagrams import DiagramCurve, diagram_curves
from geoswarm.solver.report.document.readings import not_modelled
from geoswarm.solver.report.figures.compression_plot import compression_figure
from geoswarm.solver.report.figures.diagram_plot import diagram_figure, diagram_rows

CLAY = {"lambda": 0.2, "kappa": 0.04, "M": 1.0, "nu": 0.3, "e0": 1.2}
STRAINS = [0.01, 0.03, 0.06, 0.1]


def problem_of(model: dict[str, Any], series: dict[str, list[float]], x: list[float], **more: float) -> Problem:
    """Readings of a specimen of Cam clay with known parameters."""
    return parse_problem(
        {
            "name": "clay",
            "forward_model": model,
            "parameters": {name: {"value": value} for name, value in (CLAY | more).items()}
            | {"M": {"lower": 0.5, "upper": 1.5}},
            "observations": [{"series": name, "points": {"x": x, "y": y}} for name, y in series.items()],
            "stopping": {"max_evaluations": 10},
        }
    )


def triaxial(drainage: str, **more: Any) -> dict[str, Any]:
    return {
        "kind": "triaxial",
        "material": "modified_cam_clay",
        "initial_stress": 20,
        "consolidation": [{"axial": 200}],
        "drainage": drainage,
        "shearing": [{"kind": "monotonic", "axial_strain": 0.12}],
        **more,
    }


def the_one(problem: Problem) -> DiagramCurve:
    (curve,) = diagram_curves(problem, problem.values([1.0]))
    return curve


def test_a_drained_path_climbs_three_to_one() -> None:
    curve = the_one(problem_of(triaxial("drained"), {"q": [60, 120, 150, 180]}, STRAINS))
    assert curve.derived
    assert curve.measured_x == pytest.approx(200 + np.array([60, 120, 150, 180]) / 3)  # dp' = dq/3 at constant radius
    assert curve.x == pytest.approx(200 + curve.y / 3, rel=1e-5)


def test_an_undrained_path_is_left_by_the_excess_pore_pressure() -> None:
    readings = {"q": [40.0, 80.0, 100.0, 110.0], "pore_pressure": [310.0, 350.0, 380.0, 400.0]}
    curve = the_one(problem_of(triaxial("undrained", back_pressure=300), readings, STRAINS))
    assert curve.measured_x == pytest.approx(
        [200 + 40 / 3 - 10, 200 + 80 / 3 - 50, 200 + 100 / 3 - 80, 200 + 110 / 3 - 100]
    )
    assert curve.measured_y == pytest.approx(readings["q"])
    assert curve.y[-1] == pytest.approx(curve.x[-1], rel=0.05)  # near the critical state q = M p', M = 1


def test_what_was_read_itself_goes_before_what_follows() -> None:
    curve = the_one(problem_of(triaxial("drained"), {"q": [60, 120, 150, 180], "p": [1, 2, 3, 4]}, STRAINS))
    assert not curve.derived
    assert curve.measured_x.tolist() == [1, 2, 3, 4]


@pytest.mark.parametrize(
    ("model", "series"),
    [
        (triaxial("undrained"), {"q": [1.0] * 4}),  # no pore pressure
        (triaxial("drained"), {"volumetric_strain": [0.01] * 4}),
        (
            triaxial("drained", shearing=[{"kind": "monotonic", "axial_strain": 0.2, "constant": "mean_stress"}]),
            {"q": [1.0] * 4},
        ),
    ],
)
def test_readings_that_tell_no_path_are_not_drawn(model: dict[str, Any], series: dict[str, list[float]]) -> None:
    problem = problem_of(model, series, STRAINS)
    assert diagram_curves(problem, problem.values([1.0])) == ()


def test_series_read_at_different_strains_meet_between_them() -> None:
    problem = problem_of(triaxial("drained"), {"q": [0.0, 100.0, 200.0, 300.0]}, STRAINS)
    document = problem.document()
    document["observations"].append({"series": "p", "points": {"x": [0.02, 0.08], "y": [150, 210]}})
    curve = the_one(parse_problem(document))
    assert curve.measured_x.tolist() == [150, 210]  # p is read at 2 and 8 %
    assert curve.measured_y == pytest.approx([50, 250])  # half way between 1 and 3 %; 2/4 between 6 and 10 %


def test_simple_shear_at_constant_volume_gives_the_normal_stress_by_the_pore_pressure() -> None:
    model = find_spec("direct_simple_shear").example()
    readings = {"shear_stress": [10.0, 20.0, 25.0, 28.0], "pore_pressure": [5.0, 20.0, 30.0, 40.0]}
    curve = the_one(problem_of(model, readings, STRAINS))
    assert curve.measured_x == pytest.approx([95, 80, 70, 60])  # consolidated under 100 kPa


SMALL = [1e-5, 1e-4, 1e-3, 1e-2]


@pytest.mark.parametrize("drained", [False, True])
def test_small_strains_have_the_shear_modulus_over_their_logarithm(drained: bool) -> None:
    """G = q/(2 (axial - radial)): by the axial strain undrained, with the volumetric one drained."""
    readings = {"q": [2.0, 15.0, 60.0, 120.0]}
    if drained:
        readings["volumetric_strain"] = [1e-5 / 3, 1e-4 / 3, 1e-3 / 3, 1e-2 / 3]  # radial: a third of axial, outwards
    model = triaxial("drained" if drained else "undrained")
    curves = diagram_curves(problem := problem_of(model, readings, SMALL), problem.values([1.0]))
    curve = next(one for one in curves if one.diagram.name == "shear_modulus")
    assert curve.derived
    shear = np.array(SMALL) * (4 / 3 if drained else 1.5)
    assert curve.measured_x == pytest.approx(shear)
    assert curve.measured_y == pytest.approx(np.array(readings["q"]) / (2 * shear))
    assert curve.x.min() < 2e-5
    # Elastic at first: normally consolidated Cam clay yields at once, so below G = 3 K (1 - 2 nu)/(2 (1 + nu)).
    elastic = 1.5 * 0.4 / 1.3 * 2.2 * 200 / 0.04
    assert 0.2 * elastic < curve.y[0] < 1.01 * elastic
    axes = diagram_figure("clay", curve).axes[0]
    assert axes.get_xscale() == "log"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("shear strain [-]", "secant shear modulus [kPa]")


def test_simple_shear_at_small_strains_has_it_too_and_no_logarithm_of_nothing() -> None:
    model = find_spec("direct_simple_shear").example()
    problem = problem_of(model, {"shear_stress": [0.0, 1.0, 5.0, 20.0]}, [0.0, 1e-4, 1e-3, 1e-2])
    curve = next(one for one in diagram_curves(problem, problem.values([1.0])) if one.diagram.name == "shear_modulus")
    assert curve.measured_x == pytest.approx([1e-4, 1e-3, 1e-2])
    assert curve.measured_y == pytest.approx([1e4, 5e3, 2e3])


def test_the_shear_modulus_of_a_specimen_under_unequal_stresses_needs_to_be_read() -> None:
    """Where shearing begins q is not 0, and a reading of q alone does not tell its change."""
    uneven = triaxial("undrained", consolidation=[{"axial": 200, "radial": "K0"}])
    problem = problem_of(uneven, {"q": [80.0] * 4}, SMALL)
    assert diagram_curves(problem, problem.values([1.0])) == ()
    problem = problem_of(uneven, {"shear_modulus": [9e3, 8e3, 4e3, 1e3]}, SMALL)
    (curve,) = diagram_curves(problem, problem.values([1.0]))
    assert curve.measured_y.tolist() == [9e3, 8e3, 4e3, 1e3]


def test_the_compression_curve_at_constant_rate() -> None:
    model = find_spec("crs_oedometer").example()
    readings = {"axial_stress": [30.0, 60.0, 90.0, 120.0], "pore_pressure": [3.0, 6.0, 9.0, 12.0]}
    curve = the_one(problem_of(model, readings, STRAINS, k=1e-4))
    assert curve.measured_x == pytest.approx([28, 56, 84, 112])
    assert curve.measured_y == pytest.approx([1.2 - 2.2 * strain for strain in STRAINS])
    axes = diagram_figure("clay", curve).axes[0]
    assert axes.get_xscale() == "log"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("effective stress [kPa]", "void ratio [-]")
    header, rows = diagram_rows(curve)
    assert len(header) == 5
    assert [row[0] for row in rows].count("measured") == 4
    assert np.isfinite([row[1] for row in rows]).all()


def test_a_test_with_consolidation_has_a_compression_curve_and_no_warning() -> None:
    model = find_spec("consolidation").example()
    problem = problem_of(model, {"stage_settlement": [0.001, 0.002, 0.0018]}, [1, 2, 3], k=1e-3)
    (curve,) = compression_curves(problem, problem.values([1.0]), None)
    assert curve.preconsolidation is None
    assert curve.measured_stress.tolist() == [50, 100, 25]
    assert curve.measured == pytest.approx([1.2 - 2.2 * s / 0.02 for s in (0.001, 0.002, 0.0018)])
    assert "less back pressure" in compression_figure("clay", curve).axes[0].get_xlabel()
    timed = problem_of(model, {"settlement": [0.001, 0.002, 0.0018]}, [0.5, 1, 2], k=1e-3)
    assert not_modelled(timed) == ()
