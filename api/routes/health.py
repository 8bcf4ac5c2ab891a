"""Health, for supervisors and load balancers; needs no API key."""

from __future__ import annotations

import anyio.to_thread
from fastapi import APIRouter, Request, Response

from geoswarm.api.dependencies import Service, limiter
from geoswarm.api.schemas.jobs import Health, Liveness

__all__ = ["router"]

router = APIRouter(prefix="/health", tags=["health"])

WORKING = frozenset({"ok", "embedded"})


@router.get("/live")
async def live() -> Liveness:
    """Answer while the process is alive."""
    return Liveness()


@router.get("/ready", responses={503: {"model": Health, "description": "A dependency cannot be reached"}})
async def ready(service: Service, request: Request, response: Response) -> Health:
    """Show whether database and broker can be used, and which one cannot.

    One probe runs at a time; concurrent requests get the last answer.
    """
    dependencies = await anyio.to_thread.run_sync(service.health, limiter=limiter(request, "probes"))
    healthy = WORKING.issuperset(dependencies.values())
    response.status_code = 200 if healthy else 503
    return Health(status="ok" if healthy else "unavailable", dependencies=dependencies)
