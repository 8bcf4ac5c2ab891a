"""The Python client of a geoswarm service: :class:`Client` and :class:`AsyncClient` with the same methods.

==============  =====================================================================
``sync``        :class:`Client`
``aio``         :class:`AsyncClient`
``calls``       what is asked and how answers are read, without any input or output
``models``      frozen records of the answers; those with arrays in ``points``, ``fit``, ``bodies``
``errors``      the tree of errors
``sse``         reads an event stream
==============  =====================================================================
"""

from __future__ import annotations

from geoswarm.client.administration import Key, NewKey, Operations, Session
from geoswarm.client.aio import AsyncClient
from geoswarm.client.bodies import Displacement, Mesh, MeshFields, Phase
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
from geoswarm.client.fit import Fit, FitCurve, FitParameter, FitSeries, FitShare
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
from geoswarm.client.points import PointParameter, Points, PointSeries
from geoswarm.client.sync import Client

__all__ = [
    "AsyncClient",
    "Client",
    "Attempt",
    "Best",
    "CheckResult",
    "Curve",
    "Displacement",
    "Evaluation",
    "Event",
    "Figure",
    "Fit",
    "FitCurve",
    "FitParameter",
    "FitSeries",
    "FitShare",
    "ForwardModel",
    "ForwardModelInfo",
    "Generation",
    "Health",
    "Job",
    "Key",
    "Mesh",
    "MeshFields",
    "NewKey",
    "Operations",
    "Page",
    "Parameter",
    "Phase",
    "PointParameter",
    "PointSeries",
    "Points",
    "Report",
    "Retry",
    "Series",
    "Session",
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
