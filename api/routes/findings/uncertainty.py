"""How sure the parameters of a job are: follow-up jobs that evaluate more, and what they have found.

The statistics are slow to import, so each route imports what it calls.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Query, Request, Response

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.schemas.statistics import (
    DesignRequest,
    ExploreRequest,
    GlobalRequest,
    JackknifeRequest,
    PredictRequest,
    ProfileRequest,
    SensitivityRequest,
)
from geoswarm.api.views import Noise, read_record
from geoswarm.records.job import Job
from geoswarm.records.progress import FollowUpCosts
from geoswarm.records.uncertainty import PosteriorAnswer, SurfaceAnswer, UncertaintyAnswer
from geoswarm.solver.problem import read_document

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["uncertainty"])

Key = Annotated[
    str | None,
    Header(min_length=1, max_length=200, description="the same key with the same request creates one job only"),
]
CREATED: dict[int | str, dict[str, object]] = {
    200: {"model": Job, "description": "The job that the same request has created before"}
}


FOLLOW_UP: dict[str, Any] = {"status_code": 201, "responses": {**CREATED, **problems_of(404, 408, 409, 413, 422)}}


async def _submission(
    job_id: JobId, service: Service, request: Request, response: Response, idempotency_key: Key = None
) -> Callable[..., Job]:
    """Submits a follow-up of the job, once for each key."""

    def submit(how: Callable[..., tuple[Job, bool]], *given: Any, **options: Any) -> Job:
        job, created = how(service, job_id, *given, **options, idempotency_key=idempotency_key)
        response.status_code = 201 if created else 200
        response.headers["Location"] = request.app.url_path_for("show", job_id=job.id)
        return job

    return submit


Submit = Annotated[Callable[..., Job], Depends(_submission)]


@router.post("/sensitivity", **FOLLOW_UP)
def sensitivity(submit: Submit, wanted: SensitivityRequest | None = None) -> Job:
    """Submit a follow-up that evaluates the sensitivities at the optimum: standard errors, intervals, combinations."""
    from geoswarm.workers.service.findings import submit_sensitivity

    return submit(submit_sensitivity, **(wanted or SensitivityRequest()).model_dump())


@router.post("/profile", **FOLLOW_UP)
def profile(submit: Submit, wanted: ProfileRequest | None = None) -> Job:
    """Submit a follow-up that evaluates profile objectives; needs the sensitivities at the optimum first (409)."""
    from geoswarm.workers.service.findings import submit_profile

    return submit(submit_profile, **(wanted or ProfileRequest()).model_dump())


@router.post("/jackknife", **FOLLOW_UP)
def jackknife(submit: Submit, wanted: JackknifeRequest | None = None) -> Job:
    """Submit a follow-up that fits the parameters without each test; needs the sensitivities first (409)."""
    from geoswarm.workers.service.findings import submit_jackknife

    return submit(submit_jackknife, runs=(wanted or JackknifeRequest()).runs)


@router.post("/explore", **FOLLOW_UP)
def explore(submit: Submit, wanted: ExploreRequest | None = None) -> Job:
    """Submit a follow-up that spends runs where, by the stored evaluations, a second basin is most likely."""
    from geoswarm.workers.service.findings import submit_explore

    return submit(submit_explore, **(wanted or ExploreRequest()).model_dump())


@router.post("/predict", **FOLLOW_UP)
def predict(submit: Submit, wanted: PredictRequest) -> Job:
    """Submit a follow-up that predicts another forward model with the identified parameters and their uncertainty."""
    from geoswarm.workers.service.findings import submit_prediction

    options = wanted.model_dump()
    return submit(submit_prediction, _read(options.pop("problem")), **options)


@router.post("/design", **FOLLOW_UP)
def design(submit: Submit, wanted: DesignRequest) -> Job:
    """Submit a follow-up that ranks candidate tests by how much they would narrow the intervals or a prediction."""
    from geoswarm.workers.service.findings import submit_design

    options = wanted.model_dump()
    candidates, predicted = _read(options.pop("candidates")), options.pop("predict")
    return submit(submit_design, candidates, **options, predict=None if predicted is None else _read(predicted))


@router.post("/global-sensitivity", **FOLLOW_UP)
def global_sensitivity(submit: Submit, wanted: GlobalRequest | None = None) -> Job:
    """Submit a follow-up that evaluates the design of Sobol or Morris over the whole search range."""
    from geoswarm.workers.service.findings import submit_global_sensitivity

    return submit(submit_global_sensitivity, **(wanted or GlobalRequest()).model_dump())


@router.get("/follow-ups", responses=problems_of(404, 422))
def follow_ups(job_id: JobId, service: Service) -> FollowUpCosts:
    """Estimate the runs and time of follow-ups before submitting one, from the runs of the job so far."""
    from geoswarm.workers.service.follow_up_costs import follow_up_costs

    return follow_up_costs(service, job_id)


@router.get("/uncertainty", responses=problems_of(404, 422))
def uncertainty(job_id: JobId, service: Service, noise: Noise) -> UncertaintyAnswer:
    """Show what the follow-ups of a job have found so far; of a follow-up, what it has found itself."""
    statistics = service.statistics
    follow_ups = [
        {"id": f.id, "kind": f.kind, "state": f.state, "evaluations": f.evaluations}
        for f in statistics.follow_ups(job_id)
    ]
    found = statistics.findings(job_id, noise=noise).to_json()
    return read_record(UncertaintyAnswer, found | {"follow_ups": follow_ups})


@router.get("/posterior", responses=problems_of(404, 422))
def posterior(job_id: JobId, service: Service, noise: Noise) -> PosteriorAnswer:
    """Sample the posterior through a checked response surface of the stored evaluations; takes seconds, once."""
    return read_record(PosteriorAnswer, service.statistics.posterior(job_id, noise=noise).to_json())


@router.get("/surface", responses=problems_of(404, 422))
def surface(
    job_id: JobId,
    service: Service,
    noise: Noise,
    x: Annotated[str | None, Query(max_length=200, description="across; the first free parameter if absent")] = None,
    y: Annotated[str | None, Query(max_length=200, description="upwards; the next free parameter if absent")] = None,
) -> SurfaceAnswer:
    """Cut the response surface of the stored evaluations through the best run: slices, contours, importance."""
    return read_record(SurfaceAnswer, service.statistics.surface(job_id, x=x, y=y, noise=noise).to_json())


def _read(given: dict[str, Any] | str) -> dict[str, Any]:
    """A document, read where it came as text."""
    return read_document(given, "yaml") if isinstance(given, str) else given
