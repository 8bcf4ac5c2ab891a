"""Application C of Meier et al. (2008): the creeping slope, on a section that is a synthetic look-alike."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.paper.published import SLOPE
from geoswarm.paper.slope_pictures import slope_pictures
from geoswarm.paper.study import (
    Row,
    Sampling,
    Study,
    Tell,
    bounds_rows,
    free,
    identified_rows,
    laboratory_rows,
    row,
    sample,
)
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.forward.cross_section import SectionModel
from geoswarm.solver.identifiability import Samples
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.document.build import Report, linearise_stored
from geoswarm.solver.report.record import record_of_result
from geoswarm.solver.runs.local import calibrate

__all__ = ["run_slope"]

_UNITS = {"c": "kPa", "phi": "°", "psi": "°", "G": "kPa"}
_TARGET = 2.0 * 0.005**2
"""m²: what the noise of 5 mm leaves of each of the two series; a better fit would be one to the noise."""

_STAGNATION = 20
_STOPS = {
    "max_evaluations": "number of runs",
    "target_objective": "the fit is as good as the noise allows",
    "stagnation_generations": f"no better set in {_STAGNATION} cycles",
}
_REMARKS = (
    "Neither the section's coordinates nor the GPS readings are printed. The section here is a SYNTHETIC look-alike "
    "built from the description, and the vectors are SYNTHETIC: this model with the published identified parameters, "
    "plus normal noise. So the swarm should find a set that reproduces the vectors; how well the model fits the real "
    "slope cannot be judged.",
    "Published: one of several possible solutions. Five parameters meet twelve displacement components that move "
    "together, so other sets than the published one may fit as well.",
)


@dataclass(frozen=True)
class _Forward:
    """A forward run: vectors of the survey (k, 2) in m, and rates of the points in its first and last year, m/year."""

    vectors: FloatArray
    rates: tuple[float, float]


def run_slope(
    document: dict[str, Any], seeds: Sequence[int], tell: Tell, *, samples: int, runs: int, workers: int
) -> Study:
    """Run the study: laboratory and identified values forward, statistics, swarm.

    Parameters
    ----------
    document
        The example's problem.
    seeds
        The first one is that of sampling and swarm.
    tell
        Called with a line of progress.
    samples, runs
        Forward runs of the sampling and of the swarm.
    workers
        Processes at once; they change nothing in the result.
    """
    published: Any = SLOPE
    tell("C: laboratory and identified values, forward")
    given = parse_problem(document)
    fixed = given.values([0.0] * len(given.free_names))
    laboratory = _forward(given, {**fixed, **published["laboratory"]})
    identified = _forward(given, {**fixed, **published["laboratory"], **published["identified"]})
    problem = free(document, published["bounds"], samples)
    sampling = sample(problem, None, seeds[:1], tell, workers=workers)
    tell(f"C: particle swarm, {runs} forward runs of some seconds each")
    stopping = {"max_evaluations": runs, "target_objective": _TARGET, "stagnation_generations": _STAGNATION}
    calibrated = parse_problem({**document, "stopping": stopping})
    result = calibrate(calibrated, workers=workers, seed=seeds[0])
    found = Samples.from_result(calibrated, result)
    swarm = Report(
        calibrated,
        record_of_result(calibrated, result),
        found,
        linearisation=linearise_stored(calibrated, found, result.seed),
    )
    tell("C: figures")
    rows = [
        *_input_rows(calibrated),
        *_forward_rows(laboratory, identified),
        *_statistics_rows(sampling),
        *_swarm_rows(calibrated, result),
    ]
    best = calibrated.values([(result.parameters or {})[name] for name in calibrated.free_names])
    pictures = slope_pictures(calibrated, best)
    choices = [
        (name, sampling.together.verdict(name).sentence, "identified by the swarm, as published")
        for name in problem.free_names
    ]
    return Study(
        "C",
        "Creeping slope",
        _REMARKS,
        tuple(rows),
        tuple(choices),
        {"statistics": sampling.report, "swarm": swarm},
        pictures,
    )


def _forward(problem: Problem, values: dict[str, float]) -> _Forward:
    model = problem.model
    assert isinstance(model, SectionModel)
    vector = model.spec.vectors["gps"]
    numbers = np.arange(1.0, len(vector.points) + 1.0)
    year = 365.25
    times = np.array([vector.start, vector.start + year, vector.end - year, vector.end])
    wanted = {"gps.ux": numbers, "gps.uy": numbers}
    wanted |= {f"{point}.{axis}": times for point in vector.points for axis in ("ux", "uy")}
    found = model.prepare(wanted)(values)
    paths = np.array([[found[f"{point}.ux"], found[f"{point}.uy"]] for point in vector.points])
    steps = np.linalg.norm(np.diff(paths, axis=2), axis=1)
    return _Forward(
        np.stack([found["gps.ux"], found["gps.uy"]], axis=1), (float(steps[:, 0].mean()), float(steps[:, 2].mean()))
    )


def _input_rows(problem: Problem) -> list[Row]:
    model = problem.model
    assert isinstance(model, SectionModel)
    published: Any = SLOPE
    mesh = model.nominal
    layers: Any = model.spec.layers
    cover = [float(y) for _, y in layers[0].thickness]
    years = sum(float(phase.duration or 0.0) for phase in model.spec.phases) / 365.25
    drop = model.spec.surface[0][1] - model.spec.surface[-1][1]
    slope = math.degrees(math.atan(drop / np.ptp(mesh.nodes[:, 0])))
    rock = float(layers[-1].thickness)
    return [
        row("section", "length", published["length"], float(np.ptp(mesh.nodes[:, 0])), unit="m", digits=4),
        row("section", "six-node triangles", published["triangles"], len(mesh.triangles), digits=4),
        Row("section", "thickness of the cover", "20 to 40 m", f"{min(cover):g} to {max(cover):g} m", "inside"),
        row("section", "bedrock in the model", published["rock"], rock, unit="m"),
        row("section", "creep", published["years"], years, unit="years"),
        Row("section", "mean slope of the surface", "–", f"{slope:.1f} °", "–", "about 10 ° in the paper's figure"),
        *laboratory_rows(published["laboratory"], problem, _UNITS),
        *bounds_rows(problem, published["bounds"], _UNITS),
    ]


def _forward_rows(laboratory: _Forward, identified: _Forward) -> list[Row]:
    rows = []
    for name, words, forward in (
        ("laboratory set", "millimetres", laboratory),
        ("identified set", "several cm to several dm", identified),
    ):
        lengths = 1e3 * np.linalg.norm(forward.vectors, axis=1)
        here = f"{lengths.min():.3g} to {lengths.max():.3g} mm"
        inside = lengths.max() < 10.0 if forward is laboratory else 10.0 < lengths.max() < 1000.0
        rows.append(Row("forward run", f"survey of 3 years, {name}", words, here, "agrees" if inside else "differs"))
        first, last = forward.rates
        rows.append(
            Row(
                "forward run",
                f"rate, {name}",
                "steady",
                f"{1e3 * first:.3g} mm/year, two years later {1e3 * last:.3g}",
                f"{100.0 * (last / first - 1.0):+.1f} %".replace("-", "−"),
                "mean of the points after 30 years of creep",
            )
        )
    return rows


def _statistics_rows(sampling: Sampling) -> list[Row]:
    published: Any = SLOPE
    filtered = sampling.statistics.filtered
    pair = sampling.statistics.pearson.get("phi", "mu_star")
    known = pair.lower is not None and pair.upper is not None
    interval = f"95 % interval {pair.lower:.2f} to {pair.upper:.2f}".replace("-", "−") if known else "no interval"
    return [
        row("statistics", "samples", None, filtered.total, digits=5, remark="the paper does not say how many"),
        row("statistics", "filter f", None, filtered.threshold.value, unit="m²", remark="proposed; the paper has none"),
        row(
            "statistics",
            "correlation (phi, mu_star)",
            published["correlation"],
            pair.coefficient,
            digits=2,
            remark=f"{interval}, {pair.count} good fits",
        ),
    ]


def _swarm_rows(problem: Problem, result: CalibrationResult) -> list[Row]:
    published: Any = SLOPE
    values = result.parameters or {}
    synthetic = "reference vectors made with the published value, plus noise"
    rows = identified_rows(published["identified"], values, _UNITS, synthetic)
    calibration = Calibration(problem, result.seed)
    truth = calibration.evaluate_values({**problem.values([0.0] * len(problem.free_names)), **published["identified"]})
    return [
        *rows,
        row(
            "swarm",
            "cycles of 10 runs",
            published["cycles"],
            result.generations,
            digits=5,
            remark=f"stopped by: {', '.join(_STOPS.get(reason, reason) for reason in result.stop_reasons)}",
        ),
        row("swarm", "forward runs", published["runs"], result.evaluations, digits=5),
        row(
            "swarm",
            "objective reached",
            None,
            result.objective,
            unit="m²",
            remark=f"the published set leaves {truth.objective:.3g} m² (noise alone)",
        ),
    ]
