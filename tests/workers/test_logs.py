"""Lines of the log: none can be forged, none tells a secret, and the same trouble is told once a second."""

from __future__ import annotations

import json
import logging
import sys

from geoswarm.workers.logs import MOST_OF_A_PLACE, JsonFormatter, Repetitions, TextFormatter


def record(message: str, *values: object, line: int = 1, level: int = logging.WARNING) -> logging.LogRecord:
    return logging.LogRecord("geoswarm", level, "file.py", line, message, values, None)


def test_a_line_cannot_be_forged() -> None:
    forged = "x\n2030-01-01 00:00:00 ERROR geoswarm: all is lost\r\x1b[31m"
    made = record("asked for %s", forged)
    made.path = made.job = forged
    written = TextFormatter().format(made)
    assert len(written.splitlines()) == 1
    assert written.isprintable()
    assert "asked for x\\n2030" in written


def test_lines_of_tracebacks_are_indented() -> None:
    try:
        raise ValueError("x\n2030-01-01 ERROR \x1b[31m")
    except ValueError:
        made = record("broken")
        made.exc_info = sys.exc_info()
    head, *rest = TextFormatter().format(made).splitlines()
    assert head.endswith("broken")
    assert rest
    assert all(line.startswith("  ") and line.isprintable() for line in rest)


def test_json_hides_secrets_in_the_context_too() -> None:
    made = record("GET")
    made.path = "/api/password=hunter22/redis://:hunter22@host"
    assert "hunter22" not in JsonFormatter().format(made)
    assert json.loads(JsonFormatter().format(made))["path"].startswith("/api/password=***")


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_the_same_trouble_is_told_once_a_second_and_how_often_it_was() -> None:
    clock = Clock()
    told = Repetitions(clock=clock)
    assert [told.filter(record("no room")) for _ in range(1000)].count(True) == 1
    assert told.filter(record("other trouble", line=2))
    clock.now = 1.0
    again = record("no room")
    assert told.filter(again)
    assert TextFormatter().format(again).endswith("no room [left_out=999]")


def test_one_place_does_not_flood_the_log_with_different_words() -> None:
    told = Repetitions(clock=Clock())
    assert [told.filter(record("refused %d", i)) for i in range(1000)].count(True) == MOST_OF_A_PLACE


def test_what_is_no_trouble_is_told_always() -> None:
    told = Repetitions(clock=Clock())
    assert all(told.filter(record("GET", level=logging.INFO)) for _ in range(100))
