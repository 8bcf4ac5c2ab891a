"""Threads that ask about one job at the same time share a transaction, and nobody can tell from the history."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from dataclasses import replace

import pytest

from geoswarm.solver.course import Course
from geoswarm.workers.coordinator.together import Together
from geoswarm.workers.coordinator.work import Asked, Exchange, Submission
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.integration.engines import wait_for
from tests.workers.hand import COURSE, PROBLEM, Hand, runtime_for
from tests.workers.problems import course, expected_history, line, recorded_history

WIDE = line(method={"kind": "particle_swarm", "particles": 24}, stopping={"max_evaluations": 24 * 3})


def asked(name: str, submission: Submission | None = None) -> Asked:
    return Asked(name, Submission() if submission is None else submission, live_workers=8, want=True)


class Slow:
    """Serves when it is let; remembers who came together."""

    def __init__(self) -> None:
        self.served: list[list[str]] = []
        self.begun = threading.Event()
        self.go_on = threading.Event()

    def __call__(self, _job: str, _course: Course, brought: Sequence[Asked]) -> list[Exchange]:
        self.served.append([one.worker for one in brought])
        self.begun.set()
        assert self.go_on.wait(120.0), "nobody let it go on"
        if any(one.worker == "wrong" for one in brought):
            raise ValueError("that is wrong")
        if any(one.worker == "away" for one in brought):
            raise StoreUnavailableError("away")
        return [Exchange(wakes=number) for number, _ in enumerate(brought)]


def together(names: Sequence[str]) -> tuple[Slow, dict[str, Exchange | Exception]]:
    """The first asks alone, the others while it is served."""
    slow = Slow()
    shared = Together(slow)
    found: dict[str, Exchange | Exception] = {}

    def ask(name: str) -> None:
        try:
            found[name] = shared.ask("job", COURSE, asked(name))
        except (ValueError, StoreUnavailableError) as error:
            found[name] = error

    threads = [threading.Thread(target=ask, args=(name,)) for name in names]
    threads[0].start()
    assert slow.begun.wait(120.0), "nobody was served"
    for thread in threads[1:]:
        thread.start()
    wait_for(lambda: len(shared._waiting["job"]) == len(names) - 1, "the others")
    slow.go_on.set()
    for thread in threads:
        thread.join(120.0)
    assert shared._waiting == {}
    return slow, found


def test_who_comes_alone_waits_for_nobody_and_those_who_wait_go_together() -> None:
    slow, found = together(["a", "b", "c", "d"])
    assert slow.served[0] == ["a"]
    assert sorted(slow.served[1]) == ["b", "c", "d"]
    assert [found[name] for name in slow.served[1]] == [Exchange(wakes=number) for number in range(3)]


def test_one_that_is_wrong_does_not_harm_the_others() -> None:
    slow, found = together(["a", "b", "wrong", "c"])
    assert isinstance(found.pop("wrong"), ValueError)
    assert all(isinstance(answer, Exchange) for answer in found.values())
    assert sorted(name for names in slow.served[2:] for name in names) == ["b", "c", "wrong"]


def test_a_database_that_is_away_is_told_to_all_and_asked_once() -> None:
    slow, found = together(["a", "b", "away"])
    assert len(slow.served) == 2
    assert [type(found[name]) for name in ("b", "away")] == [StoreUnavailableError] * 2


@pytest.mark.parametrize("threads", [1, 8])
def test_the_history_is_the_same_however_many_come_at_once(
    store: Store, settings: Settings, service: JobService, threads: int
) -> None:
    job_id = service.submit(WIDE)[0].id
    shared = course(WIDE)
    runtime = runtime_for(store, settings, single_seconds=0.0)
    batches: list[int] = []
    serve = runtime._together._serve

    def counted(job: str, made: Course, brought: Sequence[Asked]) -> Sequence[Exchange]:
        batches.append(len(brought))
        if len(batches) == 1 and threads > 1:
            wait_for(lambda: len(runtime._together._waiting[job]) > 1, "others that come meanwhile")
        return serve(job, made, brought)

    runtime._together._serve = counted
    runtime.start(job_id, shared.start())

    def work(name: str) -> None:
        hand = Hand(runtime, job_id, name, shared)
        hand.take()
        while service.get(job_id).state == "running":
            if hand.claim is None:
                time.sleep(0.05)
                hand.take()
            else:
                hand.submit()

    running = [threading.Thread(target=work, args=(f"w{number}",)) for number in range(threads)]
    for thread in running:
        thread.start()
    for thread in running:
        thread.join(240)
    assert recorded_history(service, job_id) == expected_history(WIDE)
    assert max(batches) > 1 or threads == 1


def test_results_that_come_together_count_once_and_claims_do_not_overlap(
    store: Store, settings: Settings, service: JobService
) -> None:
    job_id = service.submit(WIDE)[0].id
    shared = course(WIDE)
    runtime = runtime_for(store, settings, single_seconds=0.0)
    hands = [Hand(runtime, job_id, f"w{number}", shared) for number in range(5)]
    hands[0].take()  # starts the job
    answers = runtime._exchange(job_id, shared, [asked(hand.name) for hand in hands])
    claimed = [answer.claim.particles for answer in answers if answer.claim is not None]
    assert claimed == [(0,), (1,), (2,), (3,), (4,)]  # the first of them was claimed before, by the same worker
    for hand, answer in zip(hands, answers, strict=True):
        hand.claim = answer.claim
    brought = [asked(hand.name, hand.results()) for hand in hands]
    twice = [*brought, replace(brought[0], want=False)]
    answers = runtime._exchange(job_id, shared, twice)
    assert [a.claim.particles if a.claim else None for a in answers] == [(5,), (6,), (7,), (8,), (9,), None]
    found = service.evaluations(job_id, state="finished").items
    assert [(e.particle, e.worker) for e in found] == [(n, f"w{n}") for n in range(5)]


def test_a_particle_that_is_none_harms_only_who_brings_it(
    store: Store, settings: Settings, service: JobService
) -> None:
    job_id = service.submit(PROBLEM)[0].id
    runtime = runtime_for(store, settings)
    hand = Hand(runtime, job_id, "w1")
    hand.take()
    brought = hand.results()
    wrong = replace(brought, results=[replace(result, particle=99) for result in brought.results])
    with pytest.raises(IndexError):
        runtime._exchange(job_id, COURSE, [asked("w2", wrong)])
    with pytest.raises(IndexError):
        runtime._exchange(job_id, COURSE, [asked("w1", brought), asked("w2", wrong)])
    assert service.get(job_id).state == "running"
    assert service.evaluations(job_id, state="finished").items == []  # nothing of that transaction is there
    hand.exchange(brought)
    assert len(service.evaluations(job_id, state="finished").items) == len(brought.results)
