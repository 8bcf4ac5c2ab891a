"""A search method of another package acts for the service in a process apart, which it may end."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from geoswarm.solver.problem import Problem
from geoswarm.workers.agents import method_process
from geoswarm.workers.agents.desk import AgentDesk
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.integration.engines import wait_for
from tests.variants import variants
from tests.workers.problems import expected_history, line, recorded_history
from tests.workers.test_agents import ByHand

pytestmark = [
    pytest.mark.usefixtures("misbehaving_models"),
    pytest.mark.parametrize("database_url", variants(["sqlite", "postgresql"], {"postgresql"}), indirect=True),
]


@pytest.fixture
def desk(store: Store, settings: Settings) -> AgentDesk:
    return AgentDesk(store, NoWaker(), settings)


def grid(**changes: Any) -> Problem:
    return line(method={"kind": "grid", "levels": 3, **changes}, stopping={})


def work(agent: ByHand) -> None:
    """Make all runs that the agent is leased."""
    grant = agent.lease()
    while grant is not None:
        grant = agent.bring(grant, slot=0)[1]


def test_it_makes_the_same_history(desk: AgentDesk, service: JobService) -> None:
    problem = grid()
    job_id = service.submit(problem)[0].id
    work(ByHand(desk))
    job = service.get(job_id)
    assert (job.state, job.evaluations, job.generations) == ("finished", 9, 3)
    assert recorded_history(service, job_id) == expected_history(problem)


@pytest.mark.parametrize(
    ("fault", "limit", "ended"),
    variants(
        [
            ("exit", 240.0, "ended its process (exit status 0)"),
            ("hang", 3.0, "did not return within 3 s, and its process was killed"),
        ],
        {"hang"},
    ),
)
def test_a_method_that_ends_or_blocks_its_process_fails_its_job_alone(
    fault: str, limit: float, ended: str, desk: AgentDesk, service: JobService, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(method_process, "LIMIT_SECONDS", limit)
    fatal = service.submit(grid(fault=fault))[0].id
    innocent = service.submit(line(stopping={"max_evaluations": 12}))[0].id
    work(ByHand(desk))
    assert service.get(fatal).error == f"BuildError: method 'grid' {ended}; mend the package that it is from"
    assert service.get(innocent).state == "finished"


def test_meanwhile_others_are_served_and_a_service_that_ends_does_not_wait(
    desk: AgentDesk, service: JobService
) -> None:
    hanging = service.submit(grid(fault="hang"))[0].id
    waiting = threading.Thread(target=work, args=(ByHand(desk, "one"),))
    waiting.start()
    wait_for(lambda: sum(run.state == "finished" for run in service.iterate_evaluations(hanging)) == 6, "6 runs")
    wait_for(desk._methods._lock.locked, "the method to act")
    innocent = service.submit(line(stopping={"max_evaluations": 12}))[0].id
    work(ByHand(desk, "other"))
    assert (service.get(innocent).state, service.get(hanging).state) == ("finished", "running")
    desk.close()
    waiting.join()
    assert service.get(hanging).state == "running"
