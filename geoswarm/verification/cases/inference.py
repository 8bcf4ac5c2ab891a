"""Statistics and search: intervals, coverage, certified fits, global sensitivity, a known optimum."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy import stats

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, design, from_evaluations
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.identifiability.stored.global_sensitivity import analyse_design, outputs_of
from geoswarm.solver.methods.global_designs import SobolMethod
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.verification.case import Answer, Curve, Plot, case, check
from geoswarm.verification.exact.nist import PROBLEMS

__all__ = ["CASES"]

TRUTH, NOISE = np.array([1.0, 0.5]), 0.05
LINE: dict[str, Any] = {"a": {"lower": -5.0, "upper": 5.0}, "b": {"lower": -5.0, "upper": 5.0}}
DRAPER = "Draper & Smith (1998), Applied Regression Analysis, chapter 1"


def _calibration(expression: str, parameters: dict[str, Any], x: FloatArray, y: FloatArray, **more: Any) -> Calibration:
    problem = {
        "forward_model": {"kind": "formula", "series": {"y": expression}},
        "parameters": parameters,
        "observations": [{"series": "y", "points": {"x": x.tolist(), "y": y.tolist()}}],
        "stopping": {"max_evaluations": 10},
        "noise": {"kind": "white"},
        **more,
    }
    return Calibration(parse_problem(problem), 1)


def _linearised(calibration: Calibration, start: FloatArray) -> tuple[FloatArray, float, Linearisation]:
    """The minimum near a start, its objective, and what the data determine there."""
    found = polish(calibration, start)
    plan = design(calibration, found.parameters)
    evaluations = [calibration.evaluate(x) for x in plan.positions]
    return found.parameters, found.objective, from_evaluations(calibration, plan, evaluations)


def _line(x: FloatArray, random: np.random.Generator) -> FloatArray:
    found: FloatArray = TRUTH[0] + TRUTH[1] * x + random.normal(0.0, NOISE, x.size)
    return found


@case(
    "statistics-line",
    "Estimates and intervals of a straight line",
    shows="Twenty readings with noise of 0.05: both parameters, their standard errors, correlation and 95 % intervals.",
    given="y = 1 + 0.5 x, x from 0 to 4, noise stated as white",
    source=DRAPER,
    reference="normal equations; (XᵀX)⁻¹ s², s² = SSR/(n − 2); estimate ± t(0.975, n − 2) standard errors",
    allowed="finite differences instead of derivatives, and the convergence tolerance of the descent",
)
def line() -> Answer:
    """Parameters, errors, intervals."""
    x = np.linspace(0.0, 4.0, 20)
    y = _line(x, np.random.default_rng(11))
    X = np.column_stack([np.ones_like(x), x])
    inverse = np.linalg.inv(X.T @ X)
    exact = inverse @ X.T @ y
    variance = float(((y - X @ exact) ** 2).sum()) / (x.size - 2)
    errors = np.sqrt(variance * np.diag(inverse))
    half = stats.t.ppf(0.975, x.size - 2) * errors
    ours, _, linearised = _linearised(_calibration("a + b * x", LINE, x, y), TRUTH)
    correlation = inverse[0, 1] / math.sqrt(inverse[0, 0] * inverse[1, 1])
    checks = (
        check("parameters", "", ours, exact, 1.0e-7),
        check("standard errors", "", linearised.standard_errors, errors, 1.0e-5),
        check("ends of the intervals", "", linearised.intervals, np.column_stack([exact - half, exact + half]), 1.0e-5),
        check("correlation of the estimates", "", linearised.correlation()[0, 1], correlation, 1.0e-5),
    )
    places = np.array([0.0, 1.0])
    curves = (
        Curve("estimate", places, ours, places, exact),
        Curve("lower end", places, linearised.intervals[:, 0], places, exact - half),
        Curve("upper end", places, linearised.intervals[:, 1], places, exact + half),
    )
    return Answer(checks, Plot("parameter (0: intercept, 1: slope)", "value [-]", curves, dots=True))


@case(
    "statistics-student",
    "Width of intervals from few readings",
    shows="Half the width of the interval of the slope over its standard error, for 4 to 40 readings.",
    given="y = 1 + 0.5 x, x from 0 to 4, noise 0.05, stated as white",
    source="Student (1908)",
    reference="t(0.975, n − 2)",
    allowed="finite differences instead of derivatives",
)
def student() -> Answer:
    """Ratio over number of readings."""
    counts = np.array([4, 5, 6, 8, 12, 20, 40])
    ratios = []
    for count in counts.tolist():
        x = np.linspace(0.0, 4.0, count)
        y = _line(x, np.random.default_rng(0))
        _, _, linearised = _linearised(_calibration("a + b * x", LINE, x, y), TRUTH)
        low, high = linearised.intervals[1]
        ratios.append(0.5 * (high - low) / linearised.standard_errors[1])
    exact = stats.t.ppf(0.975, counts - 2)
    plot = Plot(
        "number of readings [-]",
        "half width over standard error [-]",
        (Curve("", counts, np.array(ratios), counts, exact),),
    )
    return Answer((check("half width over standard error", "", ratios, exact, 1.0e-6),), plot)


@case(
    "statistics-coverage",
    "How often intervals hold the truth",
    shows="Two hundred experiments on a straight line of fifteen readings, each with its own noise.",
    given="y = 1 + 0.5 x, x from 0 to 4, noise 0.05, stated as white",
    source="definition of a 95 % confidence interval; standard errors from (XᵀX)⁻¹ σ²",
    reference="95 % of the intervals contain the truth; the mean square of the standard errors is the true one",
    allowed="chance: three standard deviations of a share of 95 % of 200; 5 % for standard errors",
)
def coverage() -> Answer:
    """Share over the number of experiments."""
    x, random, repeats = np.linspace(0.0, 4.0, 15), np.random.default_rng(2024), 200
    held, errors = [], []
    for _ in range(repeats):
        _, _, linearised = _linearised(_calibration("a + b * x", LINE, x, _line(x, random)), TRUTH)
        low, high = linearised.intervals.T
        held.append((low <= TRUTH) & (high >= TRUTH))
        errors.append(linearised.standard_errors)
    shares = np.cumsum(held, axis=0) / np.arange(1, repeats + 1)[:, np.newaxis]
    X = np.column_stack([np.ones_like(x), x])
    expected = NOISE * np.sqrt(np.diag(np.linalg.inv(X.T @ X)))
    chance = 3.0 * math.sqrt(0.95 * 0.05 / repeats)
    checks = (
        check("share of intervals that contain the truth", "", shares[-1], 0.95, chance, scale=1.0, of="absolute"),
        check("standard errors, root mean square", "", np.sqrt(np.mean(np.square(errors), axis=0)), expected, 0.05),
    )
    at = np.arange(1, repeats + 1, dtype=np.float64)
    end = np.array([float(repeats)])
    curves = tuple(
        Curve(label, at[9::5], 100 * shares[9::5, i], end, np.array([95.0]))
        for i, label in enumerate(("intercept", "slope"))
    )
    plot = Plot("experiments [-]", "intervals that contain the truth [%]", curves, caption="Marker: 95 %.")
    return Answer(checks, plot)


@case(
    "statistics-nist",
    "Certified fits of NIST",
    shows=(
        "Misra1a, Thurber, MGH09 and BoxBOD, fitted by descent from the second start values: parameters, residual sum "
        "of squares and standard deviations."
    ),
    given="data, models and certified values of the archive; bounds around them",
    source="National Institute of Standards and Technology, Statistical Reference Datasets, nonlinear regression",
    reference="certified values of eleven digits",
    allowed="convergence of the descent (six digits) and finite differences (1 % of standard deviations)",
)
def nist() -> Answer:
    """Standard deviations against the certified ones."""
    checks, curves = [], []
    for one in PROBLEMS:
        calibration = Calibration(parse_problem(one.document()), 1)
        ours, objective, linearised = _linearised(calibration, np.array(one.start))
        certified = np.array([row[:2] for row in one.parameters.values()])
        checks += [
            check(f"parameters, {one.name}", "", ours, certified[:, 0], 1.0e-6),
            check(f"sum of squares, {one.name}", "", objective * len(one.x), one.residual_sum_of_squares, 1.0e-8),
            check(f"standard deviations, {one.name}", "", linearised.standard_errors, certified[:, 1], 1.0e-2),
        ]
        order = np.argsort(certified[:, 1])
        deviations = certified[order, 1]
        curves.append(Curve(one.name, deviations, linearised.standard_errors[order], deviations, deviations))
    plot = Plot("certified standard deviation", "standard error", tuple(curves), log_x=True, log_y=True)
    return Answer(tuple(checks), plot)


@case(
    "statistics-sobol",
    "Global sensitivity: the function of Ishigami",
    shows="Sobol indices of 20 + sin x₁ + 7 sin² x₂ + 0.1 x₃⁴ sin x₁ from 2048 blocks of a design.",
    given="xᵢ uniform from −π to π",
    source="Ishigami & Homma (1990); Saltelli et al. (2008), Global Sensitivity Analysis",
    reference="V₁ = ½ (1 + b π⁴/5)², V₂ = a²/8, V₁₃ = b² π⁸ (1/18 − 1/50); a = 7, b = 0.1",
    allowed="the scatter of 2048 blocks",
    needs=("SALib",),
)
def sobol() -> Answer:
    """Indices."""
    a, b = 7.0, 0.1
    first, second = 0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2, a * a / 8.0
    both = b * b * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = first + second + both
    bounds = {"lower": -math.pi, "upper": math.pi}
    expression = f"20 + sin(p) + {a} * sin(q) ** 2 + {b} * r ** 4 * sin(p) + 0 * x"
    calibration = _calibration(expression, {"p": bounds, "q": bounds, "r": bounds}, np.array([1.0]), np.array([0.0]))
    plan = SobolMethod(samples=2048).points(calibration.space, 1)
    outputs = outputs_of(calibration, [calibration.evaluate(x) for x in plan.positions], "y")
    found = analyse_design(calibration, plan, outputs, output="y").indices
    main, total = np.array([one.main for one in found]), np.array([one.total for one in found])
    exact_main = np.array([first, second, 0.0]) / whole
    exact_total = np.array([first + both, second, both]) / whole
    checks = (
        check("first-order indices", "", main, exact_main, 0.02, scale=1.0, of="absolute"),
        check("total indices", "", total, exact_total, 0.02, scale=1.0, of="absolute"),
    )
    places = np.array([1.0, 2.0, 3.0])
    curves = (
        Curve("first order", places, main, places, exact_main),
        Curve("total", places, total, places, exact_total),
    )
    return Answer(checks, Plot("number of the input", "index [-]", curves, dots=True))


@case(
    "search-least-squares",
    "Searches find a minimum that is known",
    shows="A parabola through twelve readings with noise, three parameters: what each method finds from its bounds.",
    given=(
        "y = 1 − 0.5 x + 2 x², noise 0.05, bounds −5 to 5; swarm of 20, differential evolution of 20, "
        "accelerated swarm of 10"
    ),
    source="normal equations of linear least squares",
    reference="(XᵀX)⁻¹ Xᵀ y and its sum of squares",
    allowed="the search stops at most 1e-6 of the least sum of squares above it",
)
def searches() -> Answer:
    """Objective above the minimum over evaluations."""
    x = np.linspace(-1.0, 1.0, 12)
    y = 1.0 - 0.5 * x + 2.0 * x**2 + np.random.default_rng(3).normal(0.0, NOISE, x.size)
    X = np.column_stack([np.ones_like(x), x, x**2])
    exact = np.linalg.solve(X.T @ X, X.T @ y)
    least = float(((y - X @ exact) ** 2).mean())
    parameters = {name: {"lower": -5.0, "upper": 5.0} for name in "abc"}
    methods: dict[str, dict[str, Any]] = {
        "particle swarm": {"kind": "particle_swarm", "particles": 20, "acceleration": "none"},
        "accelerated swarm": {"kind": "particle_swarm", "particles": 10},
        "differential evolution": {"kind": "differential_evolution", "members": 20},
    }
    checks, curves = [], []
    stopping = {"max_evaluations": 6000, "target_objective": least * (1.0 + 1.0e-6)}
    for label, method in methods.items():
        calibration = _calibration("a + b * x + c * x ** 2", parameters, x, y, method=method, stopping=stopping, seed=5)
        result = calibrate(calibration.problem)
        found = math.nan if result.objective is None else result.objective
        best = np.full(3, math.nan) if result.best is None else result.best.parameters
        checks.append(check(f"sum of squares, {label}", "", found, least, 1.0e-6))
        checks.append(check(f"parameters, {label}", "", best, exact, 1.0e-3, scale=1.0, of="absolute"))
        records = [(r.evaluations, r.objective) for r in result.generation_records if r.objective is not None]
        runs, best_so_far = np.array(records, dtype=np.float64).T
        above = np.maximum(best_so_far / least - 1.0, 1.0e-9)
        curves.append(Curve(label, runs, above, runs[-1:], np.array([1.0e-6])))
    plot = Plot(
        "forward runs [-]",
        "objective above the minimum, relative [-]",
        tuple(curves),
        log_x=True,
        log_y=True,
        caption="Markers: where the search may stop.",
    )
    return Answer(tuple(checks), plot)


CASES = (line, student, coverage, nist, sobol, searches)
