"""What the evaluations of a job tell: statistics, report, figures, other weights. A model runs for another set only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from fastapi import APIRouter, Depends, Path, Query, Response
from pydantic import BaseModel, ConfigDict, Field

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.headers import DOCUMENT_POLICY
from geoswarm.api.schemas.statistics import FigureList
from geoswarm.api.views import WantedReport, WantedView, read_record
from geoswarm.records.statistics import ReweightAnswer, StatisticsAnswer
from geoswarm.solver.problem.weighting import Weighting
from geoswarm.solver.report.figures.style import figures_available, png_of, svg_of
from geoswarm.solver.report.parts import PARTS, Part
from geoswarm.solver.system.extras import needs_extra
from geoswarm.workers.service.job_service import JobService

if TYPE_CHECKING:
    from geoswarm.solver.report.document.build import Report

__all__ = ["ReweightRequest", "router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["statistics"])

MEDIA_TYPES = {"svg": "image/svg+xml", "png": "image/png", "csv": "text/csv; charset=utf-8"}


class ReweightRequest(BaseModel):
    """Other weights for the stored responses of a job."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    weights: dict[str, float] | None = Field(None, description="w_g by series; series not named keep theirs")
    point_weights: dict[str, list[float]] | None = Field(None, description="w_h of every point, by series")
    weighting: Weighting | Literal["by_spread"] | None = Field(
        None, description="a scheme that chooses w_g, instead of weights; by_spread chooses w_h"
    )
    noise: dict[str, float] | float | None = Field(
        None, description="standard deviation of a reading, base units, for by_error"
    )


@router.get("/statistics", responses=problems_of(404, 409, 422))
def statistics(job_id: JobId, service: Service, view: WantedView) -> StatisticsAnswer:
    """Show what the stored evaluations say about the parameters.

    Answers ``samples``, ``threshold``, ``correlations``, ``projections``, ``verdicts`` with evidence and proposals,
    ``residuals``, ``weights`` (share of each series) and ``warnings``; docs/statistics.md explains them.
    """
    found = service.statistics.report(job_id, **view.options).statistics
    if found is None:
        raise _nothing_yet(service, job_id)
    return read_record(StatisticsAnswer, found.to_json())


@router.post("/reweight", responses=problems_of(404, 408, 409, 413, 422))
def reweight(job_id: JobId, service: Service, request: ReweightRequest) -> ReweightAnswer:
    """Calculate the objectives that the stored responses have under other weights; changes nothing in the job.

    Answers the share of each series, the best evaluation under the new weights beside the old one, ``warnings`` when
    the optimum would move outside the sampled region, and the problem with the new weights, ready to be submitted.
    """
    if service.statistics.stored(job_id).samples.size == 0:
        raise _nothing_yet(service, job_id)
    return read_record(ReweightAnswer, service.statistics.reweighted(job_id, **request.model_dump()))


async def _parts(
    part: Annotated[
        list[Part] | None,
        Query(max_length=len(PARTS), description="show this part only, may be repeated; absent: all"),
    ] = None,
) -> tuple[Part, ...]:
    return tuple(one for one in PARTS if part is None or one in part)


WantedParts = Annotated[tuple[Part, ...], Depends(_parts)]


@router.get(
    "/report.html", response_class=Response, responses={200: {"content": {"text/html": {}}}, **problems_of(404, 422)}
)
def report_html(job_id: JobId, service: Service, view: WantedReport, parts: WantedParts) -> Response:
    """Show the report of a job as a self-contained page; summary and alarm are in every one."""
    form = f"html {parts}"
    page = service.statistics.rendered(job_id, form, lambda report: report.html(parts).encode(), **view.options)
    return _document(page, "text/html; charset=utf-8")


@router.get(
    "/report.pdf",
    response_class=Response,
    responses={200: {"content": {"application/pdf": {}}}, **problems_of(404, 422, 501)},
)
def report_pdf(job_id: JobId, service: Service, view: WantedReport, parts: WantedParts) -> Response:
    """Show the report of a job as PDF; summary and alarm are in every one."""
    _need_figures()
    pdf = service.statistics.rendered(job_id, f"pdf {parts}", lambda report: report.pdf(parts), **view.options)
    return _document(pdf, "application/pdf", f"report-{job_id}.pdf")


@router.get("/figures", responses=problems_of(404))
def figures(job_id: JobId, service: Service, view: WantedReport) -> FigureList:
    """List the figures that can be drawn for a job."""
    return FigureList(items=list(service.statistics.report(job_id, **view.options).figures.names))


@router.get(
    "/figures/{name}.{form}",
    response_class=Response,
    responses={
        200: {"content": {"image/svg+xml": {}, "image/png": {}, "text/csv": {}}, "description": "The figure"},
        **problems_of(404, 422, 501),
    },
)
def figure(
    job_id: JobId,
    service: Service,
    name: Annotated[str, Path(max_length=200, description="as listed by /figures")],
    form: Annotated[Literal["svg", "png", "csv"], Path(description="csv: the numbers that the figure shows")],
    view: WantedReport,
) -> Response:
    """Show a figure of a job, or the numbers behind it."""
    if form != "csv":
        _need_figures()
    report = service.statistics.report(job_id, **view.options)
    if name not in report.figures.names:
        raise DetailError(
            404,
            f"Job {job_id} has no figure {name!r}; there are: {', '.join(report.figures.names) or 'none yet'}.",
            kind="no-figure",
            title="No such figure",
        )

    def make(report: Report) -> bytes:
        if form == "csv":
            return report.figures.csv(name).encode()
        return (svg_of if form == "svg" else png_of)(report.figures.draw(name))

    content = service.statistics.rendered(job_id, f"{name}.{form}", make, **view.options)
    return _document(content, MEDIA_TYPES[form])


def _document(content: bytes, media_type: str, file_name: str | None = None) -> Response:
    headers = {"Content-Security-Policy": DOCUMENT_POLICY}
    if file_name is not None:
        headers["Content-Disposition"] = f'inline; filename="{file_name}"'
    return Response(content, media_type=media_type, headers=headers)


def _nothing_yet(service: JobService, job_id: str) -> DetailError:
    state = service.get(job_id).state
    return DetailError(
        409,
        f"Job {job_id} ({state}) has no successful evaluation yet, so there is nothing to judge.",
        kind="no-evaluations",
        title="No evaluations yet",
    )


def _need_figures() -> None:
    if not figures_available():
        raise DetailError(
            501,
            f"{needs_extra('a service that draws figures', 'matplotlib')}.",
            kind="no-figures",
            title="Figures not available",
        )
