"""Examples that need no other program are run, through the command line and from Python, and find their true values."""

from __future__ import annotations

import json

import pytest

from examples.generate_reference_data import EXAMPLES, HERE
from geoswarm.cli import main
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.examples import example_names
from geoswarm.solver.problem import load_problem
from geoswarm.solver.runs.local import calibrate
from tests.variants import variants

BANDS = {  # around the true values, for the seed in the problem file; the oedometer stops at the published target
    "oedometer": {"lambda_star": (0.072, 0.097), "kappa_star": (0.040, 0.067), "c": (19.0, 35.0)},
    "isotropic_compression": {"lambda_star": (0.0885, 0.0895), "mu_star": (2.25e-3, 2.65e-3)},
    "formula": {"s_end": (0.61, 0.63), "t_half": (135.0, 145.0)},
    "combined": {
        "lambda_star": (0.0840, 0.0860),
        "kappa_star": (0.0470, 0.0490),
        "c": (25.0, 27.0),
        "isotropic.mu_star": (1.9e-3, 2.7e-3),
    },
    "triaxial": {"E": (1.75e4, 1.85e4), "nu": (0.26, 0.30), "c": (7.0, 9.0), "phi": (30.7, 31.3), "psi": (3.8, 4.2)},
    "direct_simple_shear": {"M": (1.04, 1.06), "lambda": (0.158, 0.162), "kappa": (0.029, 0.031), "nu": (0.23, 0.27)},
    "consolidation": {
        "lambda_star": (0.0890, 0.0910),
        "kappa_star": (0.0145, 0.0155),
        "k": (3.9e-5, 4.1e-5),
        "C_k": (0.56, 0.64),
    },
    "crs_oedometer": {
        "lambda_star": (0.107, 0.114),
        "kappa_star": (0.0172, 0.0188),
        "POP": (47.0, 53.0),
        "k": (2.85e-5, 3.15e-5),
        "C_k": (0.65, 0.75),
    },
    "column": {"clay.lambda_star": (0.115, 0.125), "clay.k": (5.5e-5, 6.5e-5), "clay.POP": (13.0, 17.0)},
}
OBJECTIVES = {  # two-sided: below the noise would be as wrong as far above it
    "oedometer": (2.0e-9, 5.0e-9),
    "isotropic_compression": (4.0e-9, 6.0e-9),
    "formula": (2.0e-6, 7.0e-6),
    "combined": (5.5e-9, 8.5e-9),
    "triaxial": (5.0e-7, 7.0e-7),
    "direct_simple_shear": (3.5e-5, 4.3e-5),
    "consolidation": (3.9e-11, 4.9e-11),
    "crs_oedometer": (0.40, 0.60),
    "column": (4.7e-5, 5.9e-5),
}

LONG = "slope"
"""Its swarm takes an hour; test_slope.py runs single calculations of it."""


def test_every_example_has_its_band() -> None:
    assert (
        list(example_names(engines=False)) == sorted([*BANDS, LONG]) == sorted(example.folder for example in EXAMPLES)
    )
    for example in EXAMPLES:
        if example.folder == LONG:
            continue
        assert BANDS[example.folder].keys() == example.truth.keys()
        for name, (lower, upper) in BANDS[example.folder].items():
            assert lower < example.truth[name] < upper


# The reference data and element tests cover the models of the other examples; the search is the same.
@pytest.mark.parametrize("folder", variants(sorted(BANDS), {"oedometer", "isotropic_compression", "formula", "column"}))
def test_example_finds_the_truth(folder: str) -> None:
    result = calibrate(load_problem(HERE / folder / "problem.yaml"))
    assert result.state == "finished"
    assert result.parameters is not None
    for name, (lower, upper) in BANDS[folder].items():
        assert lower < result.parameters[name] < upper
    lower, upper = OBJECTIVES[folder]
    assert result.objective is not None
    assert lower < result.objective <= upper
    if folder == "isotropic_compression":  # its links hold
        assert result.parameters["kappa_star"] == 0.5 * result.parameters["lambda_star"]
        assert result.parameters["phi"] == 20.0


@pytest.mark.parametrize("folder", variants(sorted(BANDS), {"formula"}))
def test_command_line_and_python_find_the_same(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = HERE / folder / "problem.yaml"
    assert main(["run", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    result = calibrate(load_problem(path))
    assert (document["state"], document["objective"]) == (result.state, result.objective)
    assert document["parameters"] == result.parameters
    assert document["evaluations"] == result.evaluations


@pytest.mark.parametrize(
    ("lambda_star", "kappa_star", "c", "settlement_mm"), [(0.082, 0.051, 25, 3.57), (0.064, 0.035, 27, 2.78)]
)
def test_final_settlement_of_the_published_sets(
    lambda_star: float, kappa_star: float, c: float, settlement_mm: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """Identified and laboratory set of the paper; values of an independent implementation."""
    settings = [f"lambda_star={lambda_star}", f"kappa_star={kappa_star}", f"c={c}"]
    options = [option for setting in settings for option in ("--set", setting)]
    assert main(["evaluate", str(HERE / "oedometer" / "problem.yaml"), *options, "--json"]) == 0
    response = json.loads(capsys.readouterr().out)["responses"]["settlement"]
    assert response["y_unit"] == "m"
    assert 1000.0 * response["y"][-1] == pytest.approx(settlement_mm, abs=0.02)


def test_prolonged_stage_keeps_the_integral_of_load_over_time() -> None:
    """100, 200, ... 700 kPa for a seventh of an hour each, against 50 kPa and then 800 kPa within the same hour."""
    stages = load_problem(HERE / "isotropic_compression" / "problem.yaml").document()["forward_model"]["stages"]
    longer_hours = stages[1]["duration"] * 24.0 - 17.0
    in_the_test = sum(100.0 * step / 7.0 for step in range(1, 8))
    in_the_model = 50.0 * longer_hours + 800.0 * (1.0 - longer_hours)
    assert in_the_model == pytest.approx(in_the_test, rel=1e-9)


def test_the_published_target_is_above_the_noise() -> None:
    problem = load_problem(HERE / "oedometer" / "problem.yaml")
    truth = Calibration(problem, 0).evaluate_values(problem.values([0.082, 0.051, 25.0]))
    assert truth.objective == pytest.approx(2.5e-9, rel=0.4)
