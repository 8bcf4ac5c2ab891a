"""Agents at the desk: leases by what they have announced, results once, the same history as from any worker."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sqlalchemy import update

from geoswarm.records.states import ENDED_STATES
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.objective import ObservedSeries
from geoswarm.solver.objective.outcome import Calculation
from geoswarm.solver.problem import Problem
from geoswarm.solver.system.versions import versions
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.agents.desk import AgentDesk
from geoswarm.workers.agents.prepared import needs_of
from geoswarm.workers.agents.work import Announcement, BroughtRun, Grant, Wanted
from geoswarm.workers.errors import LeaseOverError, QuotaExceededError, UnknownAgentError
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import workers
from geoswarm.workers.waker import NoWaker
from tests.workers.conftest import ON_SQLITE, MakeWorker
from tests.workers.problems import expected_history, line, predicted_tests, recorded_history

SHORT = line(stopping={"max_evaluations": 60})


class ByHand:
    """An agent whose every step is told: it calculates from what it was leased alone."""

    keeps_parts = True  # agents of earlier versions do not

    def __init__(self, desk: AgentDesk, name: str = "hand", key: str = "", kinds: Sequence[str] = ("formula",)) -> None:
        self.desk, self.name, self.key = desk, name, key
        self.accepted = self.announce(kinds)

    def announce(self, kinds: Sequence[str], **changes: Any) -> tuple[str, ...]:
        given = {"slots": 2, "versions": dict(versions()), "models": {}} | changes
        told = Announcement(self.name, "host", "Linux", 1, kinds=kinds, **given)
        return self.desk.announce(self.key, told).accepted

    def lease(self, slot: int = 0, runs: int = 100, seconds: float | None = None) -> Grant | None:
        return self.desk.lease(self.key, Wanted(self.name, slot, runs, seconds))

    def made(self, grant: Grant) -> list[BroughtRun]:
        assert grant.shared is not None
        points = {name: np.array(x) for name, x in grant.shared["points"].items()}
        run = built(parse_spec(grant.shared["forward_model"])).prepare(points)
        series = [ObservedSeries(name, x, np.zeros(x.shape), np.ones(x.shape), 1.0) for name, x in points.items()]
        calculation = Calculation(run, series, keeps_parts=self.keeps_parts and grant.shared["keeps_parts"])
        brought = []
        for one in grant.runs:
            found = calculation.outcome(one.values)
            responses = {name: values.tolist() for name, values in found.responses.items()}
            brought.append(
                BroughtRun(one.particle, one.attempt, responses, found.reason, found.message, None, 0.01, 0.0, 0.01)
            )
        return brought

    def bring(self, grant: Grant, runs: Sequence[BroughtRun] | None = None, slot: int | None = None) -> Any:
        wanted = None if slot is None else Wanted(self.name, slot, 100)
        return self.desk.submit(self.key, grant.id, self.made(grant) if runs is None else runs, None, wanted)

    def work(self) -> None:
        grant = self.lease()
        assert grant is not None
        while grant is not None:
            taken, grant = self.bring(grant, slot=0)
            assert taken


@pytest.fixture
def desk(store: Store, settings: Settings) -> AgentDesk:
    return AgentDesk(store, NoWaker(), settings)


def submitted(service: JobService, problem: Problem = SHORT) -> str:
    return service.submit(problem)[0].id


def test_an_agent_alone_makes_the_same_history(desk: AgentDesk, service: JobService) -> None:
    job_id, agent = submitted(service), ByHand(desk)
    agent.work()
    assert service.get(job_id).state == "finished"
    assert recorded_history(service, job_id) == expected_history(SHORT)


@pytest.mark.parametrize("fragile", ["a + ln(b - 0.35)", "ln(-1 - b**2)"], ids=["in some", "in all"])
def test_draws_of_which_one_test_fails_are_the_same_from_agents_and_workers(
    desk: AgentDesk, service: JobService, make_worker: MakeWorker, fragile: str
) -> None:
    """Agents kept nothing of such a draw; and a job with a test that failed in every draw had failed."""
    problem = predicted_tests(fragile)
    expected = expected_history(problem)
    assert {"sound.y"} in [set(responses) for *_, responses in expected]
    by_worker, agent = submitted(service, problem), ByHand(desk, kinds=("combined", "formula"))
    worker = make_worker()
    worker.start()
    worker.serve(by_worker)
    worker.close()
    by_agent = submitted(service, problem)
    agent.work()
    for job_id in (by_worker, by_agent):
        job = service.get(job_id)
        assert (job.state, job.error, job.failed_evaluations) == ("finished", None, 13 if "-1" in fragile else 5)
        assert recorded_history(service, job_id) == expected


@ON_SQLITE
def test_an_agent_that_brings_nothing_of_a_failed_draw(desk: AgentDesk, service: JobService) -> None:
    job_id, agent = submitted(service, predicted_tests("a + ln(b - 0.35)")), ByHand(desk, kinds=("combined", "formula"))
    agent.keeps_parts = False
    agent.work()
    assert service.get(job_id).state == "finished"
    assert [len(responses) for *_, responses in recorded_history(service, job_id)] == [0] * 5 + [2] * 8
    other = submitted(service, predicted_tests("ln(-1 - b**2)"))
    agent.work()
    assert service.get(other).state == "failed"


@ON_SQLITE
@pytest.mark.parametrize("wrong", [{"sound.y": [1.0]}, {"sound.y": [1.0, math.nan]}, {"other.y": [1.0, 2.0]}])
def test_wrong_responses_of_a_failed_draw_are_left_out(
    desk: AgentDesk, service: JobService, wrong: dict[str, list[float]]
) -> None:
    job_id, agent = submitted(service, predicted_tests("a")), ByHand(desk, kinds=("combined", "formula"))
    grant = agent.lease()
    assert grant is not None
    first, *others = agent.made(grant)
    agent.bring(grant, [replace(first, responses=wrong, reason="diverged", message="it says so"), *others])
    found = service.evaluation(job_id, 0, 0)
    assert (found.reason, found.message, found.responses) == ("diverged", "it says so", None)


def test_agents_and_workers_mixed_make_the_same_history(
    desk: AgentDesk, service: JobService, make_worker: MakeWorker
) -> None:
    job_id, agent = submitted(service), ByHand(desk)
    worker = make_worker(slice_seconds=0.01, local_batch_seconds=0.0, cheap_seconds=0.0, single_seconds=0.0)
    worker.start()
    by: set[str | None] = set()
    while service.get(job_id).state not in ENDED_STATES:
        grant = agent.lease(runs=1)
        worker.serve(job_id)
        if grant is not None:
            agent.bring(grant)
    worker.close()
    for number in range(10):
        by |= {attempt.worker for attempt in service.attempts(job_id, number, 0)}
        by |= {attempt.worker for attempt in service.attempts(job_id, number, 1)}
    assert any(name is not None and name.startswith("hand/") for name in by)
    assert worker.identity.id in by
    assert recorded_history(service, job_id) == expected_history(SHORT)


@ON_SQLITE
def test_an_agent_sees_parameters_and_points_only(desk: AgentDesk, service: JobService) -> None:
    problem = line(name="a secret name", observations=[{"series": "y", "points": {"x": [0, 1], "y": [17.25, 31.5]}}])
    job_id, agent = submitted(service, problem), ByHand(desk)
    grant = agent.lease()
    assert grant is not None
    assert grant.shared is not None
    assert grant.job == job_id
    assert set(grant.shared) == {"forward_model", "points", "inputs", "limits", "keeps_parts"}
    assert grant.shared["points"] == {"y": [0.0, 1.0]}
    assert set(grant.runs[0].values) == {"a", "b"}
    told = json.dumps([grant.shared, [dict(run.values) for run in grant.runs]])
    assert all(hidden not in told for hidden in ("17.25", "31.5", "secret", "observations", "owner"))


def test_results_count_once(desk: AgentDesk, service: JobService) -> None:
    job_id, agent = submitted(service), ByHand(desk)
    grant = agent.lease()
    assert grant is not None
    runs = agent.made(grant)
    assert agent.bring(grant, runs) == (True, None)
    before = service.evaluations(job_id).items
    assert agent.bring(grant, runs) == (False, None)
    assert service.evaluations(job_id).items == before
    assert [attempt.outcome for attempt in service.attempts(job_id, 0, 0)] == ["finished"]


def test_nobody_brings_results_for_what_was_not_leased_to_the_key(desk: AgentDesk, service: JobService) -> None:
    submitted(service)
    agent, other = ByHand(desk), ByHand(desk, "other", key="abcdefabcdef")
    grant = agent.lease()
    assert grant is not None
    with pytest.raises(LeaseOverError):
        other.bring(grant)
    with pytest.raises(LeaseOverError):
        desk.beat(other.key, grant.id)
    with pytest.raises(UnknownAgentError):
        desk.lease(other.key, Wanted(agent.name, 0, 1))
    with pytest.raises(UnknownAgentError):
        ByHand(desk, agent.name, key="abcdefabcdef")


@ON_SQLITE
def test_runs_of_other_particles_and_tries_are_left_out(desk: AgentDesk, service: JobService) -> None:
    job_id, agent = submitted(service), ByHand(desk)
    grant = agent.lease(runs=1)
    assert grant is not None
    run = agent.made(grant)[0]
    others = [
        BroughtRun(particle, attempt, run.responses, None, None, None, 0.0, 0.0, 0.0)
        for particle, attempt in ((run.particle + 1, 1), (run.particle, 9))
    ]
    assert agent.bring(grant, others) == (True, None)
    assert [e.state for e in service.evaluations(job_id).items] == ["pending"] * 6


@ON_SQLITE
def test_wrong_responses_are_failures(desk: AgentDesk, service: JobService) -> None:
    job_id, agent = submitted(service), ByHand(desk)
    wrong: dict[str, Any] = {"y": [1.0, 2.0]}, {}, {"y": [1e200] * 4}
    for responses in wrong:
        grant = agent.lease(runs=1)
        assert grant is not None
        run = grant.runs[0]
        agent.bring(grant, [BroughtRun(run.particle, run.attempt, responses, None, None, None, 0.0, 0.0, 0.0)])
    assert [e.reason for e in service.evaluations(job_id).items][:3] == ["bad_output", "bad_output", "not_finite"]


def test_only_what_was_announced_is_leased(desk: AgentDesk, service: JobService) -> None:
    submitted(service)
    agent = ByHand(desk, kinds=("oedometer",))
    assert agent.lease() is None
    older = dict(versions()) | {"geoswarm": "0.0.1"}
    assert agent.announce(["formula"], versions=older) == ()  # other numbers
    assert agent.lease() is None
    assert agent.announce(["formula", "nonsense"], models={"m": "0" * 64}) == ("formula", f"registered:m:{'0' * 64}")
    assert agent.lease() is not None


def test_needs_name_kinds_and_registered_versions() -> None:
    assert needs_of(SHORT.forward_model) == "formula"
    combined = line(
        forward_model={
            "kind": "combined",
            "parts": {"p": {"kind": "formula", "series": {"y": "a * x + b"}}},
        },
        observations=[{"series": "p.y", "points": {"x": [0, 1], "y": [1, 3]}}],
    )
    assert needs_of(combined.forward_model) == "combined formula"


@ON_SQLITE
def test_what_cannot_end_in_time_is_not_leased(desk: AgentDesk, service: JobService) -> None:
    submitted(service)
    agent = ByHand(desk)
    first = agent.lease(runs=1)  # what a run takes is not known yet
    assert first is not None
    run = agent.made(first)[0]
    taken = BroughtRun(run.particle, 1, run.responses, None, None, None, 5.0, 0.0, 5.0)
    agent.bring(first, [taken])
    following = agent.lease(runs=1)
    assert following is not None
    agent.bring(following, [])
    # A generation must end before the job's typical time is written; within it the exchange knows.
    assert following.typical == 5.0


def test_a_job_that_is_not_wanted_ends_its_leases(desk: AgentDesk, service: JobService) -> None:
    job_id, agent = submitted(service), ByHand(desk)
    first = agent.lease(runs=1)
    assert first is not None
    agent.bring(first)  # what a run takes is known now: several go out together
    grant = agent.lease(runs=2)
    assert grant is not None
    desk.beat("", grant.id)
    service.pause(job_id)
    with pytest.raises(LeaseOverError, match="its job is paused"):
        desk.beat("", grant.id)
    runs = agent.made(grant)[:1]
    assert desk.submit("", grant.id, runs, grant.runs[1].particle, None) == (True, None)
    with pytest.raises(LeaseOverError, match="it has ended"):
        desk.beat("", grant.id)
    second = service.attempts(job_id, 0, grant.runs[1].particle)
    assert [attempt.outcome for attempt in second] == ["stopped"]
    service.resume(job_id)
    service.cancel(job_id)
    service.delete(job_id)
    with pytest.raises(LeaseOverError):
        agent.bring(grant)


def test_revoking_a_key_ends_its_leases(desk: AgentDesk, service: JobService, store: Store) -> None:
    job_id = submitted(service)
    key, view = ApiKeys(store).create("pc", "agent")
    principal = ApiKeys(store).principal(key)
    assert principal is not None
    assert principal.may("agent")
    assert not any(principal.may(role) for role in ("read", "submit", "admin"))
    agent = ByHand(desk, key=view.id)
    grant = agent.lease(runs=1)
    assert grant is not None
    ApiKeys(store).revoke(view.id)
    Sweeper(desk._runtime, NoWaker()).sweep()
    first = service.evaluation(job_id, 0, grant.runs[0].particle)
    assert (first.state, first.attempts) == ("pending", 0)  # no try was counted
    with pytest.raises(LeaseOverError):
        desk.beat(view.id, grant.id)
    assert agent.bring(grant) == (False, None)
    assert [worker.id for worker in service.workers()] == []


def test_an_agent_that_was_silent_for_hours_is_listed_again(desk: AgentDesk, service: JobService, store: Store) -> None:
    """A network that is cut for longer than lost workers are listed: the agent itself has never ended."""
    submitted(service)
    agent = ByHand(desk)
    grant = agent.lease(runs=1)
    assert grant is not None
    store.write(lambda c: c.execute(update(workers).values(seen_at=0.0, lost_at=0.0)))
    Sweeper(desk._runtime, NoWaker()).sweep()
    assert service.workers() == []
    assert agent.bring(grant, slot=0) == (True, None)  # what it has made meanwhile is accepted
    with pytest.raises(UnknownAgentError):
        agent.lease()
    agent.announce(["formula"])
    assert agent.lease(runs=1) is not None
    assert {worker.id: worker.state for worker in service.workers()} == {"hand/0": "busy", "hand/1": "idle"}


def test_agents_and_leases_of_a_key_are_limited(store: Store, settings: Settings, service: JobService) -> None:
    submitted(service)
    desk = AgentDesk(store, NoWaker(), settings.model_copy(update={"quota_agents": 1, "quota_leases": 1}))
    agent = ByHand(desk)
    with pytest.raises(QuotaExceededError, match="at most 1 are accepted \\(GEOSWARM_QUOTA_AGENTS\\)"):
        ByHand(desk, "second")
    assert agent.lease(runs=1) is not None
    with pytest.raises(QuotaExceededError, match="at most 1 are accepted \\(GEOSWARM_QUOTA_LEASES\\)"):
        agent.lease(slot=1, runs=1)


def test_slots_are_workers_that_tell_what_their_agent_is(desk: AgentDesk, service: JobService) -> None:
    submitted(service)
    agent = ByHand(desk)
    agent.announce(["formula"], models={"footing": "a" * 64})
    agent.lease(slot=1, runs=1)
    found = {worker.id: worker for worker in service.workers()}
    assert {name: worker.state for name, worker in found.items()} == {"hand/0": "idle", "hand/1": "busy"}
    slot = found["hand/1"].agent
    assert slot is not None
    assert (slot.slots, slot.system, slot.version) == (2, "Linux", versions()["geoswarm"])
    assert slot.models == {"footing": "a" * 64}
    agent.announce(["formula"], slots=1)
    assert [worker.id for worker in service.workers()] == ["hand/0"]
    desk.sign_off("", "hand")
    assert service.workers() == []
