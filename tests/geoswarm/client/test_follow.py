"""Reading event streams: the format, when to reconnect, when to give up."""

from __future__ import annotations

import httpx
import pytest

from geoswarm import Client, ConnectionFailedError, NotFoundError, ServerError
from geoswarm.client import Event
from geoswarm.client.follow import Follower, SilentStreamError, pause_before
from geoswarm.client.sse import EventReader
from tests.api.conftest import LiveServer, line_problem


def feed(reader: EventReader, text: str) -> list[Event]:
    return [event for line in text.split("\n") if (event := reader.feed(line)) is not None]


def test_events_comments_and_unknown_fields() -> None:
    reader = EventReader()
    text = (
        ": hello\nretry: 1000\n\n"
        'id: 4\nevent: state\ndata: {"state": "running"}\n\n'
        ": alive\n\n"
        'id: 5\nevent:generation\ndata:{"number":\ndata:0}\nnew: field\n\n'
    )
    assert feed(reader, text) == [
        Event(id=4, kind="state", data={"state": "running"}),
        Event(id=5, kind="generation", data={"number": 0}),
    ]
    assert reader.last_id == 5


def test_an_incomplete_event_is_not_one() -> None:
    reader = EventReader(3)
    assert feed(reader, 'id: 4\nevent: state\ndata: {"st') == []
    reader.reset()
    assert feed(reader, "\n\nid: 5\ndata: {}\n\n") == [Event(id=5, kind="message", data={})]
    assert feed(reader, "id: x\ndata: {}\n\n") == []
    assert reader.last_id == 5


class Clock:
    """Time that a test moves [s]."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr("geoswarm.client.follow.monotonic", made)
    return made


def follower(**settings: float) -> Follower:
    return Follower(0, **{"patience": 10.0, "silence": 45.0, **settings})


def test_pauses_grow_and_start_again_when_something_comes() -> None:
    ours = follower()
    pauses = []
    for _ in range(6):
        ours.read_timeout()
        pauses.append(ours.broken(httpx.ConnectError("refused")))
    assert pauses == pytest.approx([0.2, 0.4, 0.8, 1.6, 3.0, 3.0], rel=1e-12)
    ours.hear(": alive")
    assert ours.broken(None) == pytest.approx(0.2, rel=1e-12)


def test_patience_ends(clock: Clock) -> None:
    ours = follower(patience=20.0)
    ours.read_timeout()
    ours.broken(httpx.ConnectError("refused"))
    clock.now += 20.0
    assert ours.broken(httpx.ConnectError("refused")) == pytest.approx(0.4, rel=1e-12)
    clock.now += 0.1
    with pytest.raises(ConnectionFailedError, match="refused"):
        ours.broken(httpx.ConnectError("refused"))


def test_refusals_are_final_but_an_unavailable_service_may_come_back(clock: Clock) -> None:
    with pytest.raises(NotFoundError):
        follower().broken(NotFoundError(404, "Not Found", ""))
    with pytest.raises(ServerError):
        follower().broken(ServerError(500, "Internal Server Error", ""))
    ours = follower(patience=20.0)
    unavailable = ServerError(503, "Database unavailable", "")
    assert ours.broken(unavailable) == pytest.approx(0.2, rel=1e-12)
    clock.now += 20.1
    with pytest.raises(ServerError, match="Database unavailable"):
        ours.broken(unavailable)


def test_silence_is_told_from_a_deadline(clock: Clock) -> None:
    ours = follower()
    ours.read_timeout()
    assert ours.broken(httpx.ReadTimeout("")) > 0.0
    ours.read_timeout()
    with pytest.raises(SilentStreamError, match="stayed silent for 45 s"):
        ours.broken(httpx.ReadTimeout(""))
    near = follower(deadline=clock.now + 0.5)
    assert near.read_timeout() == 0.5
    assert near.broken(httpx.ReadTimeout("")) == 0.0
    assert not near.expired
    clock.now += 0.5
    assert near.expired
    assert near.should_reconnect


def test_the_end_of_a_job_ends_the_stream() -> None:
    ours = follower()
    lines = ["id: 9", "event: state", 'data: {"state": "cancelled"}', ""]
    events = [event for line in lines if (event := ours.hear(line)) is not None]
    assert events == [Event(id=9, kind="state", data={"state": "cancelled"})]
    assert ours.ended
    assert ours.last_id == 9


def test_pauses_of_polling(clock: Clock) -> None:
    assert pause_before(None) == 1.0
    assert pause_before(clock.now - 1.0) == 0.0
    assert pause_before(clock.now + 0.5) == 0.5


class HoldsStreamsBack(httpx.HTTPTransport):
    """A network on which event streams open but never bring anything, as behind a proxy that collects them."""

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        if request.url.path.endswith("/events"):
            raise httpx.ReadTimeout("nothing came", request=request)
        return super().handle_request(request)


def test_waiting_asks_now_and_then_where_streams_do_not_get_through(server: LiveServer) -> None:
    with Client(server.url, transport=HoldsStreamsBack()) as client:
        job = client.submit(line_problem())
        assert client.wait(job.id, timeout=200).state == "finished"
        with pytest.raises(SilentStreamError):
            list(client.events(job.id))
