"""Read-only links: addresses that show one job to people without a key, until they expire or are revoked."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path, Request

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.administration import KeyList, NewLinkRequest
from geoswarm.records.account import Key, NewLink
from geoswarm.workers.service.links import Links

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}/links", tags=["jobs"])


async def _links(service: Service) -> Links:
    return service.links


Own = Annotated[Links, Depends(_links)]
LinkId = Annotated[str, Path(description="id of the link, which the list shows")]


@router.get("", responses=problems_of(404))
def links(job_id: JobId, own: Own) -> KeyList:
    """List the read-only links to a job, without their secrets, oldest first."""
    return KeyList(items=own.list(job_id))


@router.post("", status_code=201, responses=problems_of(404, 408, 409, 413, 422))
def create_link(job_id: JobId, wanted: NewLinkRequest, own: Own, request: Request) -> NewLink:
    """Create a link that shows this job and nothing else; the answer is the only place where it can be read.

    The link opens in a browser without a key. Its secret stands behind ``#``, which browsers send to no server. It is
    also an API key of role ``read`` for the results of this job.
    """
    if not request.app.state.authenticator.asks_here():
        raise DetailError(
            409,
            "This service asks for no API key: who can reach it sees all jobs, so a link could protect nothing. "
            f"Give the address /jobs/{job_id} itself.",
            kind="no-key-needed",
            title="No link needed",
        )
    key, view = own.create(job_id, label=wanted.label, valid_seconds=wanted.valid_days * 86400.0)
    return NewLink(path=f"/sign-in?next=/jobs/{job_id}#{key}", view=view)


@router.post("/{link_id}/revoke", responses=problems_of(404))
def revoke_link(job_id: JobId, link_id: LinkId, own: Own) -> Key:
    """Revoke a read-only link, from the next request and permanently."""
    return own.revoke(job_id, link_id)
