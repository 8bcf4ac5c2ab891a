from __future__ import annotations

import sqlite3
import time
from pathlib import Path

import pytest
from sqlalchemy import func, select, text, update

from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.errors import InvalidTransitionError, JobNotFoundError
from geoswarm.workers.operations import retention
from geoswarm.workers.operations.retention import delete_job, prune
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import attempts, evaluations, events, generations, jobs
from geoswarm.workers.waker import NoWaker
from tests.workers.conftest import MakeWorker
from tests.workers.problems import line

DAY = 86400.0
MARK = "confidential-embankment-of-the-harbour"


def finished(service: JobService, make_worker: MakeWorker, name: str, age: float) -> str:
    """A finished job that ended so long ago [s]."""
    job_id = service.submit(line(name=name, stopping={"max_evaluations": 24}))[0].id
    make_worker().serve(job_id)
    assert service.get(job_id).state == "finished"
    service.store.write(
        lambda c: c.execute(update(jobs).where(jobs.c.id == job_id).values(finished_at=database_now() - age))
    )
    return job_id


def test_old_jobs_go_and_everything_else_stays(service: JobService, make_worker: MakeWorker) -> None:
    old = finished(service, make_worker, "old", 100 * DAY)
    new = finished(service, make_worker, "new", 10 * DAY)
    waiting = service.submit(line(name="waiting"))[0].id
    assert [job.id for job in prune(service.store, 90 * DAY, dry_run=True)] == [old]
    assert service.get(old).state == "finished"
    told: list[str] = []
    pruned = prune(service.store, 90 * DAY, on_deleted=lambda job: told.append(job.name))
    assert [(job.id, job.name, job.state, job.evaluations) for job in pruned] == [(old, "old", "finished", 24)]
    assert told == ["old"]
    assert {job.id for job in service.list().items} == {new, waiting}
    assert len(service.evaluations(new, limit=1000).items) == 24
    for table in (evaluations, generations, events, attempts):
        count = select(func.count()).select_from(table).where(table.c.job_id == old)
        assert service.store.read(lambda c, count=count: c.scalar(count)) == 0
    assert prune(service.store, 90 * DAY) == []


def test_states_can_be_chosen(service: JobService, make_worker: MakeWorker) -> None:
    finished(service, make_worker, "good", 2 * DAY)
    assert prune(service.store, DAY, ("failed", "cancelled")) == []
    assert [job.name for job in prune(service.store, DAY, ("finished",))] == ["good"]


def test_a_job_is_deleted_in_short_transactions(
    service: JobService, make_worker: MakeWorker, monkeypatch: pytest.MonkeyPatch
) -> None:
    job_id = finished(service, make_worker, "large", 0.0)
    monkeypatch.setattr(retention, "ROWS_A_TRANSACTION", 10)
    seen: list[int] = []
    delete_some = retention._delete_some

    def counting(connection: object, id: str) -> bool:
        more = delete_some(connection, id)  # type: ignore[arg-type]
        seen.append(more)
        return more

    monkeypatch.setattr(retention, "_delete_some", counting)
    service.delete(job_id)
    assert seen == [True, True, False]
    with pytest.raises(JobNotFoundError):
        service.get(job_id)


def test_what_has_not_ended_is_not_deleted(service: JobService) -> None:
    job_id = service.submit(line())[0].id
    with pytest.raises(InvalidTransitionError, match="queued"):
        delete_job(service.store, job_id)
    with pytest.raises(JobNotFoundError):
        delete_job(service.store, "0" * 16)
    assert service.get(job_id).state == "queued"


@pytest.mark.parametrize("how", ["delete", "prune"])
def test_deleted_data_are_nowhere_in_the_files(tmp_path: Path, how: str) -> None:
    """Neither in free pages of the database, nor in its journal."""
    settings = Settings(database_url=f"sqlite:///{tmp_path}/jobs.db", workers=1)
    store = Store(settings)
    service = JobService(store, NoWaker(), settings)
    kept = service.submit(line(name="kept"))[0].id
    job_id = service.submit(line(name=MARK))[0].id

    def traces() -> list[str]:
        return [path.name for path in tmp_path.iterdir() if MARK.encode() in path.read_bytes()]

    assert traces()
    service.cancel(job_id)
    if how == "delete":
        service.delete(job_id)
    else:
        store.write(lambda c: c.execute(update(jobs).values(finished_at=database_now() - 10)))
        prune(store, 5.0, ("cancelled",))
    assert traces() == []
    assert service.get(kept).name == "kept"
    store.close()


def test_a_journal_that_a_reader_needs_is_emptied_by_a_later_sweep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("geoswarm.workers.store.database.SQLITE_BUSY_SECONDS", 250.0)  # who waits is seen to wait
    settings = Settings(database_url=f"sqlite:///{tmp_path}/jobs.db", workers=1)
    store = Store(settings)
    service = JobService(store, NoWaker(), settings)
    x = [i / 1000 for i in range(20_000)]
    job_id = service.submit(line(name=MARK, observations=[{"series": "y", "points": {"x": x, "y": x}}]))[0].id
    service.cancel(job_id)
    sweeper = Sweeper(Runtime(store, settings), NoWaker())
    journal = tmp_path / "jobs.db-wal"
    with store.engine.connect() as reader, reader.begin():
        assert reader.scalar(text("SELECT count(*) FROM jobs")) == 1
        began = time.monotonic()
        service.delete(job_id)  # does not wait for the reader
        assert time.monotonic() - began < 120.0
        sweeper.sweep()
        assert journal.stat().st_size > 500_000
        assert MARK.encode() in journal.read_bytes()
    sweeper.sweep()
    assert journal.stat().st_size < 100_000
    assert MARK.encode() not in journal.read_bytes()
    sizes = journal.stat().st_size
    sweeper.sweep()  # nothing is left to do
    assert journal.stat().st_size == sizes
    store.close()


def test_pruning_gives_the_space_back(tmp_path: Path) -> None:
    settings = Settings(database_url=f"sqlite:///{tmp_path}/jobs.db", workers=1)
    store = Store(settings)
    service = JobService(store, NoWaker(), settings)
    x = [i / 1000 for i in range(20_000)]
    job_id = service.submit(line(observations=[{"series": "y", "points": {"x": x, "y": x}}]))[0].id
    service.cancel(job_id)
    store.write(lambda c: c.execute(update(jobs).values(finished_at=database_now() - 10)))
    before = sum(path.stat().st_size for path in tmp_path.iterdir())
    prune(store, 5.0)
    store.close()
    after = sum(path.stat().st_size for path in tmp_path.iterdir())
    assert after < before / 2
    with sqlite3.connect(tmp_path / "jobs.db") as file:
        assert file.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    file.close()


def test_connections_work_as_before_after_pruning(service: JobService, store: Store, make_worker: MakeWorker) -> None:
    finished(service, make_worker, "old", 2 * DAY)
    assert len(prune(store, DAY)) == 1
    assert service.submit(line())[1]
    assert store.read(lambda c: c.scalar(text("SELECT 1"))) == 1
