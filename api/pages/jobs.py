"""The list of jobs, several of them side by side, and the form of a new one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import Service
from geoswarm.api.pages.shell import number, render
from geoswarm.records.job import Job
from geoswarm.records.states import ENDED_STATES, JOB_STATES, OPEN_STATES
from geoswarm.solver.words import FITS, interval_digits, verdict_in_words
from geoswarm.workers.queries.job_list import JobFilters, SortKey

__all__ = ["BADGES", "SPARK_HEIGHT", "SPARK_WIDTH", "router", "sparkline"]

router = APIRouter()

PAGE = 50
POINTS = 32
SORTS: dict[SortKey, str] = {
    "created": "Newest first",
    "finished": "Last ended first",
    "objective": "Best objective first",
    "evaluations": "Most evaluations first",
    "seconds": "Longest running first",
    "name": "Name, A to Z",
}
GROUPS = {"active": OPEN_STATES, "ended": ENDED_STATES}
MOST_FOLLOW_UPS = 200
MOST_COLUMNS = 8
MOST_PARAMETERS = 4
MOST_SERIES = 2
BADGES = {
    "describes": "describes",
    "gross_error": "gross error",
    "doubtful": "doubtful",
    "lack_of_fit": "misses",
    "error_not_met": "error not met",
    "untested": "not tested",
}
"""Kind of the verdict on the fit -> what the list shows."""


MOST_JOBS = 6
MARGIN = 2.0


@dataclass(frozen=True, slots=True)
class FoundValue:
    """A free parameter in the list: its value, the ends of its interval (empty: none), and what is wrong with it."""

    name: str
    value: str
    ends: tuple[str, ...]
    doubt: str | None


def found(job: Job, names: Sequence[str]) -> list[FoundValue]:
    """Return those of the parameters that a job has, none before an evaluation has succeeded."""
    values = []
    known = job.parameters or {}
    for name in names:
        if name not in known:
            continue
        value, interval = known[name], (job.intervals or {}).get(name)
        digits = 4 if interval is None else interval_digits(*interval)
        told = tuple(number(end, digits) for end in interval or ())
        doubt = None
        if bound := (job.at_bounds or {}).get(name):
            doubt = f"at its {bound} bound"
        elif (kind := (job.verdicts or {}).get(name, "identified")) != "identified":
            doubt = (job.verdict_words or {}).get(name, verdict_in_words(kind))
        values.append(FoundValue(name, number(value, digits), told, doubt))
    return values


@router.get("/")
def jobs_page(
    request: Request,
    service: Service,
    cursor: Annotated[str | None, Query(max_length=500)] = None,
    q: Annotated[str, Query(max_length=200)] = "",
    state: Annotated[str, Query(max_length=20, description="a state, active or ended")] = "",
    owner: Annotated[str, Query(max_length=80)] = "",
    tag: Annotated[str, Query(max_length=40)] = "",
    parent: Annotated[str, Query(max_length=64)] = "",
    columns: Annotated[str, Query(max_length=1000, description="parameters, with commas between them")] = "",
    sort: Annotated[str, Query(max_length=20)] = "created",
    order: Annotated[str, Query(max_length=20, description="ascending or descending")] = "",
) -> HTMLResponse:
    """List the jobs, newest first unless asked otherwise; what a filter does not know it leaves out.

    Without a filter, follow-ups stand below their jobs.
    """
    text, whose, tagged, followed, named = (
        "".join(letter for letter in given.strip() if letter.isprintable())
        for given in (q, owner, tag, parent, columns)
    )
    states = GROUPS.get(state, (state,) if state in JOB_STATES else ())
    key: SortKey = next((known for known in SORTS if known == sort), "created")
    ascending = {"ascending": True, "descending": False}.get(order)
    filtered = bool(text or states or whose or tagged or followed)
    parents = (followed,) if followed else None if filtered else ()
    filters = JobFilters(states, text or None, whose or None, key, ascending, tagged or None, parents)
    page = service.list(filters, limit=PAGE, cursor=cursor or None, trend=POINTS)
    follow_ups: dict[str, list[Job]] = {}
    more: dict[str, int] = {}
    if parents == () and page.items:
        below = JobFilters(sort=key, ascending=ascending, parents=tuple(job.id for job in page.items))
        listed = service.list(below, limit=MOST_FOLLOW_UPS, trend=POINTS)
        for job in listed.items:
            follow_ups.setdefault(job.parent or "", []).append(job)
        if listed.next_cursor is not None:
            every = service.count_follow_ups([job.id for job in page.items])
            more = {job_id: count for job_id, count in every.items() if count > len(follow_ups.get(job_id, ()))}
    chosen_columns = [name for name in dict.fromkeys(named.split(",")) if name][:MOST_COLUMNS]
    chosen = {
        "q": text,
        "state": state if states else "",
        "owner": whose,
        "tag": tagged,
        "parent": followed,
        "columns": ",".join(chosen_columns),
        "sort": key,
        "order": order if ascending is not None else "",
    }
    kept = {name: value for name, value in chosen.items() if value and (name, value) != ("sort", "created")}
    return render(
        request,
        "jobs",
        page=page,
        first=not cursor,
        chosen=chosen,
        filtered=filtered,
        follow_ups=follow_ups,
        more=more,
        most_follow_ups=MOST_FOLLOW_UPS,
        columns=chosen_columns,
        total=service.count(filters),
        rising=filters.rising,
        kept=kept,
        without_tag={name: value for name, value in kept.items() if name != "tag"},
        states=[*GROUPS, *JOB_STATES],
        sorts=SORTS,
        sparkline=sparkline,
        found=found,
        most=MOST_PARAMETERS,
        most_series=MOST_SERIES,
        fits=FITS,
        badges=BADGES,
        owners=request.app.state.authenticator.needed,
    )


@router.get("/compare")
def compare_page(
    request: Request,
    service: Service,
    job: Annotated[list[str] | None, Query(max_length=MOST_JOBS, description="ids of two to six jobs")] = None,
) -> HTMLResponse:
    """Show jobs side by side; jobs that are not there answer as on their own page."""
    jobs = [service.get(job_id) for job_id in dict.fromkeys(job or [])]
    return render(request, "compare", plots=True, jobs=jobs, fits=FITS, badges=BADGES)


SPARK_WIDTH, SPARK_HEIGHT = 96, 24


def sparkline(trend: Sequence[float | None] | None) -> str | None:
    """Corners of a step line of the lowest objective, logarithmic; None when there is nothing to draw."""
    levels = [math.log10(f) for f in trend or () if f is not None and f > 0 and math.isfinite(f)]
    if len(levels) < 2:
        return None
    low, high = min(levels), max(levels)
    span = high - low or 1.0
    step = (SPARK_WIDTH - 2 * MARGIN) / (len(levels) - 1)
    corners: list[str] = []
    for index, level in enumerate(levels):
        x = MARGIN + index * step
        y = MARGIN + (SPARK_HEIGHT - 2 * MARGIN) * (high - level) / span
        corners.append(f"H{x:.1f} V{y:.1f}" if corners else f"M{x:.1f} {y:.1f}")
    return " ".join(corners)


@router.get("/new")
def new_page(
    request: Request,
    service: Service,
    from_job: Annotated[str | None, Query(alias="from", max_length=64, description="job to start from")] = None,
    example: Annotated[str | None, Query(max_length=64, description="example to start from")] = None,
) -> HTMLResponse:
    """Show the form, empty or filled from an earlier job or an example."""
    source = None if from_job is None else service.get(from_job)
    return render(request, "new", plots=True, source=source, example=example)
