"""Two generations under way at once, with real workers whose runs differ in length."""

from __future__ import annotations

import os
import signal
from typing import Any

import pytest

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.integration.engines import STEADY, celery_workers, wait_for, wait_until_ended
from tests.workers.problems import expected_history, recorded_history

pytestmark = pytest.mark.usefixtures("misbehaving_models")


def uneven(seconds: float, **changes: Any) -> Problem:
    """A line of which a third of the runs take four times as long as the others."""
    return parse_problem(
        {
            "forward_model": {"kind": "misbehaving", "behaviour": "uneven", "seconds": seconds, "above": -9},
            "parameters": {"slope": {"lower": -8, "upper": 8}},
            "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0.1, 1, 2.2]}}],
            "method": {"kind": "particle_swarm", "particles": 5, "overlap": True},
            "stopping": {"max_evaluations": 50},
            "seed": 3,
        }
        | changes
    )


def share_used(service: JobService, job: str, slots: int) -> float:
    """Share of the slots' time that runs took, from the first begun to the last begun."""
    runs = list(service.iterate_evaluations(job))
    times = [(e.started_at.timestamp(), e.finished_at.timestamp()) for e in runs if e.started_at and e.finished_at]
    first, last = min(begun for begun, _ in times), max(begun for begun, _ in times)
    return sum(min(ended, last) - begun for begun, ended in times) / (slots * (last - first))


def overlaps(service: JobService, job: str) -> int:
    """Number of runs that were begun before the last run of the generation before theirs had ended."""
    runs = list(service.iterate_evaluations(job))
    ends: dict[int, float] = {}
    for e in runs:
        assert e.finished_at is not None
        ends[e.generation] = max(ends.get(e.generation, 0.0), e.finished_at.timestamp())
    return sum(e.generation > 0 and e.started_at.timestamp() < ends[e.generation - 1] for e in runs if e.started_at)


@pytest.mark.slow
def test_embedded_workers_begin_runs_of_the_next_generation(settings: Settings) -> None:
    problem = uneven(0.1)
    with open_engine(settings) as engine:
        job = engine.service.submit(problem)[0].id
        assert wait_until_ended(engine.service, job).state == "finished"
        assert overlaps(engine.service, job) > 0
        assert recorded_history(engine.service, job) == expected_history(problem)


@pytest.fixture
def settings(tmp_path: Any) -> Settings:
    return Settings(database_url=f"sqlite:///{tmp_path / 'jobs.db'}", workers=3, **STEADY)


@pytest.mark.slow
def test_celery_workers_do_so_and_kills_change_nothing(fresh_postgres_url: str, fresh_redis_url: str) -> None:
    celery = Settings(database_url=fresh_postgres_url, broker_url=fresh_redis_url, **STEADY)
    problem = uneven(0.1, stopping={"max_evaluations": 120}, failures={"retry": {"worker_lost": 100}})
    with open_engine(celery) as engine, celery_workers(celery, count=4) as processes:
        service = engine.service
        wait_for(lambda: len(service.workers()) == 4, "four workers")
        job = service.submit(problem)[0].id
        for killed, generations in enumerate((4, 9)):
            wait_for(lambda n=generations: service.get(job).generations >= n, "progress")  # type: ignore[misc]
            os.kill(processes[killed].pid, signal.SIGKILL)
        assert wait_until_ended(service, job).state == "finished"
        assert overlaps(service, job) > 0
        assert recorded_history(service, job) == expected_history(problem)
