"""Processes that run forward calculations."""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.dependencies import Service, problems_of
from geoswarm.api.schemas.jobs import WorkerList

__all__ = ["router"]

router = APIRouter(prefix="/workers", tags=["workers"])


@router.get("", responses=problems_of())
def list_workers(service: Service) -> WorkerList:
    """List the workers, what they do and when they were last seen."""
    return WorkerList(items=service.workers())
