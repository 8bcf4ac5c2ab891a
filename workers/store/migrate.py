"""Upgrades the schema at start, with any number of processes starting at once."""

from __future__ import annotations

import logging
import re
import sqlite3
import time
from pathlib import Path

from sqlalchemy import Connection, Engine, inspect, text
from sqlalchemy.exc import OperationalError, ProgrammingError

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.settings import mask_url
from geoswarm.workers.store.tables import metadata

__all__ = ["HEAD", "upgrade"]

HEAD = max(path.name[:4] for path in Path(__file__).parent.glob("migrations/versions/[0-9]*.py"))
"""Revision that this program works with: the newest in ``migrations/versions``."""

log = logging.getLogger(__name__)

ADVISORY_LOCK = 7_265_100_831  # any number that no other program uses on this database
WAL_TRIES = 100
_MISFIT = re.compile(r"already exists|duplicate column|does not exist|no such (table|column)")


def upgrade(engine: Engine) -> None:
    """Create or migrate the schema; returns at once when it is current.

    Raises
    ------
    StoreUnavailableError
        When the database was written by a newer version of this program, or belongs to another one.
    """
    with engine.connect() as connection:
        if _revision(connection) == HEAD:
            _check_tables(connection)
            return
    if engine.dialect.name == "sqlite":
        _use_write_ahead_log(engine)
    with engine.connect() as connection:
        connection.execution_options(write=True)
        with connection.begin():
            if engine.dialect.name == "postgresql":
                connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": ADVISORY_LOCK})
            # Another process did it while this one waited for the lock.
            if _revision(connection) != HEAD:
                _run_migrations(connection)


def _revision(connection: Connection) -> str | None:
    tables = inspect(connection).get_table_names()
    if "alembic_version" not in tables:
        if "jobs" in tables:
            raise StoreUnavailableError(
                f"database {mask_url(str(connection.engine.url))} has a table 'jobs' that geoswarm did not make;"
                " use an empty database"
            )
        return None
    revision: str | None = connection.scalar(text("SELECT version_num FROM alembic_version"))
    if revision is None and "jobs" in tables:
        raise _disagreement(connection, None, "there are tables already")
    return revision


def _check_tables(connection: Connection) -> None:
    """Make sure that the tables of the newest schema are there."""
    missing = sorted(set(metadata.tables) - set(inspect(connection).get_table_names()))
    if missing:
        raise _disagreement(connection, HEAD, f"it has no table {', '.join(missing)}")


def _disagreement(connection: Connection, revision: str | None, why: str) -> StoreUnavailableError:
    label = "is empty" if revision is None else f"says {revision}"
    return StoreUnavailableError(
        f"database {mask_url(str(connection.engine.url))}: its tables do not fit its schema version (table "
        f"alembic_version {label}): {why}; restore a backup of all its tables, or use an empty database"
    )


def _run_migrations(connection: Connection) -> None:
    logging.getLogger("alembic").setLevel(logging.WARNING)  # one line of ours instead of its many
    # Imported here: a process that finds the schema current saves the time.
    from alembic import command
    from alembic.config import Config
    from alembic.util.exc import CommandError

    config = Config()
    config.set_main_option("script_location", str(Path(__file__).with_name("migrations")).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    revision = _revision(connection)
    try:
        command.upgrade(config, HEAD)
    except CommandError as error:
        raise StoreUnavailableError(
            f"database {mask_url(str(connection.engine.url))} cannot be upgraded to schema {HEAD}"
            f" (written by a newer geoswarm?): {error}"
        ) from error
    except (OperationalError, ProgrammingError) as error:
        cause = str(error.orig).partition("\n")[0]
        if error.connection_invalidated or not _MISFIT.search(cause):
            raise
        raise _disagreement(connection, revision, cause) from error
    log.info("database schema upgraded to %s", HEAD)


def _use_write_ahead_log(engine: Engine) -> None:
    """Switch to WAL, which stays with the file; SQLite refuses while others switch too, and does not wait itself."""
    raw = engine.raw_connection()
    try:
        for trial in range(WAL_TRIES):
            try:
                raw.cursor().execute("PRAGMA journal_mode = WAL")
            except sqlite3.OperationalError as error:
                if "locked" not in str(error) or trial == WAL_TRIES - 1:
                    raise
                time.sleep(0.05)
            else:
                return
    finally:
        raw.close()
