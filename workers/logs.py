"""Log records on stderr, as text or as one JSON object a line; secrets are made unreadable in both.

A text line ends where its record ends: control characters are escaped, lines of tracebacks are indented. The same
trouble is logged once a second.

Records about a job carry ``job``, and where it applies ``generation``, ``evaluation`` (the particle) and ``worker``.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
import textwrap
import time
from collections import Counter
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Literal, TypeAlias

from geoswarm.solver.words import visible
from geoswarm.workers.secrets import redact

__all__ = ["CONTEXT", "JsonFormatter", "KnownEvents", "LogFormat", "Repetitions", "TextFormatter", "start_logging"]

LogFormat: TypeAlias = Literal["text", "json"]

CONTEXT = (
    "job",
    "generation",
    "evaluation",
    "worker",
    "reason",
    "method",
    "path",
    "status",
    "seconds",
    "key",
    "trace",
    "left_out",
)
"""What a record may carry beside its message (``extra=``)."""

MOST_OF_A_PLACE = 10
LONGEST_COMPARED = 1000
FORMAT_VARIABLE = "GEOSWARM_LOG_FORMAT"


class JsonFormatter(logging.Formatter):
    """One JSON object a record: time, level, logger, message, pid, the context that it carries, the traceback."""

    def format(self, record: logging.LogRecord) -> str:
        """Write a record."""
        entry: dict[str, object] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": redact(record.getMessage()),
            "pid": record.process,
        }
        entry |= {name: redact(value) if isinstance(value, str) else value for name, value in _context(record)}
        if record.exc_info:
            entry["traceback"] = redact(self.formatException(record.exc_info))
        return json.dumps(entry, ensure_ascii=False, default=str)


class TextFormatter(logging.Formatter):
    """A line for readers, with the context at its end."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")

    def format(self, record: logging.LogRecord) -> str:
        """Write a record."""
        traceback = self.formatException(record.exc_info) if record.exc_info else record.exc_text
        record.message = visible(record.getMessage())
        record.asctime = self.formatTime(record)
        line = self.formatMessage(record)
        context = " ".join(f"{name}={visible(str(value))}" for name, value in _context(record))
        line += f" [{context}]" if context else ""
        if traceback:
            line += "\n" + textwrap.indent(visible(traceback, lines=True), "  ")
        return redact(line)


def _context(record: logging.LogRecord) -> list[tuple[str, object]]:
    return [(name, value) for name in CONTEXT if (value := getattr(record, name, None)) is not None]


class KnownEvents(logging.Filter):
    """Leaves out what others log about events that are handled: it would look like a fault of ours.

    That a reader of events has gone (asyncio warns with every write until it notices), that a stopping service gave up
    a request (the server has a line for all of them), that a connection was ready just when its reader gave up (anyio
    does not mind), and the traceback of a pool process that was killed (Celery's,
    without a line of what was killed); the line that says so stays.
    """

    def filter(self, record: logging.LogRecord) -> bool:
        """Decide about a record."""
        if record.name == "asyncio" and record.getMessage().startswith("socket.send() raised exception"):
            return False
        kind = record.exc_info[0] if isinstance(record.exc_info, tuple) else None
        if record.name == "asyncio" and kind is asyncio.InvalidStateError:
            return False
        if record.name == "uvicorn.error" and kind is asyncio.CancelledError:
            return False
        if record.name.startswith(("celery", "billiard")) and kind is not None and kind.__name__ == "WorkerLostError":
            record.exc_info = record.exc_text = None
        return True


class Repetitions(logging.Filter):
    """Lets the same warning through once in ``every`` seconds, and ``most`` of one place in the sources in that time.

    The next one that is let through carries how many were ``left_out``.
    """

    def __init__(
        self, every: float = 1.0, most: int = MOST_OF_A_PLACE, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__()
        self._every = every
        self._most = most
        self._clock = clock
        self._began = clock()
        self._seen: Counter[tuple[object, ...]] = Counter()
        self._left_out: Counter[tuple[object, ...]] = Counter()

    def filter(self, record: logging.LogRecord) -> bool:
        """Decide about a record."""
        if record.levelno < logging.WARNING:
            return True
        if self._clock() - self._began >= self._every:
            self._began = self._clock()
            self._seen.clear()
        place = (record.name, record.pathname, record.lineno)
        same = (*place, record.getMessage()[:LONGEST_COMPARED])
        if self._seen[same] or self._seen[place] >= self._most:
            self._left_out[place] += 1
            return False
        self._seen[same] += 1
        self._seen[place] += 1
        left_out = self._left_out.pop(place, 0)
        if left_out:
            record.left_out = left_out
        return True


def start_logging(level: str | int, form: LogFormat | None = None) -> None:
    """Write records of a level and above to stderr; processes that this one starts take over the form."""
    chosen = form or os.environ.get(FORMAT_VARIABLE, "text")
    os.environ[FORMAT_VARIABLE] = chosen
    handler = logging.StreamHandler()
    handler.setFormatter(JsonFormatter() if chosen == "json" else TextFormatter())
    handler.addFilter(KnownEvents())
    handler.addFilter(Repetitions())
    logging.basicConfig(level=level.upper() if isinstance(level, str) else level, handlers=[handler], force=True)
