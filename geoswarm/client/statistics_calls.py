"""What is asked of the service about statistics, uncertainty and reports, and how its answers are read."""

from __future__ import annotations

import json
import uuid
from collections.abc import Mapping
from typing import Any, Literal
from urllib.parse import quote

from geoswarm.client.calls import JSON_BODY, Call, Query, job_path, plain, present, reader
from geoswarm.client.models import Figure, Job, Report

__all__ = [
    "FollowUp",
    "Noise",
    "figure",
    "figures",
    "follow_up",
    "posterior",
    "report",
    "report_pdf",
    "reweight",
    "statistics",
    "uncertainty",
]

Noise = Mapping[str, float] | float | None
"""Known standard deviation of a reading, base units: one for all series, or one each."""

FollowUp = Literal["sensitivity", "profile", "global-sensitivity"]


def _view(threshold: float | None, noise: Noise, posterior: bool) -> dict[str, Query]:
    query: dict[str, Query] = present(threshold=threshold)
    if posterior:
        query["posterior"] = "true"
    return query | _noise(noise)


def _noise(noise: Noise) -> dict[str, Query]:
    if noise is None:
        return {}
    return {"noise": [f"{k}={v!r}" for k, v in noise.items()] if isinstance(noise, Mapping) else repr(float(noise))}


def statistics(job_id: str, threshold: float | None, noise: Noise) -> Call[dict[str, Any]]:
    """Judge the parameters."""
    return Call("GET", f"{job_path(job_id)}/statistics", reader(dict[str, Any]), _view(threshold, noise, False))


def reweight(job_id: str, **request: Any) -> Call[dict[str, Any]]:
    """Calculate stored objectives under other weights."""
    content = json.dumps(present(**request), default=plain)
    return Call("POST", f"{job_path(job_id)}/reweight", reader(dict[str, Any]), headers=JSON_BODY, content=content)


def follow_up(job_id: str, route: FollowUp, idempotency_key: str | None, **request: Any) -> Call[Job]:
    """Submit a follow-up; without a key a fresh one is used, so that a repeated request never creates two."""
    headers = {**JSON_BODY, "Idempotency-Key": idempotency_key or str(uuid.uuid4())}
    content = json.dumps(present(**request), default=plain)
    return Call("POST", f"{job_path(job_id)}/{route}", reader(Job), headers=headers, content=content)


def uncertainty(job_id: str, noise: Noise) -> Call[dict[str, Any]]:
    """Show what follow-ups have found."""
    return Call("GET", f"{job_path(job_id)}/uncertainty", reader(dict[str, Any]), _noise(noise))


def posterior(job_id: str, noise: Noise) -> Call[dict[str, Any]]:
    """Sample the posterior."""
    return Call("GET", f"{job_path(job_id)}/posterior", reader(dict[str, Any]), _noise(noise))


def report(job_id: str, threshold: float | None, noise: Noise, posterior: bool) -> Call[Report]:
    """Show the report as a page."""
    query = _view(threshold, noise, posterior)
    return Call("GET", f"{job_path(job_id)}/report.html", lambda response: Report(response.text), query)


def report_pdf(job_id: str, threshold: float | None, noise: Noise, posterior: bool) -> Call[bytes]:
    """Show the report as PDF."""
    query = _view(threshold, noise, posterior)
    return Call("GET", f"{job_path(job_id)}/report.pdf", lambda response: response.content, query)


def figures(job_id: str, noise: Noise, posterior: bool) -> Call[tuple[str, ...]]:
    """List figures."""
    query = _view(None, noise, posterior)
    return Call("GET", f"{job_path(job_id)}/figures", reader(tuple[str, ...], "items"), query)


def figure(
    job_id: str,
    name: str,
    form: Literal["svg", "png", "csv"],
    threshold: float | None,
    noise: Noise,
    posterior: bool,
) -> Call[Figure]:
    """Show a figure."""
    path = f"{job_path(job_id)}/figures/{quote(name, safe='')}.{form}"
    query = _view(threshold, noise, posterior)
    return Call("GET", path, lambda response: Figure(name, form, response.content), query)
