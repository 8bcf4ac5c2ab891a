"""The service itself: its health, for supervisors and load balancers without an API key, and its workers."""

from __future__ import annotations

import anyio.to_thread
from fastapi import APIRouter, Request, Response

from geoswarm.api.dependencies import Service, limiter, problems_of
from geoswarm.api.schemas.responses import Liveness, WorkerList
from geoswarm.records.service import Health

__all__ = ["health_router", "workers_router"]

health_router = APIRouter(prefix="/health", tags=["health"])

WORKING = frozenset({"ok", "embedded"})


@health_router.get("/live")
async def live() -> Liveness:
    """Answer while the process is alive."""
    return Liveness()


@health_router.get("/ready", responses={503: {"model": Health, "description": "A dependency cannot be reached"}})
async def ready(service: Service, request: Request, response: Response) -> Health:
    """Show whether database and broker can be used, and which one cannot.

    One probe runs at a time; concurrent requests get the last answer.
    """
    dependencies = await anyio.to_thread.run_sync(service.health, limiter=limiter(request, "probes"))
    healthy = WORKING.issuperset(dependencies.values())
    response.status_code = 200 if healthy else 503
    return Health(status="ok" if healthy else "unavailable", dependencies=dependencies)


workers_router = APIRouter(prefix="/workers", tags=["workers"])


@workers_router.get("", responses=problems_of())
def list_workers(service: Service) -> WorkerList:
    """List the workers, what they do and when they were last seen."""
    return WorkerList(items=service.workers())
