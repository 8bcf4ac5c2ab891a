"""The routes of /api/v1, /health and /metrics, one module a resource."""

from __future__ import annotations

from fastapi import APIRouter

from api.routes import (
    events,
    examples,
    fit,
    forward_models,
    health,
    jobs,
    measurements,
    metrics,
    problems,
    results,
    session,
    statistics,
    uncertainty,
    workers,
)

__all__ = ["API_PREFIX", "api_router", "health_router", "metrics_router"]

API_PREFIX = "/api/v1"

api_router = APIRouter(prefix=API_PREFIX)
for module in (
    jobs,
    results,
    fit,
    statistics,
    uncertainty,
    events,
    problems,
    examples,
    measurements,
    forward_models,
    workers,
    session,
):
    api_router.include_router(module.router)
health_router = health.router
metrics_router = metrics.router
