"""What is asked of the service and how its answers are read; no input or output, so that both clients share it."""

from __future__ import annotations

import json
import os
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Generic, Literal, TypeAlias, TypeVar
from urllib.parse import quote

import httpx
from pydantic import TypeAdapter

from geoswarm.client.errors import (
    ConflictError,
    ConnectionFailedError,
    GeoswarmError,
    HttpError,
    InvalidProblemError,
    Issue,
    NotFoundError,
    ServerError,
    UnauthorizedError,
)
from geoswarm.client.models import (
    Attempt,
    Best,
    CheckResult,
    Evaluation,
    ForwardModel,
    ForwardModelInfo,
    Generation,
    Health,
    Job,
    Page,
    Retry,
    WarmStart,
    Worker,
)
from geoswarm.environment import SecretFileError, secret

__all__ = [
    "API",
    "DEFAULT_URL",
    "Call",
    "JSON_BODY",
    "Problem",
    "Query",
    "SortKey",
    "attempts",
    "best",
    "change",
    "change_stopping",
    "check",
    "connection_failed",
    "connection_settings",
    "delete",
    "error_of",
    "evaluations",
    "evaluations_file",
    "events",
    "forward_model",
    "forward_models",
    "generations",
    "get",
    "health",
    "job_path",
    "list_jobs",
    "not_ours",
    "plain",
    "present",
    "problem",
    "read_json",
    "reader",
    "retry_failed",
    "submit",
    "warm_starts",
    "workers",
]

DEFAULT_URL = "http://127.0.0.1:8765"
API = "/api/v1"

T = TypeVar("T")
Problem = Mapping[str, Any] | str | Path
"""A problem as a mapping, or the path of a problem file."""

Json = Mapping[str, Any]
Query = str | int | float | list[str]
SortKey: TypeAlias = Literal["created", "finished", "name", "objective", "evaluations", "seconds"]


@dataclass(frozen=True, slots=True)
class Call(Generic[T]):
    """One request and how to read its answer."""

    method: str
    path: str
    read: Callable[[httpx.Response], T]
    query: Mapping[str, Query] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    content: str | bytes | None = None
    accepted: frozenset[int] = frozenset()
    """Statuses beside 2xx that ``read`` understands."""


def connection_settings(base_url: str | None, api_key: str | None) -> tuple[str, dict[str, str]]:
    """Base URL and headers from arguments or GEOSWARM_URL and GEOSWARM_API_KEY (or the file GEOSWARM_API_KEY_FILE).

    Raises
    ------
    GeoswarmError
        When the URL is not one of HTTP, the file with the key cannot be used, or the key cannot be sent.
    """
    url = base_url or os.environ.get("GEOSWARM_URL") or DEFAULT_URL
    try:
        parsed = httpx.URL(url)
    except httpx.InvalidURL as error:
        raise GeoswarmError(f"the address {url!r} of the service is not a URL: {error}") from None
    if parsed.scheme not in ("http", "https") or not parsed.host:
        raise GeoswarmError(f"the address {url!r} of the service must look like {DEFAULT_URL}")
    try:
        key = api_key or secret("GEOSWARM_API_KEY")
    except SecretFileError as error:
        raise GeoswarmError(str(error)) from None
    if key and not (key.isascii() and key.isprintable()):
        wrong = next(character for character in key if not (character.isascii() and character.isprintable()))
        where = "the API key" if api_key else "the API key in GEOSWARM_API_KEY"
        raise GeoswarmError(f"{where} has the character {wrong!r}; keys are printable ASCII, such as gsw_0f3a...")
    return url, {"Authorization": f"Bearer {key}"} if key else {}


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def not_ours(response: httpx.Response, why: str) -> GeoswarmError:
    """The error about an answer that cannot be read."""
    return GeoswarmError(f"the answer from {response.url} is not one of a geoswarm service: {why}")


def read_json(kind: Any, text: bytes, response: httpx.Response) -> Any:
    """Read JSON of an answer as a record.

    Raises
    ------
    GeoswarmError
        When it is none.
    """
    try:
        return _adapter(kind).validate_json(text)
    except ValueError as error:
        raise not_ours(response, str(error).splitlines()[0]) from None


def reader(kind: Any, item: str | None = None) -> Callable[[httpx.Response], Any]:
    """How to read an answer, or one item of it, as a record."""

    def read(response: httpx.Response) -> Any:
        if item is None:
            return read_json(kind, response.content, response)
        try:
            return _adapter(kind).validate_python(response.json()[item])
        except (ValueError, LookupError, TypeError) as error:
            raise not_ours(response, str(error).splitlines()[0]) from None

    return read


def _nothing(_: httpx.Response) -> None:
    return None


def job_path(job_id: str) -> str:
    if not job_id:
        raise ValueError("job_id is empty; give the id of a job")
    return f"{API}/jobs/{quote(job_id, safe='')}"


def present(**query: Any) -> dict[str, Query]:
    return {name: value for name, value in query.items() if value is not None}


def _problem_text(problem: Problem) -> str:
    """A problem as JSON with its measured points in it.

    Raises
    ------
    geoswarm.solver.errors.ProblemError
        When the file, or one that it refers to, cannot be read or is wrong.
    """
    if isinstance(problem, str | Path):
        from geoswarm.solver.problem import load_problem  # slow; only needed for files

        problem = load_problem(Path(problem)).document()
    return json.dumps(problem, default=plain)


def plain(value: Any) -> Any:
    """Arrays and numbers of NumPy, and other mappings, as JSON knows them."""
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a problem cannot hold {value!r} ({type(value).__name__})")


JSON_BODY = {"Content-Type": "application/json"}


def submit(problem: Problem, idempotency_key: str | None) -> Call[Job]:
    """Create a job; without a key a fresh one is used, so that a repeated request never creates two."""
    key = idempotency_key or str(uuid.uuid4())
    headers = {**JSON_BODY, "Idempotency-Key": key}
    return Call("POST", f"{API}/jobs", reader(Job), headers=headers, content=_problem_text(problem))


def check(problem: Problem) -> Call[CheckResult]:
    """Validate, run once, estimate."""
    content = _problem_text(problem)
    return Call("POST", f"{API}/problems/check", reader(CheckResult), headers=JSON_BODY, content=content)


def warm_starts(problem: Problem) -> Call[tuple[WarmStart, ...]]:
    """Name earlier jobs to learn from."""
    content = _problem_text(problem)
    read = reader(tuple[WarmStart, ...], "items")
    return Call("POST", f"{API}/problems/warm-starts", read, headers=JSON_BODY, content=content)


def list_jobs(**filters: Any) -> Call[Page[Job]]:
    """List jobs."""
    return Call("GET", f"{API}/jobs", reader(Page[Job]), present(**filters))


def get(job_id: str) -> Call[Job]:
    """Show a job."""
    return Call("GET", job_path(job_id), reader(Job))


def problem(job_id: str) -> Call[dict[str, Any]]:
    """Show the problem of a job."""
    return Call("GET", f"{job_path(job_id)}/problem", reader(dict[str, Any]))


def change(job_id: str, action: Literal["cancel", "pause", "resume"]) -> Call[Job]:
    """Cancel, pause or resume."""
    return Call("POST", f"{job_path(job_id)}/{action}", reader(Job))


def change_stopping(job_id: str, stopping: Mapping[str, Any]) -> Call[Job]:
    """Replace the stop criteria."""
    content = json.dumps({"stopping": dict(stopping)}, default=plain)
    return Call("PATCH", job_path(job_id), reader(Job), headers=JSON_BODY, content=content)


def retry_failed(job_id: str) -> Call[Retry]:
    """Run failed evaluations again."""
    return Call("POST", f"{job_path(job_id)}/retry-failed", reader(Retry))


def attempts(job_id: str, generation: int, particle: int) -> Call[tuple[Attempt, ...]]:
    """Show the tries at an evaluation."""
    path = f"{job_path(job_id)}/evaluations/{generation:d}/{particle:d}/attempts"
    return Call("GET", path, reader(tuple[Attempt, ...], "items"))


def delete(job_id: str) -> Call[None]:
    """Delete an ended job."""
    return Call("DELETE", job_path(job_id), _nothing)


def best(job_id: str) -> Call[Best]:
    """Show the best evaluation."""
    return Call("GET", f"{job_path(job_id)}/best", reader(Best))


def generations(
    job_id: str, after: int, limit: int, diversity: bool, points: int | None
) -> Call[tuple[Generation, ...]]:
    """Show generations."""
    query = present(after=after, limit=limit, diversity=True if diversity else None, points=points)
    return Call("GET", f"{job_path(job_id)}/generations", reader(tuple[Generation, ...], "items"), query)


def evaluations(job_id: str, **filters: Any) -> Call[Page[Evaluation]]:
    """Show one page of evaluations."""
    query = present(**filters, format="json")
    query["responses"] = "true" if query.get("responses") else "false"
    return Call("GET", f"{job_path(job_id)}/evaluations", reader(Page[Evaluation]), query)


def evaluations_file(job_id: str, form: Literal["csv", "parquet"], responses: bool, **filters: Any) -> Call[None]:
    """Stream all evaluations as CSV or Parquet."""
    query = present(**filters, format=form)
    if responses:
        query["responses"] = "true"
    return Call("GET", f"{job_path(job_id)}/evaluations", _nothing, query)


def events(job_id: str, after: int) -> Call[None]:
    """Stream events."""
    headers = {"Accept": "text/event-stream", "Last-Event-ID": str(after)}
    return Call("GET", f"{job_path(job_id)}/events", _nothing, headers=headers)


def forward_models() -> Call[tuple[ForwardModelInfo, ...]]:
    """List kinds of forward model."""
    return Call("GET", f"{API}/forward-models", reader(tuple[ForwardModelInfo, ...], "items"))


def forward_model(kind: str) -> Call[ForwardModel]:
    """Show a kind of forward model."""
    return Call("GET", f"{API}/forward-models/{quote(kind, safe='')}", reader(ForwardModel))


def workers() -> Call[tuple[Worker, ...]]:
    """List workers."""
    return Call("GET", f"{API}/workers", reader(tuple[Worker, ...], "items"))


def health() -> Call[Health]:
    """Show health; unavailable is an answer, not an error."""
    return Call("GET", "/health/ready", reader(Health), accepted=frozenset({503}))


ERRORS: dict[int, type[HttpError]] = {
    401: UnauthorizedError,
    403: UnauthorizedError,
    404: NotFoundError,
    409: ConflictError,
    422: InvalidProblemError,
}


def error_of(response: httpx.Response) -> HttpError:
    """The error that a refusal (status 4xx, 5xx, or a redirection) stands for; its content has been read."""
    status = response.status_code
    kind = ERRORS.get(status, ServerError if status >= 500 else HttpError)
    try:
        detail = response.json()
    except ValueError:
        detail = None
    if not isinstance(detail, dict) or "title" not in detail:  # from a proxy, or from something else on this port
        phrase = httpx.codes.get_reason_phrase(status) or "Error"
        return kind(status, phrase, f"{response.request.method} {response.url} was answered without a problem detail")
    return kind(
        status,
        str(detail["title"]),
        str(detail.get("detail", "")),
        [Issue(item.get("path", ""), item.get("message", "")) for item in detail.get("issues") or []],
        type=detail.get("type", "about:blank"),
        instance=detail.get("instance"),
    )


def connection_failed(url: str, error: Exception) -> ConnectionFailedError:
    """What to tell about a request that got no complete answer."""
    why = str(error) or type(error).__name__
    if isinstance(error, httpx.ConnectError):
        return ConnectionFailedError(f"no geoswarm service answers at {url} ({why}); 'geoswarm serve' starts one")
    if isinstance(error, httpx.TimeoutException):
        return ConnectionFailedError(f"the geoswarm service at {url} did not answer in time ({why})")
    return ConnectionFailedError(f"the connection to {url} broke: {why}")
