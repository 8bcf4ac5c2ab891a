"""Differential evolution: what Storn and Price say of it, and that it goes on bit for bit alike."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
from scipy import optimize

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.search.differential_evolution import DifferentialEvolution, EvolutionSettings
from geoswarm.solver.search.space import SearchSpace
from tests.solver.problems import decay_document
from tests.solver.test_local import bits


def box(dimension: int, half: float, feasible: bool = True) -> SearchSpace:
    log = np.zeros(dimension, dtype=bool)
    names = tuple(f"x{i}" for i in range(dimension))
    limit = (lambda x: float(x.sum()) >= 0.0) if feasible is not True else (lambda _: True)
    return SearchSpace(names, np.full(dimension, -half), np.full(dimension, half), log, limit)


FUNCTIONS = {
    "sphere": (3, 5.12, lambda x: float(x @ x), EvolutionSettings(15, 0.7, 0.5)),
    "saddle": (2, 2.048, lambda x: float(100 * (x[0] ** 2 - x[1]) ** 2 + (1 - x[0]) ** 2), EvolutionSettings(20, 0.8)),
}


def ours(space: SearchSpace, function: Callable[[FloatArray], float], settings: EvolutionSettings, seed: int) -> int:
    """Evaluations until the objective is below 1e-6."""
    search = DifferentialEvolution(space, settings, seed)
    for count in range(1, 1000):
        objectives = np.array([function(x) for x in search.ask()])
        if objectives.min() <= 1e-6:
            return count * settings.members
        search.tell(objectives)
    raise AssertionError("not reached")


def theirs(space: SearchSpace, function: Callable[[FloatArray], float], settings: EvolutionSettings, seed: int) -> int:
    """The same with SciPy."""
    found = optimize.differential_evolution(
        function,
        list(zip(space.lower, space.upper, strict=True)),
        strategy="rand1bin",
        popsize=settings.members // space.dimension,
        mutation=settings.weight,
        recombination=settings.crossover,
        init="random",
        updating="deferred",
        polish=False,
        tol=0.0,
        maxiter=1000,
        rng=seed,
        callback=lambda intermediate_result: intermediate_result.fun <= 1e-6,
    )
    return int(found.nfev)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_it_needs_as_many_evaluations_as_another_implementation(name: str) -> None:
    dimension, half, function, settings = FUNCTIONS[name]
    space = box(dimension, half)
    counts = np.array([[count(space, function, settings, seed) for count in (ours, theirs)] for seed in range(11)])
    mine, other = np.median(counts, axis=0)
    assert 0.75 < mine / other < 1.33


def test_proposals_stay_inside_and_feasible() -> None:
    space = box(4, 1.0, feasible=False)
    search = DifferentialEvolution(space, EvolutionSettings(12, 0.9, 0.9), seed=2)
    for _ in range(30):
        positions = search.ask()
        assert (np.abs(positions) <= 1.0).all()
        assert (positions.sum(axis=1) >= 0.0).all()
        search.tell(np.array([float(((x - 0.9) ** 2).sum()) for x in positions]))


def test_a_snapshot_goes_on_bit_for_bit() -> None:
    problem = parse_problem(
        decay_document(method={"kind": "differential_evolution"}, stopping={"max_evaluations": 200})
    )
    whole = calibrate(problem, seed=3)
    assert whole.evaluations == 200
    progress = Course(Calibration(problem, 3)).start()
    for generation in range(whole.generations - 1):
        objectives = [r.evaluation.objective for r in whole.history if r.generation == generation]
        progress = type(progress).from_json(json.loads(json.dumps(progress.to_json())))
        progress = Course(Calibration(problem, 3)).advance(progress, objectives, 0.0, criteria=()).progress
        expected = [r.evaluation.parameters for r in whole.history if r.generation == generation + 1]
        assert progress.positions.tobytes() == np.array(expected).tobytes()
    assert bits(calibrate(problem, seed=3)) == bits(whole)
    assert bits(calibrate(problem, seed=4)) != bits(whole)


def test_it_finds_the_parameters_of_exact_data() -> None:
    method = {"kind": "differential_evolution", "members": 20}
    result = calibrate(parse_problem(decay_document(method=method, stopping={"max_evaluations": 1500})), seed=3)
    assert result.parameters == {"amplitude": pytest.approx(3.0, rel=1e-3), "rate": pytest.approx(0.7, rel=1e-3)}


def test_a_generation_must_fit() -> None:
    method = {"kind": "differential_evolution", "members": 20}
    with pytest.raises(ProblemError, match=r"must be at least the number of members \(20\), got 10"):
        parse_problem(decay_document(method=method, stopping={"max_evaluations": 10}))
    with pytest.raises(ProblemError, match="a differential evolution needs at least one criterion"):
        parse_problem(decay_document(method=method, stopping={}))
