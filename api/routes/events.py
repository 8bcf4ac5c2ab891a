"""Live events of a job as server-sent events."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from contextlib import aclosing, suppress
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.types import Receive, Scope, Send

from geoswarm.api.access.authentication import Authenticator
from geoswarm.api.access.limits import Shares
from geoswarm.api.dependencies import Feed, JobId, Service, problems_of
from geoswarm.api.errors import DetailError, detail_response
from geoswarm.api.events.feed import EventFeed
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import StoreUnavailableError

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["results"])

RECONNECT_MILLISECONDS = 1000
MAX_EVENT_ID = 2**63 - 1


@router.get(
    "/events",
    response_class=StreamingResponse,
    responses={
        200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}, "description": "A stream of events"},
        204: {"description": "The job has ended and there is nothing after the given event: do not reconnect"},
        **problems_of(404, 422),
    },
)
async def events(
    job_id: JobId,
    feed: Feed,
    service: Service,
    request: Request,
    after: Annotated[int | None, Query(ge=0, le=MAX_EVENT_ID, description="id of the last event received")] = None,
    last_event_id: Annotated[
        str | None, Header(description="sent by clients that reconnect; takes precedence over after")
    ] = None,
) -> Response:
    """Follow a job: ``state``, ``generation`` and ``versions`` events, from the first one or after a given one.

    Of a job with hundreds of generations a second, some events are skipped, but never the last of several.
    Comments keep a silent connection alive. The stream ends after the event that ends the job, and when the key or
    session that opened it is no longer valid.
    """
    start = _start(after, last_event_id)
    await anyio.to_thread.run_sync(service.get, job_id)  # the feed itself knows no owners
    if not await feed.read(job_id, start) and await feed.has_ended(job_id):
        return Response(status_code=204)
    return _EventStream(
        _stream(feed, job_id, start, request),
        media_type="text/event-stream",
        headers={"X-Accel-Buffering": "no"},
    )


class _EventStream(StreamingResponse):
    """A stream that has its place among those of its key as long as it is open."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        streams: Shares = scope["app"].state.streams
        principal: Principal = scope["state"]["principal"]
        key = principal.key_id or ""
        hindered = streams.take(key)
        if hindered is not None:
            await self.body_iterator.aclose()  # type: ignore[attr-defined]  # the generator that the route made
            await detail_response(_too_many(streams, each=hindered == "each"))(scope, receive, send)
            return
        try:
            await super().__call__(scope, receive, send)
        finally:
            streams.give_back(key)


def _too_many(streams: Shares, *, each: bool) -> DetailError:
    of = f"{streams.each} of this API key" if each else f"{streams.in_all}"
    return DetailError(
        429 if each else 503,
        f"The maximum number of open event streams, {of}, is reached.",
        kind="rate-limited" if each else "unavailable",
        headers={"Retry-After": "5"},
    )


def _start(after: int | None, last_event_id: str | None) -> int:
    if last_event_id is None:
        return after or 0
    if last_event_id.isascii() and last_event_id.isdigit() and int(last_event_id) <= MAX_EVENT_ID:
        return int(last_event_id)
    raise DetailError(422, f"Last-Event-ID {last_event_id!r} is not the id of an event (a whole number).")


async def _stream(feed: EventFeed, job_id: str, after: int, request: Request) -> AsyncIterator[str]:
    authenticator: Authenticator = request.app.state.authenticator
    # A key is revoked, a session ends, the first key is made meanwhile: the stream ends. Without keys that is quickly
    # known, else looked up twice a heartbeat.
    pause = 0.5 * feed.heartbeat_seconds if authenticator.needed else 0.0
    looked = time.monotonic()
    yield f"retry: {RECONNECT_MILLISECONDS}\n\n"
    async with aclosing(feed.listen(job_id, after)) as listening:
        async for text in listening:
            if time.monotonic() >= looked + pause:
                with suppress(StoreUnavailableError):
                    if not await authenticator.admits(request.headers):
                        return
                looked = time.monotonic()
            yield ": still here\n\n" if text is None else text
