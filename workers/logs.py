"""Log records on stderr, as text or as one JSON object a line; secrets are made unreadable in both.

Records about a job carry ``job``, and where it applies ``generation``, ``evaluation`` (the particle) and ``worker``.
"""

from __future__ import annotations

import json
import logging
import os
from datetime import UTC, datetime
from typing import Literal, TypeAlias

from geoswarm.workers.secrets import redact

__all__ = ["CONTEXT", "JsonFormatter", "KnownEvents", "LogFormat", "TextFormatter", "start_logging"]

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
)
"""What a record may carry beside its message (``extra=``)."""

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
        entry |= {name: getattr(record, name) for name in CONTEXT if getattr(record, name, None) is not None}
        if record.exc_info:
            entry["traceback"] = redact(self.formatException(record.exc_info))
        return json.dumps(entry, ensure_ascii=False, default=str)


class TextFormatter(logging.Formatter):
    """A line for readers, with the context at its end."""

    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")

    def format(self, record: logging.LogRecord) -> str:
        """Write a record."""
        context = [f"{name}={getattr(record, name)}" for name in CONTEXT if getattr(record, name, None) is not None]
        head, newline, traceback = super().format(record).partition("\n")
        return redact(f"{head} [{' '.join(context)}]{newline}{traceback}" if context else head + newline + traceback)


class KnownEvents(logging.Filter):
    """Leaves out what others log about events that are handled: it would look like a fault of ours.

    That a reader of events has gone (asyncio warns with every write until it notices), and the traceback of a pool
    process that was killed (Celery's, without a line of what was killed); the line that says so stays.
    """

    def filter(self, record: logging.LogRecord) -> bool:
        """Decide about a record."""
        if record.name == "asyncio" and record.getMessage().startswith("socket.send() raised exception"):
            return False
        kind = record.exc_info[0] if isinstance(record.exc_info, tuple) else None
        if record.name.startswith(("celery", "billiard")) and kind is not None and kind.__name__ == "WorkerLostError":
            record.exc_info = record.exc_text = None
        return True


def start_logging(level: str | int, form: LogFormat | None = None) -> None:
    """Write records of a level and above to stderr; processes that this one starts take over the form."""
    chosen = form or os.environ.get(FORMAT_VARIABLE, "text")
    os.environ[FORMAT_VARIABLE] = chosen
    handler = logging.StreamHandler()
    handler.setFormatter(JsonFormatter() if chosen == "json" else TextFormatter())
    handler.addFilter(KnownEvents())
    logging.basicConfig(level=level.upper() if isinstance(level, str) else level, handlers=[handler], force=True)
