"""The statistics of the published laboratory studies (Meier et al. 2008, applications A and B), twenty seeds each.

The reference data are synthetic: the published identified sets with 0.05 mm of noise. Samples are drawn as published
(2000 and 1820, logarithmic scales, filters 1e-7 and 2e-7 m2). Published correlations: A (lambda*, c) 0.88 and
(lambda*, kappa*) 0.64; B (lambda*, c) 0.96. Parameters on a logarithmic scale are correlated as logarithms.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, Statistics, analyse, fit_line
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from tests.contracts.repository import ROOT

SEEDS = 20


def study(example: str, samples: int, threshold: float, parameters: dict[str, Any], seeds: int) -> list[Statistics]:
    document = load_problem(ROOT / "examples" / example / "problem.yaml").document()
    document["parameters"] |= parameters
    document |= {"method": {"kind": "monte_carlo", "samples": samples, "batch": 1000}, "stopping": {}}
    found = []
    for seed in range(seeds):
        problem = parse_problem(document | {"seed": 100 + seed})
        drawn = Samples.from_result(problem, calibrate(problem))
        found.append(analyse(Calibration(problem, 1), drawn, threshold=threshold))
    return found


def oedometer(seeds: int) -> list[Statistics]:
    free = {"mu_star": {"lower": 1e-5, "upper": 0.75, "scale": "log"}, "phi": {"lower": 8, "upper": 30}}
    return study("oedometer", 2000, 1e-7, free, seeds)


def isotropic(seeds: int) -> list[Statistics]:
    return study("isotropic_compression", 1820, 2e-7, {"c": {"lower": 0.001, "upper": 100}}, seeds)


def coefficients(studies: list[Statistics], second: str) -> Any:
    return np.array([s.pearson_search.get("lambda_star", second).coefficient for s in studies])


def check_oedometer(studies: list[Statistics], least: float) -> None:
    """The published verdicts in at least this share of the studies: among 15 to 30 good fits chance has its part."""
    wanted = {
        "phi": {"not_identified"},
        "mu_star": {"not_identified"},
        **{name: {"identified", "in_combination"} for name in ("lambda_star", "kappa_star", "c")},
    }
    for name, kinds in wanted.items():
        share = np.mean([statistics.verdict(name).kind in kinds for statistics in studies])
        assert share >= least, name
    assert all(statistics.samples.failed == 0 for statistics in studies)


def check_isotropic(studies: list[Statistics]) -> None:
    cohesion = np.linspace(20.0, 90.0, 8)
    published_here = 0.057 + 0.00106 * cohesion
    for statistics in studies:
        assert statistics.verdict("lambda_star").kind == "in_combination"
        assert statistics.verdict("c").kind == "in_combination"
        link = next(p for p in statistics.verdict("lambda_star").proposals if p.kind == "link")
        assert link.line is not None
        assert link.line.partner == "c"
        line = fit_line(statistics.filtered.samples, "lambda_star", "c")
        assert line is not None
        np.testing.assert_allclose(line.value(cohesion), published_here, rtol=0.10)


def test_verdicts_of_the_oedometer_study() -> None:
    check_oedometer(oedometer(2), 1.0)


def test_verdicts_and_line_of_the_isotropic_study() -> None:
    check_isotropic(isotropic(2))


@pytest.mark.slow
def test_oedometer_study_over_twenty_seeds() -> None:
    studies = oedometer(SEEDS)
    check_oedometer(studies, 0.9)
    with_c, with_kappa = coefficients(studies, "c"), coefficients(studies, "kappa_star")
    assert np.quantile(with_c, 0.025) <= 0.88 <= np.quantile(with_c, 0.975)
    assert np.quantile(with_kappa, 0.025) <= 0.64 <= np.quantile(with_kappa, 0.975)
    assert 0.80 <= with_c.mean() <= 0.92
    assert 0.60 <= with_kappa.mean() <= 0.80
    assert (with_c > with_kappa).mean() >= 0.9
    assert (with_kappa > 0).all()


@pytest.mark.slow
def test_isotropic_study_over_twenty_seeds() -> None:
    studies = isotropic(SEEDS)
    check_isotropic(studies)
    found = coefficients(studies, "c")
    assert np.quantile(found, 0.025) <= 0.96 <= np.quantile(found, 0.975)
    assert 0.95 <= found.mean() <= 0.975
