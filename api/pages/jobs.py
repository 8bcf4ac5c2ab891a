"""The list of jobs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.dependencies import Service
from geoswarm.api.pages.shell import number, render
from geoswarm.api.pages.sparkline import sparkline
from geoswarm.records.job import Job
from geoswarm.records.states import ENDED_STATES, JOB_STATES, OPEN_STATES
from geoswarm.solver.words import FITS, ends, interval_digits, verdict_in_words
from geoswarm.workers.queries.job_list import JobFilters, SortKey

__all__ = ["BADGES", "router"]

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


@dataclass(frozen=True, slots=True)
class FoundValue:
    """A free parameter in the list: its value, the ends of its interval (empty: none), and what is wrong with it."""

    name: str
    value: str
    ends: tuple[str, ...]
    doubt: str | None


def found(job: Job) -> list[FoundValue]:
    """Return the first free parameters of a job, none before an evaluation has succeeded."""
    if job.parameters is None:
        return []
    values = []
    for name in job.free_parameters[:MOST_PARAMETERS]:
        value, interval = job.parameters[name], (job.intervals or {}).get(name)
        told = () if interval is None else ends(*interval, plain=True)
        digits = 4 if interval is None else interval_digits(*interval)
        doubt = None
        if bound := (job.at_bounds or {}).get(name):
            doubt = f"at its {bound} bound"
        elif (kind := (job.verdicts or {}).get(name, "identified")) != "identified":
            doubt = verdict_in_words(kind)
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
    sort: Annotated[str, Query(max_length=20)] = "created",
    order: Annotated[str, Query(max_length=20, description="ascending or descending")] = "",
) -> HTMLResponse:
    """List the jobs, newest first unless asked otherwise; what a filter does not know it leaves out."""
    text = "".join(letter for letter in q.strip() if letter.isprintable())
    states = GROUPS.get(state, (state,) if state in JOB_STATES else ())
    whose = "".join(letter for letter in owner.strip() if letter.isprintable())
    key: SortKey = next((known for known in SORTS if known == sort), "created")
    ascending = {"ascending": True, "descending": False}.get(order)
    filters = JobFilters(states, text or None, whose or None, key, ascending)
    page = service.list(filters, limit=PAGE, cursor=cursor or None, trend=POINTS)
    chosen = {
        "q": text,
        "state": state if states else "",
        "owner": whose,
        "sort": key,
        "order": order if ascending is not None else "",
    }
    return render(
        request,
        "jobs",
        page=page,
        first=not cursor,
        chosen=chosen,
        filtered=bool(text or states or whose),
        total=service.count(filters),
        rising=filters.rising,
        kept={name: value for name, value in chosen.items() if value and (name, value) != ("sort", "created")},
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
