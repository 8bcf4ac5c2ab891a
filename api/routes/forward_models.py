"""Installed forward models: their section of the problem file, parameters and series with units."""

from __future__ import annotations

import inspect
from typing import Any

from fastapi import APIRouter
from pydantic import ValidationError

from geoswarm.api.dependencies import problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.responses import ForwardModelList
from geoswarm.api.views import record_of
from geoswarm.records.problem import ForwardModelDetail, ForwardModelSummary, Parameter, Series
from geoswarm.solver.errors import BrokenForwardModelError, ExpressionError, ProblemError, UnknownForwardModelError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.registry import PROGRAMS_REFUSED, built, find_spec, offered_kinds, parse_spec
from geoswarm.solver.registered.schema import registered_models

__all__ = ["router"]

router = APIRouter(prefix="/forward-models", tags=["forward models"])

VARIES = "Parameters and series follow from the section; those listed here belong to the example."
UNKNOWN = "Parameters and series are known only for a given section; check a problem to see them."


@router.get("", responses=problems_of())
def list_forward_models() -> ForwardModelList:
    """List the kinds of forward model that a problem can name, and the models that the operator has registered."""
    own = [_summary(kind) for kind in offered_kinds() if kind != "registered"]
    registered = [
        ForwardModelSummary(kind="registered", model=name, description=declaration.title or name)
        for name, declaration in registered_models()
    ]
    return ForwardModelList(items=[*own, *registered])


@router.get("/{kind}", responses=problems_of(404))
def show_forward_model(kind: str) -> ForwardModelDetail:
    """Show a kind of forward model: JSON schema of its section, parameters and series with units."""
    try:
        spec = find_spec(kind)
    except UnknownForwardModelError as error:
        raise DetailError(404, str(error), kind="unknown-forward-model", title="Unknown forward model") from None
    except BrokenForwardModelError as error:
        raise DetailError(500, str(error), kind="broken-forward-model", title="Broken forward model") from None
    if spec.programs:
        message = f"kind {kind} {PROGRAMS_REFUSED}"
        raise DetailError(404, message, kind="unknown-forward-model", title="Unknown forward model")
    example = spec.example() or {"kind": kind}
    model = _build(example)
    varies = spec.depends_on_section or model is None or model.open_parameters
    return ForwardModelDetail(
        kind=kind,
        model=None,
        description=_first_lines(spec),
        json_schema=spec.model_json_schema(),
        example=None if model is None else example,
        depends_on_section=varies,
        note=UNKNOWN if model is None else VARIES if varies else None,
        parameters=[] if model is None else [record_of(Parameter, info) for info in model.parameters],
        series=[] if model is None else [record_of(Series, info) for info in model.series],
    )


def _summary(kind: str) -> ForwardModelSummary:
    try:
        return ForwardModelSummary(kind=kind, model=None, description=_first_lines(find_spec(kind)))
    except BrokenForwardModelError as error:
        return ForwardModelSummary(kind=kind, model=None, description=str(error))


def _build(section: dict[str, Any]) -> ForwardModel | None:
    try:
        return built(parse_spec(section))
    except (ValidationError, ProblemError, ExpressionError, BrokenForwardModelError):
        return None


def _first_lines(spec: type[ForwardModelSpec]) -> str:
    """First paragraph of the section's documentation, without markup."""
    paragraph = (inspect.getdoc(spec) or "").partition("\n\n")[0]
    return " ".join(paragraph.replace("``", "").split())
