"""Counts, times, logs and traces every request; by the route's template, never by what a client wrote."""

from __future__ import annotations

import logging
import time

from prometheus_client import CollectorRegistry, Counter, Histogram, disable_created_metrics
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from geoswarm.api.settings import API_PREFIX
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.tracing import span

__all__ = ["Observer", "RequestMetrics"]

disable_created_metrics()  # type: ignore[no-untyped-call]  # untyped library; drops unused times
logger = logging.getLogger("geoswarm.access")

METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})
MOST_OF_PATH = 500
"""Characters of a path that logs and traces show."""
BUCKETS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0, 3.0, 10.0)


class RequestMetrics:
    """Counters of the requests to one application."""

    def __init__(self) -> None:
        self.registry = CollectorRegistry()
        self.requests = Counter(
            "geoswarm_http_requests",
            "Requests to this process.",
            ["method", "route", "status"],
            registry=self.registry,
        )
        self.seconds = Histogram(
            "geoswarm_http_seconds",
            "Time until the answer to a request began.",
            ["route"],
            buckets=BUCKETS,
            registry=self.registry,
        )


class Observer:
    """ASGI middleware around everything else."""

    def __init__(self, app: ASGIApp, metrics: RequestMetrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        method = scope["method"] if scope["method"] in METHODS else "other"
        began = time.monotonic()

        async def watch(message: Message) -> None:
            if message["type"] == "http.response.start":
                self._note(scope, method, message["status"], time.monotonic() - began)
            await send(message)

        with span(f"HTTP {method}", method=method, path=scope["path"][:MOST_OF_PATH]):
            await self._app(scope, receive, watch)

    def _note(self, scope: Scope, method: str, status: int, seconds: float) -> None:
        route = str(getattr(scope.get("route"), "path", "-"))
        if scope["path"].startswith(API_PREFIX) and not route.startswith(API_PREFIX) and route != "-":
            route = API_PREFIX + route
        self._metrics.requests.labels(method, route, str(status)).inc()
        self._metrics.seconds.labels(route).observe(seconds)
        principal: Principal | None = scope.get("state", {}).get("principal")
        logger.info(
            "%s %s %d",
            method,
            route,
            status,
            extra={
                "method": method,
                "path": scope["path"][:MOST_OF_PATH],
                "status": status,
                "seconds": round(seconds, 6),
                "key": principal.key_id if principal else None,
            },
        )
