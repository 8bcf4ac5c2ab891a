"""Intervals between tests of a sand whose specimens differ from each other and from the law."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.problem import Problem, parse_problem
from tests.solver.identifiability.cases import linearised

KARLSRUHE = {"phi_c": 33.1, "h_s": 4.0e6, "n": 0.27, "e_d0": 0.677, "e_c0": 1.054, "e_i0": 1.212}
KARLSRUHE |= {"alpha": 0.14, "beta": 2.5}
FREE = {"phi_c": (30.0, 36.0), "alpha": (0.05, 0.3), "beta": (0.8, 4.5)}
STRAIN = np.linspace(0.005, 0.12, 10)
LOADS = [20.0, 50.0, 100.0, 200.0, 400.0]
TESTS = {
    **{f"OE{k}": ("oedometer", 10.0, e) for k, e in enumerate((0.75, 0.85, 0.95))},
    **{f"TMD{k}": ("triaxial", p, e) for k, (p, e) in enumerate([(100, 0.75), (200, 0.8), (400, 0.85), (50, 0.8)])},
    **{f"TMD{k + 4}": ("triaxial", p, e) for k, (p, e) in enumerate([(100, 0.9), (200, 0.95), (300, 0.78)])},
}
SERIES = {"oedometer": {"stage_axial_strain": 2e-4}, "triaxial": {"q": 0.01, "volumetric_strain": 5e-4}}
"""Errors of a reading: strain, and of q its part of the cell pressure."""


def section(name: str, void_ratio: float) -> dict[str, Any]:
    kind, stress, _ = TESTS[name]
    own: dict[str, Any] = {"kind": kind, "material": "hypoplastic_sand", "initial_stress": stress}
    if kind == "oedometer":
        own |= {"height": 0.02, "stages": [{"stress": load, "duration": 1.0} for load in LOADS]}
    else:
        own["shearing"] = [{"kind": "monotonic", "axial_strain": 0.12}]
    return own | {"initial_void_ratio": void_ratio}


def points(kind: str) -> FloatArray:
    return STRAIN if kind == "triaxial" else np.arange(1.0, len(LOADS) + 1.0)


def missed(kind: str, series: str, x: FloatArray, y: FloatArray) -> FloatArray:
    """What the law lacks: seating of caps in the oedometer, a softer start and less dilation of sheared specimens."""
    if kind == "oedometer":
        return y + 4e-4 * np.sqrt(x)
    return y * (1.0 - 0.06 * np.exp(-x / 0.02)) if series == "q" else 0.92 * y


def specimen(name: str, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Readings of a specimen whose void ratio and friction angle are not those that are known of it."""
    kind, stress, e = TESTS[name]
    own = KARLSRUHE | {"phi_c": KARLSRUHE["phi_c"] + 0.7 * rng.normal()}
    x = points(kind)
    found = built(parse_spec(section(name, e + 0.012 * rng.normal()))).prepare(dict.fromkeys(SERIES[kind], x))(own)
    return {
        f"{name}.{series}": missed(kind, series, x, found[series])
        + error * (stress if series == "q" else 1.0) * rng.normal(size=x.size)
        for series, error in SERIES[kind].items()
    }


def data_base(readings: dict[str, FloatArray]) -> Problem:
    """Ten tests that count alike."""
    observations = []
    for series, y in readings.items():
        name = series.partition(".")[0]
        kind, stress, _ = TESTS[name]
        size = {"oedometer": 0.01, "triaxial": 0.02}[kind] if not series.endswith(".q") else 3.0 * stress
        weight = 1.0 / size**2 / len(SERIES[kind])
        observations.append(
            {"series": series, "points": {"x": points(kind).tolist(), "y": y.tolist()}, "weight": weight}
        )
    fixed = {name: {"value": value} for name, value in KARLSRUHE.items() if name not in FREE}
    return parse_problem(
        {
            "forward_model": {"kind": "combined", "parts": {name: section(name, e) for name, (*_, e) in TESTS.items()}},
            "parameters": fixed | {name: {"lower": low, "upper": high} for name, (low, high) in FREE.items()},
            "observations": observations,
            "stopping": {"max_evaluations": 100},
        }
    )


def best_of(problem: Problem, start: FloatArray) -> FloatArray:
    """The minimum by SciPy."""
    calibration = Calibration(problem, 1)

    def residuals(place: FloatArray) -> FloatArray:
        return calibration.objective.weighted_residuals(
            calibration.evaluate(calibration.space.from_unit(place)).responses
        )

    begin = calibration.space.to_unit(start)
    found = least_squares(residuals, begin, bounds=(0.0, 1.0), diff_step=1e-3, x_scale=0.1, xtol=1e-6, ftol=1e-8)
    return calibration.space.from_unit(found.x)


@pytest.mark.slow
@pytest.mark.timeout(1500)
def test_intervals_cover_what_this_law_makes_of_all_specimens() -> None:
    """200 data bases of ten tests; with fixed weights, the mean reading of all specimens has the best parameters.

    A 95 % interval covers 91 to 98.5 % of 200 with a chance of 99.7 %.
    """
    rng = np.random.default_rng(45)
    bases = [{series: y for name in TESTS for series, y in specimen(name, rng).items()} for _ in range(200)]
    mean = {series: np.mean([base[series] for base in bases], axis=0) for series in bases[0]}
    middle = best_of(data_base(mean), np.array([KARLSRUHE[name] for name in FREE]))
    covered = []
    for base in bases:
        problem = data_base(base)
        without = linearised(problem, best_of(problem, middle).tolist()).without
        assert without is not None
        covered.append((without.intervals[:, 0] <= middle) & (middle <= without.intervals[:, 1]))
    share = np.mean(covered, axis=0)
    assert ((share >= 0.91) & (share <= 0.985)).all(), share
