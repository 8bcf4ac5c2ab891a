"""The runtime against real databases, driven step by step from one thread."""

from __future__ import annotations

from functools import cache

import pytest
from hypothesis import HealthCheck, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from sqlalchemy import select, update

from geoswarm.solver.runner.evaluator import InlineEvaluator
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Submission
from geoswarm.workers.execution.claim_runner import ClaimRunner
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import attempts, evaluations, jobs
from tests.workers.conftest import MakeWorker
from tests.workers.hand import LEARNING, PROBLEM, Hand, finish, pass_time, runtime_for
from tests.workers.problems import History, course, expected_history, line, recorded_history

PATIENT = line(method=LEARNING, stopping={"max_evaluations": 60}, failures={"retry": {"worker_lost": 1000}})


@cache
def expected() -> History:
    return expected_history(PROBLEM)


@pytest.fixture
def job_id(service: JobService) -> str:
    return service.submit(PROBLEM)[0].id


def lost_tries(store: Store) -> list[tuple[int, int, str, str]]:
    statement = select(attempts.c.particle, attempts.c.number, attempts.c.worker, attempts.c.outcome)
    return [tuple(row) for row in store.read(lambda c: c.execute(statement.order_by(attempts.c.id)).all())]


def listed(service: JobService, job_id: str) -> list[tuple[int, str | None, str, bool]]:
    """The tries at the first evaluation as the service tells them."""
    return [(t.number, t.worker, t.outcome, t.counted) for t in service.attempts(job_id, 0, 0)]


def test_expensive_or_unknown_runs_go_one_by_one_and_cheap_ones_in_chunks(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    runtime = runtime_for(store, settings)
    hand = Hand(runtime, job_id, "w1")
    hand.take()
    sizes = []
    while hand.claim is not None:
        sizes.append(len(hand.claim.particles))
        hand.submit()
    assert sizes[:3] == [1, 3, 2]  # the first run tells what one costs
    assert set(sizes[3:]) == {3}
    assert recorded_history(service, job_id) == expected()


def test_a_wide_first_generation_learns_only_once_what_a_run_costs(
    store: Store, settings: Settings, service: JobService
) -> None:
    problem = line(method={"kind": "particle_swarm", "particles": 40}, stopping={"max_evaluations": 40})
    job_id = service.submit(problem)[0].id
    hand = Hand(runtime_for(store, settings, single_seconds=0.0), job_id, "w1", course(problem))
    hand.take()
    noted = []
    for _ in range(35):
        noted.append(store.read(lambda c: c.scalar(select(jobs.c.typical_seconds))))
        hand.submit()
    assert noted[:32] == [None] * 32  # each exchange asks what was handed in
    assert noted[32] is not None
    assert set(noted[32:]) == {noted[32]}


def test_the_first_result_counts_and_a_late_one_is_recorded(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    runtime = runtime_for(store, settings)
    slow, fast = Hand(runtime, job_id, "slow"), Hand(runtime, job_id, "fast")
    slow.take()
    assert slow.claim is not None
    late = slow.results()
    assert runtime.expire(job_id, 0, ["slow"]) == 1
    finish(fast)
    assert service.get(job_id).state == "finished"
    assert slow.exchange(late).claim is None
    assert lost_tries(store) == [(0, 1, "slow", "late")]  # it was not lost after all
    assert listed(service, job_id) == [(1, "slow", "late", False), (2, "fast", "finished", True)]
    assert recorded_history(service, job_id) == expected()
    first = service.evaluations(job_id, limit=1).items[0]
    assert (first.worker, first.attempts) == ("fast", 2)


def test_a_result_that_arrives_before_its_second_try_counts(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    runtime = runtime_for(store, settings)
    first, second = Hand(runtime, job_id, "w1"), Hand(runtime, job_id, "w2")
    first.take()
    runtime.expire(job_id, 0, ["w1"])
    second.take()
    assert second.claim is not None
    assert second.claim.particles == (0,)
    assert second.claim.attempts == (2,)
    once = first.results()
    for _ in range(2):  # the answer to the first was lost
        first.exchange(once, want=False)
        assert listed(service, job_id) == [(2, "w2", "superseded", False), (1, "w1", "finished", True)]
    second.submit()
    assert listed(service, job_id) == [(2, "w2", "late", False), (1, "w1", "finished", True)]
    finish(second)
    assert recorded_history(service, job_id) == expected()


def test_a_worker_that_was_given_up_too_early_is_counted_with_its_own_try(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    runtime = runtime_for(store, settings)
    first, second = Hand(runtime, job_id, "w1"), Hand(runtime, job_id, "w2")
    first.take()
    once = first.results()
    runtime.expire(job_id, 0, ["w1"])
    first.exchange(once, want=False)
    assert listed(service, job_id) == [(1, "w1", "finished", True)]
    finish(second)
    assert lost_tries(store) == []
    assert recorded_history(service, job_id) == expected()


def test_an_exchange_whose_answer_was_lost_can_be_repeated(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    hand = Hand(runtime_for(store, settings), job_id, "w1")
    hand.take()
    submission = hand.results()
    first = hand.exchange(submission)
    again = hand.exchange(submission)
    assert first.claim is not None
    assert again.claim is not None
    assert (again.claim.particles, again.claim.attempts) == (first.claim.particles, first.claim.attempts)
    finish(hand)
    assert lost_tries(store) == []
    assert {e.attempts for e in service.iterate_evaluations(job_id)} == {1}
    assert recorded_history(service, job_id) == expected()


def test_what_was_not_begun_is_given_back_untouched(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    store.write(lambda c: c.execute(update(jobs).values(typical_seconds=0.001)))
    runtime = runtime_for(store, settings)
    hand = Hand(runtime, job_id, "w1")
    hand.take()
    assert hand.claim is not None
    assert hand.claim.particles == (0, 1, 2)
    hand.submit(1, want=False)
    states = [(e.state, e.attempts) for e in service.evaluations(job_id).items]
    assert states == [("finished", 1)] + [("pending", 0)] * 5


def test_a_poisonous_evaluation_fails_alone_after_three_lost_workers(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    store.write(lambda c: c.execute(update(jobs).values(typical_seconds=0.001)))
    runtime = runtime_for(store, settings)
    for i in range(3):
        victim = Hand(runtime, job_id, f"victim{i}")
        victim.take()
        assert victim.claim is not None
        # The chunk of the first victim takes its neighbours with it; later it is alone.
        assert victim.claim.particles == ((0, 1, 2) if i == 0 else (0,))
        runtime.expire(job_id, 0, [f"victim{i}"])
    finish(Hand(runtime, job_id, "survivor"))
    poisoned, *others = service.evaluations(job_id, limit=1000).items
    assert (poisoned.state, poisoned.reason, poisoned.attempts) == ("failed", "worker_lost", 3)
    assert poisoned.message is not None
    assert "victim2" in poisoned.message
    assert {e.state for e in others} == {"finished"}
    assert service.get(job_id).failed_evaluations == 1
    assert service.get(job_id).state == "finished"


def test_leases_end_by_the_database_clock_unless_renewed(store: Store, settings: Settings, job_id: str) -> None:
    runtime = runtime_for(store, settings, lease_seconds=600.0)
    hand = Hand(runtime, job_id, "w1")
    hand.take()
    assert hand.claim is not None
    pass_time(store, 400.0)
    runtime.renew(hand.claim, "w1")
    pass_time(store, 400.0)
    assert runtime.expire(job_id, 0, []) == 0
    pass_time(store, 400.0)
    assert runtime.expire(job_id, 0, []) == 1
    assert runtime.expire(job_id, 0, []) == 0


def test_pause_keeps_results_and_resume_goes_on_with_the_same_bits(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    hand = Hand(runtime_for(store, settings), job_id, "w1")
    hand.take()
    for _ in range(8):
        hand.submit()
    assert service.pause(job_id).state == "paused"
    assert hand.submit().claim is None  # kept, but nothing new is handed out
    done = len(service.evaluations(job_id, state="finished", limit=1000).items)
    assert hand.take().claim is None
    assert service.resume(job_id).state == "running"
    finish(hand)
    assert done > 6
    assert recorded_history(service, job_id) == expected()
    states = [event.data["state"] for event in service.events(job_id) if event.kind == "state"]
    assert states == ["queued", "running", "paused", "running", "finished"]


def test_a_burst_that_was_paused_or_overtaken_changes_nothing(
    store: Store, settings: Settings, service: JobService, make_worker: MakeWorker
) -> None:
    # a search that learns from the runs goes through the database after each generation
    swarm = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
    problem = line(method=swarm, stopping={"max_evaluations": 60})
    textbook, expected = course(problem), expected_history(problem)
    job_id = service.submit(problem)[0].id
    runtime = Runtime(store, settings)
    store.write(lambda c: c.execute(update(jobs).values(typical_seconds=1e-5)))
    hand = Hand(runtime, job_id, "w1", textbook)
    hand.take()
    assert hand.claim is not None
    assert hand.claim.job is not None
    worker = make_worker()
    patient = settings.model_copy(update={"chunk_seconds": 60.0})  # however slow the machine is just now
    whole = ClaimRunner(
        hand.claim, InlineEvaluator(), textbook, patient, worker.heartbeat, lambda *_: (True, None)
    ).run()
    assert len(whole.local_batches) == 10
    service.pause(job_id)
    assert hand.exchange(whole).claim is None
    view = service.get(job_id)
    assert (view.state, view.generations) == ("paused", 0)
    assert len(service.evaluations(job_id, state="finished").items) == 6
    service.resume(job_id)
    other = Hand(runtime_for(store, settings), job_id, "w2", textbook)
    other.take()
    other.submit()
    hand.exchange(whole)  # far too late
    finish(other)
    assert recorded_history(service, job_id) == expected
    assert [g.number for g in service.generations(job_id)] == list(range(10))


def test_the_claim_ahead_leaves_out_what_is_under_way(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    runtime = runtime_for(store, settings)
    hand, other = Hand(runtime, job_id, "w1"), Hand(runtime, job_id, "w2")
    hand.take()
    store.write(lambda c: c.execute(update(jobs).values(typical_seconds=0.1)))
    other.take()
    assert other.claim is not None
    assert (other.claim.particles, other.claim.typical) == ((1, 2), 0.1)
    ahead = other.reach_ahead(1)
    assert ahead is not None
    assert ahead.particles == (3,)
    assert other.claim.particles == (2, 3)
    assert other.reach_ahead(0) is not None
    assert other.claim.particles == (2, 3, 4)
    states = [e.state for e in service.evaluations(job_id).items]
    assert states == ["running", "finished", "running", "running", "running", "pending"]
    assert other.submit(1, want=False).left
    states = [e.state for e in service.evaluations(job_id).items]
    assert states == ["running", "finished", "finished", "pending", "pending", "pending"]


def test_nothing_ahead_when_others_have_ended_the_generation(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    runtime = runtime_for(store, settings)
    slow, quick = Hand(runtime, job_id, "w1"), Hand(runtime, job_id, "w2")
    slow.take()
    held = slow.claim
    runtime.expire(job_id, 0, ["w1"])
    while service.get(job_id).generations == 0:
        if quick.claim is None:
            quick.take()
        quick.submit()
    slow.claim = held
    assert slow.reach_ahead(0) is None
    assert slow.claim is held


def test_cancel_in_mid_generation_stops_dispatch(
    store: Store, settings: Settings, service: JobService, job_id: str
) -> None:
    hand = Hand(runtime_for(store, settings), job_id, "w1")
    hand.take()
    service.cancel(job_id)
    assert hand.submit().claim is None
    states = [e.state for e in service.evaluations(job_id).items]
    assert states == ["finished"] + ["pending"] * 5


def test_running_time_leaves_out_pauses_and_silence(store: Store, settings: Settings, service: JobService) -> None:
    problem = line(stopping={"max_evaluations": 10**6, "max_seconds": 10_000.0})
    job_id = service.submit(problem)[0].id
    made = course(problem)
    hand = Hand(runtime_for(store, settings, lease_seconds=600.0), job_id, "w1", made)
    hand.take()
    service.pause(job_id)
    # A pause, and an engine that was down for a day: neither counts.
    pass_time(store, 2000.0)
    service.resume(job_id)
    pass_time(store, 86400.0)
    for _ in range(6):
        hand.submit()
        if hand.claim is None:
            hand.take()
    seconds = service.get(job_id).seconds
    assert seconds is not None
    assert 600.0 <= seconds < 2000.0  # the lease's length for the day of silence, and what these steps take
    assert service.get(job_id).state == "running"
    store.write(lambda c: c.execute(update(jobs).values(run_seconds=10_000.0)))
    while hand.claim is not None:
        hand.submit()
    assert service.get(job_id).stop_reasons == ["max_seconds"]


@hypothesis_settings(
    max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
@given(
    actions=st.lists(
        st.tuples(
            st.sampled_from(["take", "submission", "part", "ahead", "twice", "die", "expire", "pause", "resume"]),
            st.integers(0, 2),
        ),
        max_size=60,
    )
)
def test_any_order_of_workers_losses_and_pauses_gives_the_same_history(
    store: Store, settings: Settings, service: JobService, actions: list[tuple[str, int]]
) -> None:
    job_id = service.submit(PATIENT)[0].id
    runtime = runtime_for(store, settings)
    hands = [Hand(runtime, job_id, f"w{i}") for i in range(3)]
    parked: list[tuple[Hand, Submission]] = []
    for action, i in actions:
        hand = hands[i]
        state = service.get(job_id).state
        if action == "take" and hand.claim is None:
            hand.take()
        elif action in ("submission", "part") and hand.claim is not None:
            hand.submit(1 if action == "part" else None)
        elif action == "ahead" and hand.claim is not None:
            hand.reach_ahead(len(hand.claim.particles) - 1)
        elif action == "twice" and hand.claim is not None:
            results = hand.results()
            hand.exchange(results, want=False)
            hand.exchange(results)
        elif action == "die" and hand.claim is not None:
            parked.append((hand, hand.results()))
            hand.claim = None
        elif action == "expire":
            runtime.expire(job_id, max(service.get(job_id).generations, 0), [h.name for h in hands if h.claim is None])
        elif action == "pause" and state in ("queued", "running"):
            service.pause(job_id)
        elif action == "resume" and state == "paused":
            service.resume(job_id)
    if service.get(job_id).state == "paused":
        service.resume(job_id)
    for generation in range(10):
        runtime.expire(job_id, generation, [hand.name for hand in hands])
    for hand, results in parked:  # ghosts: what the dead had calculated
        Hand(runtime, job_id, hand.name).exchange(results, want=False)
    finish(Hand(runtime, job_id, "last"))
    assert service.get(job_id).state == "finished"
    assert recorded_history(service, job_id) == expected()
    counted = store.read(
        lambda c: c.execute(select(evaluations.c.state).where(evaluations.c.job_id == job_id)).scalars().all()
    )
    assert list(counted) == ["finished"] * 60
    for view in [view for view in service.iterate_evaluations(job_id) if view.attempts > 1]:
        tries = service.attempts(job_id, view.generation, view.particle)
        assert sum(t.counted for t in tries) == 1
        assert sorted(t.number for t in tries) == list(range(1, view.attempts + 1)), tries
