"""The view of a job's statistics: threshold, known noise, posterior sample, and another set of parameters beside it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import anyio.to_thread
from fastapi import Depends, Query, Request
from pydantic import TypeAdapter

from geoswarm.api.dependencies import JobId, Service, limiter, require_runs
from geoswarm.api.errors import DetailError
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem import read_document
from geoswarm.solver.report.jsonable import jsonable

if TYPE_CHECKING:
    from geoswarm.solver.report.compared import Compared

__all__ = ["Noise", "View", "WantedReport", "WantedView", "read_record", "record_of"]


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
    """Threshold of good fits, known noise, whether to sample the posterior, and another set of parameters."""

    threshold: float | None
    noise: dict[str, float] | float | None
    posterior: bool
    compared: Compared | None = None

    @property
    def options(self) -> dict[str, Any]:
        """As arguments of a report."""
        return {name: getattr(self, name) for name in ("threshold", "noise", "posterior", "compared")}


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


async def _with_compared(
    request: Request,
    job_id: JobId,
    service: Service,
    view: WantedView,
    compare: Annotated[
        str | None,
        Query(
            max_length=20_000,
            description="another set of parameters to show beside the result, YAML or JSON (`phi_c: 33.1` a line, and "
            "a name): one forward run within the limits of a test run, for which the role submit is needed",
        ),
    ] = None,
) -> View:
    if compare is None:
        return view
    require_runs(service)

    def calculate() -> Compared:
        try:
            return service.compared(job_id, read_document(compare, "yaml"))
        except ProblemError as error:
            issues = [Issue(f"query.compare.{one.path}".rstrip("."), one.message) for one in error.issues]
            raise DetailError(
                422, "; ".join(map(str, issues)), kind="invalid-request", title="Invalid request", issues=issues
            ) from None

    return replace(view, compared=await anyio.to_thread.run_sync(calculate, limiter=limiter(request, "test runs")))


WantedReport = Annotated[View, Depends(_with_compared)]


T = TypeVar("T")


def read_record(kind: type[T], document: Mapping[str, Any]) -> T:
    """Return a document as a record; what is not finite in it is None.

    Raises
    ------
    ValueError
        When a field is missing, or is not of its type.
    """
    record: Any = kind
    found: T = _adapter(record).validate_python(jsonable(document))
    return found


def record_of(kind: type[T], source: Any) -> T:
    """Return a record of the attributes of the same names; what is not finite in them is None."""
    record: Any = kind
    return read_record(kind, {one.name: getattr(source, one.name) for one in fields(record)})


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)
