"""Application A of Meier et al. (2008): the oedometer test."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from geoswarm.paper.published import OEDOMETER
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
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.document.build import report_of_result
from geoswarm.solver.runs.local import calibrate

__all__ = ["run_oedometer"]

_UNITS = {"c": "kPa", "phi": "°"}
_REMARKS = (
    "The measured settlements were never printed. The reference data here are SYNTHETIC: this model with the published "
    "identified parameters, plus normal noise of 0.05 mm (seed 1571). So the swarm should find the published values "
    "again; how well the model fits the real clay cannot be judged.",
    "Published: axisymmetric finite elements with self-weight. Here: one material point with a small initial stress.",
    "Correlations of few good fits scatter widely: 'here' is the median over several seeds, and the remark gives their "
    "middle 90 %. The paper does not print whether it correlated parameters or, on its logarithmic scales, their "
    "logarithms: both are shown.",
)


def run_oedometer(document: dict[str, Any], seeds: Sequence[int], tell: Tell) -> Study:
    """Run the study: laboratory values forward, statistics, choice of parameters, swarm.

    Parameters
    ----------
    document
        The example's problem: forward model, reference data, swarm.
    seeds
        Of the samplings; the first also of the swarm.
    tell
        Called with a line of progress.
    """
    published = OEDOMETER
    tell("A: laboratory values, forward")
    given = parse_problem(document)
    laboratory = _settlement(given, published["laboratory"])
    identified = _settlement(given, {**published["laboratory"], **published["identified"]})
    problem = free(document, published["bounds"], published["samples"])
    sampling = sample(problem, published["filter"], seeds, tell)
    choices, chosen = _choose(problem, sampling)
    tell(f"A: particle swarm on {', '.join(chosen)}")
    calibrated = _swarm_problem(document, problem, chosen)
    result = calibrate(calibrated, seed=seeds[0])
    swarm = report_of_result(calibrated, result)
    rows = [
        *_input_rows(problem, calibrated),
        *_forward_rows(laboratory, identified),
        *_statistics_rows(sampling),
        *_swarm_rows(result),
        *minimum_rows(swarm, published["identified"], _UNITS),
    ]
    reports = {"statistics": sampling.report, "swarm": swarm}
    return Study("A", "Oedometer test", _REMARKS, tuple(rows), tuple(choices), reports)


def _settlement(problem: Problem, values: dict[str, float]) -> float:
    """Settlement at the end of the test [m]."""
    time = float(sum(days for _, days in OEDOMETER["stages"]))
    return float(problem.model.prepare({"settlement": np.array([time])})(values)["settlement"][0])


def _choose(problem: Problem, sampling: Sampling) -> tuple[list[tuple[str, str, str]], list[str]]:
    """What the verdicts of all samplings together lead to: fix what they do not identify, keep the rest."""
    rows, chosen = [], []
    for name in problem.free_names:
        verdict = sampling.together.verdict(name)
        if verdict.kind == "not_identified":
            value = OEDOMETER["laboratory"][name]
            rows.append((name, verdict.sentence, f"fixed at the laboratory value {value:g}"))
        else:
            chosen.append(name)
            rows.append((name, verdict.sentence, "identified by the swarm"))
    return rows, chosen


def _swarm_problem(document: dict[str, Any], problem: Problem, chosen: list[str]) -> Problem:
    parameters = {name: {"value": value} for name, value in OEDOMETER["laboratory"].items()}
    for p in problem.free:
        if p.name in chosen:
            initial = OEDOMETER["laboratory"][p.name]
            parameters[p.name] = {"lower": p.lower, "upper": p.upper, "scale": p.scale, "initial": initial}
    stopping = {"max_evaluations": OEDOMETER["runs"], "target_objective": OEDOMETER["objective"]}
    method = {"kind": "particle_swarm", "particles": 10}
    return parse_problem({**document, "parameters": parameters, "stopping": stopping, "method": method})


def _input_rows(problem: Problem, given: Problem) -> list[Row]:
    spec: Any = problem.forward_model
    stages: Any = OEDOMETER["stages"]
    same = [(s.stress, round(s.duration, 6)) for s in spec.stages] == [(float(p), round(d, 6)) for p, d in stages]
    height: Any = OEDOMETER["height"]
    return [
        row("specimen", "height", 1e3 * height, 1e3 * spec.height, unit="mm", digits=4),
        Row(
            "specimen",
            "load stages",
            f"{len(stages)}, 9 to 800 kPa",
            f"{len(spec.stages)}, 9 to 800 kPa",
            "0" if same else "stages differ",
        ),
        *laboratory_rows(OEDOMETER["laboratory"], given, _UNITS),
        *bounds_rows(problem, OEDOMETER["bounds"], _UNITS),
    ]


def _forward_rows(laboratory: float, identified: float) -> list[Row]:
    remark = "an earlier independent calculation with the same material law; the paper shows curves only"
    return [
        row(
            "forward run",
            "final settlement, laboratory set",
            2.78,
            1e3 * laboratory,
            unit="mm",
            remark=remark,
        ),
        row(
            "forward run",
            "final settlement, identified set",
            3.57,
            1e3 * identified,
            unit="mm",
            remark=remark,
        ),
        Row(
            "forward run",
            "the laboratory set underestimates the deformation",
            "yes",
            "yes" if laboratory < identified else "no",
            f"{100.0 * (laboratory / identified - 1.0):+.0f} % settlement".replace("-", "−"),
        ),
    ]


def _statistics_rows(sampling: Sampling) -> list[Row]:
    published: Any = OEDOMETER
    rows = [
        row("statistics", "samples", published["samples"], sampling.statistics.filtered.total, digits=5),
        row("statistics", "filter f", published["filter"], sampling.statistics.filtered.threshold.value, unit="m²"),
    ]
    for (first, second), value in published["correlations"].items():
        rows += correlation_rows(sampling, first, second, value)
    rows.append(coordinates_row(sampling, published["correlations"]))
    for name in published["bounds"]:
        verdict = sampling.together.verdict(name)
        expected = "not identifiable" if name in published["not_identifiable"] else "concentrates"
        agrees = (verdict.kind == "not_identified") == (name in published["not_identifiable"])
        rows.append(
            Row(
                "statistics",
                f"verdict on {name}",
                expected,
                verdict.kind.replace("_", " "),
                "agrees" if agrees else "differs",
                verdict.sentence,
            )
        )
    return rows


def _swarm_rows(result: CalibrationResult) -> list[Row]:
    published: Any = OEDOMETER
    values = result.parameters or {}
    synthetic = "reference data made with the published value, plus noise"
    noise = "noise alone leaves 2.5e-9 m²; stopped at the published 5e-9 m²"
    return [
        *identified_rows(published["identified"], values, _UNITS, synthetic),
        row("swarm", "cycles of 10 runs", published["cycles"], result.generations, digits=5, remark="one swarm each"),
        row("swarm", "forward runs", published["runs"], result.evaluations, digits=5),
        row("swarm", "objective reached", published["objective"], result.objective, unit="m²", remark=noise),
    ]
