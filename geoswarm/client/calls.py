"""How requests are put together and answers are read; no input or output, so that both clients share it."""

from __future__ import annotations

import json
import os
import ssl
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
from geoswarm.environment import SecretFileError, secret

__all__ = [
    "API",
    "DEFAULT_URL",
    "FILE_BODY",
    "JSON_BODY",
    "LIMITS",
    "Call",
    "Noise",
    "OtherSet",
    "Problem",
    "Query",
    "SortKey",
    "authorities",
    "connection_failed",
    "connection_settings",
    "error_of",
    "job_path",
    "noise_query",
    "not_ours",
    "nothing",
    "plain",
    "present",
    "problem_text",
    "question_document",
    "read_json",
    "reader",
    "view_query",
]

DEFAULT_URL = "http://127.0.0.1:8765"
API = "/api/v1"

LIMITS = httpx.Limits(max_connections=100, max_keepalive_connections=20, keepalive_expiry=4.0)
"""Idle connections are left before the service closes them, after 5 s: a request could meet one that just closes."""

T = TypeVar("T")
Problem = Mapping[str, Any] | str | Path
"""A problem as a mapping, or the path of a problem file."""

Query = str | int | float | list[str]
JSON_BODY = {"Content-Type": "application/json"}
FILE_BODY = {"Content-Type": "application/octet-stream"}

Noise = Mapping[str, float] | float | None
"""Known standard deviation of a reading, base units: one for all series, or one each."""

OtherSet = Mapping[str, Any] | str | Path | None
"""Another set of parameters: values by name, and a ``name``; or the path of such a file."""

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


def authorities(url: str) -> ssl.SSLContext | bool:
    """What httpx checks certificates of a service with: none is trusted where none is used.

    Reading the authorities takes longer than a request.
    """
    return url.lower().startswith("https:") or ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)


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


def reader(kind: type[T], item: str | None = None) -> Callable[[httpx.Response], T]:
    """How to read an answer, or one item of it, as a record."""
    record: Any = kind

    def read(response: httpx.Response) -> Any:
        if item is None:
            return read_json(record, response.content, response)
        try:
            return _adapter(record).validate_python(response.json()[item])
        except (ValueError, LookupError, TypeError) as error:
            raise not_ours(response, str(error).splitlines()[0]) from None

    return read


def nothing(_: httpx.Response) -> None:
    """How to read an answer whose content does not matter, or is streamed."""


def job_path(job_id: str) -> str:
    """Path of a job."""
    if not job_id:
        raise ValueError("job_id is empty; give the id of a job")
    return f"{API}/jobs/{quote(job_id, safe='')}"


def present(**query: Any) -> dict[str, Query]:
    """What was given: everything but None."""
    return {name: value for name, value in query.items() if value is not None}


def problem_text(problem: Problem) -> str:
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


def question_document(problem: Problem) -> Mapping[str, Any]:
    """A problem that another one completes, with its measured points in it.

    Raises
    ------
    geoswarm.solver.errors.ProblemError
        When the file, or one that it refers to, cannot be read.
    """
    if isinstance(problem, str | Path):
        from geoswarm.solver.problem.draft import inlined_document  # slow; only needed for files

        return inlined_document(Path(problem))
    return problem


def plain(value: Any) -> Any:
    """Arrays and numbers of NumPy, and other mappings, as JSON knows them."""
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a problem cannot hold {value!r} ({type(value).__name__})")


def view_query(threshold: float | None, noise: Noise, posterior: bool, compare: OtherSet = None) -> dict[str, Query]:
    """How the results of a job are looked at, as a query."""
    query: dict[str, Query] = present(threshold=threshold)
    if posterior:
        query["posterior"] = "true"
    if isinstance(compare, str | Path):
        path = Path(compare)
        query["compare"] = json.dumps({"name": path.stem, **question_document(path)})
    elif compare is not None:
        query["compare"] = json.dumps(compare, default=plain)
    return query | noise_query(noise)


def noise_query(noise: Noise) -> dict[str, Query]:
    """A known standard deviation as a query: one number, or ``series=number`` each."""
    if noise is None:
        return {}
    return {"noise": [f"{k}={v!r}" for k, v in noise.items()] if isinstance(noise, Mapping) else repr(float(noise))}


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
