"""What libraries log about events that are handled."""

from __future__ import annotations

import asyncio
import logging

import pytest

from geoswarm.workers.logs import KnownEvents


class WorkerLostError(Exception):
    """As Celery's pool calls it."""


def record(name: str, message: str, error: Exception | None = None) -> logging.LogRecord:
    info = None if error is None else (type(error), error, None)
    return logging.LogRecord(name, logging.WARNING, "", 0, message, (), info)


def test_a_reader_that_has_gone_is_no_warning() -> None:
    known = KnownEvents()
    assert not known.filter(record("asyncio", "socket.send() raised exception."))
    assert known.filter(record("asyncio", "Task was destroyed but it is pending!"))


def test_a_connection_that_was_ready_too_late_is_no_error() -> None:
    message = "Exception in callback Future.set_result(None)"
    assert not KnownEvents().filter(record("asyncio", message, asyncio.InvalidStateError("invalid state")))
    assert KnownEvents().filter(record("asyncio", message, ValueError("a bug")))


@pytest.mark.parametrize(("error", "kept"), [(WorkerLostError("signal 9"), False), (ValueError("a bug"), True)])
def test_a_killed_pool_process_has_a_line_but_no_traceback(error: Exception, kept: bool) -> None:
    made = record("celery.app.trace", "Task handler raised error", error)
    assert KnownEvents().filter(made)
    assert (made.exc_info is not None) is kept
