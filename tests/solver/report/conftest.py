"""Runs that several tests of reports look at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.document.build import Report, report_of_result
from geoswarm.solver.runs.local import calibrate

EXAMPLE = Path(__file__).parents[3] / "examples" / "oedometer" / "problem.yaml"


@dataclass(frozen=True)
class Run:
    """A problem, its result and its report, of which each form is drawn once."""

    problem: Problem
    result: CalibrationResult
    report: Report

    @cached_property
    def page(self) -> str:
        return self.report.html()

    @cached_property
    def pdf(self) -> bytes:
        return self.report.pdf()


def oedometer(**changes: Any) -> dict[str, Any]:
    """The published test with the laboratory values to start from."""
    document = load_problem(EXAMPLE).document()
    for name, value in {"lambda_star": 0.064, "kappa_star": 0.035, "c": 27.0}.items():
        document["parameters"][name]["initial"] = value
    return document | changes


@pytest.fixture(scope="package")
def swarm() -> Run:
    """A swarm on the published oedometer test."""
    problem = parse_problem(oedometer())
    result = calibrate(problem)
    return Run(problem, result, report_of_result(problem, result))


@pytest.fixture(scope="package")
def sampling() -> Run:
    """The published statistical analysis: 2000 samples of five parameters, filter 1e-7 m²."""
    document = oedometer(method={"kind": "monte_carlo", "samples": 2000}, stopping={})
    document["parameters"] |= {
        "phi": {"lower": 8, "upper": 30},
        "mu_star": {"lower": 1e-5, "upper": 0.75, "scale": "log"},
    }
    problem = parse_problem(document)
    result = calibrate(problem)
    return Run(problem, result, report_of_result(problem, result, threshold=1e-7))


@pytest.fixture(scope="package")
def failed() -> Run:
    """A run in which no evaluation succeeds."""
    problem = parse_problem(
        {
            "name": "hopeless",
            "forward_model": {"kind": "formula", "series": {"y": "ln(-a) * x"}},
            "parameters": {"a": {"lower": 1, "upper": 2}},
            "observations": [{"series": "y", "points": {"x": [1, 2], "y": [1, 2]}}],
            "stopping": {"max_evaluations": 20},
            "seed": 1,
        }
    )
    result = calibrate(problem)
    return Run(problem, result, report_of_result(problem, result))
