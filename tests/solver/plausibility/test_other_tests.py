"""Readings of tests other than the oedometer that no soil can have, or hardly: consolidation, triaxial, shear."""

from __future__ import annotations

from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.plausibility import impossible
from geoswarm.solver.plausibility.readings import doubtful_readings
from geoswarm.solver.problem import Problem, parse_problem

CONSOLIDATION = {
    "kind": "consolidation",
    "material": "soft_soil",
    "height": 0.02,
    "initial_stress": 50.0,
    "initial_void_ratio": 1.4,
    "stages": [{"stress": 100.0, "duration": 1.0}],
}
FLOW = {"kappa_star": 0.01, "k": 1e-5, "C_k": 1.0, "c": 1.0, "phi": 25.0}


@pytest.mark.parametrize(
    ("settlements", "said"),
    [
        ([0.1, 0.3, 0.44], ""),
        ([-0.1, -0.3, -0.44], "the readings are negative (down to -0.44 mm) while the stress rises to 100 kPa"),
        ([100.0, 300.0, 440.0], "the largest reading, 440 mm, is more than the height of the specimen, 0.02 m"),
        ([1e-6, 3e-6, 4.4e-6], ""),  # the pore water has hardly begun to flow
    ],
)
def test_a_test_with_consolidation(settlements: list[float], said: str) -> None:
    problem = {
        "forward_model": CONSOLIDATION,
        "parameters": {
            "lambda_star": {"lower": 0.02, "upper": 0.4},
            **{name: {"value": value} for name, value in FLOW.items()},
        },
        "observations": [
            {"series": "settlement", "x_unit": "min", "y_unit": "mm"}
            | {"points": {"x": [1.0, 60.0, 1400.0], "y": settlements}}
        ],
        "stopping": {"max_evaluations": 10},
    }
    found = [doubt.message for doubt in doubtful_readings(parse_problem(problem))]
    assert said in "".join(found)
    assert bool(found) == bool(said)


def sheared(kind: str, **observation: Any) -> Problem:
    """A test on modified Cam clay consolidated under 100 kPa."""
    triaxial = kind == "triaxial"
    end = {"axial_strain": 0.1} if triaxial else {"shear_strain": 0.2}
    document = {
        "forward_model": {
            "kind": kind,
            "material": "modified_cam_clay",
            "initial_stress": 20,
            "consolidation": [{"axial": 100} if triaxial else {"normal_stress": 100}],
            "shearing": [{"kind": "monotonic", **end}],
        },
        "parameters": {
            "lambda": {"lower": 0.05, "upper": 0.3},
            "kappa": {"value": 0.02},
            "M": {"value": 1.1},
            "nu": {"value": 0.3},
            "e0": {"value": 1.0},
        },
        "observations": [observation],
        "stopping": {"max_evaluations": 10},
    }
    return parse_problem(document)


X = [0.01, 0.05, 0.1]


def test_a_test_without_consolidation() -> None:
    problem = sheared("triaxial", series="q", points={"x": X, "y": [30, 60, 80]}).document()
    problem["forward_model"]["consolidation"] = []
    assert impossible(parse_problem(problem)) == []


@pytest.mark.parametrize(
    ("kind", "observation", "said"),
    [
        ("triaxial", {"series": "q", "points": {"x": X, "y": [30, 60, 80]}}, None),
        ("triaxial", {"series": "q", "points": {"x": X, "y": [0.03, 0.06, 0.08]}}, "in MPa it would be 80 kPa: y_unit"),
        ("triaxial", {"series": "q", "y_unit": "MPa", "points": {"x": X, "y": [30, 60, 800]}}, "in kPa it would be"),
        ("triaxial", {"series": "q", "y_unit": "kPa", "points": {"x": X, "y": [3e4, 6e4, 2e5]}}, "in Pa it would be"),
        ("triaxial", {"series": "volumetric_strain", "points": {"x": X, "y": [0.5, 1, 2.4]}}, "in % it would be 0.024"),
        ("triaxial", {"series": "volumetric_strain", "y_unit": "%", "points": {"x": X, "y": [0.5, 1, 2.4]}}, None),
        (
            "direct_simple_shear",
            {"series": "shear_stress", "points": {"x": X, "y": [0.003, 0.02, 0.03]}},
            "the largest value of τ, 0.03 kPa, is 0.0003 times the largest stress that is applied, 100 kPa; in MPa it",
        ),
        ("direct_simple_shear", {"series": "pore_pressure", "points": {"x": X, "y": [0.0, 0.0, 0.01]}}, None),
    ],
)
def test_stresses_and_strains_of_shear_tests(kind: str, observation: dict[str, Any], said: str | None) -> None:
    found = impossible(sheared(kind, **observation))
    if said is None:
        assert found == []
    else:
        assert said in found[0].message
        assert found[0].path == "observations[0].y_unit"


@pytest.mark.parametrize(
    ("x", "y", "said"),
    [
        (
            X,
            [0.3, 0.6, 0.8],
            "kPa, is 0.008 times the largest stress that is applied, 100 kPa; in bar it would be 80 kPa",
        ),
        (X, [2942, 5884, 7845], "is 78 times the largest stress that is applied, 100 kPa; in Pa it would be 7.8 kPa"),
        ([1e-4, 5e-4, 1e-3], [0.3, 0.6, 0.8], ""),  # small strains, of a test that was stopped or in per cent
        ([1e-4, 5e-4, 1e-3], [30, 60, 80], "axial strain ends at 0.1 %, 0.01 of that of the test, 0.1; in 1 it fits"),
    ],
)
def test_slips_that_a_soil_could_have_are_named(x: list[float], y: list[float], said: str) -> None:
    """kg/cm² taken for kPa, and the other way round; per cent for fractions."""
    unit = {"x_unit": "%"} if x is not X else {}
    points = {"x": [value * 100 for value in x] if x is not X else x, "y": y}
    problem = sheared("triaxial", series="q", points=points, **unit)
    found = "".join(doubt.message for doubt in doubtful_readings(problem))
    assert said in found
    assert impossible(problem) == []


@pytest.mark.parametrize(("x", "said"), [([0.0, 0.01, 0.05], "where it would be no stress over no strain"), (X, "")])
def test_a_secant_modulus_at_strain_0_is_refused(x: list[float], said: str) -> None:
    problem = sheared("triaxial", series="secant_modulus", points={"x": x, "y": [9000, 8000, 4000]})
    assert said in "".join(issue.message for issue in impossible(problem))
    assert bool(impossible(problem)) == bool(said)


@pytest.mark.parametrize(
    ("strains", "anew"),
    [
        ([0.5, 1, 2, 5, 0.5, 1, 2, 5], "axial strain restarts at point 5, 0.5 % after 5, as where two tests stand"),
        ([0, 1, 2, 5, 4, 3, 5.5, 8], ""),  # a loop
        ([0, 1, 2, 5, 0], ""),  # the last reading after the test
        ([0, 0.01, 0, 0.02, 0, 1, 2], ""),  # noise at its beginning
    ],
)
def test_two_tests_in_one_table(strains: list[float], anew: str) -> None:
    points = {"x": strains, "y": [30.0 + 5.0 * strain for strain in strains]}
    found = [issue.message for issue in impossible(sheared("triaxial", series="q", x_unit="%", points=points))]
    assert anew in "".join(found)
    assert len(found) == bool(anew)


@pytest.mark.parametrize(
    ("given", "x", "said"),
    [
        ("day", [60.0, 3600.0, 84000.0], "in s they would fit: x_unit: s"),
        ("h", [1.0, 60.0, 1400.0], "in min they would fit: x_unit: min"),
        ("year", [2019.5, 2020.25, 2021.0], "these may be calendar years: give dates (2019-07-02)"),
        ("day", [1.0, 2.0, 5e8], ""),
    ],
)
def test_times_outside_a_test_that_fit_in_another_unit(given: str, x: list[float], said: str) -> None:
    problem = {
        "forward_model": CONSOLIDATION,
        "parameters": {"lambda_star": {"lower": 0.02, "upper": 0.4}} | {k: {"value": v} for k, v in FLOW.items()},
        "observations": [
            {"series": "settlement", "x_unit": given, "y_unit": "mm", "points": {"x": x, "y": [0.1, 0.3, 0.4]}}
        ],
        "stopping": {"max_evaluations": 10},
    }
    with pytest.raises(ProblemError) as caught:
        parse_problem(problem)
    (message,) = [issue.message for issue in caught.value.issues]
    assert said in message
    assert ("they would fit" in message) == ("they would fit" in said)
