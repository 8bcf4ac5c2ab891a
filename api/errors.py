"""Errors of the HTTP side and their form: RFC 9457 problem details, never a traceback.

::

    ApiError
    ├── PortInUseError        the address to listen on is taken or not available
    ├── ApiSettingsError      a setting of the service is wrong
    └── DetailError           a request that is answered with a problem detail (status, type, title, detail)

Errors of ``workers`` and ``solver`` are translated by :func:`install_error_handlers`.
"""

from __future__ import annotations

import logging
import uuid
from collections.abc import Callable, Mapping, Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel, ConfigDict, Field
from starlette.datastructures import MutableHeaders
from starlette.exceptions import HTTPException
from starlette.routing import Match, Mount

from geoswarm.api.headers import add_security_headers
from geoswarm.solver.errors import InfeasibleSpaceError, Issue, ProblemError, StatisticsError
from geoswarm.solver.sentences import parts_json
from geoswarm.workers.errors import (
    AttachmentNotFoundError,
    AttachmentRefusedError,
    BrokerUnavailableError,
    EvaluationNotFoundError,
    HookNotFoundError,
    HookRefusedError,
    IdempotencyConflictError,
    InvalidCursorError,
    InvalidTransitionError,
    JobNotFoundError,
    KeyNotFoundError,
    LeaseOverError,
    ModelsUnavailableError,
    NoOptimumError,
    NotHandedOutError,
    NothingLeftError,
    NothingToRetryError,
    QuotaExceededError,
    SettingsError,
    StoreUnavailableError,
    UnknownAgentError,
)

__all__ = [
    "ApiError",
    "ApiSettingsError",
    "DetailError",
    "IssueDetail",
    "KeyWords",
    "PortInUseError",
    "ProblemDetail",
    "detail_response",
    "install_error_handlers",
]

logger = logging.getLogger("geoswarm.api")

_METHODS = ("DELETE", "GET", "HEAD", "PATCH", "POST", "PUT")
MEDIA_TYPE = "application/problem+json"
TYPE_PREFIX = "urn:geoswarm:error:"
MOST_ISSUES = 100
"""Mistakes that an answer lists; how many more there are is said."""


class ApiError(Exception):
    """Base of the errors that the HTTP side raises on purpose."""


class PortInUseError(ApiError):
    """The address to listen on cannot be used."""


class ApiSettingsError(ApiError):
    """A setting of the service is wrong; the message names it and what it accepts."""


class KeyWords(BaseModel):
    """A key of the problem in a sentence, for which a form has words of its own."""

    model_config = ConfigDict(from_attributes=True)

    path: str = Field(description="its place, for example observations[0].y_unit")
    text: str = Field(description="as a problem file says it: `y_unit: mm`")
    value: str = Field(description="what it is to be given; empty where it is only named")


class IssueDetail(BaseModel):
    """One mistake in what was sent."""

    path: str = Field(description="where it is, for example parameters.c.lower")
    message: str = Field(description="what is wrong there and what is accepted")
    parts: list[str | KeyWords] | None = Field(None, description="the message with the keys in it, if it names some")


class ProblemDetail(BaseModel):
    """An error as RFC 9457 describes it (application/problem+json)."""

    type: str = Field(description="URI that names the kind of error; about:blank when the status says it all")
    title: str
    status: int
    detail: str
    instance: str | None = Field(default=None, description="identifies this occurrence; it is also in the server's log")
    issues: list[IssueDetail] | None = Field(default=None, description="every mistake, when what was sent is wrong")


class DetailError(ApiError):
    """Answered with a problem detail of this status.

    Parameters
    ----------
    status
        HTTP status code.
    detail
        What happened and what would be accepted, in one or two sentences.
    kind
        Last part of the ``type`` URI; None gives ``about:blank``.
    title
        Short name of the kind; the status phrase unless given.
    issues
        Mistakes in what was sent.
    headers
        Further response headers.
    """

    def __init__(
        self,
        status: int,
        detail: str,
        *,
        kind: str | None = None,
        title: str | None = None,
        issues: Sequence[Issue] = (),
        headers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.detail = detail
        self.kind = kind
        self.title = title
        self.issues = tuple(issues)
        self.headers = dict(headers or {})


def role_refused(role: str, needs: str) -> DetailError:
    """The error for a key of a role that is not enough; ``needs``: what needs which role."""
    words = f"This API key has the role {role!r}; {needs}."
    return DetailError(403, words, kind="role-refused", title="Role refused")


def _issue(issue: Issue) -> dict[str, Any]:
    return {"path": issue.path, "message": issue.message, "parts": parts_json(issue.parts) or None}


def detail_response(error: DetailError, *, instance: str | None = None) -> JSONResponse:
    """Build the application/problem+json response of an error."""
    body = ProblemDetail(
        type=TYPE_PREFIX + error.kind if error.kind else "about:blank",
        title=error.title or HTTPStatus(error.status).phrase,
        status=error.status,
        detail=error.detail,
        instance=instance,
        issues=[IssueDetail.model_validate(_issue(issue)) for issue in error.issues] or None,
    )
    return JSONResponse(
        body.model_dump(exclude_none=True), status_code=error.status, headers=error.headers, media_type=MEDIA_TYPE
    )


def invalid_problem(issues: Sequence[Issue]) -> DetailError:
    """The answer to a problem that cannot be accepted, with its mistakes."""
    count = len(issues)
    detail = str(issues[0]) if count == 1 else f"{count} mistakes; the first: {issues[0]}"
    return DetailError(422, detail, kind="invalid-problem", title="Invalid problem", issues=issues)


def translate(error: Exception) -> DetailError:
    """The problem detail that stands for an error of ``solver``, ``workers`` or the web framework."""
    match error:
        case DetailError():
            return error
        case ProblemError():
            return invalid_problem(error.issues)
        case InfeasibleSpaceError():
            return invalid_problem([Issue("constraints", str(error))])
        case RequestValidationError():
            faults = error.errors()
            issues = [Issue(".".join(str(part) for part in item["loc"]), item["msg"]) for item in faults[:MOST_ISSUES]]
            if len(faults) > MOST_ISSUES:
                issues.append(Issue("", f"{len(faults) - MOST_ISSUES} more mistakes"))
            return DetailError(
                422, "; ".join(map(str, issues)), kind="invalid-request", title="Invalid request", issues=issues
            )
        case JobNotFoundError():
            return DetailError(404, str(error), kind="job-not-found", title="Job not found")
        case EvaluationNotFoundError():
            return DetailError(404, str(error), kind="evaluation-not-found", title="Evaluation not found")
        case NothingLeftError():
            return DetailError(409, str(error), kind="nothing-left", title="Nothing left to evaluate")
        case NothingToRetryError():
            return DetailError(409, str(error), kind="nothing-to-retry", title="No failed evaluation")
        case InvalidTransitionError():
            return DetailError(409, str(error), kind="invalid-transition", title="Not possible in this state")
        case NoOptimumError():
            return DetailError(409, str(error), kind="no-optimum", title="No optimum yet")
        case IdempotencyConflictError():
            return DetailError(409, str(error), kind="idempotency-conflict", title="Idempotency key already used")
        case StatisticsError():
            return DetailError(422, str(error), kind="invalid-statistics", title="Statistics not possible")
        case InvalidCursorError():
            return DetailError(400, str(error), kind="invalid-cursor", title="Invalid cursor")
        case UnknownAgentError():
            return DetailError(404, f"{error}.", kind="unknown-agent", title="Unknown agent")
        case LeaseOverError():
            return DetailError(410, f"{error}.", kind="lease-over", title="Lease over")
        case NotHandedOutError():
            return DetailError(404, f"{error}.", kind="not-handed-out", title="Not handed out")
        case ModelsUnavailableError():
            return DetailError(409, f"{error}.", kind="models-unavailable", title="Models unavailable")
        case AttachmentNotFoundError():
            return DetailError(404, f"{error}.", kind="attachment-not-found", title="File not found")
        case AttachmentRefusedError():
            issues = [Issue(error.field, error.message)]
            return DetailError(422, f"{error}.", kind="invalid-attachment", title="File refused", issues=issues)
        case HookNotFoundError():
            return DetailError(404, str(error), kind="hook-not-found", title="Hook not found")
        case HookRefusedError():
            issues = [Issue(error.field, str(error))]
            return DetailError(422, str(error), kind="invalid-hook", title="Invalid hook", issues=issues)
        case KeyNotFoundError():
            return DetailError(404, str(error), kind="unknown-key", title="Unknown key")
        case SettingsError():  # of a key that cannot be made so
            issues = [Issue("body", str(error))]
            return DetailError(422, str(error), kind="invalid-request", title="Invalid request", issues=issues)
        case QuotaExceededError():
            return DetailError(403, f"{error}.", kind="quota-exceeded", title="Quota exceeded")
        case StoreUnavailableError() | BrokerUnavailableError():
            title = "Database" if isinstance(error, StoreUnavailableError) else "Broker"
            return DetailError(
                503, str(error), kind="unavailable", title=f"{title} unavailable", headers={"Retry-After": "5"}
            )
        case HTTPException():
            return DetailError(error.status_code, str(error.detail), headers=error.headers)
    raise TypeError(f"no problem detail is defined for {type(error).__name__}")


TRANSLATED: tuple[type[Exception], ...] = (
    AttachmentNotFoundError,
    AttachmentRefusedError,
    DetailError,
    ProblemError,
    InfeasibleSpaceError,
    RequestValidationError,
    JobNotFoundError,
    EvaluationNotFoundError,
    HookNotFoundError,
    HookRefusedError,
    KeyNotFoundError,
    SettingsError,
    InvalidTransitionError,
    NoOptimumError,
    NothingLeftError,
    NothingToRetryError,
    IdempotencyConflictError,
    InvalidCursorError,
    StatisticsError,
    QuotaExceededError,
    LeaseOverError,
    ModelsUnavailableError,
    NotHandedOutError,
    UnknownAgentError,
    StoreUnavailableError,
    BrokerUnavailableError,
)


def wants_page(request: Request) -> bool:
    """Whether a browser asks for a page, so that an error should be one, too."""
    return not request.url.path.startswith("/api/") and "text/html" in request.headers.get("accept", "")


def _allowed(app: FastAPI, request: Request, named: str | None) -> str:
    """All methods of a path: several routes may share it, and each names its own only (``named``)."""
    routes = [route for route in app.routes if not isinstance(route, Mount)]
    possible = [
        method
        for method in _METHODS
        if any(route.matches({**request.scope, "method": method})[0] is Match.FULL for route in routes)
    ]
    return ", ".join(possible) or named or "other methods"


def install_error_handlers(app: FastAPI, pages: Callable[[Request, DetailError], Response]) -> None:
    """Make the application answer every error with a problem detail, or with a page where a page was asked for.

    ``pages`` builds the page of an error.
    """

    def told(request: Request, error: DetailError) -> Response:
        return pages(request, error) if wants_page(request) else detail_response(error)

    async def known(request: Request, error: Exception) -> Response:
        return told(request, translate(error))

    async def http(request: Request, error: Exception) -> Response:
        found = translate(error)
        if found.status == 404:
            found.detail = f"There is nothing at {request.url.path}. The routes are listed in /openapi.json."
        elif found.status == 405:
            headers = MutableHeaders(found.headers)
            headers["allow"] = allowed = _allowed(app, request, headers.get("allow"))
            found.headers = dict(headers)
            found.detail = f"{request.method} is not possible at {request.url.path}; possible: {allowed}."
        return told(request, found)

    async def unexpected(request: Request, error: Exception) -> JSONResponse:
        occurrence = f"urn:uuid:{uuid.uuid4()}"
        logger.error("unexpected error %s at %s %s", occurrence, request.method, request.url.path, exc_info=error)
        detail = "An internal error occurred. The server's log has its cause under this instance."
        response = detail_response(DetailError(500, detail), instance=occurrence)
        add_security_headers(response.headers)  # this answer does not pass the gate
        response.headers["Connection"] = "close"  # which the server does after an error that it did not expect
        return response

    for kind in TRANSLATED:
        app.add_exception_handler(kind, known)
    app.add_exception_handler(HTTPException, http)
    app.add_exception_handler(Exception, unexpected)
