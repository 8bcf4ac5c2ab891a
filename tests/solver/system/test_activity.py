"""What is waited is counted in its thread, and told to a listener."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from geoswarm.solver.runner.shared_state import IDLE, SharedState
from geoswarm.solver.system import activity
from geoswarm.solver.system.activity import counting, doing, has_waited, listen, waiting


@pytest.fixture
def shared(monkeypatch: pytest.MonkeyPatch) -> Iterator[SharedState]:
    monkeypatch.setattr(activity, "_listeners", [])
    descriptor = os.memfd_create("state")
    state = SharedState(descriptor, new=True)
    listen(state)
    yield state
    state.close()
    os.close(descriptor)


def test_waiting_is_counted_where_somebody_counts(shared: SharedState) -> None:
    shared.begin(0)
    with counting() as outer:
        has_waited(3.0)
        with counting() as inner, waiting():
            now = shared.current.waited
            assert 3.0 <= now <= shared.current.waited  # it goes on while it is waited
        has_waited(0.5)
    assert outer.seconds == 3.5
    assert inner.seconds >= 0.0
    has_waited(1.0)  # nobody counts
    assert outer.seconds == 3.5
    assert shared.current.waited == pytest.approx(4.5 + inner.seconds, rel=1e-12)


def test_the_next_evaluation_has_not_waited(shared: SharedState) -> None:
    shared.begin(0)
    with pytest.raises(KeyError), waiting():
        raise KeyError
    has_waited(2.0)
    assert shared.current.waited >= 2.0
    shared.begin(1)
    assert shared.current.waited == 0.0


def test_what_is_done_is_told_while_it_lasts(shared: SharedState) -> None:
    assert shared.doing == ""
    with doing("reading series φ from out.csv"):
        assert shared.doing == "reading series φ from out.csv"
    assert shared.doing == ""
    with doing("ü" * 1000):
        assert shared.doing.startswith("ü" * 90)
        assert not shared.stopped
    with pytest.raises(ZeroDivisionError), doing("something"):
        raise ZeroDivisionError
    assert shared.doing == ""


WRITER = """
import sys
from geoswarm.solver.runner.shared_state import SharedState

shared = SharedState(int(sys.argv[1]), new=False)
for count in range(200_000):
    shared.begin(3 + count % 4)
"""


def test_what_is_read_was_written_at_one_moment() -> None:
    """A position whose beginning was not written yet would look as if it had run since the machine was started."""
    descriptor = os.memfd_create("state")
    shared = SharedState(descriptor, new=True)
    before = shared.current.since
    with subprocess.Popen([sys.executable, "-c", WRITER, str(descriptor)], pass_fds=[descriptor]) as writer:
        while writer.poll() is None:
            for _ in range(1000):
                index, since, _ = shared.current
                assert index in (IDLE, 3, 4, 5, 6)
                assert before <= since <= time.monotonic()
    assert writer.returncode == 0
    assert shared.current.position == 6
    shared.close()
    os.close(descriptor)
