"""Databases of every released schema come up to date with all that is in them, and their jobs go on."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

import psycopg
import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from sqlalchemy import create_engine, text

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.migrate import HEAD
from geoswarm.workers.store.tables import metadata
from geoswarm.workers.waker import NoWaker

SCHEMAS = Path(__file__).parent / "schemas"
VERSIONS = Path(__file__).parents[2] / "workers" / "store" / "migrations" / "versions"
REVISIONS = sorted(path.name[:4] for path in VERSIONS.glob("[0-9]*.py"))
RELEASED = sorted({path.name.partition(".")[0] for path in SCHEMAS.glob("*.sql")})


@pytest.fixture
def database_url(empty_database_url: str) -> str:
    return empty_database_url


def fill(database_url: str, revision: str) -> None:
    """Make an old database: a finished job, one in mid-generation, and a queued one."""
    if database_url.startswith("sqlite"):
        with sqlite3.connect(database_url.removeprefix("sqlite:///")) as file:
            file.executescript((SCHEMAS / f"{revision}.sqlite.sql").read_text(encoding="utf-8"))
        file.close()
        return
    with psycopg.connect(database_url.replace("+psycopg", ""), autocommit=True) as connection:
        connection.execute((SCHEMAS / f"{revision}.postgresql.sql").read_bytes())


@pytest.fixture(params=RELEASED)
def old_store(request: pytest.FixtureRequest, database_url: str, settings: Settings) -> Callable[[], Store]:
    fill(database_url, request.param)
    return lambda: Store(settings)


def test_every_revision_but_the_newest_has_a_fixture() -> None:
    assert REVISIONS[-1] == HEAD
    assert RELEASED == ["0001"]  # released: a schema that was in a published version


@pytest.mark.slow
@pytest.mark.parametrize("revision", REVISIONS[1:-1])
def test_jobs_go_on_from_every_schema_on_the_way(database_url: str, settings: Settings, revision: str) -> None:
    """Also from schemas between two released ones, as who follows the development has them."""
    fill(database_url, "0001")
    config = Config()
    config.set_main_option("script_location", str(VERSIONS.parent))
    engine = create_engine(database_url)
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, revision)
    engine.dispose()
    check_that_it_goes_on(Store(settings), settings)


@pytest.mark.parametrize(
    ("seeing", "other", "there"), [("alice", "bob", True), ("chief", "alice", False), (None, "bob", True)]
)
def test_follow_ups_of_before_know_their_job(database_url: str, seeing: str | None, other: str, there: bool) -> None:
    """Those of its owner and of administrators do, not those of others, or of a job that is not there."""
    fill(database_url, "0001")
    engine = create_engine(database_url)
    with engine.begin() as connection:
        config = Config()
        config.set_main_option("script_location", str(VERSIONS.parent))
        config.attributes["connection"] = connection
        command.upgrade(config, "0015")
        connection.execute(
            text(
                "INSERT INTO api_keys (id, hash, owner, role, label, created_at)"
                " VALUES ('1', '', 'chief', 'admin', '', 0), ('2', '', 'bob', 'submit', '', 0)"
            )
        )
        ids = {row.name: row.id for row in connection.execute(text("SELECT id, name FROM jobs"))}
        connection.execute(text("UPDATE jobs SET owner = 'alice' WHERE name = 'line'"))
        for name, owner, of in (
            ("half", seeing, ids["line"]),
            ("queued", other, ids["line"] if there else "0" * 16),
        ):
            problem = json.dumps({"method": {"kind": "sensitivity", "of": of}}, separators=(",", ":"))
            connection.execute(
                text("UPDATE jobs SET owner = :owner, problem = :problem WHERE name = :name"),
                {"owner": owner, "problem": problem, "name": name},
            )
        command.upgrade(config, "0016")
        parents = {row.name: row.parent for row in connection.execute(text("SELECT name, parent FROM jobs"))}
    engine.dispose()
    assert parents == {"line": None, "half": ids["line"], "queued": None}


def test_an_old_database_comes_up_to_date(old_store: Callable[[], Store]) -> None:
    store = old_store()
    with store.engine.connect() as connection:
        assert connection.scalar(text("SELECT version_num FROM alembic_version")) == HEAD
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        differences = [d for d in compare_metadata(context, metadata) if "alembic_version" not in str(d)]
    store.close()
    assert differences == []


def test_what_was_there_stays_and_belongs_to_administrators(old_store: Callable[[], Store], settings: Settings) -> None:
    store = old_store()
    service = JobService(store, NoWaker(), settings)
    found = {job.name: job for job in service.list().items}
    assert {name: job.state for name, job in found.items()} == {
        "line": "finished",
        "half": "running",
        "queued": "queued",
    }
    done = found["line"]
    assert done.objective == pytest.approx(2.1094814351302325, rel=1e-12)
    assert len(service.evaluations(done.id, responses=True).items) == done.evaluations == 12
    assert [event.kind for event in service.events(done.id)][-1] == "state"
    again, new = service.submit(parse_problem(service.problem(done.id)), idempotency_key="first")
    assert (again.id, new) == (done.id, False)
    stranger = service.on_behalf_of(Principal("alice", "submit"))
    assert stranger.list().items == []
    with pytest.raises(JobNotFoundError):
        stranger.get(done.id)
    store.close()


def test_an_unfinished_job_goes_on_and_equals_an_undisturbed_run(
    old_store: Callable[[], Store], settings: Settings
) -> None:
    check_that_it_goes_on(old_store(), settings)


def check_that_it_goes_on(store: Store, settings: Settings) -> None:
    """The job in mid-generation comes to the end that it would have had."""
    with store.engine.connect() as connection:
        assert connection.scalar(text("SELECT version_num FROM alembic_version")) == HEAD
    service = JobService(store, NoWaker(), settings)
    worker = Worker(store, NoWaker(), settings, Identity.new("embedded"))
    worker.start()
    Sweeper(worker.runtime, NoWaker()).sweep()  # its former worker is gone
    half = next(job for job in service.list().items if job.name == "half")
    while service.get(half.id).state == "running":
        worker.serve(half.id)
    expected = calibrate(parse_problem(service.problem(half.id)), seed=half.seed)
    evaluations = service.evaluations(half.id).items
    assert [e.objective for e in evaluations] == [record.evaluation.objective for record in expected.history]
    assert [list(e.parameters.values()) for e in evaluations] == [
        record.evaluation.parameters.tolist() for record in expected.history
    ]
    assert service.get(half.id).objective == expected.objective
    worker.close()
    store.close()
