"""Statements that each exchange executes: built and compiled once, and given to the driver as they are.

SQLAlchemy takes as long to look up a compiled statement and to describe its columns as the database takes to answer.
On PostgreSQL a single one bypasses psycopg's cursors, too (:mod:`.prepared`).
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from typing import Any

from sqlalchemy import Connection, Insert, Select, Table, Update, bindparam, insert, update
from sqlalchemy.exc import DBAPIError

__all__ = ["Statement", "change", "commit", "enter"]

MANY = 50  # rows
CURSOR, PREPARED = "cursor", "prepared"  # of a connection, for all statements


class Statement:
    """A statement for SQLite and PostgreSQL, on columns whose values their drivers take and return as they are.

    Events of SQLAlchemy's engine do not report it.
    """

    def __init__(self, statement: Select[Any] | Insert | Update) -> None:
        self._statement = statement
        names = [column.name for column in statement.selected_columns] if isinstance(statement, Select) else []
        self._make = namedtuple("Row", names)._make  # type: ignore[attr-defined]  # names that are known only now
        self._compiled: dict[str, tuple[str, dict[str, Any], Sequence[str] | None]] = {}

    def rows(self, connection: Connection, given: Mapping[str, Any]) -> list[Any]:
        """Return what it selects.

        Raises
        ------
        sqlalchemy.exc.DBAPIError
        """
        return list(map(self._make, self._execute(connection, [given])[0]))

    def write(self, connection: Connection, given: Sequence[Mapping[str, Any]]) -> int:
        """Execute it with each of these values; return the number of rows that it wrote.

        Raises
        ------
        sqlalchemy.exc.DBAPIError
        """
        return self._execute(connection, given)[1]

    def _execute(self, connection: Connection, given: Sequence[Mapping[str, Any]]) -> tuple[Sequence[Any], int]:
        """Return the rows and the number of rows written."""
        dialect, kept = connection.dialect, connection.connection.info  # what is kept with a connection goes with it
        prepared = dialect.name == "postgresql" and len(given) == 1
        text, fixed, order = self._compile(_numbered() if prepared else dialect)
        values: Sequence[Any] = [{**fixed, **one} for one in given] if fixed else given
        if order is not None:
            values = [[one[name] for name in order] for one in values]
        try:
            if prepared:
                if PREPARED not in kept:
                    from geoswarm.workers.store.prepared import PreparedStatements  # nobody else needs the driver

                    kept[PREPARED] = PreparedStatements(_driver(connection))
                answer: tuple[Sequence[Any], int] = kept[PREPARED].execute(text, values[0])
                return answer
            if CURSOR not in kept:
                kept[CURSOR] = _driver(connection).cursor()
            cursor = kept[CURSOR]
            if len(values) == 1:
                cursor.execute(text, values[0])
            else:
                cursor.executemany(text, values)
            return cursor.fetchall() if cursor.description else (), cursor.rowcount
        except dialect.loaded_dbapi.Error as error:
            raise _of_sqlalchemy(connection, text, values, error) from error

    def _compile(self, dialect: Any) -> tuple[str, dict[str, Any], Sequence[str] | None]:
        key = dialect.paramstyle
        if key not in self._compiled:
            compiled = self._statement.compile(dialect=dialect)
            fixed = {name: value for name, value in compiled.params.items() if value is not None}
            self._compiled[key] = (str(compiled), fixed, compiled.positiontup if compiled.positional else None)
        return self._compiled[key]


def commit(connection: Connection) -> None:
    """Commit by libpq where it executed statements; SQLAlchemy then finds that nothing is left to commit.

    Raises
    ------
    sqlalchemy.exc.DBAPIError
    """
    prepared = connection.connection.info.get(PREPARED)
    if prepared is None:
        return
    try:
        prepared.commit()
    except connection.dialect.loaded_dbapi.Error as error:
        raise _of_sqlalchemy(connection, "COMMIT", (), error) from error


def _driver(connection: Connection) -> Any:
    return connection.connection.driver_connection


@cache
def _numbered() -> Any:
    """Return PostgreSQL's dialect with values as libpq takes them: ``$1``, ``$2`` ..."""
    from sqlalchemy.dialects.postgresql.psycopg import PGDialect_psycopg

    return PGDialect_psycopg(paramstyle="numeric_dollar")  # type: ignore[no-untyped-call]  # as the library has it


@cache
def change(table: Table, key: tuple[str, ...], names: tuple[str, ...]) -> Statement:
    """Return the statement that sets columns to ``to_NAME`` where those of the key are ``of_NAME``; built once."""
    here = (table.c[name] == bindparam(f"of_{name}") for name in key)
    return Statement(update(table).where(*here).values({name: bindparam(f"to_{name}") for name in names}))


def enter(connection: Connection, table: Table, rows: Sequence[Mapping[str, Any]]) -> None:
    """Insert rows with the same columns: a few in one statement, many by PostgreSQL's COPY, at a third of the cost.

    Raises
    ------
    sqlalchemy.exc.DBAPIError
    """
    names = tuple(rows[0])
    if len(rows) < MANY:
        given = {f"{name}_{number}": row[name] for number, row in enumerate(rows) for name in names}
        _insert(table, names, len(rows)).write(connection, [given])
    elif connection.dialect.name == "postgresql":
        _copy(connection, table, names, rows)
    else:
        _insert(table, names, 1).write(connection, [{f"{name}_0": row[name] for name in names} for row in rows])


@lru_cache(maxsize=256)
def _insert(table: Table, names: tuple[str, ...], count: int) -> Statement:
    values: Any = [{name: bindparam(f"{name}_{number}") for name in names} for number in range(count)]
    return Statement(insert(table).values(values).inline())


def _copy(connection: Connection, table: Table, names: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> None:
    text = f"COPY {table.name} ({', '.join(names)}) FROM STDIN"
    try:
        with _driver(connection).cursor() as cursor, cursor.copy(text) as copy:
            for row in rows:
                copy.write_row([row[name] for name in names])
    except connection.dialect.loaded_dbapi.Error as error:
        raise _of_sqlalchemy(connection, text, rows, error) from error


def _of_sqlalchemy(connection: Connection, text: str, values: Any, error: Any) -> DBAPIError:
    """Return what SQLAlchemy makes of an error of the driver."""
    dialect = connection.dialect
    dead = dialect.is_disconnect(error, _driver(connection), None)
    if dead:
        connection.invalidate(error)
    kind = dialect.loaded_dbapi.Error
    made: DBAPIError = DBAPIError.instance(text, values, error, kind, connection_invalidated=dead)
    return made
