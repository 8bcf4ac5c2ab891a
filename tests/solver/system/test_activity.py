"""What is waited is counted in its thread, and told to a listener."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from geoswarm.solver.runner.shared_state import SharedState
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
            now = shared.waited
            assert 3.0 <= now <= shared.waited  # it goes on while it is waited
        has_waited(0.5)
    assert outer.seconds == 3.5
    assert inner.seconds >= 0.0
    has_waited(1.0)  # nobody counts
    assert outer.seconds == 3.5
    assert shared.waited == pytest.approx(4.5 + inner.seconds, rel=1e-12)


def test_the_next_evaluation_has_not_waited(shared: SharedState) -> None:
    shared.begin(0)
    with pytest.raises(KeyError), waiting():
        raise KeyError
    has_waited(2.0)
    assert shared.waited >= 2.0
    shared.begin(1)
    assert shared.waited == 0.0


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
