"""Statistics and uncertainty of a job."""

from __future__ import annotations

import asyncio
import json
import uuid
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from geoswarm.client._async.connection import AsyncConnection
from geoswarm.client.calls import (
    JSON_BODY,
    Call,
    Noise,
    Problem,
    job_path,
    noise_query,
    plain,
    present,
    question_document,
    reader,
    view_query,
)
from geoswarm.records.job import Job
from geoswarm.records.statistics import ReweightAnswer, StatisticsAnswer
from geoswarm.records.uncertainty import PosteriorAnswer, SurfaceAnswer, UncertaintyAnswer

__all__ = [
    "design",
    "explore",
    "global_sensitivity",
    "jackknife",
    "posterior",
    "predict",
    "profile",
    "reweight",
    "sensitivity",
    "statistics",
    "surface",
    "uncertainty",
]


async def statistics(
    self: AsyncConnection, job_id: str, *, threshold: float | None = None, noise: Noise = None
) -> StatisticsAnswer:
    """Show what a job's stored evaluations say about each parameter: verdicts, correlations, projections, proposals.

    Parameters
    ----------
    threshold
        Objective up to which a fit counts as good; proposed by the service when None.
    noise
        Known standard deviation of a reading, base units, one for all series or one each.

    Examples
    --------
    >>> statistics = await client.statistics(job.id, noise=0.1)
    >>> [verdict.parameter for verdict in statistics.verdicts]
    ['a', 'b']
    """
    query = view_query(threshold, noise, False)
    return await self._send(Call("GET", f"{job_path(job_id)}/statistics", reader(StatisticsAnswer), query))


async def reweight(
    self: AsyncConnection,
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
        ``by_error``, ``by_count``, ``by_range`` or ``by_test`` instead of ``weights``, or
        ``by_spread`` for those of points.
    noise
        Standard deviation of a reading, base units, for ``by_error``.

    Examples
    --------
    >>> answer = await client.reweight(job.id, weights={"y": 2.0})
    >>> answer.moved, answer.problem["observations"][0]["weight"]
    (False, 2.0)
    """
    request = present(weights=weights, point_weights=point_weights, weighting=weighting, noise=noise)
    content = json.dumps(request, default=plain)
    path = f"{job_path(job_id)}/reweight"
    return await self._send(Call("POST", path, reader(ReweightAnswer), headers=JSON_BODY, content=content))


async def sensitivity(
    self: AsyncConnection,
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
        Go to the minimum first; otherwise evaluate one generation at the best evaluation.
    step
        Largest difference in parts of the searched range; 0.005 when None.
    at
        Another optimum: values of the free parameters.

    Examples
    --------
    >>> follow_up = await client.sensitivity(job.id)
    >>> follow_up.method
    'sensitivity'
    """
    request = present(polish=polish, step=step, at=at)
    return await _submit_follow_up(self, f"{job_path(job_id)}/sensitivity", request, idempotency_key)


async def profile(
    self: AsyncConnection,
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

    Examples
    --------
    >>> ended = await client.wait((await client.sensitivity(job.id)).id, timeout=60)
    >>> follow_up = await client.profile(job.id, parameters=["a"], noise=0.1)
    >>> follow_up.method
    'profile'
    """
    request = present(parameters=parameters, noise=noise)
    return await _submit_follow_up(self, f"{job_path(job_id)}/profile", request, idempotency_key)


async def jackknife(
    self: AsyncConnection, job_id: str, *, runs: int | None = None, idempotency_key: str | None = None
) -> Job:
    """Submit a follow-up that fits the parameters without each test, with a limited number of runs.

    The job must have its sensitivities already, and three tests or more.

    Examples
    --------
    >>> from geoswarm import HttpError
    >>> try:
    ...     await client.jackknife(job.id)
    ... except HttpError as error:
    ...     error.detail[-12:]
    'a single one'
    """
    return await _submit_follow_up(self, f"{job_path(job_id)}/jackknife", present(runs=runs), idempotency_key)


async def explore(
    self: AsyncConnection,
    job_id: str,
    *,
    runs: int | None = None,
    noise: Noise = None,
    idempotency_key: str | None = None,
) -> Job:
    """Submit a follow-up that spends runs where, by the stored evaluations, a second basin is most likely.

    Parameters
    ----------
    runs
        Maximum number of evaluations; 100 when None.

    Examples
    --------
    >>> follow_up = await client.explore(job.id, runs=20)
    >>> follow_up.method
    'explore'
    """
    request = present(runs=runs, noise=noise)
    return await _submit_follow_up(self, f"{job_path(job_id)}/explore", request, idempotency_key)


async def predict(
    self: AsyncConnection,
    job_id: str,
    problem: Problem,
    *,
    runs: int | None = None,
    level: float | None = None,
    noise: Noise = None,
    source: Literal["auto", "posterior", "covariance"] | None = None,
    idempotency_key: str | None = None,
) -> Job:
    """Submit a follow-up that predicts another forward model with the identified parameters and their uncertainty.

    ``uncertainty(job.id).predictions`` of the follow-up, or of the job itself, has the bands.

    Parameters
    ----------
    problem
        The problem that is predicted: a mapping, or the path of a problem file. Its observations say where (points with
        x; y if it was measured); it gives the parameters that the job does not identify.
    runs, level
        Number of forward runs (200 when None), and probability of the band at each x (0.9).
    noise
        Known standard deviation of a reading, base units.
    source
        Where the draws come from; ``auto`` when None.

    Examples
    --------
    >>> further = [{"series": "y", "points": {"x": [3, 4]}}]
    >>> later = {"forward_model": problem["forward_model"], "observations": further}
    >>> follow_up = await client.predict(job.id, later, noise=0.1)
    >>> follow_up.method
    'predict'
    """
    document = await asyncio.to_thread(question_document, problem)
    request = present(problem=document, runs=runs, level=level, noise=noise, source=source)
    return await _submit_follow_up(self, f"{job_path(job_id)}/predict", request, idempotency_key)


async def design(
    self: AsyncConnection,
    job_id: str,
    candidates: Problem,
    *,
    predict: Problem | None = None,
    criterion: Literal["widths", "volume", "prediction"] | None = None,
    draws: int | None = None,
    noise: Noise = None,
    idempotency_key: str | None = None,
) -> Job:
    """Submit a follow-up that ranks candidate tests by how much they would narrow the intervals or a prediction.

    ``uncertainty(job.id).designs`` of the follow-up, or of the job itself, has the order.

    Parameters
    ----------
    candidates
        A mapping with ``candidates``, or the path of a file of them.
    predict
        A problem whose prediction is to become narrower.
    criterion
        How to rank them; ``prediction`` when one is given, else ``widths``.
    draws
        Number of points around the optima over which the worth is averaged; 8 when None.
    noise
        Known standard deviation of a reading, base units.

    Examples
    --------
    >>> far = {"name": "far", "observations": [{"series": "y", "points": {"x": [9]}}]}
    >>> near = {"name": "near", "observations": [{"series": "y", "points": {"x": [3]}}]}
    >>> follow_up = await client.design(job.id, {"candidates": [near, far]}, noise=0.1)
    >>> follow_up.method
    'design'
    """
    document = dict(await asyncio.to_thread(question_document, candidates))
    document.pop("name", None)
    other = None if predict is None else await asyncio.to_thread(question_document, predict)
    request = present(candidates=document, predict=other, criterion=criterion, draws=draws, noise=noise)
    return await _submit_follow_up(self, f"{job_path(job_id)}/design", request, idempotency_key)


async def global_sensitivity(
    self: AsyncConnection,
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

    Examples
    --------
    >>> follow_up = await client.global_sensitivity(job.id, kind="morris", samples=8)
    >>> follow_up.method
    'morris'
    """
    request = present(kind=kind, samples=samples)
    return await _submit_follow_up(self, f"{job_path(job_id)}/global-sensitivity", request, idempotency_key)


async def uncertainty(self: AsyncConnection, job_id: str, *, noise: Noise = None) -> UncertaintyAnswer:
    """Show what the follow-ups of a job have found: intervals, profiles, global sensitivities.

    Examples
    --------
    >>> ended = await client.wait((await client.sensitivity(job.id)).id, timeout=60)
    >>> found = await client.uncertainty(job.id, noise=0.1)
    >>> "sensitivity" in [one.kind for one in found.follow_ups]
    True
    """
    return await self._send(
        Call("GET", f"{job_path(job_id)}/uncertainty", reader(UncertaintyAnswer), noise_query(noise))
    )


async def posterior(self: AsyncConnection, job_id: str, *, noise: Noise = None) -> PosteriorAnswer:
    """Sample the posterior through a checked response surface of the stored evaluations; no forward run.

    Examples
    --------
    >>> sample = await client.posterior(job.id, noise=0.1)
    >>> round(sample.medians["b"], 1)
    2.0
    """
    return await self._send(Call("GET", f"{job_path(job_id)}/posterior", reader(PosteriorAnswer), noise_query(noise)))


async def surface(
    self: AsyncConnection, job_id: str, *, x: str | None = None, y: str | None = None, noise: Noise = None
) -> SurfaceAnswer:
    """Cut the response surface of the stored evaluations through the best run: slices, contours; no forward run.

    Parameters
    ----------
    x, y
        Parameters of the contours; the first ones when None.
    noise
        Known standard deviation of a reading, base units.

    Examples
    --------
    >>> view = await client.surface(job.id, x="a", y="b")
    >>> view.contours.x, view.contours.y
    ('a', 'b')
    """
    query = {**present(x=x, y=y), **noise_query(noise)}
    return await self._send(Call("GET", f"{job_path(job_id)}/surface", reader(SurfaceAnswer), query))


async def _submit_follow_up(
    self: AsyncConnection, path: str, request: Mapping[str, Any], idempotency_key: str | None
) -> Job:
    """Submit a follow-up; without a key a fresh one is used, so that a repeated request never creates two."""
    headers = {**JSON_BODY, "Idempotency-Key": idempotency_key or str(uuid.uuid4())}
    content = json.dumps(request, default=plain)
    return await self._send(Call("POST", path, reader(Job), headers=headers, content=content))
