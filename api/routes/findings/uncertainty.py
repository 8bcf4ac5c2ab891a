"""How sure the parameters of a job are: follow-up jobs that evaluate more, and what they have found.

The statistics are slow to import, so each route imports what it calls.
"""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Header, Request, Response

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
from geoswarm.records.uncertainty import PosteriorAnswer, UncertaintyAnswer
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
    from geoswarm.workers.service.findings import submit_sensitivity

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
    from geoswarm.workers.service.findings import submit_profile

    options = (wanted or ProfileRequest()).model_dump()
    return _created(request, response, submit_profile(service, job_id, **options, idempotency_key=idempotency_key))


@router.post("/jackknife", status_code=201, responses={**CREATED, **problems_of(404, 408, 409, 413, 422)})
def jackknife(
    job_id: JobId,
    service: Service,
    request: Request,
    response: Response,
    wanted: JackknifeRequest | None = None,
    idempotency_key: Key = None,
) -> Job:
    """Submit a follow-up that fits the parameters without each test; needs the sensitivities first (409)."""
    from geoswarm.workers.service.findings import submit_jackknife

    runs = (wanted or JackknifeRequest()).runs
    return _created(request, response, submit_jackknife(service, job_id, runs=runs, idempotency_key=idempotency_key))


@router.post("/explore", status_code=201, responses={**CREATED, **problems_of(404, 408, 409, 413, 422)})
def explore(
    job_id: JobId,
    service: Service,
    request: Request,
    response: Response,
    wanted: ExploreRequest | None = None,
    idempotency_key: Key = None,
) -> Job:
    """Submit a follow-up that spends runs where, by the stored evaluations, a second basin is most likely."""
    from geoswarm.workers.service.findings import submit_explore

    options = (wanted or ExploreRequest()).model_dump()
    return _created(request, response, submit_explore(service, job_id, **options, idempotency_key=idempotency_key))


@router.post("/predict", status_code=201, responses={**CREATED, **problems_of(404, 408, 409, 413, 422)})
def predict(
    job_id: JobId,
    service: Service,
    request: Request,
    response: Response,
    wanted: PredictRequest,
    idempotency_key: Key = None,
) -> Job:
    """Submit a follow-up that predicts another forward model with the identified parameters and their uncertainty."""
    from geoswarm.workers.service.findings import submit_prediction

    options = wanted.model_dump()
    problem = _read(options.pop("problem"))
    submitted = submit_prediction(service, job_id, problem, **options, idempotency_key=idempotency_key)
    return _created(request, response, submitted)


@router.post("/design", status_code=201, responses={**CREATED, **problems_of(404, 408, 409, 413, 422)})
def design(
    job_id: JobId,
    service: Service,
    request: Request,
    response: Response,
    wanted: DesignRequest,
    idempotency_key: Key = None,
) -> Job:
    """Submit a follow-up that ranks candidate tests by how much they would narrow the intervals or a prediction."""
    from geoswarm.workers.service.findings import submit_design

    options = wanted.model_dump()
    candidates = _read(options.pop("candidates"))
    predicted = options.pop("predict")
    options["predict"] = None if predicted is None else _read(predicted)
    submitted = submit_design(service, job_id, candidates, **options, idempotency_key=idempotency_key)
    return _created(request, response, submitted)


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
    from geoswarm.workers.service.findings import submit_global_sensitivity

    options = (wanted or GlobalRequest()).model_dump()
    submitted = submit_global_sensitivity(service, job_id, **options, idempotency_key=idempotency_key)
    return _created(request, response, submitted)


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


def _read(given: dict[str, Any] | str) -> dict[str, Any]:
    """A document, read where it came as text."""
    return read_document(given, "yaml") if isinstance(given, str) else given


def _created(request: Request, response: Response, submitted: tuple[Job, bool]) -> Job:
    job, created = submitted
    response.status_code = 201 if created else 200
    response.headers["Location"] = request.app.url_path_for("show", job_id=job.id)
    return job
