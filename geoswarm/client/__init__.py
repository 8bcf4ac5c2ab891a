"""The Python client of a geoswarm service: :class:`Client` and :class:`AsyncClient` with the same methods.

==============  =====================================================================
``sync``        :class:`Client`
``aio``         :class:`AsyncClient`
``calls``       what is asked and how answers are read, without any input or output
``models``      frozen records of the answers
``errors``      the tree of errors
``sse``         reads an event stream
==============  =====================================================================
"""

from __future__ import annotations

from geoswarm.client.aio import AsyncClient
from geoswarm.client.errors import (
    ConflictError,
    ConnectionFailedError,
    GeoswarmError,
    HttpError,
    InvalidProblemError,
    Issue,
    JobFailedError,
    NotFoundError,
    ServerError,
    UnauthorizedError,
    WaitTimeoutError,
)
from geoswarm.client.models import (
    Attempt,
    Best,
    CheckResult,
    Curve,
    Evaluation,
    Event,
    Figure,
    ForwardModel,
    ForwardModelInfo,
    Generation,
    Health,
    Job,
    Page,
    Parameter,
    Report,
    Retry,
    Series,
    TestRun,
    WarmStart,
    Worker,
)
from geoswarm.client.sync import Client

__all__ = [
    "AsyncClient",
    "Client",
    "Attempt",
    "Best",
    "CheckResult",
    "Curve",
    "Evaluation",
    "Event",
    "Figure",
    "ForwardModel",
    "ForwardModelInfo",
    "Generation",
    "Health",
    "Job",
    "Page",
    "Parameter",
    "Report",
    "Retry",
    "Series",
    "TestRun",
    "WarmStart",
    "Worker",
    "ConflictError",
    "ConnectionFailedError",
    "GeoswarmError",
    "HttpError",
    "InvalidProblemError",
    "Issue",
    "JobFailedError",
    "NotFoundError",
    "ServerError",
    "UnauthorizedError",
    "WaitTimeoutError",
]
