"""Application B of Meier et al. (2008): the isotropic compression test."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from geoswarm.paper.published import ISOTROPIC
from geoswarm.paper.study import (
    Row,
    Sampling,
    Study,
    Tell,
    bounds_rows,
    coordinates_row,
    correlation_rows,
    free,
    identified_rows,
    laboratory_rows,
    minimum_rows,
    row,
    sample,
)
from geoswarm.solver.identifiability import FittedLine, fit_line
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.document.build import report_of_result
from geoswarm.solver.runs.local import calibrate

__all__ = ["run_isotropic"]

_UNITS = {"c": "kPa"}
_REMARKS = (
    "The measured displacements were never printed. The reference data here are SYNTHETIC: this model with the "
    "published identified parameters, plus normal noise of 0.05 mm on both series (seed 1572).",
    "As published, the 800 kPa are applied at once and the 50 kPa stage is prolonged so that the integral of load over "
    "time is the same; kappa* = 0.5 lambda*; both series have the weight 1.",
    "The paper prints neither its filter nor the equation of its line: those beside 'published' are of an earlier "
    "independent calculation with the same material law.",
)


def run_isotropic(document: dict[str, Any], seeds: Sequence[int], tell: Tell) -> Study:
    """Run the study: laboratory values forward, statistics, choice of parameters, swarm; arguments as for study A."""
    published: Any = ISOTROPIC
    tell("B: laboratory values, forward")
    given = parse_problem(document)
    forward = [_displacement(given, {**published["laboratory"], **values}) for values in ({}, _identified())]
    problem = free(document, published["bounds"], published["samples"])
    sampling = sample(problem, published["filter"], seeds, tell)
    line = fit_line(sampling.together.filtered.samples, "lambda_star", "c")
    tell("B: particle swarm on lambda_star, mu_star")
    calibrated = _swarm_problem(document)
    result = calibrate(calibrated, seed=seeds[0])
    swarm = report_of_result(calibrated, result)
    rows = [
        *_input_rows(problem, calibrated),
        *_forward_rows(*forward),
        *_statistics_rows(sampling, line),
        *_swarm_rows(result),
        *minimum_rows(swarm, published["identified"], _UNITS),
    ]
    reports = {"statistics": sampling.report, "swarm": swarm}
    return Study("B", "Isotropic compression test", _REMARKS, tuple(rows), tuple(_choices(sampling, line)), reports)


def _identified() -> dict[str, float]:
    values: Any = ISOTROPIC["identified"]
    return {**values, "kappa_star": 0.5 * values["lambda_star"]}


def _displacement(problem: Problem, values: dict[str, float]) -> float:
    """Vertical displacement at the end of the test [m]."""
    spec: Any = problem.forward_model
    end = sum(stage.duration for stage in spec.stages)
    return float(problem.model.prepare({"axial_displacement": np.array([end])})(values)["axial_displacement"][0])


def _swarm_problem(document: dict[str, Any]) -> Problem:
    parameters = {**document["parameters"]}
    for name in ("lambda_star", "mu_star"):
        initial: Any = ISOTROPIC["laboratory"]
        parameters[name] = {**parameters[name], "initial": initial[name]}
    stopping = {"max_evaluations": ISOTROPIC["runs"]}
    return parse_problem({**document, "parameters": parameters, "stopping": stopping})


def _choices(sampling: Sampling, line: FittedLine | None) -> list[tuple[str, str, str]]:
    words = {
        "lambda_star": "identified by the swarm",
        "mu_star": "identified by the swarm, as published: the upper part of its range is excluded, and with c fixed "
        "its interval at the optimum is finite",
        "c": "fixed at the laboratory value 27 kPa: lambda* follows from c"
        + ("" if line is None else f", lambda* = {line.expression}"),
    }
    return [
        (name, sampling.together.verdict(name).sentence, words[name]) for name in sampling.report.problem.free_names
    ]


def _input_rows(problem: Problem, given: Problem) -> list[Row]:
    spec: Any = problem.forward_model
    published: Any = ISOTROPIC
    return [
        row("specimen", "height", 1e3 * published["height"], 1e3 * spec.height, unit="mm", digits=4),
        row("specimen", "diameter", 1e3 * published["diameter"], 1e3 * spec.diameter, unit="mm", digits=4),
        row("specimen", "30 kPa stage", 3.0, 24.0 * spec.stages[0].duration, unit="h"),
        row(
            "specimen",
            "50 kPa stage",
            17.0,
            24.0 * spec.stages[1].duration,
            unit="h",
            remark="prolonged for the hour in which the load was raised to 800 kPa",
        ),
        row("specimen", "800 kPa stage", 21.0, spec.stages[2].duration, unit="day"),
        *laboratory_rows(published["laboratory"], given, _UNITS),
        *bounds_rows(problem, published["bounds"], _UNITS),
    ]


def _forward_rows(laboratory: float, identified: float) -> list[Row]:
    quantity = "vertical displacement at the end"
    remark = "the paper shows a curve only"
    return [
        row("forward run", f"{quantity}, laboratory set", None, 1e3 * laboratory, unit="mm", remark=remark),
        row("forward run", f"{quantity}, identified set", None, 1e3 * identified, unit="mm", remark=remark),
    ]


def _statistics_rows(sampling: Sampling, line: FittedLine | None) -> list[Row]:
    published: Any = ISOTROPIC
    rows = [
        row("statistics", "samples", published["samples"], sampling.statistics.filtered.total, digits=5),
        row("statistics", "filter f", published["filter"], sampling.statistics.filtered.threshold.value, unit="m²"),
        *correlation_rows(sampling, "lambda_star", "c", published["correlation"]),
        coordinates_row(sampling, {("lambda_star", "c"): published["correlation"]}),
    ]
    for name, key, unit in (("c", "good_c", "kPa"), ("lambda_star", "good_lambda_star", "")):
        projection = next(p for p in sampling.together.projections if p.parameter == name)
        middle = "middle 90 % of the good fits of all seeds; read from a figure in the paper"
        for which, value, found in zip(
            ("from", "to"), published[key], (projection.lower, projection.upper), strict=True
        ):
            rows.append(row("statistics", f"good fits, {name} {which}", value, found, unit=unit, remark=middle))
    if line is not None and line.scale == "linear":
        low, high = published["good_c"]
        c = np.linspace(low, high, 71)
        ideal = published["line"][0] + published["line"][1] * c
        largest = float(np.abs(line.value(c) / ideal - 1.0).max())
        rows.append(
            Row(
                "statistics",
                "line lambda* over c",
                "0.057 + 0.00106 c",
                f"{line.intercept:.3f} + {line.slope:.5f} c",
                f"at most {100.0 * largest:.1f} % for c from 20 to 90 kPa",
                f"all seeds together; good fits scatter {100.0 * line.residual:.0f} % around it",
            )
        )
    mu = sampling.together.verdict("mu_star")
    below = next(p for p in sampling.together.projections if p.parameter == "mu_star")
    upper = "–" if below.upper is None else f"{below.upper:.2g}"
    rows.append(
        Row(
            "statistics",
            "mu* has a preferred range",
            "yes",
            f"good fits up to {upper} of 0.75",
            "agrees above, open below",
            mu.sentence,
        )
    )
    return rows


def _swarm_rows(result: CalibrationResult) -> list[Row]:
    published: Any = ISOTROPIC
    values = result.parameters or {}
    synthetic = "reference data made with the published value, plus noise"
    return [
        *identified_rows(published["identified"], values, _UNITS, synthetic),
        row("swarm", "kappa_star", 0.5 * 0.089, values.get("kappa_star"), remark="linked: 0.5 lambda*"),
        row("swarm", "cycles of 10 runs", published["cycles"], result.generations, digits=5),
        row("swarm", "forward runs", published["runs"], result.evaluations, digits=5),
    ]
