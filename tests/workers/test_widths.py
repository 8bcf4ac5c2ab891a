"""Generations whose size follows the workers, and two generations under way at once: histories as in process."""

from __future__ import annotations

import random
from typing import Any

import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.forward.formula import FormulaSpec
from geoswarm.solver.methods.widths import Situation
from geoswarm.solver.problem import Problem, Stopping
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.queries.jobs import lock_job
from geoswarm.workers.queries.workers import forget_worker, see_worker
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import unpack_json
from tests.workers.conftest import MakeWorker
from tests.workers.hand import Hand, runtime_for
from tests.workers.problems import course, expected_history, line, recorded_history

NAMES = ("w0", "w1", "w2", "w3")


def curved(**changes: Any) -> Problem:
    """A curve that is not linear in one of its parameters, for an accelerated search."""
    xs = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0]
    return line(
        forward_model={"kind": "formula", "series": {"y": "a * exp(-b * x)"}},
        parameters={"a": {"lower": 0, "upper": 10}, "b": {"lower": 0, "upper": 5}},
        observations=[{"series": "y", "points": {"x": xs, "y": [4.2, 2.9, 1.7, 1.2, 0.8, 0.2]}}],
        **({"method": {"kind": "particle_swarm", "particles": 4, "overlap": True}} | changes),
    )


def serve_in_any_order(
    store: Store, settings: Settings, service: JobService, problem: Problem, order: int, *, kills: bool
) -> tuple[str, int]:
    """Let four workers hand in at random, some killed; return the job and how often two generations were out."""
    runtime = runtime_for(store, settings, cheap_seconds=0.0, single_seconds=0.0)
    job, made, chance = service.submit(problem)[0].id, course(problem), random.Random(order)
    hands = [Hand(runtime, job, name, made) for name in NAMES]
    both = 0
    while service.get(job).state in ("queued", "running"):
        hand = chance.choice(hands)
        if hand.claim is None:
            hand.take()
        elif kills and chance.random() < 0.1:
            runtime.expire(job, hand.claim.generation, [hand.name])
            hand.claim = None
        else:
            hand.submit(want=chance.random() < 0.7)
        both += len({h.claim.generation for h in hands if h.claim is not None}) == 2
    return job, both


@pytest.mark.parametrize("stopping", [{"max_evaluations": 42}, {"max_evaluations": 200, "stagnation_generations": 4}])
@pytest.mark.parametrize(
    ("database_url", "order"),
    [("sqlite", 1), pytest.param("sqlite", 2, marks=pytest.mark.slow), ("postgresql", 1)],
    indirect=["database_url"],
)
def test_two_generations_are_out_and_any_order_gives_the_history_of_a_run_in_process(
    store: Store, settings: Settings, service: JobService, stopping: dict[str, int], order: int
) -> None:
    problem = curved(stopping=stopping, failures={"retry": {"worker_lost": 1000}})
    job, both = serve_in_any_order(store, settings, service, problem, order, kills=True)
    assert both > 5
    assert recorded_history(service, job) == expected_history(problem)
    view = service.get(job)
    assert view.state == "finished"
    assert view.evaluations == len(recorded_history(service, job)) <= stopping["max_evaluations"]


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_what_was_out_when_a_job_ended_is_begun_anew_when_it_goes_on(
    store: Store, settings: Settings, service: JobService
) -> None:
    problem = curved(stopping={"max_evaluations": 200, "target_objective": 1.0})
    job, _ = serve_in_any_order(store, settings, service, problem, 1, kills=False)
    found = recorded_history(service, job)
    assert found == expected_history(problem)
    assert service.get(job).stop_reasons == ["target_objective"]
    service.change_stopping(job, Stopping(max_evaluations=len(found) + 16))
    hand = Hand(runtime_for(store, settings), job, "w0", course(problem))
    while service.get(job).state == "running":
        hand.submit() if hand.claim else hand.take()
    longer = expected_history(curved(stopping={"max_evaluations": len(found) + 16}))
    assert recorded_history(service, job) == longer


def progress_of(store: Store, job: str) -> Progress:
    def read(connection: Any) -> Progress:
        locked = lock_job(connection, job)
        assert locked is not None
        return Progress.from_json(unpack_json(locked.row.progress))

    return store.write(read)


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_generations_follow_the_workers_and_what_was_recorded_gives_the_same_history(
    service: JobService, store: Store, make_worker: MakeWorker, settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FormulaSpec, "quick", False)
    problem = curved(method={"kind": "particle_swarm", "particles": "auto"}, stopping={"max_evaluations": 30})
    job, crew = service.submit(problem)[0].id, [make_worker() for _ in range(4)]
    store.write(lambda connection: see_worker(connection, crew[0].identity))
    hand = Hand(runtime_for(store, settings), job, crew[0].identity.id, course(problem))
    while service.get(job).state in ("queued", "running"):
        begun = service.get(job).generations
        for worker in crew[1:]:
            if begun in (2, 3):
                store.write(lambda connection, worker=worker: see_worker(connection, worker.identity))  # type: ignore[misc]
            else:
                store.write(lambda connection, worker=worker: forget_worker(connection, worker.identity.id))  # type: ignore[misc]
        hand.submit() if hand.claim else hand.take()
    found = recorded_history(service, job)
    sizes = [sum(row[0] == g for row in found) for g in range(service.get(job).generations)]
    assert sizes[:3] == [1, 1, 1]
    assert 4 in sizes
    assert sum(sizes) == 30
    assert [n for n, _, count in progress_of(store, job).widths for _ in range(count)][: len(sizes)] == sizes
    widths = iter(sizes[1:])
    again = calibrate(problem, situations=lambda seen, g: Situation(1 if g < 0 else next(widths, 1), seen.lengths))
    assert [(r.generation, r.particle, tuple(r.evaluation.parameters.tolist())) for r in again.history] == [
        row[:3] for row in found
    ]


def test_a_generation_is_as_large_as_workers_and_licences_allow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FormulaSpec, "quick", False)
    problem = curved(method={"kind": "particle_swarm", "particles": "auto"})
    assert [len(Course(Calibration(problem, 1)).start(slots).positions) for slots in (1, 3, 17)] == [1, 3, 17]
    monkeypatch.setattr(FormulaSpec, "slots", 2, raising=False)
    assert problem.forward_model.at_once(8) == 2
    assert problem.forward_model.at_once(8, machines=3) == 6
    monkeypatch.setattr(FormulaSpec, "quick", True)
    assert [len(Course(Calibration(problem, 1)).start(slots).positions) for slots in (1, 3, 17)] == [10, 10, 17]
