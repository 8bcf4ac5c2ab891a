"""What has ended is told once, in a form that stays, whatever fails or is lost meanwhile."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, TypeAlias

import pytest
from sqlalchemy import select, update

from geoswarm.records.job import Job
from geoswarm.workers.access.principal import LOCAL, Principal
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.errors import HookNotFoundError, HookRefusedError, JobNotFoundError, QuotaExceededError
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.notices import notifier as notifier_module
from geoswarm.workers.notices.hooks import Hooks
from geoswarm.workers.notices.notifier import AGAIN_SECONDS, Notifier
from geoswarm.workers.notices.queue import hold_due
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.notices.verdicts import NOTHING
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import deliveries
from tests.workers.conftest import ON_SQLITE, ON_SQLITE_FIRST, MakeWorker
from tests.workers.notices.conftest import Receiver
from tests.workers.problems import line

MakeNotifier: TypeAlias = Callable[[], Notifier]
NOW = (0.0,) * 8


@pytest.fixture
def make_notifier(store: Store, settings: Settings, notices: NoticeSettings) -> MakeNotifier:
    return lambda: Notifier(store, settings, notices, again=NOW)


@pytest.fixture
def hooks(store: Store, notices: NoticeSettings) -> Hooks:
    return Hooks(store, LOCAL, notices)


def run(worker: Worker, service: JobService, **changes: Any) -> Job:
    """Bring a job to its end."""
    job, _ = service.submit(line(stopping={"max_evaluations": 24}, **changes))
    worker.start()
    worker.serve(job.id)
    worker.close()
    return service.get(job.id)


@ON_SQLITE_FIRST
def test_a_finished_job_is_told_with_its_result(
    hooks: Hooks, receiver: Receiver, service: JobService, make_worker: MakeWorker, make_notifier: MakeNotifier
) -> None:
    made = hooks.create(receiver.url)
    job = run(make_worker(), service)
    assert make_notifier().deliver() == 1
    assert make_notifier().deliver() == 0
    (told,) = receiver.documents()
    assert told["type"] == "job.finished"
    data = told["data"]
    assert (data["id"], data["name"], data["state"]) == (job.id, "line", "finished")
    assert data["objective"] == job.objective
    assert data["parameters"] == job.parameters
    assert (data["evaluations"], data["generations"]) == (24, 4)
    assert data["stop_reasons"] == ["max_evaluations"]
    assert data["url"] == f"https://geoswarm.example.org/jobs/{job.id}"
    assert set(data["verdicts"]) == {"a", "b"}
    assert data["fit"]
    (view,) = hooks.list()
    assert (view.id, view.last_state, view.last_tries, view.last_error) == (made.view.id, "delivered", 1, None)


def test_failed_and_cancelled_jobs_are_told_to_who_wants_to_know(
    hooks: Hooks, receiver: Receiver, service: JobService, store: Store, settings: Settings, make_notifier: MakeNotifier
) -> None:
    hooks.create(receiver.url, states=["failed"])
    cancelled, _ = service.submit(line(name="cancelled"))
    service.cancel(cancelled.id)
    broken, _ = service.submit(line(name="broken"))
    Runtime(store, settings).give_up(broken.id, "the model is gone")
    while make_notifier().deliver():
        pass
    (told,) = receiver.documents()
    assert (told["type"], told["data"]["name"], told["data"]["error"]) == (
        "job.failed",
        "broken",
        "the model is gone",
    )
    assert told["data"]["objective"] is None


def test_failures_run_again_are_told_when_they_have_been(
    hooks: Hooks,
    receiver: Receiver,
    service: JobService,
    make_worker: MakeWorker,
    store: Store,
    settings: Settings,
    notices: NoticeSettings,
) -> None:
    failing = {"kind": "formula", "series": {"y": "a * x + b + 0 * sqrt(a - 2)"}}
    job = run(make_worker(), service, forward_model=failing)
    assert job.failed_evaluations
    hooks.create(receiver.url)
    service.retry_failed(job.id)
    worker = make_worker()
    worker.start()
    while service.get(job.id).state == "running":
        worker.serve(job.id)
    worker.close()
    assert Notifier(store, settings, notices, find=lambda _settings, _job: NOTHING).deliver() == 1
    assert receiver.documents()[0]["type"] == "job.finished"


def test_what_is_not_taken_is_tried_again_by_whoever_is_there(
    hooks: Hooks, receiver: Receiver, service: JobService, make_notifier: MakeNotifier
) -> None:
    hooks.create(receiver.url)
    receiver.statuses = [500, 503]
    job, _ = service.submit(line())
    service.cancel(job.id)
    for count in (1, 2, 3):
        assert make_notifier().deliver() == 1  # each time another process
        assert len(receiver.bodies) == count
    assert len({*receiver.bodies}) == 1
    assert len({headers["webhook-id"] for headers in receiver.headers}) == 1
    (view,) = hooks.list()
    assert (view.last_state, view.last_tries) == ("delivered", 3)


def test_tries_become_rarer_and_end(
    hooks: Hooks, receiver: Receiver, service: JobService, store: Store, settings: Settings, notices: NoticeSettings
) -> None:
    hooks.create(receiver.url)
    receiver.statuses = [500] * 20
    job, _ = service.submit(line())
    service.cancel(job.id)
    notifier = Notifier(store, settings, notices)
    for pause in AGAIN_SECONDS:
        assert notifier.deliver() == 1
        now, due = store.read(lambda c: c.execute(select(database_now(), deliveries.c.due_at)).one())
        assert pause - 60 < due - now <= pause
        assert notifier.deliver() == 0
        store.write(lambda c: c.execute(update(deliveries).values(due_at=0.0)))
    assert notifier.deliver() == 1
    (view,) = hooks.list()
    assert (view.last_state, view.last_error) == ("given_up", "answered with status 500")
    assert len(receiver.bodies) == len(AGAIN_SECONDS) + 1


def test_a_process_lost_in_mid_try_loses_nothing(
    hooks: Hooks, receiver: Receiver, service: JobService, store: Store, make_notifier: MakeNotifier
) -> None:
    hooks.create(receiver.url)
    job, _ = service.submit(line())
    service.cancel(job.id)
    assert len(store.write(lambda c: hold_due(c, 4, 600.0))) == 1  # and then it is killed
    assert make_notifier().deliver() == 0
    store.write(lambda c: c.execute(update(deliveries).values(held_until=0.0)))
    assert make_notifier().deliver() == 1
    assert hooks.list()[0].last_tries == 2


def test_several_processes_tell_each_thing_once(
    hooks: Hooks, receiver: Receiver, service: JobService, make_notifier: MakeNotifier
) -> None:
    hooks.create(receiver.url)
    hooks.create(f"{receiver.url}/other")
    for number in range(6):
        job, _ = service.submit(line(name=f"job {number}"))
        service.cancel(job.id)
    start = threading.Barrier(3)

    def deliver() -> None:
        start.wait()
        for _ in range(40):
            notifier.deliver()

    notifier = make_notifier()
    threads = [threading.Thread(target=deliver) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    while make_notifier().deliver():
        pass
    told = sorted(
        (path, document["data"]["name"]) for path, document in zip(receiver.paths, receiver.documents(), strict=True)
    )
    assert told == sorted((path, f"job {n}") for path in ("/hook", "/hook/other") for n in range(6))


def test_a_hook_for_one_job_hears_of_it_alone_and_at_once_when_it_has_ended(
    hooks: Hooks, receiver: Receiver, service: JobService, make_notifier: MakeNotifier
) -> None:
    ended, _ = service.submit(line(name="ended"))
    service.cancel(ended.id)
    other, _ = service.submit(line(name="other"))
    hooks.create(receiver.url, job_id=ended.id)
    hooks.create(receiver.url, job_id=ended.id, states=["finished"])
    service.cancel(other.id)
    while make_notifier().deliver():
        pass
    assert [document["data"]["name"] for document in receiver.documents()] == ["ended"]


def test_a_test_says_that_the_hook_works(hooks: Hooks, receiver: Receiver, make_notifier: MakeNotifier) -> None:
    made = hooks.create(receiver.url)
    hooks.test(made.view.id)
    assert make_notifier().deliver() == 1
    assert receiver.documents()[0]["type"] == "hook.test"


def test_who_is_removed_is_not_told_any_more(
    hooks: Hooks, receiver: Receiver, service: JobService, make_notifier: MakeNotifier
) -> None:
    made = hooks.create(receiver.url)
    job, _ = service.submit(line())
    service.cancel(job.id)
    hooks.delete(made.view.id)
    assert make_notifier().deliver() == 0
    assert hooks.list() == []
    with pytest.raises(HookNotFoundError):
        hooks.test(made.view.id)


def test_hooks_and_jobs_of_others_are_not_there(
    store: Store, notices: NoticeSettings, service: JobService, receiver: Receiver, make_notifier: MakeNotifier
) -> None:
    alice, bob = (Principal(name, "submit") for name in ("alice", "bob"))
    job, _ = service.on_behalf_of(alice).submit(line())
    made = Hooks(store, alice, notices).create(receiver.url)
    other = Hooks(store, bob, notices)
    other.create(f"{receiver.url}/bob")
    assert [hook.owner for hook in other.list()] == ["bob"]
    for change in (other.delete, other.test):
        with pytest.raises(HookNotFoundError):
            change(made.view.id)
    with pytest.raises(JobNotFoundError):
        other.create(receiver.url, job_id=job.id)
    assert [hook.owner for hook in Hooks(store, LOCAL, notices).list()] == ["alice", "bob"]
    service.cancel(job.id)
    while make_notifier().deliver():
        pass
    assert receiver.paths == ["/hook"]


def test_an_owner_has_so_many_hooks_and_no_more(store: Store, service: JobService, receiver: Receiver) -> None:
    few = NoticeSettings(hooks_per_owner=2, hook_networks=("127.0.0.0/8",))
    hooks = Hooks(store, Principal("alice", "submit"), few)
    job, _ = service.on_behalf_of(Principal("alice", "submit")).submit(line())
    for _ in range(2):
        hooks.create(receiver.url, job_id=job.id)
    with pytest.raises(QuotaExceededError, match="2 hooks are set; at most 2 are accepted"):
        hooks.create(receiver.url)
    Hooks(store, Principal("bob", "submit"), few).create(receiver.url)
    service.cancel(job.id)
    Notifier(store, service.settings, few, again=NOW).deliver()  # those have done their work
    hooks.create(receiver.url)


@ON_SQLITE
def test_states_must_be_those_of_an_end(hooks: Hooks) -> None:
    with pytest.raises(HookRefusedError, match="must be one or more of finished, failed, cancelled"):
        hooks.create("https://example.org", states=[])


def test_deliveries_go_when_their_job_is_deleted(
    hooks: Hooks, receiver: Receiver, service: JobService, store: Store, make_notifier: MakeNotifier
) -> None:
    hooks.create(receiver.url)
    job, _ = service.submit(line())
    service.cancel(job.id)
    service.delete(job.id)
    assert make_notifier().deliver() == 0
    assert store.read(lambda c: c.execute(select(deliveries.c.id)).all()) == []


def test_the_thread_tells_by_itself_and_ends(
    hooks: Hooks,
    receiver: Receiver,
    service: JobService,
    make_notifier: MakeNotifier,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from tests.workers.notices.conftest import wait_for

    monkeypatch.setattr(notifier_module, "LOOK_SECONDS", 0.02)
    hooks.create(receiver.url)
    notifier = make_notifier()
    notifier.start()
    try:
        job, _ = service.submit(line())
        service.cancel(job.id)
        wait_for(lambda: bool(receiver.bodies))
    finally:
        notifier.stop()
    assert receiver.documents()[0]["data"]["id"] == job.id
