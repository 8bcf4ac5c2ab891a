"""Everything that the client raises.

::

    GeoswarmError
    ├── ConnectionFailedError       the service cannot be reached, or the connection broke
    ├── WaitTimeoutError            the job did not end in the given time; it goes on
    ├── JobFailedError              the job that was waited for has failed
    └── HttpError                   the service refused: status, title, detail, issues
        ├── UnauthorizedError       401, 403: the API key is missing, wrong or not enough, or the host is refused
        ├── NotFoundError           404
        ├── ConflictError           409: not possible in the job's state, or the idempotency key was used before
        ├── InvalidProblemError     422: what was sent is wrong; ``issues`` lists every mistake
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
    """Base of all errors of the client."""


class ConnectionFailedError(GeoswarmError):
    """The service cannot be reached, or the connection broke."""


class WaitTimeoutError(GeoswarmError):
    """The job did not end in the given time; it goes on."""

    def __init__(self, job_id: str, timeout: float) -> None:
        self.job_id = job_id
        self.timeout = timeout
        super().__init__(f"job {job_id} did not end within {timeout:g} s; it goes on, wait again or cancel it")


class JobFailedError(GeoswarmError):
    """The job that was waited for has failed; ``job`` has what it found before."""

    def __init__(self, job: Job) -> None:
        self.job = job
        super().__init__(f"job {job.id} ({job.name}) failed: {job.error or 'no reason was given'}")


@dataclass(frozen=True, slots=True)
class Issue:
    """One mistake in what was sent: where it is and what is wrong there."""

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
        Every mistake in what was sent.
    type
        URI of the kind of error.
    instance
        Identifies an unexpected error in the service's log.
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
    """The API key is missing or wrong, its role or quota does not suffice, or the host name is not answered."""


class NotFoundError(HttpError):
    """There is no such thing."""


class ConflictError(HttpError):
    """Not possible in the job's present state, or the idempotency key was used with another problem."""


class InvalidProblemError(HttpError):
    """What was sent is wrong; ``issues`` lists every mistake."""


class ServerError(HttpError):
    """The service has a problem."""
