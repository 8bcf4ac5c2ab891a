"""Agents: workers that reach the service by HTTP and nothing else. They see parameters and points x, no measurement."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, replace
from functools import partial
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Path, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse
from pydantic import ValidationError

from geoswarm.api.access.bodies import FileContent
from geoswarm.api.dependencies import Service, problems_of
from geoswarm.api.events.open_work import OpenWorkWatch
from geoswarm.api.schemas.agents import AgentTerms, Announced, Brought, LeaseAnswer, LeaseRequest, ResultsAnswer
from geoswarm.workers.agents.handed_out import HandedOut
from geoswarm.workers.agents.work import Announcement, BroughtRun, Grant, Wanted

__all__ = ["router"]

router = APIRouter(prefix="/agents", tags=["agents"])

BROUGHT_BODY = {
    "required": True,
    "content": {"application/json": {"schema": {"$ref": "#/components/schemas/Brought"}}},
}
AgentName = Annotated[str, Path(pattern=r"^[A-Za-z0-9._-]{1,60}$", description="that it has announced itself with")]
Digest = Annotated[str, Path(pattern=r"^[0-9a-f]{64}$", description="SHA-256 of the file")]
LeaseId = Annotated[str, Path(pattern=r"^[0-9a-f]{32}$", description="of the lease")]


async def _watch(request: Request) -> OpenWorkWatch:
    watch: OpenWorkWatch = request.app.state.open_work
    return watch


async def _key(service: Service) -> str:
    """The key of the sender; the gate has checked its permission."""
    return service.principal.key_id or ""


async def _models(request: Request) -> HandedOut:
    handed_out: HandedOut = request.app.state.handed_out
    return handed_out


Models = Annotated[HandedOut, Depends(_models)]
Watch = Annotated[OpenWorkWatch, Depends(_watch)]
Key = Annotated[str, Depends(_key)]


@router.put("/models", responses=problems_of(404, 408, 413, 422))
async def announce(agent: Announced, request: Request, key: Key, watch: Watch) -> AgentTerms:
    """Announce an agent with what it can run, or update it."""
    told = Announcement(
        agent.agent, agent.host, agent.system, agent.pid, agent.slots, agent.versions, agent.kinds, agent.models
    )
    terms = await watch.in_thread(lambda: watch.desk.announce(key, told))
    return AgentTerms(
        heartbeat_seconds=terms.heartbeat_seconds,
        lease_seconds=terms.lease_seconds,
        wait_seconds=request.app.state.settings.agent_wait_seconds,
        accepted=list(terms.accepted),
    )


@router.get(
    "/models",
    response_class=Response,
    responses={200: {"content": {"application/json": {}}}, **problems_of(404, 409)},
)
async def signed_models(models: Models) -> Response:
    """The signed list of registered models that agents may fetch, as ``geoswarm models sign`` has made it."""
    document = await anyio.to_thread.run_sync(models.document)
    return Response(document, media_type="application/json")


@router.get(
    "/models/files/{sha256}",
    response_class=FileResponse,
    responses={200: {"content": {"application/octet-stream": {}}}, **problems_of(404, 409, 422)},
)
async def model_file(sha256: Digest, models: Models) -> FileResponse:
    """One file of a model of that list, by its SHA-256."""
    path = await anyio.to_thread.run_sync(models.file, sha256)
    return FileResponse(path, media_type="application/octet-stream")


@router.delete("/{agent}", status_code=204, response_class=Response, responses=problems_of(422))
async def sign_off(agent: AgentName, key: Key, watch: Watch) -> None:
    """Sign off an agent; what it still holds goes to others when its lease expires."""
    if await watch.in_thread(lambda: watch.desk.sign_off(key, agent)):
        watch.dismiss(agent)


@router.post("/leases", response_model=LeaseAnswer, responses=problems_of(404, 408, 413, 422))
async def lease(wanted: LeaseRequest, request: Request, key: Key, watch: Watch) -> Response:
    """Request a lease, and wait for it."""
    desk, began, admitted = watch.desk, time.monotonic(), request.app.state.authenticator.admits
    asked = _wanted(wanted)
    offers = await watch.in_thread(lambda: desk.offers(key, wanted.agent))
    while True:
        waited = time.monotonic() - began
        left = None if wanted.seconds is None else max(wanted.seconds - waited, 0.0)
        now_asked = replace(asked, seconds=left)
        grant = None
        nothing = wanted.wait > 0 and watch.nothing_for(offers, left)
        if not nothing and not await request.is_disconnected():  # a client that has left must not be given anything
            grant = await watch.in_thread(partial(desk.lease, key, now_asked))
        if grant is not None or waited >= wanted.wait or watch.closed or await request.is_disconnected():
            return _answer({"lease": _shown(grant)})
        woken = await watch.wait(wanted.agent, offers, left, wanted.wait - waited, request.receive)
        # A key may have been revoked meanwhile; the next request with it is refused.
        if not woken or not await admitted(request.headers):
            return _answer({"lease": None})


@router.post("/leases/{lease}/beat", status_code=204, response_class=Response, responses=problems_of(410, 422))
async def beat(lease: LeaseId, key: Key, watch: Watch) -> None:
    """Extend a lease. Status 410 means that it has ended: kill what runs for it."""
    await watch.in_thread(lambda: watch.desk.beat(key, lease))


@router.post(
    "/leases/{lease}/results",
    response_model=ResultsAnswer,
    responses=problems_of(408, 410, 413, 422),
    openapi_extra={"requestBody": BROUGHT_BODY},
)
async def hand_in(lease: LeaseId, content: FileContent, key: Key, watch: Watch) -> Response:
    """Deliver the results of a lease, which ends it, and request the next one. Delivering twice changes nothing."""
    return await watch.in_thread(lambda: _take_in(watch, key, lease, content))


def _take_in(watch: OpenWorkWatch, key: str, lease_id: str, content: bytes) -> Response:
    try:
        brought = Brought.model_validate_json(content)
    except ValidationError as error:
        raise RequestValidationError(
            [{**item, "loc": ("body", *item["loc"])} for item in error.errors(include_url=False)]
        ) from None
    runs = [
        BroughtRun(r.particle, r.attempt, r.responses, r.reason, r.message, r.log, r.seconds, r.began, r.ended)
        for r in brought.runs
    ]
    wanted = None if brought.next is None or watch.closed else _wanted(brought.next)
    taken, grant = watch.desk.submit(key, lease_id, runs, brought.killed, wanted)
    return _answer({"taken": taken, "lease": _shown(grant)})


def _wanted(request: LeaseRequest) -> Wanted:
    return Wanted(request.agent, request.slot, request.runs, request.seconds, frozenset(request.frames))


def _shown(grant: Grant | None) -> dict[str, Any] | None:
    return None if grant is None else asdict(grant)


def _answer(content: dict[str, Any]) -> Response:
    return Response(json.dumps(content, allow_nan=False, separators=(",", ":")), media_type="application/json")
