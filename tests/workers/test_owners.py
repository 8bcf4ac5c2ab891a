"""Whose jobs somebody sees, and how many there may be."""

from __future__ import annotations

import contextlib
import pkgutil
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, cast

import pytest

from geoswarm.records.job import Job
from geoswarm.solver.problem import Problem, Stopping, parse_problem
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.access.quotas import sizes
from geoswarm.workers.errors import IdempotencyConflictError, JobNotFoundError, QuotaExceededError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.store import Store
from tests.api.conftest import line_problem
from tests.workers.conftest import ON_SQLITE, MakeWorker

ALICE, BOB, ADMIN = Principal("alice", "submit", "a"), Principal("bob", "submit", "b"), Principal("root", "admin", "r")


def problem(**changes: Any) -> Problem:
    return parse_problem(line_problem(**changes))


def limited(service: JobService, principal: Principal, **quotas: int) -> JobService:
    bound = service.on_behalf_of(principal)
    bound.settings = service.settings.model_copy(update=quotas)
    return bound


def test_owners_see_their_own_jobs_and_administrators_all(service: JobService) -> None:
    own, _ = service.on_behalf_of(ALICE).submit(problem(name="a"))
    service.on_behalf_of(BOB).submit(problem(name="b"))
    service.submit(problem(name="nobody"))
    names = {who: [job.name for job in service.on_behalf_of(who).list().items] for who in (ALICE, BOB, ADMIN)}
    assert names == {ALICE: ["a"], BOB: ["b"], ADMIN: ["nobody", "b", "a"]}
    assert service.on_behalf_of(Principal(None, "read")).list().items == []
    assert service.on_behalf_of(Principal("alice", "read")).get(own.id).name == "a"


@ON_SQLITE
@pytest.mark.parametrize(
    "method",
    [
        "get",
        "problem",
        "parsed_problem",
        "cancel",
        "pause",
        "resume",
        "delete",
        "best",
        "evaluations",
        "generations",
        "events",
    ],
)
def test_the_job_of_somebody_else_is_not_there(service: JobService, method: str) -> None:
    job, _ = service.on_behalf_of(ALICE).submit(problem())
    with pytest.raises(JobNotFoundError, match="there is no job"):
        getattr(service.on_behalf_of(BOB), method)(job.id)
    with pytest.raises(JobNotFoundError):
        service.on_behalf_of(BOB).iterate_evaluations(job.id)
    assert service.get(job.id).state == "queued"


def test_every_method_with_a_job_refuses_strangers(service: JobService) -> None:
    """Also those that are added later."""
    job, _ = service.on_behalf_of(ALICE).submit(problem())
    stranger = service.on_behalf_of(BOB)
    tried = 0
    for name in dir(JobService):
        method = getattr(stranger, name)
        if name.startswith("_") or not callable(method) or "job_id" not in getattr(method, "__annotations__", {}):
            continue
        place = {} if name not in ("attempts", "evaluation") else {"generation": 0, "particle": 0}
        needed = {"change_stopping": {"stopping": Stopping(max_evaluations=10)}, "compared": {"document": {}}}
        further: dict[str, Any] = needed.get(name, {})
        tried += 1
        with pytest.raises(JobNotFoundError):
            method(job.id, **place, **further)
    assert tried >= 11


def test_idempotency_keys_of_two_owners_do_not_meet(service: JobService) -> None:
    first, _ = service.on_behalf_of(ALICE).submit(problem(), idempotency_key="k")
    second, new = service.on_behalf_of(BOB).submit(problem(name="other"), idempotency_key="k")
    assert new
    assert second.id != first.id
    again, new = service.on_behalf_of(ALICE).submit(problem(), idempotency_key="k")
    assert (again.id, new) == (first.id, False)
    with pytest.raises(IdempotencyConflictError, match="'k' was used"):
        service.on_behalf_of(ALICE).submit(problem(name="other"), idempotency_key="k")


def test_open_jobs_are_limited_for_each_owner(service: JobService) -> None:
    alice = limited(service, ALICE, quota_jobs=2)
    first, _ = alice.submit(problem())
    alice.submit(problem(), idempotency_key="k")
    with pytest.raises(QuotaExceededError, match="alice has 2 jobs that have not ended; at most 2"):
        alice.submit(problem())
    assert not alice.submit(problem(), idempotency_key="k")[1]  # nothing new, nothing refused
    limited(service, BOB, quota_jobs=2).submit(problem())
    limited(service, ADMIN, quota_jobs=0).submit(problem())
    alice.cancel(first.id)
    assert alice.submit(problem())[1]


def at_once(monkeypatch: pytest.MonkeyPatch, place: str, *submit: Callable[[], object]) -> list[object]:
    """Submit from several threads which meet behind a function, if they can; return what came of each."""
    function, meeting = cast(Callable[..., object], pkgutil.resolve_name(place)), threading.Barrier(len(submit))

    def meets(*given: Any, **named: Any) -> object:
        found = function(*given, **named)
        with contextlib.suppress(threading.BrokenBarrierError):
            meeting.wait(1.0)
        return found

    def result(one: Callable[[], object]) -> object:
        try:
            return one()
        except QuotaExceededError as error:
            return error

    monkeypatch.setattr(place, meets)
    with ThreadPoolExecutor(len(submit)) as threads:
        return list(threads.map(result, submit))


def test_one_idempotency_key_at_once_gives_one_job_whatever_the_quota(
    service: JobService, monkeypatch: pytest.MonkeyPatch
) -> None:
    alice = limited(service, ALICE, quota_jobs=1)
    submit = partial(alice.submit, problem(), idempotency_key="k")
    found = at_once(monkeypatch, "geoswarm.workers.queries.jobs.find_by_idempotency_key", submit, submit)
    jobs = cast(list[tuple[Job, bool]], found)
    assert sorted(new for _, new in jobs) == [False, True]
    assert jobs[0][0].id == jobs[1][0].id


def test_two_owners_at_once_do_not_both_take_the_last_room(
    service: JobService, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    large = problem(stopping={"max_evaluations": 10**6})
    room = int(store.size_bytes() / 1e6 + 1.5 * sizes(large, {}, None)["evaluation_bytes"])
    submit = [partial(limited(service, who, quota_total_mb=room).submit, large) for who in (ALICE, BOB)]
    found = at_once(monkeypatch, "geoswarm.workers.service.job_service.check_quotas", *submit)
    (refused,) = [one for one in found if isinstance(one, QuotaExceededError)]
    assert "GEOSWARM_QUOTA_TOTAL_MB" in str(refused)


def test_two_links_at_once_are_not_both_the_last_one(service: JobService, monkeypatch: pytest.MonkeyPatch) -> None:
    alice = service.on_behalf_of(ALICE)
    job_id = alice.submit(problem())[0].id
    monkeypatch.setattr("geoswarm.workers.service.links.MOST_LINKS", 2)
    alice.links.create(job_id, valid_seconds=60.0)
    create = partial(alice.links.create, job_id, valid_seconds=60.0)
    found = at_once(monkeypatch, "geoswarm.workers.queries.api_keys.list_keys", create, create)
    (refused,) = [one for one in found if isinstance(one, QuotaExceededError)]
    assert "the job has 2 valid links" in str(refused)
    monkeypatch.undo()
    assert len(alice.links.list(job_id)) == 2


def test_stored_and_planned_evaluations_are_limited(service: JobService, make_worker: MakeWorker) -> None:
    alice = limited(service, ALICE, quota_evaluations=150)
    done, _ = alice.submit(problem())
    alice.submit(problem())
    with pytest.raises(QuotaExceededError, match="have or plan 120 evaluations and this one 60 more; at most 150"):
        alice.submit(problem())
    worker = make_worker()
    worker.start()
    worker.serve(done.id)
    worker.close()
    assert service.get(done.id).state == "finished"
    with pytest.raises(QuotaExceededError, match="have or plan 120"):
        alice.submit(problem())
    alice.delete(done.id)
    assert alice.submit(problem())[1]


def test_workers_do_not_tell_what_they_do_for_others(service: JobService, make_worker: MakeWorker) -> None:
    job, _ = service.on_behalf_of(ALICE).submit(problem())
    worker = make_worker()
    worker.start()
    course = worker._course(job.id)
    assert course is not None
    worker.runtime.start(job.id, course.start())
    from geoswarm.workers.coordinator.work import Submission

    worker.runtime.exchange(job.id, worker.identity.id, course, Submission(), live_workers=1, want=True)
    (own,) = service.on_behalf_of(ALICE).workers()
    (other,) = service.on_behalf_of(BOB).workers()
    assert (own.job, own.generation, own.evaluations, own.state) == (job.id, 0, 1, "busy")
    assert own.busy_since is not None
    assert (other.job, other.generation, other.evaluations, other.state) == (None, None, 1, "busy")
    worker.close()
