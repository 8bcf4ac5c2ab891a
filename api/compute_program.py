"""The program of a process for requests that calculate: the same application, behind no door."""

from __future__ import annotations

import json
import os
import socket
import sys
import threading
from collections.abc import Mapping
from typing import Any

import uvicorn
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from geoswarm.api.app import create_app
from geoswarm.api.compute.process import PRINCIPAL_HEADER, ROUTE_HEADER
from geoswarm.solver.system.processes import go_first_without_memory
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.hosts.alone import remote_waker
from geoswarm.workers.hosts.embedded import PipeWaker
from geoswarm.workers.logs import start_logging
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

__all__ = ["InternalApp", "main"]

IDLE_SECONDS = 86_400  # the service closes idle connections long before: a request would meet one that closes just then


class InternalApp:
    """An application without a gate: the service, which alone reaches this process, names the sender."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and (text := Headers(scope=scope).get(PRINCIPAL_HEADER)) is not None:
            scope.setdefault("state", {})["principal"] = Principal(**json.loads(text))

        async def with_route(message: Message) -> None:
            if message["type"] == "http.response.start" and (route := scope.get("route")) is not None:
                MutableHeaders(scope=message)[ROUTE_HEADER] = route.path
            await send(message)

        await self._app(scope, receive, with_route)


def main(given: Mapping[str, Any]) -> None:
    """Answer until the service dies or ends this process.

    Parameters
    ----------
    given
        ``settings`` of the engine, ``waker`` (ends of the pipe, empty with a broker), ``listener`` (descriptor) and
        ``log_level``.
    """
    threading.Thread(target=_follow_parent, daemon=True).start()
    start_logging(given["log_level"])
    go_first_without_memory()
    settings = Settings(**given["settings"])
    store = Store(settings)
    ends = given["waker"]
    waker = PipeWaker(settings.workers, (ends[0], ends[1])) if ends else remote_waker(settings)
    app = create_app(JobService(store, waker, settings), door=False)
    config = uvicorn.Config(
        InternalApp(app),
        log_config=None,
        log_level="warning",
        access_log=False,
        server_header=False,
        lifespan="off",
        timeout_keep_alive=IDLE_SECONDS,
    )
    uvicorn.Server(config).run(sockets=[socket.socket(fileno=given["listener"])])


def _follow_parent() -> None:
    """End with the service: its end closes standard input."""
    while os.read(sys.stdin.fileno(), 1):
        pass
    os._exit(0)
