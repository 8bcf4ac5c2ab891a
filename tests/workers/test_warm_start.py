"""Jobs that learn from earlier ones, and runs that are not made twice, in the service as in process."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from sqlalchemy import select, update

from geoswarm.solver.calibration import WarmStartRuns
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.runs.warm_start import EarlierRuns, best_of, forward_model_hash, offer_of
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.queries import offers
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import jobs
from tests.solver.problems import decay_document
from tests.workers.conftest import MakeWorker

AIMED = {"kind": "particle_swarm", "particles": 6}


def document(**changes: Any) -> dict[str, Any]:
    return decay_document(**{"method": AIMED, "stopping": {"max_evaluations": 30}, **changes})


def run(service: JobService, make_worker: MakeWorker, body: dict[str, Any]) -> str:
    job = service.submit(parse_problem(body))[0].id
    worker = make_worker()
    while service.get(job).state in ("queued", "running"):
        worker.serve(job)
    return job


def history(service: JobService, job: str) -> list[tuple[list[float], float | None]]:
    return [(list(e.parameters.values()), e.objective) for e in service.iterate_evaluations(job)]


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_job_learns_from_an_earlier_one_as_a_run_in_process_does(
    service: JobService, make_worker: MakeWorker
) -> None:
    sampling = document(method={"kind": "monte_carlo", "samples": 40}, stopping=None)
    source = run(service, make_worker, sampling)
    warm = service.submit(parse_problem(document(warm_start={"jobs": [source]})))[0].id
    service.delete(source)  # what it offers is stored with the job
    worker = make_worker()
    worker.serve(warm)
    for _ in range(20):  # other workers, which know nothing of it, go on
        make_worker().serve(warm)
    assert service.get(warm).state == "finished"
    problem, earlier = parse_problem(document()), calibrate(parse_problem(sampling)).history
    runs = EarlierRuns(
        parse_problem(sampling),
        np.array([r.evaluation.parameters for r in earlier]),
        [r.evaluation.responses for r in earlier],
    )
    offer = offer_of(problem, runs)
    assert isinstance(offer, WarmStartRuns)
    expected = calibrate(problem, offer=best_of(problem, [offer]))
    assert history(service, warm) == [
        (r.evaluation.parameters.tolist(), r.evaluation.objective) for r in expected.history
    ]


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_a_job_that_is_not_there_or_offers_nothing_is_named(service: JobService, make_worker: MakeWorker) -> None:
    source = run(service, make_worker, document())
    with pytest.raises(ProblemError, match=r"warm_start.jobs\[1\]: there is no job 0123456789abcdef"):
        service.submit(parse_problem(document(warm_start={"jobs": [source, "0123456789abcdef"]})))
    other = {"kind": "formula", "series": {"y": "amplitude * exp(-rate * x / 2)"}}
    with pytest.raises(ProblemError, match="has another forward model"):
        service.submit(parse_problem(document(forward_model=other, warm_start={"jobs": [source]})))
    stranger = service.on_behalf_of(Principal("alice", "submit"))
    with pytest.raises(ProblemError, match="there is no job"):
        stranger.submit(parse_problem(document(warm_start={"jobs": [source]})))


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_earlier_jobs_that_would_help_are_named(service: JobService, make_worker: MakeWorker) -> None:
    problem = parse_problem(document())
    assert service.warm_starts(problem) == []
    older = run(service, make_worker, document(name="older", stopping={"max_evaluations": 12}))
    newer = run(service, make_worker, document(name="newer", stopping={"max_evaluations": 24}))
    other = {"kind": "formula", "series": {"y": "amplitude * exp(-rate * x / 2)"}}
    run(service, make_worker, document(forward_model=other))
    service.submit(problem)  # nothing calculated yet
    assert [(w.job, w.name, w.evaluations) for w in service.warm_starts(problem)] == [
        (newer, "newer", 24),
        (older, "older", 12),
    ]
    assert service.submit(parse_problem(document(warm_start={"jobs": [newer, older]})))[1]
    assert service.on_behalf_of(Principal("alice", "submit")).warm_starts(problem) == []
    assert service.warm_starts(parse_problem(document(warm_start={"jobs": [older]}))) == []
    plain = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
    assert service.warm_starts(parse_problem(document(method=plain))) == []


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_the_same_parameters_are_run_once(service: JobService, make_worker: MakeWorker) -> None:
    whole = {"lower": 1, "upper": 4, "integer": True}
    body = document(parameters={"amplitude": whole, "rate": whole}, stopping={"max_evaluations": 48})
    job = run(service, make_worker, body)
    evaluations = list(service.iterate_evaluations(job))
    made = [tuple(e.parameters.values()) for e in evaluations if e.seconds]
    assert len(made) == len(set(made)) == 16
    expected = calibrate(parse_problem(body))
    assert history(service, job) == [
        (r.evaluation.parameters.tolist(), r.evaluation.objective) for r in expected.history
    ]


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_documents_of_earlier_jobs_are_not_read_again_for_each_question(
    service: JobService, make_worker: MakeWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    sampling = document(method={"kind": "monte_carlo", "samples": 10}, stopping=None)
    source = run(service, make_worker, sampling)
    other = document(method={"kind": "monte_carlo", "samples": 10}, stopping=None)
    other["forward_model"] = {"kind": "formula", "series": {"y": "0.5 * amplitude * exp(-rate * x)"}}
    different = run(service, make_worker, other)
    read: list[str] = []
    stored_problem = offers._stored_problem

    def count(store: Store, job_id: str) -> Problem:
        read.append(job_id)
        return stored_problem(store, job_id)

    monkeypatch.setattr(offers, "_stored_problem", count)
    problem = parse_problem(document())
    for _ in range(3):
        (found,) = service.warm_starts(problem)
        assert (found.job, found.evaluations) == (source, 10)
    assert read == [source]
    read.clear()
    with pytest.raises(ProblemError, match="has another forward model"):
        service.submit(parse_problem(document(warm_start={"jobs": [different]})))
    assert not read


@pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
def test_jobs_from_before_the_hash_are_looked_at_once(service: JobService, make_worker: MakeWorker) -> None:
    source = run(service, make_worker, document(method={"kind": "monte_carlo", "samples": 10}, stopping=None))
    problem = parse_problem(document())

    def stored() -> str | None:
        return service.store.read(lambda c: c.scalar(select(jobs.c.forward_hash).where(jobs.c.id == source)))

    assert stored() == forward_model_hash(problem)
    service.store.write(lambda c: c.execute(update(jobs).values(forward_hash=None)))
    (found,) = service.warm_starts(problem)
    assert found.job == source
    assert stored() == forward_model_hash(problem)
