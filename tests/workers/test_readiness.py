"""Readiness harms nobody and tells what is wrong; a database file is the same as long as it is in use."""

from __future__ import annotations

import os
import shutil
import sqlite3
import stat
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from geoswarm.workers.doorbell import MuteDoorbell
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.operations.probe import OneAtATime
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.api.conftest import live_server
from tests.workers.problems import line
from tests.workers.test_unwritable import wait_until


@pytest.fixture
def sqlite_settings(tmp_path: Path) -> Settings:
    return Settings(database_url=f"sqlite:///{tmp_path}/jobs.db", workers=1)


@pytest.fixture
def sqlite_store(sqlite_settings: Settings) -> Iterator[Store]:
    store = Store(sqlite_settings)
    yield store
    store.close()


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Another program writes into the file and does not end."""
    other = sqlite3.connect(path, isolation_level=None)
    try:
        other.execute("BEGIN EXCLUSIVE")
        yield
    finally:
        other.rollback()
        other.close()


def test_one_looks_and_the_others_get_the_last_answer() -> None:
    go_on = threading.Event()
    looks: list[int] = []

    def look() -> str:
        looks.append(1)
        if len(looks) > 1:
            go_on.wait(60)
        return f"answer {len(looks)}"

    asked = OneAtATime(look, patience=1.0)
    assert asked.answer() == "answer 1"
    with ThreadPoolExecutor(20) as pool:
        answers = list(pool.map(lambda _: asked.answer(), range(20)))
        assert len(looks) == 2
        assert answers.count("answer 1") == 19
        assert [answer for answer in answers if "has not answered for" in answer] == ["has not answered for 1 s"]
        assert "has not answered for" in asked.answer()
        go_on.set()
        wait_until(lambda: asked.answer().startswith("answer"), 30)


def test_a_locked_file_does_not_make_the_service_unreachable(sqlite_store: Store, tmp_path: Path) -> None:
    service = JobService(sqlite_store, MuteDoorbell())
    with live_server(service) as server, httpx.Client(base_url=server.url, timeout=60) as client:
        assert client.get("/health/ready").status_code == 200
        time.sleep(2.1)
        with locked(tmp_path / "jobs.db"), ThreadPoolExecutor(60) as pool:
            began = time.monotonic()
            asked = [pool.submit(httpx.get, f"{server.url}/health/ready", timeout=60) for _ in range(60)]
            assert client.get("/api/v1/jobs").status_code == 200
            assert {one.result().status_code for one in asked} <= {200, 503}
            assert time.monotonic() - began < 15.0  # it was 20 s for each forty of them
            answer = client.get("/health/ready")
            assert answer.status_code == 503
            assert "has not answered for" in answer.json()["dependencies"]["database"]
        wait_until(lambda: client.get("/health/ready").status_code == 200, 60)
    service.close()


@pytest.mark.parametrize("what", ["removed", "replaced"])
def test_a_file_that_was_removed_or_replaced_is_not_used_any_more(
    sqlite_store: Store, sqlite_settings: Settings, tmp_path: Path, what: str
) -> None:
    service = JobService(sqlite_store, MuteDoorbell(), sqlite_settings)
    kept = service.submit(line())[0].id
    path, aside = tmp_path / "jobs.db", tmp_path / "aside.db"
    path.rename(aside)
    if what == "replaced":
        shutil.copy(aside, path)
    with pytest.raises(StoreUnavailableError, match=f"jobs.db was {what} while it was in use"):
        service.submit(line())
    with pytest.raises(StoreUnavailableError, match=what):
        service.get(kept)
    assert what in service.health()["database"]
    with pytest.raises(StoreUnavailableError, match=what):
        Store(sqlite_settings, sqlite_store.file)
    assert path.exists() is (what == "replaced")
    aside.replace(path)
    assert service.get(kept).state == "queued"
    assert service.health()["database"] == "ok"
    service.close()


def test_a_new_worker_makes_no_second_database(sqlite_settings: Settings, tmp_path: Path) -> None:
    path, aside = tmp_path / "jobs.db", tmp_path / "aside.db"
    with open_engine(sqlite_settings) as engine:
        wait_until(lambda: len(engine.service.workers()) == 1)
        assert engine.supervisor is not None
        (first,) = engine.supervisor.pids
        path.rename(aside)
        os.kill(first, 9)
        wait_until(lambda: engine.supervisor is not None and engine.supervisor.pids not in ([], [first]))
        (second,) = engine.supervisor.pids
        wait_until(lambda: engine.supervisor is not None and engine.supervisor.pids != [second])  # it has ended itself
        assert not path.exists()
        aside.rename(path)
        wait_until(lambda: [w for w in engine.service.workers() if w.state == "idle"] != [])


def test_a_damaged_table_is_told(sqlite_store: Store, sqlite_settings: Settings, tmp_path: Path) -> None:
    sqlite_store.close()
    with sqlite3.connect(tmp_path / "jobs.db") as connection:
        size = connection.execute("PRAGMA page_size").fetchone()[0]
        page = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'attempts'").fetchone()[0]
    connection.close()
    with (tmp_path / "jobs.db").open("r+b") as file:
        file.seek((page - 1) * size)
        file.write(b"\xff" * size)
    store = Store(sqlite_settings)
    assert "can be reached, but not read" in JobService(store, MuteDoorbell()).health()["database"]
    store.close()


def test_a_disk_without_its_reserve_is_told(sqlite_store: Store, sqlite_settings: Settings) -> None:
    settings = sqlite_settings.model_copy(update={"disk_reserve_mb": 1e12})
    why = JobService(sqlite_store, MuteDoorbell(), settings).health()["database"]
    assert "MB left; at least 1000000000000 MB" in why
    assert "GEOSWARM_DISK_RESERVE_MB" in why


def test_only_its_owner_may_read_the_file(sqlite_store: Store, tmp_path: Path) -> None:
    JobService(sqlite_store, MuteDoorbell()).submit(line())
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.glob("jobs.db*")}
    assert modes
    assert set(modes.values()) == {0o600}
