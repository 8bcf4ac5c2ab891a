"""Health, for supervisors and load balancers; needs no API key."""

from __future__ import annotations

from fastapi import APIRouter, Response

from geoswarm.api.dependencies import Service
from geoswarm.api.schemas import Health, Liveness

__all__ = ["router"]

router = APIRouter(prefix="/health", tags=["health"])

WORKING = frozenset({"ok", "embedded"})


@router.get("/live")
async def live() -> Liveness:
    """Tell that the process answers."""
    return Liveness()


@router.get("/ready", responses={503: {"model": Health, "description": "A dependency cannot be reached"}})
def ready(service: Service, response: Response) -> Health:
    """Tell whether database and broker can be reached, and which one cannot."""
    dependencies = service.health()
    healthy = WORKING.issuperset(dependencies.values())
    response.status_code = 200 if healthy else 503
    return Health(status="ok" if healthy else "unavailable", dependencies=dependencies)
