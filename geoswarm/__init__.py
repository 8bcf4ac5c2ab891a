"""Finds the parameters of geotechnical models from measurements.

>>> from geoswarm import Client
>>> with Client() as client:                              # doctest: +SKIP
...     job = client.submit(Path("problem.yaml"))
...     print(client.wait(job.id).parameters)

The names below are loaded when they are used, so importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geoswarm.client import (
        AsyncClient,
        Client,
        ConflictError,
        ConnectionFailedError,
        GeoswarmError,
        HttpError,
        InvalidProblemError,
        JobFailedError,
        NotFoundError,
        ServerError,
        UnauthorizedError,
        WaitTimeoutError,
    )

__all__ = [
    "AsyncClient",
    "Client",
    "ConflictError",
    "ConnectionFailedError",
    "GeoswarmError",
    "HttpError",
    "InvalidProblemError",
    "JobFailedError",
    "NotFoundError",
    "ServerError",
    "UnauthorizedError",
    "WaitTimeoutError",
]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module("geoswarm.client"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
