"""A backup that was made while jobs ran is restored on another server: they go on there, to the same end."""

from __future__ import annotations

import io
import os
import sqlite3
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy.engine import make_url

from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.access.principal import LOCAL, Principal
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity
from geoswarm.workers.notices.hooks import Hooks
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.servers import PostgresServer, find_program
from tests.workers.hand import Hand, runtime_for
from tests.workers.problems import course, expected_history, line, recorded_history

PROBLEM = line(stopping={"max_evaluations": 60})
PHOTO = b"\xff\xd8\xff\xe0" + os.urandom(600_000)


def settings_for(url: str) -> Settings:
    return Settings(database_url=url, workers=1, isolate=False, lease_seconds=600.0, heartbeat_seconds=150.0)


def begin(store: Store, settings: Settings) -> tuple[str, str, str]:
    """Leave a finished job, one in mid-generation with a claim under way, and a queued one; their ids."""
    service = JobService(store, NoWaker(), settings)
    ids = [service.submit(PROBLEM, idempotency_key=name)[0].id for name in ("done", "half", "queued")]
    finish(store, settings, ids[0])
    hand = Hand(runtime_for(store, settings), ids[1], "lost", course(PROBLEM))
    hand.take()
    for _ in range(5):
        hand.submit(1)
    assert service.get(ids[1]).state == "running"
    service.attachments.add(ids[0], "photo.jpg", io.BytesIO(PHOTO))
    ApiKeys(store).create("anna", "submit")
    Hooks(store, Principal("anna", "submit"), NoticeSettings()).create("https://example.org/hook")
    return ids[0], ids[1], ids[2]


def finish(store: Store, settings: Settings, job_id: str) -> None:
    worker = Worker(store, NoWaker(), settings, Identity.new("embedded"))
    worker.start()
    Sweeper(worker.runtime, NoWaker()).release(job_id, 0, ["lost"])
    while JobService(store, NoWaker(), settings).get(job_id).state in ("queued", "running"):
        Sweeper(worker.runtime, NoWaker()).sweep()
        worker.serve(job_id)
    worker.close()


def check_copy(url: str, ids: tuple[str, str, str], key_count: int = 1) -> None:
    """All is there, and what was not finished comes to the end that it would have had."""
    settings = settings_for(url)
    with closing(Store(settings)) as store:
        service = JobService(store, NoWaker(), settings)
        done, half, queued = ids
        states = {job.id: job.state for job in service.list().items}
        assert states == {done: "finished", half: "running", queued: "queued"}
        expected = expected_history(PROBLEM)
        assert recorded_history(service, done) == expected
        for job_id in (half, queued):
            finish(store, settings, job_id)
            assert recorded_history(service, job_id) == expected
        assert service.submit(PROBLEM, idempotency_key="done")[0].id == done
        (file,) = service.attachments.list(done)
        assert b"".join(service.attachments.content(done, file.sha256)) == PHOTO
        assert len(ApiKeys(store).list()) == key_count
        assert [hook.owner for hook in Hooks(store, LOCAL, NoticeSettings()).list()] == ["anna"]
        again, new = service.submit(PROBLEM)  # sequences go on where they were
        assert new
        finish(store, settings, again.id)


@pytest.fixture
def other_server() -> Iterator[PostgresServer]:
    with PostgresServer() as server:
        yield server


def run(program: str, url: str, *arguments: str) -> None:
    parts = make_url(url)
    given = ["--host", str(parts.host), "--port", str(parts.port), "--username", str(parts.username)]
    done = subprocess.run(
        [str(find_program(program)), *given, "--no-password", *arguments],
        env=os.environ | {"PGPASSWORD": str(parts.password)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_postgresql_by_pg_dump(fresh_postgres_url: str, other_server: PostgresServer, tmp_path: Path) -> None:
    settings = settings_for(fresh_postgres_url)
    with closing(Store(settings)) as store:
        ids = begin(store, settings)
        dump = str(tmp_path / "geoswarm.dump")
        run(
            "pg_dump",
            fresh_postgres_url,
            "--format=custom",
            "--file",
            dump,
            make_url(fresh_postgres_url).database or "",
        )
        url = other_server.create_database()
        run("pg_restore", url, "--no-owner", "--exit-on-error", "--dbname", make_url(url).database or "", dump)
        check_copy(url, ids)
        service = JobService(store, NoWaker(), settings)
        assert service.get(ids[1]).state == "running"  # the original knows nothing of it, and goes on by itself
        finish(store, settings, ids[1])
        assert recorded_history(service, ids[1]) == expected_history(PROBLEM)


@pytest.mark.parametrize("statement", ["VACUUM INTO", "backup"])
def test_sqlite_while_it_is_written(tmp_path: Path, statement: str) -> None:
    settings = settings_for(f"sqlite:///{tmp_path}/jobs.db")
    copy = tmp_path / "copy.db"
    with closing(Store(settings)) as store:
        ids = begin(store, settings)
        with closing(sqlite3.connect(tmp_path / "jobs.db")) as connection:
            if statement == "backup":
                with closing(sqlite3.connect(copy)) as target:
                    connection.backup(target)
            else:
                connection.execute("VACUUM INTO ?", (str(copy),))
    check_copy(f"sqlite:///{copy}", ids)
