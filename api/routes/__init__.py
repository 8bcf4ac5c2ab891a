"""The routes of /api/v1, /health and /metrics, one module a resource; ``findings`` has what a job tells."""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.paths import API_PREFIX
from geoswarm.api.routes import (
    administration,
    events,
    examples,
    forward_models,
    health,
    jobs,
    measurements,
    metrics,
    problems,
    results,
    session,
    workers,
)
from geoswarm.api.routes.findings import fit, mesh, points, statistics, uncertainty

__all__ = ["api_router", "health_router", "metrics_router"]

api_router = APIRouter(prefix=API_PREFIX)
for module in (
    jobs,
    results,
    fit,
    points,
    statistics,
    uncertainty,
    events,
    problems,
    examples,
    measurements,
    forward_models,
    workers,
    session,
    administration,
    mesh,
):
    api_router.include_router(module.router)
health_router = health.router
metrics_router = metrics.router
