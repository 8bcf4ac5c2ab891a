"""Until when an agent runs, and how long it waits."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest

from geoswarm.agent.server import LONGEST_SECONDS, Backoff, Patience
from geoswarm.agent.spans import seconds_until

NOON = datetime(2026, 5, 1, 12, 0, tzinfo=UTC)


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("+90", 90.0),
        ("+90m", 5400.0),
        ("+1.5h", 5400.0),
        ("+2d", 172800.0),
        ("12:30", 1800.0),
        ("11:30", 84600.0),
        ("12:00:05", 5.0),
        ("2026-05-01T13:00+00:00", 3600.0),
        ("2026-05-01 13:00+00:00", 3600.0),
        (str(int(NOON.timestamp()) + 60), 60.0),
    ],
)
def test_times_and_spans(text: str, seconds: float) -> None:
    assert seconds_until(text, NOON) == seconds


@pytest.mark.parametrize("text", ["", "soon", "+", "+5y", "-5m", "25:00", "2026-13-01", "2026-05-01T11:00+00:00", "0"])
def test_what_is_no_time_or_over_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="accepted: \\+SPAN"):
        seconds_until(text, NOON)


def test_waits_grow_up_to_half_a_minute_and_differ() -> None:
    waits = [Backoff() for _ in range(20)]
    for _ in range(12):
        found = [wait.next() for wait in waits]
    assert all(LONGEST_SECONDS / 2 <= seconds <= LONGEST_SECONDS for seconds in found)
    assert len(set(found)) == 20


def test_a_request_for_work_waits_longer_while_nothing_breaks_it_off() -> None:
    patience = Patience()
    patience.answered(50.0, after=2.0)  # the service went down, or the agent asked for less
    waits = []
    for _ in range(5):
        waits.append(patience.seconds(50.0))
        patience.answered(50.0, after=waits[-1])
    assert waits == [50.0, 100.0, 200.0, 300.0, 300.0]
    assert Patience().seconds(600.0) == 600.0


def test_a_request_that_was_broken_off_is_not_tried_again_so_soon() -> None:
    patience = Patience()
    patience.broken_off(50.0, after=30.0)  # a restart of the service says nothing about proxies
    patience.answered(50.0, after=50.0)
    assert patience.seconds(50.0) == 100.0
    patience.broken_off(50.0, after=60.0)
    for _ in range(3):
        assert patience.seconds(50.0) == 50.0
        patience.answered(50.0, after=50.0)
