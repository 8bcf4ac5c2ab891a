"""What every page of a job needs: the job, what its method is for, what it follows, whether it has a body."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.methods.registry import find_method
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.service.job_service import JobService

__all__ = ["job_frame"]

WITH_BODY = frozenset({"section", "finite_element"})


def job_frame(service: JobService, job_id: str) -> dict[str, Any]:
    """Return ``job``, ``role`` (search, sampling or follow_up), ``parent`` (a job or None) and ``has_mesh``.

    Raises
    ------
    JobNotFoundError
        When there is no such job; a parent that has been deleted is None.
    """
    job = service.get(job_id)
    document = service.problem(job_id)
    parent = None
    if (followed := document["method"].get("of")) is not None:
        try:
            parent = service.get(followed)
        except JobNotFoundError:
            parent = None
    return {
        "job": job,
        "role": find_method(job.method).role,
        "parent": parent,
        "has_mesh": _has_body(document["forward_model"]),
    }


def _has_body(section: dict[str, Any]) -> bool:
    """Whether a forward model, or a part of it, has a body; without building it."""
    sections = [section, *section["parts"].values()] if section["kind"] == "combined" else [section]
    return any(one["kind"] in WITH_BODY for one in sections)
