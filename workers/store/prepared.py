"""Statements that a connection to PostgreSQL has prepared, executed by libpq.

A cursor of psycopg takes four times as long for a statement with few values and rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import psycopg
from psycopg.adapt import PyFormat, Transformer
from psycopg.errors import InvalidSqlStatementName, lookup
from psycopg.pq import DiagnosticField, ExecStatus, TransactionStatus
from psycopg.pq.abc import PGresult

__all__ = ["PreparedStatements"]

BINARY, TEXT = PyFormat.BINARY, PyFormat.TEXT


class PreparedStatements:
    """Those of one connection. Other threads go on while the database answers; signals are handled afterwards.

    psycopg lets the database forget all prepared statements after a failed transaction: the next one that needs one
    fails with :class:`psycopg.errors.InvalidSqlStatementName`, and can be tried again.
    """

    def __init__(self, connection: psycopg.Connection[Any]) -> None:
        self._connection = connection
        self._values = Transformer(connection)
        self._names: dict[str, bytes] = {}
        self._count = 0

    def execute(self, text: str, values: Sequence[Any]) -> tuple[list[tuple[Any, ...]], int]:
        """Execute a statement whose values are ``$1``, ``$2`` ...; return the rows and the number of rows changed.

        Raises
        ------
        psycopg.Error
        """
        libpq = self._connection.pgconn
        if libpq.transaction_status == TransactionStatus.IDLE and not self._connection.autocommit:
            self._checked(libpq.exec_(b"BEGIN"))
        name = self._names.get(text)
        if name is None:
            self._count += 1
            name = b"geoswarm_%d" % self._count
            self._checked(libpq.prepare(name, text.encode()))
            self._names[text] = name
        # A type that depends on a number's size would not fit the next one: the types are those of the statement.
        formats = [BINARY if type(value) is bytes else TEXT for value in values]
        given: Any = self._values.dump_sequence(values, formats)  # None is NULL, which the types of psycopg leave out
        result = self._checked(libpq.exec_prepared(name, given, self._values.formats))
        if result.status != ExecStatus.TUPLES_OK:
            return [], result.command_tuples or 0
        self._values.set_pgresult(result)
        return self._values.load_rows(0, result.ntuples, tuple), result.ntuples

    def commit(self) -> None:
        """Commit what they have done; the connection then is in no transaction.

        Raises
        ------
        psycopg.Error
        """
        libpq = self._connection.pgconn
        if libpq.transaction_status == TransactionStatus.INTRANS:
            self._checked(libpq.exec_(b"COMMIT"))

    def _checked(self, result: PGresult) -> PGresult:
        if result.status in (ExecStatus.TUPLES_OK, ExecStatus.COMMAND_OK):
            return result
        state = result.error_field(DiagnosticField.SQLSTATE)
        try:
            kind = psycopg.OperationalError if state is None else lookup(state.decode())
        except KeyError:
            kind = psycopg.DatabaseError
        if kind is InvalidSqlStatementName:
            self._names.clear()
        raise kind(result.get_error_message())
