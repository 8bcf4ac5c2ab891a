from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import Connection, create_engine, func, inspect, literal, select, text

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.statements import Statement, enter
from geoswarm.workers.store.tables import metadata, turns
from tests.servers import free_port

CUT = text(
    "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = current_database()"
    " AND pid <> pg_backend_pid()"
)
"""Ends the connections of others."""


@pytest.fixture
def database_url(empty_database_url: str) -> str:
    return empty_database_url


def test_migrations_make_the_tables_that_the_program_uses(store: Store) -> None:
    with store.engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), metadata) == []


def test_partial_index_covers_only_running_evaluations(store: Store) -> None:
    indexes = {index["name"]: index for index in inspect(store.engine).get_indexes("evaluations")}
    where = indexes["ix_evaluations_running"]["dialect_options"][f"{store.engine.dialect.name}_where"]
    assert "running" in str(where)


def test_many_processes_may_start_at_once(settings: Settings) -> None:
    stores: list[Store] = []
    threads = [threading.Thread(target=lambda: stores.append(Store(settings))) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for store in stores:
        store.ping()
        store.close()
    assert len(stores) == 6


def test_the_clock_is_utc_and_moves_inside_a_transaction(store: Store) -> None:
    def twice(connection: object) -> tuple[float, float]:
        first = connection.scalar(select(database_now()))
        time.sleep(0.02)
        return first, connection.scalar(select(database_now()))

    before = time.time()
    first, second = store.read(twice)
    assert before - 1.0 < first <= second - 0.01
    assert second < time.time() + 1.0


def test_a_newer_schema_is_refused(settings: Settings) -> None:
    store = Store(settings)
    store.write(lambda connection: connection.execute(text("UPDATE alembic_version SET version_num = '9999'")))
    store.close()
    with pytest.raises(StoreUnavailableError, match="written by a newer geoswarm"):
        Store(settings)


def test_somebody_elses_database_is_refused(settings: Settings) -> None:
    engine = create_engine(settings.database_url)
    with engine.begin() as connection:
        connection.execute(text("CREATE TABLE jobs (id INTEGER)"))
    engine.dispose()
    with pytest.raises(StoreUnavailableError, match="table 'jobs' that geoswarm did not make"):
        Store(settings)


def test_unreachable_server_is_one_clear_line_without_password() -> None:
    url = f"postgresql://me:topsecret@127.0.0.1:{free_port()}/jobs"
    with pytest.raises(StoreUnavailableError) as caught:
        Store(Settings(database_url=url))
    message = str(caught.value)
    assert message.startswith("database postgresql+psycopg://me:***@127.0.0.1")
    assert "refused" in message
    assert "topsecret" not in message
    assert "\n" not in message


def test_wrong_password_is_one_clear_line(fresh_postgres_url: str) -> None:
    scheme, _, rest = fresh_postgres_url.partition("://")
    user, _, host = rest.partition("@")
    name = user.split(":")[0]
    with pytest.raises(StoreUnavailableError, match="password authentication failed") as caught:
        Store(Settings(database_url=f"{scheme}://{name}:notthisone@{host}"))
    assert "notthisone" not in str(caught.value)


def test_missing_folder_and_a_file_that_is_no_database(tmp_path: Path) -> None:
    with pytest.raises(StoreUnavailableError, match="there is no folder"):
        Store(Settings(database_url=f"sqlite:///{tmp_path / 'nowhere' / 'jobs.db'}"))
    (tmp_path / "text.db").write_text("this is not a database, whatever its name says" * 30)
    with pytest.raises(StoreUnavailableError, match="file is not a database"):
        Store(Settings(database_url=f"sqlite:///{tmp_path / 'text.db'}"))


def test_a_cut_connection_is_replaced(fresh_postgres_url: str) -> None:
    store = Store(Settings(database_url=fresh_postgres_url))
    killer = Store(Settings(database_url=fresh_postgres_url))
    seven = Statement(select(literal(7).label("seven")))
    for ask in (lambda c: c.scalar(text("SELECT 7")), lambda c: seven.rows(c, {})[0].seven):
        store.ping()
        killer.write(lambda connection: connection.execute(CUT))
        assert store.read(ask) == 7
    store.close()
    killer.close()


def test_all_connections_that_were_cut_are_replaced(fresh_postgres_url: str) -> None:
    """A store keeps one to write with beside those that have read; when the server restarts, all are dead."""
    store, killer = (Store(Settings(database_url=fresh_postgres_url)) for _ in range(2))
    both = threading.Barrier(2)
    seven = Statement(select(literal(7).label("seven")))

    def read(connection: Connection) -> None:
        both.wait(60.0)
        connection.execute(text("SELECT 7"))

    threads = [threading.Thread(target=store.read, args=(read,)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for ask in (store.write, store.read):
        store.write(lambda c: c.execute(text("SELECT 7")))
        store.ping()
        killer.write(lambda c: c.execute(CUT))
        assert ask(lambda c: seven.rows(c, {})[0].seven) == 7
    store.close()
    killer.close()


def test_writes_follow_each_other_on_one_connection_until_one_fails(fresh_postgres_url: str) -> None:
    store = Store(Settings(database_url=fresh_postgres_url))
    backend = Statement(select(func.pg_backend_pid().label("pid")))

    def write(connection: Connection, fail: bool = False) -> int:
        if fail:
            raise ZeroDivisionError
        return int(backend.rows(connection, {})[0].pid)

    first = store.write(write)
    assert store.write(write) == first
    assert store.write(lambda _: store.write(write)) != first  # while that one is busy
    with pytest.raises(ZeroDivisionError):
        store.write(lambda connection: write(connection, fail=True))
    assert isinstance(store.write(write), int)
    store.close()


def test_what_the_commit_refuses_is_undone_and_said(fresh_postgres_url: str) -> None:
    store = Store(Settings(database_url=fresh_postgres_url))
    once = text("ALTER TABLE turns ADD CONSTRAINT once UNIQUE (served_at) DEFERRABLE INITIALLY DEFERRED")
    store.write(lambda c: c.execute(once))
    rows = [{"line": line, "served_at": 1.0} for line in "ab"]
    with pytest.raises(StoreUnavailableError, match=r"(?i)unique"):
        store.write(lambda c: enter(c, turns, rows))
    store.write(lambda c: enter(c, turns, rows[:1]))
    assert store.read(lambda c: c.execute(select(turns.c.line)).scalars().all()) == ["a"]
    store.close()


def test_writers_wait_for_each_other_instead_of_failing(store: Store) -> None:
    store.write(lambda c: c.execute(text("CREATE TABLE counter (n INTEGER)")))
    store.write(lambda c: c.execute(text("INSERT INTO counter VALUES (0)")))

    def add(connection: object) -> None:
        n = connection.scalar(text("SELECT n FROM counter" + lock))
        time.sleep(0.002)
        connection.execute(text("UPDATE counter SET n = :n"), {"n": n + 1})

    lock = "" if store.engine.dialect.name == "sqlite" else " FOR UPDATE"
    threads = [threading.Thread(target=lambda: [store.write(add) for _ in range(10)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert store.read(lambda c: c.scalar(text("SELECT n FROM counter"))) == 40
