"""The view of a job's statistics: threshold, known noise, posterior sample; the same for all their routes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Query

from geoswarm.api.errors import DetailError
from geoswarm.solver.errors import Issue

__all__ = ["Noise", "View", "WantedView"]


def _noise(
    noise: Annotated[
        list[str] | None,
        Query(
            max_length=1000,
            description="known standard deviation of a reading in base units: a number for all series, or "
            "SERIES=NUMBER for each; that of the problem if absent",
        ),
    ] = None,
) -> dict[str, float] | float | None:
    if noise is None:
        return None
    found: dict[str, float] = {}
    for item in noise:
        series, named, text = item.rpartition("=")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0.0) or bool(series) != bool(named):
            issue = Issue("query.noise", f"must be a number above 0, or SERIES=NUMBER; got {item[:80]!r}")
            raise DetailError(422, str(issue), kind="invalid-request", title="Invalid request", issues=[issue])
        found[series] = value
    if "" in found and len(found) > 1:
        issue = Issue("query.noise", "give one number for all series, or SERIES=NUMBER for each")
        raise DetailError(422, str(issue), kind="invalid-request", title="Invalid request", issues=[issue])
    return found.get("", found)


Noise = Annotated[dict[str, float] | float | None, Depends(_noise)]


@dataclass(frozen=True, slots=True)
class View:
    """Threshold of good fits, known noise, and whether to sample the posterior."""

    threshold: float | None
    noise: dict[str, float] | float | None
    posterior: bool

    @property
    def options(self) -> dict[str, Any]:
        """As arguments of a report."""
        return {"threshold": self.threshold, "noise": self.noise, "posterior": self.posterior}


def _view(
    noise: Noise,
    threshold: Annotated[
        float | None,
        Query(gt=0, allow_inf_nan=False, description="objective up to which a fit counts as good; proposed if absent"),
    ] = None,
    posterior: Annotated[bool, Query(description="sample the posterior, too; takes seconds")] = False,
) -> View:
    return View(threshold, noise, posterior)


WantedView = Annotated[View, Depends(_view)]
