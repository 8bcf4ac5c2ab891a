"""No confident wrong statement about problems of known structure, whatever the seed of search and noise."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import binom
from scipy.stats import t as student

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, Statistics, Verdict, analyse, from_evaluations
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.document.build import linearise_stored, report_of_result
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.alike import ALIKE
from tests.solver.identifiability.zoo import CONFIDENT, SWARM, ZOO, Animal

CHANCE = 1e-5  # that a right statement is called wrong: about 1000 are looked at


def wrong_words(animal: Animal, problem: Problem, statistics: Statistics) -> list[str]:
    """Sentences that say more than the data do, or that deny what they tell."""
    found = []
    for verdict in statistics.verdicts:
        name, sure = verdict.parameter, verdict.kind in CONFIDENT
        if sure and name in animal.never:
            found.append(f"sure of {name}: {verdict.sentence}")
        if sure and animal.truth is not None and not near(verdict, animal.truth[name], free_of(statistics), CHANCE):
            found.append(f"{name} is {animal.truth[name]:g}: {verdict.sentence}")
        if name in animal.always and verdict.kind == "not_identified":
            found.append(f"denies {name}: {verdict.sentence}")
        if verdict.evidence.basis == "linearisation" and sure and "could still hide in" not in verdict.sentence:
            found.append(f"nothing of other basins: {verdict.sentence}")
        if verdict.kind == "in_combination" and name not in animal.tied:
            found.append(f"combination: {verdict.sentence}")
        if "no influence" in verdict.sentence and name not in animal.silent:
            found.append(f"influence: {verdict.sentence}")
    if animal.wrong and statistics.fit.kind == "describes":
        found.append(f"wrong model: {statistics.fit.sentence}")
    pairs = statistics.basins.exchanges
    found += [f"no exchange: {pair}" for pair in pairs if not set(pair) <= set(animal.exchange)]
    told = sum("fits as well as the optimum" in warning for warning in statistics.warnings)
    lowest = float(statistics.samples.objectives.min())
    alike = sum(other.objective <= max(1.1 * lowest, 1e-9) for other in statistics.basins.others)
    if told > alike:
        found.append(f"{told} fit as well, of which {alike} do")
    if len(problem.observations[0].x) != animal.points:
        found.append("another problem")
    return found


def free_of(statistics: Statistics) -> int:
    return 1 if statistics.linearisation is None else statistics.linearisation.degrees_of_freedom


def near(verdict: Verdict, truth: float, free: int, chance: float) -> bool:
    """Whether chance explains that a 95 % interval, Student's t with so many degrees of freedom, misses a value."""
    low, high = verdict.evidence.range_lower, verdict.evidence.range_upper
    if low is None or high is None:
        return True
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    wider = float(student.ppf(1.0 - 0.5 * chance, free) / student.ppf(0.975, free))
    return abs(truth - middle) <= wider * half + 1e-6 * abs(truth)


def statements(problem: Problem, result: CalibrationResult) -> dict[str, Statistics]:
    """What is said by a report, from stored runs alone, and from these and sensitivities at the minimum."""
    report = report_of_result(problem, result).statistics
    assert report is not None
    samples = Samples.from_result(problem, result)
    calibration = Calibration(problem, result.seed)
    alone = analyse(calibration, samples, linearisation=linearise_stored(problem, samples, result.seed))
    found = {"report": report, "stored runs": alone}
    if problem.method.role == "search":  # as a service does: a follow-up polishes and calculates sensitivities
        best = polish(calibration, samples.parameters[samples.best])
        at = from_evaluations(calibration, *evaluate_differences(calibration, best.parameters))
        responses = best.evaluation.responses
        found["sensitivities"] = analyse(calibration, samples, linearisation=at, at_optimum=responses)
    return found


def judge_seed(name: str, seed: int, method: dict[str, Any] | None = None) -> tuple[list[str], bool]:
    """Wrong words of one seed, and whether the 95 % interval of a parameter that is sure misses it."""
    animal = ZOO[name]
    noise = np.random.default_rng([seed, len(name)]).standard_normal(animal.points)
    problem = animal.make(noise, method)
    said = statements(problem, calibrate(problem, seed=seed))
    truth = animal.truth or {}
    sure = [v for v in said["report"].verdicts if v.kind in CONFIDENT and v.parameter in truth]
    missed = any(not near(v, truth[v.parameter], free_of(said["report"]), 0.05) for v in sure)
    return [
        f"{name}, seed {seed}, {source}: {words}"
        for source, statistics in said.items()
        for words in wrong_words(animal, problem, statistics)
    ], missed


@pytest.mark.parametrize("name", ZOO)
def test_no_confident_wrong_word(name: str) -> None:
    """After the textbook swarm, which leaves basins unfinished, as it costs nothing beside the runs."""
    assert judge_seed(name, 0, SWARM)[0] == []


@pytest.mark.parametrize("name", ["two basins", "unequal basins"])
@pytest.mark.parametrize("runs", [30, 40])
def test_descents_that_were_cut_short_make_nothing_sure(name: str, runs: int) -> None:
    """With so few runs after a textbook swarm no descent to the other basin ends; its first runs are lower already."""
    animal, said = ZOO[name], []
    for seed in range(2):
        problem = animal.make(np.random.default_rng([seed, len(name)]).standard_normal(animal.points), SWARM)
        problem = parse_problem(problem.document() | {"answer": {"max_evaluations": runs}})
        statistics = report_of_result(problem, calibrate(problem, seed=seed)).statistics
        assert statistics is not None
        said += wrong_words(animal, problem, statistics)
    assert said == []


@pytest.mark.slow
@pytest.mark.parametrize("method", [None, SWARM], ids=["accelerated", "swarm"])
@pytest.mark.parametrize("name", ZOO)
def test_no_confident_wrong_word_of_twenty_seeds(name: str, method: dict[str, Any] | None) -> None:
    """Besides, no more intervals miss the truth than 95 % intervals of each parameter may (1e-3)."""
    judged = [judge_seed(name, seed, method) for seed in range(20)]
    assert [words for found, _ in judged for words in found] == []
    parameters = len(ZOO[name].truth or {})
    assert sum(missed for _, missed in judged) <= binom.ppf(0.999, 20, 0.05 * max(parameters, 1))


@pytest.mark.slow
@pytest.mark.parametrize("name", ALIKE)
def test_a_parameter_with_several_values_is_identified_within_one_basin_at_most(name: str) -> None:
    """In four seeds; where the other solution was not met, the verdict says in how much of the space one could hide."""
    animal, said = ALIKE[name], []
    for seed in range(4):
        problem = animal.make(np.random.default_rng([seed, len(name)]).standard_normal(animal.points), None)
        statistics = report_of_result(problem, calibrate(problem, seed=seed)).statistics
        assert statistics is not None
        said += [v for v in statistics.verdicts if v.parameter in animal.never and v.kind in CONFIDENT]
    assert [verdict.sentence for verdict in said if not verdict.evidence.sparse] == []
