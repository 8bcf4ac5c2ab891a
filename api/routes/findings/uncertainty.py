"""How sure the parameters of a job are: follow-up jobs that evaluate more, and what they have found."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Header, Request, Response

from geoswarm.api.answers import read_record
from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.schemas.statistics import (
    GlobalRequest,
    ProfileRequest,
    SensitivityRequest,
)
from geoswarm.api.views import Noise
from geoswarm.records.job import Job
from geoswarm.records.uncertainty import PosteriorAnswer, UncertaintyAnswer
from geoswarm.workers.service.findings import submit_global_sensitivity, submit_profile, submit_sensitivity

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["uncertainty"])

Key = Annotated[
    str | None,
    Header(min_length=1, max_length=200, description="the same key with the same request creates one job only"),
]
CREATED: dict[int | str, dict[str, object]] = {
    200: {"model": Job, "description": "The job that the same request has created before"}
}


@router.post("/sensitivity", status_code=201, responses={**CREATED, **problems_of(404, 408, 409, 413, 422)})
def sensitivity(
    job_id: JobId,
    service: Service,
    request: Request,
    response: Response,
    wanted: SensitivityRequest | None = None,
    idempotency_key: Key = None,
) -> Job:
    """Submit a follow-up that evaluates the sensitivities at the optimum: standard errors, intervals, combinations."""
    options = (wanted or SensitivityRequest()).model_dump()
    return _created(request, response, submit_sensitivity(service, job_id, **options, idempotency_key=idempotency_key))


@router.post("/profile", status_code=201, responses={**CREATED, **problems_of(404, 408, 409, 413, 422)})
def profile(
    job_id: JobId,
    service: Service,
    request: Request,
    response: Response,
    wanted: ProfileRequest | None = None,
    idempotency_key: Key = None,
) -> Job:
    """Submit a follow-up that evaluates profile objectives; needs the sensitivities at the optimum first (409)."""
    options = (wanted or ProfileRequest()).model_dump()
    return _created(request, response, submit_profile(service, job_id, **options, idempotency_key=idempotency_key))


@router.post("/global-sensitivity", status_code=201, responses={**CREATED, **problems_of(404, 408, 409, 413, 422)})
def global_sensitivity(
    job_id: JobId,
    service: Service,
    request: Request,
    response: Response,
    wanted: GlobalRequest | None = None,
    idempotency_key: Key = None,
) -> Job:
    """Submit a follow-up that evaluates the design of Sobol or Morris over the whole search range."""
    options = (wanted or GlobalRequest()).model_dump()
    submitted = submit_global_sensitivity(service, job_id, **options, idempotency_key=idempotency_key)
    return _created(request, response, submitted)


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


def _created(request: Request, response: Response, submitted: tuple[Job, bool]) -> Job:
    job, created = submitted
    response.status_code = 201 if created else 200
    response.headers["Location"] = request.app.url_path_for("show", job_id=job.id)
    return job
