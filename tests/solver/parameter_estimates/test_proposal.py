"""Proposed parameters enclose what the readings were made from; a problem may lack them altogether."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.parameter_estimates.proposal import candidates_of, proposed, with_parameters
from geoswarm.solver.problem import load_problem, parse_problem
from tests.solver.ags.synthetic import CC, CS, E0, START, STRESSES, void_ratio

EXAMPLES = Path(__file__).parents[3] / "examples"
NUMBERS = [float(n) for n in range(1, len(STRESSES) + 1)]
OEDOMETER = {
    "forward_model": {
        "kind": "oedometer",
        "material": "soft_soil",
        "height": 0.02,
        "initial_stress": START,
        "initial_void_ratio": E0,
        "stages": [{"stress": stress, "duration": 1.0} for stress in STRESSES],
    },
    "observations": [{"series": "stage_void_ratio", "points": {"x": NUMBERS, "y": void_ratio(STRESSES)}}],
}


def test_a_problem_without_parameters_gets_those_that_its_law_needs() -> None:
    document = with_parameters(OEDOMETER)
    assert list(document["parameters"]) == ["lambda_star", "kappa_star", "c", "phi"]
    assert document["parameters"]["lambda_star"] == {"lower": 0.01, "upper": 0.3, "scale": "log"}
    assert parse_problem(document).free_names == ("lambda_star", "kappa_star", "c", "phi")
    own = {**OEDOMETER, "parameters": {"c": {"value": 1}}}
    assert with_parameters(own)["parameters"] == own["parameters"]  # what is wrong with them is told as ever


def test_readings_become_bounds_and_estimates_by_the_terms_of_the_law() -> None:
    """Cc = 2.303 lambda* (1 + e_0), Cs = 2.303 kappa* (1 + e_0) (1 + nu)/(3 (1 - nu)), sigma_p = sigma_0 + POP."""
    found = {one.name: one for one in proposed(parse_problem(with_parameters(OEDOMETER)))}
    truth = CC / (math.log(10.0) * (1.0 + E0))
    section = found["lambda_star"].section
    assert section["initial"] == pytest.approx(truth, rel=5e-3)
    assert section["lower"] == pytest.approx(truth / 2.0, rel=0.05)
    assert section["upper"] == pytest.approx(truth * 2.0, rel=0.05)
    assert found["kappa_star"].section["initial"] == pytest.approx(
        CS / (math.log(10.0) * (1.0 + E0)) / 0.4509804, rel=5e-3
    )
    assert found["POP"].section["lower"] == 0.0
    assert found["POP"].section["upper"] > 80.0 - START
    assert not found["c"].candidates
    assert found["c"].section == {"lower": 0.0, "upper": 50.0}


@pytest.mark.parametrize(
    ("example", "truth"),
    [
        ("triaxial", {"E": 1.8e4, "c": 8.0, "phi": 31.0, "psi": 4.0}),  # what its readings were made with, see its data
        ("consolidation", {"kappa_star": 0.015, "k": 4.0e-5}),
        ("crs_oedometer", {"lambda_star": 0.11, "POP": 50.0, "k": 3.0e-5, "C_k": 0.7}),
    ],
)
def test_proposed_bounds_enclose_what_readings_were_made_with(example: str, truth: dict[str, float]) -> None:
    found = {one.name: one.section for one in proposed(load_problem(EXAMPLES / example / "problem.yaml"))}
    for name, value in truth.items():
        assert found[name]["lower"] <= value <= found[name]["upper"], name


def test_a_formula_keeps_its_own_bounds() -> None:
    for one in proposed(load_problem(EXAMPLES / "formula" / "problem.yaml")):
        assert one.as_given
        assert not one.candidates


def test_the_normal_compression_line_of_cam_clay_is_read_from_the_largest_load() -> None:
    stages = [{"stress": stress, "duration": 1.0} for stress in (50.0, 100.0, 200.0, 400.0, 800.0, 100.0)]
    truth = {"lambda": 0.2, "kappa": 0.04, "M": 1.0, "nu": 0.3, "N": 3.2}
    document = {
        "forward_model": {
            "kind": "oedometer",
            "material": "modified_cam_clay",
            "height": 0.02,
            "initial_stress": 25.0,
            "stages": stages,
            "POP": 50.0,
        },
        "parameters": {name: {"value": value} for name, value in truth.items()} | {"N": {"lower": 2.0, "upper": 5.0}},
        "observations": [{"series": "stage_void_ratio", "points": {"x": [1.0], "y": [1.0]}}],
        "stopping": {"max_evaluations": 10},
    }
    problem = parse_problem(document)
    x = np.arange(1.0, 7.0)
    y = problem.model.prepare({"stage_void_ratio": x})(truth)["stage_void_ratio"]
    readings = [{"series": "stage_void_ratio", "points": {"x": x.tolist(), "y": y.tolist()}}]
    (found,) = candidates_of(parse_problem(document | {"observations": readings}))["N"]
    assert found.value == pytest.approx(truth["N"], rel=5e-3)
    free = {name: {"lower": truth[name] / 4.0, "upper": truth[name] * 4.0} for name in ("lambda", "kappa")}
    parameters = document["parameters"] | free  # type: ignore[operator]
    read = candidates_of(parse_problem(document | {"observations": readings, "parameters": parameters}))
    assert [read[name][0].value for name in ("lambda", "N")] == pytest.approx([0.2, 3.2], rel=0.02)
