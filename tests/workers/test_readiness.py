"""Readiness harms nobody and tells what is wrong; a database file is the same as long as it is in use."""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
import stat
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.operations.probe import OneAtATime, Probe
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import live_server
from tests.integration.engines import wait_for
from tests.workers.problems import line


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


class Look:
    """Answers when it is let."""

    def __init__(self) -> None:
        self.looks = 0
        self.go_on = threading.Event()
        self.go_on.set()

    def __call__(self) -> str:
        self.looks += 1
        number = self.looks
        assert self.go_on.wait(120.0), "nobody let it go on"
        return f"answer {number}"


def test_one_looks_and_the_others_get_the_last_answer() -> None:
    look = Look()
    asked = OneAtATime(look, patience=250.0)
    assert asked.answer() == "answer 1"
    look.go_on.clear()
    with ThreadPoolExecutor(20) as pool:
        answers = [pool.submit(asked.answer) for _ in range(20)]
        wait_for(lambda: sum(one.done() for one in answers) == 19, "the answers of those who need not look")
        assert look.looks == 2
        look.go_on.set()
        assert sorted(one.result() for one in answers) == ["answer 1"] * 19 + ["answer 2"]


def test_a_look_that_takes_too_long_is_told_to_all() -> None:
    look = Look()
    asked = OneAtATime(look, patience=0.1)
    wait_for(lambda: asked.answer().startswith("answer"), "an answer")
    look.go_on.clear()
    looks = look.looks
    with ThreadPoolExecutor(20) as pool:
        first = asked.answer()
        answers = [first, *pool.map(lambda _: asked.answer(), range(20))]
        assert look.looks == looks + 1
        assert ["has not answered for" in answer for answer in answers] == [True] * 21
        look.go_on.set()
        wait_for(lambda: asked.answer().startswith("answer"), "an answer again")


def test_a_locked_file_does_not_make_the_service_unreachable(
    sqlite_store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    under_way: list[int] = []
    at_once: list[int] = []
    database = Probe.database

    def counted(self: Probe) -> str:
        under_way.append(1)
        at_once.append(len(under_way))
        try:
            return database(self)
        finally:
            under_way.pop()

    def ready() -> int:
        return client.get("/health/ready").status_code

    monkeypatch.setattr(Probe, "database", counted)
    service = JobService(sqlite_store, NoWaker())
    with live_server(service) as server, httpx.Client(base_url=server.url, timeout=120) as client:
        wait_for(lambda: ready() == 200, "a service that is ready")
        with locked(tmp_path / "jobs.db"), ThreadPoolExecutor(60) as pool:
            asked = [pool.submit(httpx.get, f"{server.url}/health/ready", timeout=120) for _ in range(60)]
            assert client.get("/api/v1/jobs").status_code == 200
            assert {one.result().status_code for one in asked} <= {200, 503}
            assert max(at_once) == 1  # forty that wait for the file would keep all others out
            wait_for(lambda: ready() == 503, "the word that the database does not answer")
            wait_for(
                lambda: "has not answered for" in client.get("/health/ready").json()["dependencies"]["database"],
                "the reason",
            )
        wait_for(lambda: ready() == 200, "a service that is ready again")
    service.close()


@pytest.mark.parametrize("what", ["removed", "replaced"])
def test_a_file_that_was_removed_or_replaced_is_not_used_any_more(
    sqlite_store: Store, sqlite_settings: Settings, tmp_path: Path, what: str
) -> None:
    service = JobService(sqlite_store, NoWaker(), sqlite_settings)
    kept = service.submit(line())[0].id
    path, aside = tmp_path / "jobs.db", tmp_path / "aside.db"
    path.rename(aside)
    if what == "replaced":
        shutil.copy(aside, path)
    with pytest.raises(StoreUnavailableError, match=f"jobs.db was {what} while it was in use"):
        service.submit(line())
    with pytest.raises(StoreUnavailableError, match=what):
        service.get(kept)
    wait_for(lambda: what in service.health()["database"], f"the word that the file was {what}")
    with pytest.raises(StoreUnavailableError, match=what):
        Store(sqlite_settings, sqlite_store.file)
    assert path.exists() is (what == "replaced")
    aside.replace(path)
    assert service.get(kept).state == "queued"
    wait_for(lambda: service.health()["database"] == "ok", "the word that all is well")
    service.close()


def test_a_new_worker_makes_no_second_database(sqlite_settings: Settings, tmp_path: Path) -> None:
    path, aside = tmp_path / "jobs.db", tmp_path / "aside.db"
    with open_engine(sqlite_settings) as engine:
        wait_for(lambda: len(engine.service.workers()) == 1, "a worker")
        supervisor = engine.supervisor
        assert supervisor is not None
        (first,) = supervisor.pids
        path.rename(aside)
        os.kill(first, 9)
        wait_for(lambda: supervisor.pids not in ([], [first]), "another worker")
        (second,) = supervisor.pids
        wait_for(lambda: supervisor.pids != [second], "its end: there is no database")
        assert not path.exists()
        aside.rename(path)
        wait_for(lambda: any(worker.state == "idle" for worker in engine.service.workers()), "a worker that is idle")


def test_a_damaged_table_is_reported(sqlite_store: Store, sqlite_settings: Settings, tmp_path: Path) -> None:
    sqlite_store.close()
    with sqlite3.connect(tmp_path / "jobs.db") as connection:
        size = connection.execute("PRAGMA page_size").fetchone()[0]
        page = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'attempts'").fetchone()[0]
    connection.close()
    with (tmp_path / "jobs.db").open("r+b") as file:
        file.seek((page - 1) * size)
        file.write(b"\xff" * size)
    store = Store(sqlite_settings)
    service = JobService(store, NoWaker())
    wait_for(lambda: "can be reached, but not read" in service.health()["database"], "the word of it")
    store.close()


def test_a_disk_without_its_reserve_is_reported(sqlite_store: Store, sqlite_settings: Settings) -> None:
    settings = sqlite_settings.model_copy(update={"disk_reserve_mb": 1e12})
    service = JobService(sqlite_store, NoWaker(), settings)
    words = re.compile(r"MB left; at least 1000000000000 MB .*GEOSWARM_DISK_RESERVE_MB")
    wait_for(lambda: words.search(service.health()["database"]) is not None, "the reason")


def test_only_its_owner_may_read_the_file(sqlite_store: Store, tmp_path: Path) -> None:
    JobService(sqlite_store, NoWaker()).submit(line())
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.glob("jobs.db*")}
    assert modes
    assert set(modes.values()) == {0o600}
