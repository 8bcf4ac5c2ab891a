"""An exploration finds the basin that a search has missed, and ends where it has to."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import Linearisation, Samples, StatisticsError, analyse
from geoswarm.solver.identifiability.optimum.hidden import Unseen
from geoswarm.solver.identifiability.remedies import follow_up
from geoswarm.solver.identifiability.stored.exploring import explore_problem
from geoswarm.solver.identifiability.stored.findings import Findings, findings_of
from geoswarm.solver.identifiability.stored.follow_ups import same_question
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.runs.runlog import RunLog
from tests.solver.identifiability.cases import X, free, linearised, problem_of

NOISE = 0.05 * np.random.default_rng(2).standard_normal(X.size)
BEST = [1.7, 4.0]


def missed() -> tuple[Problem, Samples, Linearisation]:
    """a = 1.7 and a = 4.3 fit alike; the stored runs are those below 3."""
    y = 4.0 * np.exp(-0.5 * X) + 1.3**2 * X + NOISE
    problem = problem_of("b * exp(-0.5 * x) + (a - 3)**2 * x", {"a": free(0.1, 5.9), "b": free()}, y)
    places = np.random.default_rng(0).uniform([0.1, 0.1], [3.0, 10.0], (80, 2))
    around = np.array(BEST) + np.random.default_rng(1).uniform(-0.05, 0.05, (40, 2))
    parameters = np.concatenate([places, around])
    calibration = Calibration(problem, 1)
    objectives = [calibration.evaluate(place).objective for place in parameters]
    samples = Samples.from_arrays(problem, parameters, np.array(objectives))
    return problem, samples, linearised(problem, BEST)


def explored(problem: Problem, follow_up: Problem) -> Findings:
    assert same_question(problem, follow_up)
    result = calibrate(follow_up, seed=3)
    return findings_of(follow_up, 3, [record.evaluation for record in result.history])


def test_the_missed_basin_is_found_and_named() -> None:
    problem, samples, found = missed()
    before = analyse(Calibration(problem, 1), samples, linearisation=found)
    assert before.verdict("a").words == "identified within one basin"
    assert before.basins.hidden is not None
    assert 0.2 < before.basins.hidden < 0.5  # of the half that nobody looked at, all but a rim
    assert before.basins.remedies == (follow_up("explore"),)
    for linearisation in (found, None):  # with and without the width of a basin
        findings = explored(problem, explore_problem(problem, samples, linearisation, seed=3, runs=60))
        assert 0 < len(findings.explored) <= 60
        after = analyse(
            Calibration(problem, 1), samples, linearisation=found, elsewhere=findings.explored, left=findings.left
        )
        assert after.verdict("a").kind == "not_identified"
        assert "the data allow both" in after.verdict("a").sentence
        assert "4.3" in after.verdict("a").sentence
        assert after.verdict("b").kind == "identified"
        assert after.basins.hidden is not None
        assert after.basins.hidden < before.basins.hidden


def test_places_are_where_no_run_came_near() -> None:
    problem, samples, found = missed()
    follow_up = explore_problem(problem, samples, found, seed=3, runs=20, of="0123456789abcdef")
    method = follow_up.document()["method"]
    assert method["of"] == "0123456789abcdef"
    a = np.array(method["points"]["a"])
    assert len(a) == 10
    assert (a > 3.0).mean() > 0.7  # the runs left out all of this half
    points = np.column_stack([a, method["points"]["b"]])
    unseen = Unseen.of(samples, found, float(samples.objectives.min()))
    assert np.median(unseen.distances(samples.to_unit(points))) > 1.0


def test_an_exploration_goes_on_from_a_snapshot_bit_for_bit() -> None:
    problem, samples, found = missed()
    follow_up = explore_problem(problem, samples, found, seed=3, runs=60)
    whole = calibrate(follow_up, seed=3)
    method = follow_up.method
    calibration = Calibration(follow_up, 3)
    assert sum(record.evaluation.objective is not None for record in whole.history) <= 60
    search = method.search(calibration.space)  # type: ignore[attr-defined]  # of a follow-up
    log = RunLog(calibration)
    made = [calibration.evaluate(p) for p in search.ask()]
    log.add([one.parameters for one in made], [one.objective for one in made])
    runs = log.runs(lambda keys: [made[particle].responses for _, particle in keys])
    search.tell(np.array([one.objective for one in made]), runs)
    again = method.search(calibration.space, search.snapshot())  # type: ignore[attr-defined]  # of a follow-up
    np.testing.assert_array_equal(search.ask(), again.ask())


def test_descents_side_by_side_go_as_each_goes_alone() -> None:
    y = np.exp(-0.5 * X) * np.cos(2.0 * X) + NOISE
    problem = problem_of("exp(-a * x) * cos(b * x)", {"a": free(0.01, 3.0), "b": free(0.1, 9.0)}, y)
    starts = [(1.0, 4.0), (2.0, 6.5), (0.3, 8.5)]

    def places(points: list[tuple[float, float]]) -> set[tuple[float, ...]]:
        listed = {"a": [a for a, _ in points], "b": [b for _, b in points]}
        method = {"kind": "explore", "at": {"a": 0.5, "b": 2.0}, "points": listed, "runs": 1000}
        result = calibrate(parse_problem(problem.document() | {"method": method, "stopping": {}}), seed=1)
        return {tuple(record.evaluation.parameters.tolist()) for record in result.history}

    alone = [places([start]) for start in starts]
    assert min(map(len, alone)) > 10  # each goes some way
    assert places(starts) == set().union(*alone)


def test_one_run_is_enough_and_none_is_refused() -> None:
    problem, samples, found = missed()
    assert len(explored(problem, explore_problem(problem, samples, found, seed=3, runs=1)).explored) == 1
    with pytest.raises(ProblemError, match=r"method\.runs"):
        explore_problem(problem, samples, found, seed=3, runs=0)
    with pytest.raises(StatisticsError, match="no evaluation has succeeded"):
        explore_problem(problem, samples.select(np.zeros(0, dtype=np.int64)), None, seed=3)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ({"a": [1.0]}, "must name the free parameters a, b"),
        ({"a": [1.0], "b": [1.0, 2.0]}, "the same number of values for each parameter"),
        ({"a": [9.0], "b": [1.0]}, "between the bounds 0.1 and 5.9"),
    ],
)
def test_wrong_points_are_reported(points: dict[str, list[float]], message: str) -> None:
    method = {"kind": "explore", "at": {"a": 1.7, "b": 4.0}, "points": points}
    with pytest.raises(ProblemError, match=message):
        problem_of(
            "b * exp(-0.5 * x) + (a - 3)**2 * x", {"a": free(0.1, 5.9), "b": free()}, X, method=method, stopping={}
        )
