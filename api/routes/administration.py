"""For administrators: API keys, and how the installation is doing."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path

from geoswarm.api.dependencies import Feed, Service, problems_of
from geoswarm.api.errors import role_refused
from geoswarm.api.schemas.administration import KeyList, NewKeyRequest
from geoswarm.records.account import Key, NewKey
from geoswarm.records.service import Operations
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService

__all__ = ["router"]


async def _administrated(service: Service) -> JobService:
    """The service, for administrators only."""
    if not service.principal.may("admin"):
        raise role_refused(service.principal.role, "this needs 'admin'")
    return service


Administrated = Annotated[JobService, Depends(_administrated)]
KeyId = Annotated[str, Path(pattern=r"^[0-9a-f]{12}$", description="public part of the key")]

router = APIRouter(tags=["administration"])


@router.get("/operations", responses=problems_of())
def show_operations(service: Administrated, feed: Feed) -> Operations:
    """Show waiting and running work and the outcomes of forward runs; administrators only."""
    measures = service.measures()
    runs = {label: int(value) for (name, label), value in measures.counters.items() if name == "runs"}
    return Operations(
        jobs=dict(measures.jobs),
        waiting=measures.waiting,
        running=measures.running,
        oldest_wait=measures.oldest_wait,
        workers=dict(measures.workers),
        outcomes=runs,
        lost_evaluations=int(measures.counters.get(("lease_expirations", ""), 0)),
        event_streams=feed.listeners,
    )


@router.get("/keys", responses=problems_of())
def list_keys(service: Administrated) -> KeyList:
    """List all API keys, without their secrets; administrators only."""
    return KeyList(items=ApiKeys(service.store).list())


@router.post("/keys", status_code=201, responses=problems_of(408, 413, 422))
def create_key(wanted: NewKeyRequest, service: Administrated) -> NewKey:
    """Create an API key; the answer is the only place where it can be read. Administrators only."""
    key, view = ApiKeys(service.store).create(
        wanted.owner, wanted.role, label=wanted.label, valid_seconds=wanted.valid_seconds
    )
    return NewKey(key=key, view=view)


@router.post("/keys/{key_id}/revoke", responses=problems_of(404, 422))
def revoke_key(key_id: KeyId, service: Administrated) -> Key:
    """Revoke an API key, from the next request and permanently; administrators only."""
    return ApiKeys(service.store).revoke(key_id)
