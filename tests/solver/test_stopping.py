from __future__ import annotations

import pytest

from geoswarm.solver.progress.stopping import (
    MaxEvaluations,
    MaxSeconds,
    StagnationGenerations,
    StopCriterion,
    SwarmStatus,
    TargetObjective,
    satisfied_reasons,
)


def status(
    evaluations: int = 10,
    next_evaluations: int = 10,
    seconds: float = 1.0,
    objective: float | None = 1.0,
    stagnation: int = 0,
) -> SwarmStatus:
    return SwarmStatus(evaluations, next_evaluations, seconds, objective, stagnation)


@pytest.mark.parametrize(
    ("criterion", "no", "yes"),
    [
        (MaxEvaluations(30), status(evaluations=20), status(evaluations=30)),
        (MaxEvaluations(25), status(evaluations=10), status(evaluations=20)),  # the next ten would exceed 25
        (MaxSeconds(2.0), status(seconds=1.99), status(seconds=2.0)),
        (TargetObjective(0.5), status(objective=0.51), status(objective=0.5)),
        (TargetObjective(0.5), status(objective=None), status(objective=0.0)),
        (StagnationGenerations(5), status(stagnation=4), status(stagnation=5)),
    ],
)
def test_criterion(criterion: StopCriterion, no: SwarmStatus, yes: SwarmStatus) -> None:
    assert not criterion.satisfied(no)
    assert criterion.satisfied(yes)


def test_all_satisfied_reasons_are_reported() -> None:
    criteria = [TargetObjective(0.5), MaxEvaluations(10), MaxSeconds(60.0), StagnationGenerations(3)]
    assert satisfied_reasons(criteria, status(objective=0.1, stagnation=9)) == (
        "target_objective",
        "max_evaluations",
        "stagnation_generations",
    )
    assert satisfied_reasons(criteria, status(evaluations=0, next_evaluations=10)) == ()
