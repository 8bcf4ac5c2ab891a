"""The first dashboard: a list of jobs and a page a job, rendered on the server.

The script only renews the ``main`` part of a page: on every event of the job, and now and then in the list.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from api.dependencies import JobId, Service
from api.feed import ENDED_STATES
from workers.views import GenerationView, JobView

__all__ = ["Convergence", "convergence", "number", "router"]

router = APIRouter(include_in_schema=False)

PLOT_WIDTH, PLOT_HEIGHT = 640, 300
LEFT, RIGHT, TOP, BOTTOM = 64, 12, 12, 40
MOST_POINTS = 1000


def number(value: float | None, digits: int = 4) -> str:
    """A number for readers; a dash for None."""
    return "–" if value is None else f"{value:.{digits}g}"


def progress(job: JobView) -> float | None:
    """Share of the planned evaluations, from 0 to 1; None without a plan."""
    return min(job.evaluations / job.max_evaluations, 1.0) if job.max_evaluations else None


@dataclass(frozen=True, slots=True)
class Convergence:
    """Pixel coordinates of a convergence plot: objective (logarithmic) over evaluations."""

    best: str
    generations: list[tuple[float, float]]
    y_ticks: list[tuple[float, str]]
    x_ticks: list[tuple[float, str]]


def convergence(views: Sequence[GenerationView]) -> Convergence | None:
    """Place the best objective so far (line) and of each generation (dots); None when there is nothing to draw."""
    best = [(v.evaluations, v.objective) for v in views if v.objective is not None and v.objective > 0]
    own = [(v.evaluations, v.best_objective) for v in views if v.best_objective is not None and v.best_objective > 0]
    if not best:
        return None
    levels = [math.log10(f) for _, f in (*best, *own) if math.isfinite(f)]
    low, high = math.floor(min(levels)), math.ceil(max(levels))
    high = max(high, low + 1)
    last = max(n for n, _ in best)

    def place(evaluations: int, objective: float) -> tuple[float, float]:
        x = LEFT + (PLOT_WIDTH - LEFT - RIGHT) * evaluations / last
        y = TOP + (PLOT_HEIGHT - TOP - BOTTOM) * (high - math.log10(objective)) / (high - low)
        return round(x, 1), round(y, 1)

    corners: list[str] = []
    for n, f in best:
        x, y = place(n, f)
        corners.append(f"H{x} V{y}" if corners else f"M{x} {y}")
    decade = max(1, math.ceil((high - low) / 6))
    return Convergence(
        best=" ".join(corners),
        generations=[place(n, f) for n, f in own if math.isfinite(f)],
        y_ticks=[(place(0, 10.0**power)[1], f"1e{power}") for power in range(low, high + 1, decade)],
        x_ticks=[(place(n, 10.0**low)[0], str(n)) for n in (0, last // 2, last)],
    )


templates = Environment(
    loader=FileSystemLoader(Path(__file__).parent / "templates"),
    autoescape=select_autoescape(),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
templates.filters["number"] = number
templates.globals.update(progress=progress, ended_states=ENDED_STATES)


@router.get("/")
def jobs_page(service: Service, cursor: Annotated[str | None, Query(max_length=500)] = None) -> HTMLResponse:
    """List the jobs, newest first."""
    page = service.list(limit=50, cursor=cursor)
    return HTMLResponse(templates.get_template("jobs.html").render(page=page, first=cursor is None))


@router.get("/jobs/{job_id}", name="job_page")
def job_page(job_id: JobId, service: Service, request: Request) -> HTMLResponse:
    """Show a job: progress, identified parameters, convergence."""
    job = service.get(job_id)
    generations = service.generations(job_id, after=max(-1, job.generations - MOST_POINTS - 1), limit=MOST_POINTS)
    events = request.app.url_path_for("events", job_id=job_id)
    return HTMLResponse(
        templates.get_template("job.html").render(job=job, plot=convergence(generations), events=events)
    )
