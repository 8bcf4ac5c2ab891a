# Generated from geoswarm/client/_async/analysis.py by scripts/generate_client.py; `make format` renews it.
"""Statistics, uncertainty and reports of a job."""

from __future__ import annotations

import json
import uuid
from collections.abc import Mapping, Sequence
from typing import Any, Literal
from urllib.parse import quote

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import JSON_BODY, Call, Noise, job_path, noise_query, plain, present, reader, view_query
from geoswarm.client.models import Figure, Report
from geoswarm.records.job import Job
from geoswarm.records.statistics import ReweightAnswer, StatisticsAnswer
from geoswarm.records.uncertainty import PosteriorAnswer, UncertaintyAnswer

__all__ = [
    "figure",
    "figures",
    "global_sensitivity",
    "posterior",
    "profile",
    "report",
    "report_pdf",
    "reweight",
    "sensitivity",
    "statistics",
    "uncertainty",
]


def statistics(
    self: Connection, job_id: str, *, threshold: float | None = None, noise: Noise = None
) -> StatisticsAnswer:
    """Judge the parameters of a job from its stored evaluations: verdicts, correlations, projections, proposals.

    Parameters
    ----------
    threshold
        Objective up to which a fit is good; proposed by the service when None.
    noise
        Known standard deviation of a reading, base units, one for all series or one each.
    """
    query = view_query(threshold, noise, False)
    return self._send(Call("GET", f"{job_path(job_id)}/statistics", reader(StatisticsAnswer), query))


def reweight(
    self: Connection,
    job_id: str,
    *,
    weights: Mapping[str, float] | None = None,
    point_weights: Mapping[str, Sequence[float]] | None = None,
    weighting: str | None = None,
    noise: Noise = None,
) -> ReweightAnswer:
    """Calculate the objectives that the stored responses have under other weights; no forward run.

    Parameters
    ----------
    weights, point_weights
        w_g by series and w_h of every point by series.
    weighting
        ``by_error``, ``by_count`` or ``by_range`` in place of ``weights``, or ``by_spread`` for those of points.
    noise
        Standard deviation of a reading, base units, for ``by_error``.
    """
    request = present(weights=weights, point_weights=point_weights, weighting=weighting, noise=noise)
    content = json.dumps(request, default=plain)
    path = f"{job_path(job_id)}/reweight"
    return self._send(Call("POST", path, reader(ReweightAnswer), headers=JSON_BODY, content=content))


def sensitivity(
    self: Connection,
    job_id: str,
    *,
    polish: bool = True,
    step: float | None = None,
    at: Mapping[str, float] | None = None,
    idempotency_key: str | None = None,
) -> Job:
    """Submit a follow-up that evaluates the sensitivities at the optimum of a job: standard errors, intervals.

    Parameters
    ----------
    polish
        Go to the minimum first; without, one generation at the best evaluation.
    step
        Largest difference in parts of the searched range; 0.005 when None.
    at
        Another optimum: values of the free parameters.
    """
    request = present(polish=polish, step=step, at=at)
    return _submit_follow_up(self, f"{job_path(job_id)}/sensitivity", request, idempotency_key)


def profile(
    self: Connection,
    job_id: str,
    *,
    parameters: Sequence[str] | None = None,
    noise: Noise = None,
    idempotency_key: str | None = None,
) -> Job:
    """Submit a follow-up that evaluates profile objectives; the job must have its sensitivities already.

    Parameters
    ----------
    parameters
        Those to profile; all free ones when None.
    noise
        Known standard deviation of a reading, base units.
    """
    request = present(parameters=parameters, noise=noise)
    return _submit_follow_up(self, f"{job_path(job_id)}/profile", request, idempotency_key)


def global_sensitivity(
    self: Connection,
    job_id: str,
    *,
    kind: Literal["sobol", "morris"] = "sobol",
    samples: int | None = None,
    idempotency_key: str | None = None,
) -> Job:
    """Submit a follow-up that evaluates the design of Sobol or Morris over the whole search range.

    Parameters
    ----------
    samples
        Base points, a power of two (256 when None), or trajectories (20).
    """
    request = present(kind=kind, samples=samples)
    return _submit_follow_up(self, f"{job_path(job_id)}/global-sensitivity", request, idempotency_key)


def uncertainty(self: Connection, job_id: str, *, noise: Noise = None) -> UncertaintyAnswer:
    """Show what the follow-ups of a job have found: intervals, profiles, global sensitivities."""
    return self._send(Call("GET", f"{job_path(job_id)}/uncertainty", reader(UncertaintyAnswer), noise_query(noise)))


def posterior(self: Connection, job_id: str, *, noise: Noise = None) -> PosteriorAnswer:
    """Sample the posterior through a checked response surface of the stored evaluations; no forward run."""
    return self._send(Call("GET", f"{job_path(job_id)}/posterior", reader(PosteriorAnswer), noise_query(noise)))


def report(
    self: Connection, job_id: str, *, threshold: float | None = None, noise: Noise = None, posterior: bool = False
) -> Report:
    """Show the report of a job, on request with a posterior sample; a notebook displays it."""
    query = view_query(threshold, noise, posterior)
    return self._send(Call("GET", f"{job_path(job_id)}/report.html", lambda response: Report(response.text), query))


def report_pdf(
    self: Connection, job_id: str, *, threshold: float | None = None, noise: Noise = None, posterior: bool = False
) -> bytes:
    """Show the report of a job as PDF."""
    query = view_query(threshold, noise, posterior)
    return self._send(Call("GET", f"{job_path(job_id)}/report.pdf", lambda response: response.content, query))


def figures(self: Connection, job_id: str, *, noise: Noise = None, posterior: bool = False) -> tuple[str, ...]:
    """List the figures that can be drawn of a job."""
    query = view_query(None, noise, posterior)
    return self._send(Call("GET", f"{job_path(job_id)}/figures", reader(tuple[str, ...], "items"), query))


def figure(
    self: Connection,
    job_id: str,
    name: str,
    *,
    form: Literal["svg", "png", "csv"] = "svg",
    threshold: float | None = None,
    noise: Noise = None,
    posterior: bool = False,
) -> Figure:
    """Show a figure of a job, or (csv) the numbers behind it; a notebook displays it."""
    path = f"{job_path(job_id)}/figures/{quote(name, safe='')}.{form}"
    query = view_query(threshold, noise, posterior)
    return self._send(Call("GET", path, lambda response: Figure(name, form, response.content), query))


def _submit_follow_up(self: Connection, path: str, request: Mapping[str, Any], idempotency_key: str | None) -> Job:
    """Submit a follow-up; without a key a fresh one is used, so that a repeated request never creates two."""
    headers = {**JSON_BODY, "Idempotency-Key": idempotency_key or str(uuid.uuid4())}
    content = json.dumps(request, default=plain)
    return self._send(Call("POST", path, reader(Job), headers=headers, content=content))
