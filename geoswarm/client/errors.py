"""Everything that the client raises.

::

    GeoswarmError
    ├── ConnectionFailedError       the service cannot be reached, or the connection broke
    ├── WaitTimeoutError            the job did not end in the given time; it continues
    ├── JobFailedError              the job that was waited for failed
    └── HttpError                   the service refused: status, title, detail, issues
        ├── UnauthorizedError       401, 403: the API key is missing, wrong or insufficient, or the host is refused
        ├── NotFoundError           404
        ├── ConflictError           409: not possible in the job's state, or the idempotency key was used before
        ├── InvalidProblemError     422: the request is invalid; ``issues`` lists every mistake
        └── ServerError             5xx: the service has a problem, ``detail`` says which

Problem files that cannot be read raise :class:`geoswarm.solver.errors.ProblemError` before anything is sent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from geoswarm.records.job import Job

__all__ = [
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


class GeoswarmError(Exception):
    """Base of all errors of the client.

    Examples
    --------
    >>> from geoswarm import Client, GeoswarmError
    >>> with Client() as client:
    ...     try:
    ...         client.get("0123456789abcdef")
    ...     except GeoswarmError as error:
    ...         print(type(error).__name__)
    NotFoundError
    """


class ConnectionFailedError(GeoswarmError):
    """The service cannot be reached, or the connection broke.

    Examples
    --------
    >>> from geoswarm import Client, ConnectionFailedError
    >>> with Client("http://127.0.0.1:1") as client:
    ...     try:
    ...         client.list()
    ...     except ConnectionFailedError:
    ...         print("nothing answers there")
    nothing answers there
    """


class WaitTimeoutError(GeoswarmError):
    """The job did not end in the given time; it continues.

    Examples
    --------
    >>> from geoswarm import Client, WaitTimeoutError
    >>> problem = {
    ...     "forward_model": {"kind": "formula", "series": {"y": {"expression": "a * x"}}},
    ...     "parameters": {"a": {"lower": 0, "upper": 1}},
    ...     "observations": [{"series": "y", "points": {"x": [1, 2], "y": [2, 4]}}],
    ...     "stopping": {"max_seconds": 600},
    ... }
    >>> with Client() as client:
    ...     job = client.submit(problem)
    ...     try:
    ...         client.wait(job.id, timeout=0.1)
    ...     except WaitTimeoutError as error:
    ...         print(error.job_id == job.id)
    ...         state = client.cancel(job.id).state
    True
    """

    def __init__(self, job_id: str, timeout: float) -> None:
        self.job_id = job_id
        self.timeout = timeout
        super().__init__(f"job {job_id} did not end within {timeout:g} s; it continues; wait again or cancel it")


class JobFailedError(GeoswarmError):
    """The job that was waited for failed; ``job`` has what it found before.

    Examples
    --------
    >>> from geoswarm import Client, JobFailedError
    >>> problem = {
    ...     "forward_model": {"kind": "formula", "series": {"y": {"expression": "ln(a - 2) * x"}}},
    ...     "parameters": {"a": {"lower": 0, "upper": 1}},
    ...     "observations": [{"series": "y", "points": {"x": [1, 2], "y": [2, 4]}}],
    ...     "stopping": {"max_evaluations": 20},
    ... }
    >>> with Client() as client:
    ...     job = client.submit(problem)
    ...     try:
    ...         client.wait(job.id, timeout=60)
    ...     except JobFailedError as error:
    ...         print(error.job.failed_evaluations)
    20
    """

    def __init__(self, job: Job) -> None:
        self.job = job
        super().__init__(f"job {job.id} ({job.name}) failed: {job.error or 'no reason was given'}")


@dataclass(frozen=True, slots=True)
class Issue:
    """One mistake in a request: where it is and what is wrong there."""

    path: str
    message: str

    def __str__(self) -> str:
        return f"{self.path}: {self.message}" if self.path else self.message


class HttpError(GeoswarmError):
    """The service refused a request.

    Attributes
    ----------
    status
        HTTP status code.
    title, detail
        Kind of error and what happened, from the problem detail.
    issues
        Every mistake in the request.
    type
        URI of the kind of error.
    instance
        Identifies an unexpected error in the service's log.

    Examples
    --------
    >>> from geoswarm import Client, HttpError
    >>> with Client() as client:
    ...     try:
    ...         client.get("0123456789abcdef")
    ...     except HttpError as error:
    ...         print(error.status, error.detail != "")
    404 True
    """

    def __init__(
        self,
        status: int,
        title: str,
        detail: str,
        issues: Sequence[Issue] = (),
        *,
        type: str = "about:blank",
        instance: str | None = None,
    ) -> None:
        self.status = status
        self.title = title
        self.detail = detail
        self.issues = tuple(issues)
        self.type = type
        self.instance = instance
        lines = [f"{title} ({status}): {detail}"]
        if len(self.issues) > 1:
            lines += [f"  {issue}" for issue in self.issues]
        super().__init__("\n".join(lines))


class UnauthorizedError(HttpError):
    """The API key is missing or wrong, its role or quota is insufficient, or the host name is refused.

    Examples
    --------
    >>> from geoswarm import Client, UnauthorizedError
    >>> with Client(api_key="gsw_0123456789ab_wrong") as client:
    ...     try:
    ...         client.list()
    ...     except UnauthorizedError as error:
    ...         print(error.status)
    401
    """


class NotFoundError(HttpError):
    """The resource does not exist.

    Examples
    --------
    >>> from geoswarm import Client, NotFoundError
    >>> with Client() as client:
    ...     try:
    ...         client.get("0123456789abcdef")
    ...     except NotFoundError as error:
    ...         print(error.status)
    404
    """


class ConflictError(HttpError):
    """Not possible in the job's present state, or the idempotency key was used with another problem.

    Examples
    --------
    >>> from geoswarm import Client, ConflictError
    >>> with Client() as client:
    ...     try:
    ...         client.cancel(next(client.iterate_jobs(state="finished")).id)
    ...     except ConflictError as error:
    ...         print(error.status)
    409
    """


class InvalidProblemError(HttpError):
    """The request is invalid; ``issues`` lists every mistake.

    Examples
    --------
    >>> from geoswarm import Client, InvalidProblemError
    >>> with Client() as client:
    ...     try:
    ...         client.check({"parameters": {}})
    ...     except InvalidProblemError as error:
    ...         print(len(error.issues) > 0)
    True
    """


class ServerError(HttpError):
    """The service has a problem.

    Examples
    --------
    >>> from geoswarm import ServerError
    >>> error = ServerError(503, "Not ready", "the database can be read, but not written")
    >>> print(error)
    Not ready (503): the database can be read, but not written
    """
