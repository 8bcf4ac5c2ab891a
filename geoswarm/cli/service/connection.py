"""Talks to a service for the commands about jobs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note

if TYPE_CHECKING:
    from geoswarm.client import Client, Job

__all__ = ["SLOW_ANSWER", "connect", "find_calibration", "find_job"]

LATEST = "latest"
_SEARCHED_PAGES, _PAGE = 10, 200
_SHORTEST_PREFIX = 4
_UNAUTHORIZED = 401
SLOW_ANSWER = 900.0
"""For what the service calculates before it answers, such as a posterior sample [s]."""
_LONGEST_CHAIN = 10


@contextmanager
def connect(url: str, api_key: str | None, timeout: float = 60.0) -> Iterator[Client]:
    """Give a client; nothing is sent yet.

    Parameters
    ----------
    timeout
        How long an answer may take [s].

    Raises
    ------
    BadInputError
        When the service asks for another key.
    """
    from geoswarm.client import Client, UnauthorizedError

    try:
        with Client(url, api_key=api_key, timeout=timeout) as client:
            yield client
    except UnauthorizedError as error:
        if error.status != _UNAUTHORIZED:
            raise
        given = "another one" if api_key else "one"
        raise BadInputError(f"{error}\nGive {given} with --api-key KEY or in GEOSWARM_API_KEY.") from error


def find_job(client: Client, job: str) -> Job:
    """Return the job with this id, or the only one whose id begins with it (among the newest 2000).

    ``latest`` stands for the newest job.

    Raises
    ------
    BadInputError
        When no job, or several, are meant.
    """
    from geoswarm.client import NotFoundError

    if job == LATEST:
        newest = client.list(limit=1).items
        if not newest:
            raise BadInputError("there is no job yet; 'geoswarm submit PROBLEM' makes one")
        return newest[0]
    try:
        return client.get(job)
    except NotFoundError:
        if len(job) < _SHORTEST_PREFIX:
            raise BadInputError(f"there is no job '{job}' (an abbreviated id has at least 4 characters)") from None
    found = _with_prefix(client, job)
    if len(found) > 1:
        raise BadInputError(f"'{job}' begins the ids of several jobs: {', '.join(j.id for j in found[:5])}")
    if not found:
        raise BadInputError(f"there is no job '{job}'; 'geoswarm list' shows the jobs")
    return found[0]


def find_calibration(client: Client, job: str) -> Job:
    """Return a job as :func:`find_job` does, but for ``latest`` the calibration that the newest job examines.

    Raises
    ------
    BadInputError
        When no job, or several, are meant.
    """
    from geoswarm.client import NotFoundError

    newest = found = find_job(client, job)
    for _ in range(_LONGEST_CHAIN if job == LATEST else 0):
        examined = client.problem(found.id).get("method", {}).get("of")
        if examined is None:
            break
        try:
            found = client.get(examined)
        except NotFoundError:
            break
    if found is not newest:
        note(f"The newest job, {newest.id}, is a follow-up: this is the calibration {found.id} that it examines.")
    return found


def _with_prefix(client: Client, prefix: str) -> list[Job]:
    found: list[Job] = []
    cursor: str | None = None
    for _ in range(_SEARCHED_PAGES):
        page = client.list(limit=_PAGE, cursor=cursor)
        found += [job for job in page.items if job.id.startswith(prefix)]
        cursor = page.next_cursor
        if cursor is None:
            break
    return found
