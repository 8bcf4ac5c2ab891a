"""What jobs may take of the disk, and what happens while it has no room: nothing is begun, nothing finished is lost."""

from __future__ import annotations

import pytest
from sqlalchemy import func, select

from geoswarm.solver.problem import Problem, Stopping
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import QuotaExceededError, StoreUnavailableError
from geoswarm.workers.operations.probe import Probe
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import evaluations
from tests.workers.conftest import MakeWorker, RecordingWaker
from tests.workers.hand import COURSE, PROBLEM, Hand, runtime_for
from tests.workers.problems import expected_history, line, recorded_history

ALICE, BOB, ADMIN = Principal("alice", "submit", "a"), Principal("bob", "submit", "b"), Principal("root", "admin", "r")
ON_A_FILE = pytest.mark.parametrize("database_url", ["sqlite"], indirect=True)
NO_ROOM = 1e9  # MB to be kept free: more than any disk has


def wide(points: int = 1000, planned: int = 1000) -> Problem:
    x = [i / points for i in range(points)]
    return line(
        observations=[{"series": "y", "points": {"x": x, "y": x}}],
        method={"kind": "monte_carlo", "samples": planned, "batch": 50},
        stopping={},
    )


def limited(service: JobService, principal: Principal, **quotas: float) -> JobService:
    bound = service.on_behalf_of(principal)
    bound.settings = service.settings.model_copy(update=quotas)
    return bound


def test_the_bytes_of_an_owner_are_counted_when_a_job_is_submitted(service: JobService) -> None:
    alice = limited(service, ALICE, quota_mb=20.0)
    first = alice.submit(wide())[0].id
    alice.submit(wide())
    words = (
        r"the jobs of alice have or plan 17\.3 MB of data and this one 8\.6 MB more \(1000 evaluations of 8616 bytes\);"
        r" at most 20\.0 MB are kept \(GEOSWARM_QUOTA_MB\)\. Delete jobs"
    )
    with pytest.raises(QuotaExceededError, match=words):
        alice.submit(wide())
    alice.submit(line())  # small ones fit
    limited(service, BOB, quota_mb=20.0).submit(wide())
    limited(service, ADMIN, quota_mb=0.0, quota_total_mb=0.0).submit(wide())
    alice.cancel(first)
    assert alice.submit(wide())[1]  # what will not be calculated takes nothing


def test_the_bytes_of_all_owners_are_counted_with_what_the_database_has(service: JobService) -> None:
    total = service.store.size_bytes() / 1e6 + 20.0
    limited(service, ALICE, quota_total_mb=total).submit(wide())
    limited(service, BOB, quota_total_mb=total).submit(wide())
    words = r"the database has [\d.]+ MB, jobs that have not ended plan 17\.2 MB and this one 8\.6 MB more .* for all"
    with pytest.raises(QuotaExceededError, match=words):
        limited(service, Principal("carla", "submit"), quota_total_mb=total).submit(wide())


def test_more_evaluations_of_a_job_are_counted_too(service: JobService) -> None:
    alice = limited(service, ALICE)
    alice._runtime.settings = service.settings.model_copy(update={"quota_mb": 1.0})
    job_id = alice.submit(line())[0].id
    with pytest.raises(QuotaExceededError, match=r"GEOSWARM_QUOTA_MB"):
        alice.change_stopping(job_id, Stopping(max_evaluations=5000))
    alice.change_stopping(job_id, Stopping(max_evaluations=500))


@pytest.mark.parametrize("points", [4, 1000])
def test_the_estimate_is_near_what_is_stored(service: JobService, make_worker: MakeWorker, points: int) -> None:
    store = service.store
    store._size = None
    before = store.size_bytes()
    problem = wide(points, 1000)
    job_id = service.submit(problem)[0].id
    worker = make_worker()
    worker.start()
    while service.get(job_id).state != "finished":
        worker.serve(job_id)
    worker.close()
    store._size = None
    row = store.read(lambda c: c.execute(select(func.count()).select_from(evaluations))).scalar_one()
    assert row == 1000
    assert store.size_bytes() > before
    job = store.read(lambda c: c.exec_driver_sql("SELECT evaluation_bytes FROM jobs")).scalar_one()
    stored = (store.size_bytes() - before) / 1000
    assert stored < 2.5 * job  # an SQLite file has its journal beside it


def short_of(settings: Settings) -> Settings:
    return settings.model_copy(update={"disk_reserve_mb": NO_ROOM})


@ON_A_FILE
def test_without_room_finished_runs_come_in_and_none_goes_out(
    store: Store, service: JobService, settings: Settings
) -> None:
    job_id = service.submit(PROBLEM)[0].id
    one, two = (Hand(runtime_for(store, settings), job_id, name, COURSE) for name in ("w1", "w2"))
    one.take()
    two.take()
    assert one.claim is not None
    roomy = one.runtime.settings
    one.runtime.settings = two.runtime.settings = short_of(settings)
    done = service.get(job_id).evaluations
    while two.claim is not None:
        two.submit()
    answer = one.submit()
    assert answer.claim is None
    assert answer.left
    finished = select(func.count()).where(evaluations.c.state == "finished")
    assert store.read(lambda c: c.scalar(finished)) >= 2
    assert service.get(job_id).evaluations >= done
    one.runtime.settings = two.runtime.settings = roomy
    two.take()
    while two.claim is not None:
        two.submit()
    assert service.get(job_id).state == "finished"
    assert recorded_history(service, job_id) == expected_history(PROBLEM)


@ON_A_FILE
def test_workers_wait_for_room_and_go_on(
    service: JobService, settings: Settings, make_worker: MakeWorker, caplog: pytest.LogCaptureFixture
) -> None:
    problem = line(stopping={"max_evaluations": 60})
    job_id = service.submit(problem)[0].id
    worker = make_worker()
    worker.start()
    roomy, worker.runtime.settings = worker.runtime.settings, short_of(settings)
    assert [worker.next_job() for _ in range(5)] == [None] * 5
    worker.serve(job_id)  # it was woken
    assert service.get(job_id).evaluations == 0
    waits = [record.message for record in caplog.records if "waits: database: its disk has" in record.message]
    assert len(waits) == 1
    worker.runtime.settings = roomy
    assert worker.next_job() == job_id
    worker.serve(job_id)
    assert service.get(job_id).state == "finished"
    assert recorded_history(service, job_id) == expected_history(problem)
    worker.close()


@ON_A_FILE
def test_the_reason_shows_in_the_job_in_readiness_and_to_who_submits(
    store: Store, service: JobService, settings: Settings
) -> None:
    job_id, done = service.submit(line(), idempotency_key="k")[0].id, service.submit(line())[0].id
    service.cancel(done)
    assert service.get(job_id).warnings == []
    full = JobService(store, RecordingWaker(), short_of(settings))
    reason = r"database: its disk has \d+ MB left; at least 1000000000 MB are kept free \(GEOSWARM_DISK_RESERVE_MB\)"
    with pytest.raises(StoreUnavailableError, match=reason):
        full.submit(line())
    assert not full.submit(line(), idempotency_key="k")[1]
    (warning,) = full.get(job_id).warnings
    assert warning.startswith("waits: database: its disk has")
    assert {view.id: len(view.warnings) for view in full.list().items} == {job_id: 1, done: 0}
    assert Probe(store, reserve_bytes=1e15).database() == full._runtime.shortage()
    full.delete(done)  # making room is possible
