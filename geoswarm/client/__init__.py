"""The Python client of a geoswarm service: :class:`Client` and :class:`AsyncClient` with the same methods.

==================  ===============================================================================================
``_async``          :class:`AsyncClient`, the source
``_sync``           :class:`Client`, generated from it by ``scripts/generate_client.py``
``calls``           how requests are put together and answers are read, without any input or output
``models``          frozen records that only the client has, some with arrays; all others are in :mod:`geoswarm.records`
``errors``          the tree of errors
``follow``          when to reconnect to an event stream, when to give up
``sse``             reads an event stream
``points``          evaluations of a job as arrays, from the block of float32 that plots use
``files``           files that appear only when they are complete
==================  ===============================================================================================
"""

from __future__ import annotations

from geoswarm.client._async.client import AsyncClient
from geoswarm.client._sync.client import Client
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
from geoswarm.client.models import Displacement, Figure, Mesh, MeshFields, Phase, Report
from geoswarm.client.points import PointParameter, Points, PointSeries
from geoswarm.records.account import Hook, Key, NewHook, NewKey
from geoswarm.records.evaluation import Attempt, Best, Evaluation, Response
from geoswarm.records.fit import Fit, FitCurve, FitParameter, FitSeries
from geoswarm.records.job import Attachment, Event, Generation, Job, Retry
from geoswarm.records.problem import CheckResult, Parameter, Series, TestRun, WarmStart
from geoswarm.records.problem import ForwardModelDetail as ForwardModel
from geoswarm.records.problem import ForwardModelSummary as ForwardModelInfo
from geoswarm.records.record import Page
from geoswarm.records.service import Health, Operations, Session, Worker
from geoswarm.records.statistics import ReweightAnswer, SeriesShare, StatisticsAnswer, WeightShare
from geoswarm.records.uncertainty import PosteriorAnswer, SurfaceAnswer, UncertaintyAnswer

__all__ = [
    "AsyncClient",
    "Client",
    "Attachment",
    "Attempt",
    "Best",
    "CheckResult",
    "Displacement",
    "Evaluation",
    "Event",
    "Figure",
    "Fit",
    "FitCurve",
    "FitParameter",
    "FitSeries",
    "ForwardModel",
    "ForwardModelInfo",
    "Generation",
    "Health",
    "Hook",
    "Job",
    "Key",
    "Mesh",
    "MeshFields",
    "NewHook",
    "NewKey",
    "Operations",
    "Page",
    "Parameter",
    "Phase",
    "PointParameter",
    "PointSeries",
    "Points",
    "PosteriorAnswer",
    "Report",
    "Response",
    "Retry",
    "ReweightAnswer",
    "Series",
    "SeriesShare",
    "Session",
    "StatisticsAnswer",
    "SurfaceAnswer",
    "TestRun",
    "UncertaintyAnswer",
    "WarmStart",
    "WeightShare",
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
