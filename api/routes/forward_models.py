"""Installed forward models: their section of the problem file, parameters and series with units."""

from __future__ import annotations

import inspect
from typing import Any

from fastapi import APIRouter
from pydantic import ValidationError

from geoswarm.api.dependencies import problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.jobs import ForwardModelDetail, ForwardModelList, ForwardModelSummary, Parameter, Series
from geoswarm.solver.errors import BrokenForwardModelError, ExpressionError, ProblemError, UnknownForwardModelError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.registry import built, find_spec, kinds, parse_spec

__all__ = ["EXAMPLES", "router"]

router = APIRouter(prefix="/forward-models", tags=["forward models"])

_OEDOMETER = {
    "kind": "oedometer",
    "height": 0.02,
    "initial_stress": 0.2,
    "stages": [{"stress": 50, "duration": 1}, {"stress": 100, "duration": 1}],
    "initial_void_ratio": 1.0,
}
_ISOTROPIC = {
    "kind": "isotropic_compression",
    "height": 0.1,
    "diameter": 0.05,
    "initial_stress": 10,
    "stages": [{"stress": 50, "duration": 1}, {"stress": 100, "duration": 1}],
}
_SOIL = {"law": "elastic", "E": "E", "nu": 0.3, "unit_weight": 20}
_SECTION = {
    "kind": "section",
    "surface": [[0, 10], [10, 10], [25, 2], [40, 2]],
    "layers": [{"name": "clay", "thickness": "depth", "rows": 2}, {"name": "rock", "bottom": -4}],
    "points": {"A": {"x": 8}},
    "element_length": 2.5,
    "nominal": {"depth": 3},
    "materials": {"soil": _SOIL, "rock": {"law": "elastic", "E": 1e6, "nu": 0.25, "unit_weight": 22}},
    "phases": [
        {"name": "weight", "kind": "gravity", "materials": {"clay": "rock", "rock": "rock"}},
        {"name": "soil", "kind": "plastic", "materials": {"clay": "soil"}},
    ],
    "zero_at_phase": "soil",
}
_FINITE_ELEMENT = {
    "kind": "finite_element",
    "mesh": {
        "nodes": [[0, 0], [2, 0], [2, 1], [0, 1]],
        "triangles": [[0, 1, 2], [0, 2, 3]],
        "regions": {"clay": [0, 1]},
        "lines": {"base": [[0, 1]]},
    },
    "points": {"A": [2, 1]},
    "fixities": {"base": "both"},
    "materials": {"soil": _SOIL},
    "phases": [{"name": "weight", "kind": "gravity", "materials": {"clay": "soil"}}],
}
EXAMPLES: dict[str, dict[str, Any]] = {
    "formula": {"kind": "formula", "series": {"settlement": {"expression": "a * (1 - exp(-b * x))"}}},
    "combined": {"kind": "combined", "parts": {"oedometer": _OEDOMETER, "isotropic": _ISOTROPIC}},
    "oedometer": _OEDOMETER,
    "isotropic_compression": _ISOTROPIC,
    "section": _SECTION,
    "finite_element": _FINITE_ELEMENT,
}
"""A section of each built-in kind; other kinds may give one as the first of the ``examples`` of their JSON schema."""

DEPENDENT = frozenset({"formula", "combined", "section", "finite_element"})
VARIES = "Parameters and series follow from the section; those listed here belong to the example."
UNKNOWN = "Parameters and series are known only for a given section; check a problem to see them."


@router.get("", responses=problems_of())
def list_forward_models() -> ForwardModelList:
    """List the kinds of forward model that a problem can name."""
    return ForwardModelList(items=[_summary(kind) for kind in kinds()])


@router.get("/{kind}", responses=problems_of(404))
def show_forward_model(kind: str) -> ForwardModelDetail:
    """Show a kind of forward model: JSON schema of its section, parameters and series with units."""
    try:
        spec = find_spec(kind)
    except UnknownForwardModelError as error:
        raise DetailError(404, str(error), kind="unknown-forward-model", title="Unknown forward model") from None
    except BrokenForwardModelError as error:
        raise DetailError(500, str(error), kind="broken-forward-model", title="Broken forward model") from None
    schema = spec.model_json_schema()
    example = EXAMPLES.get(kind) or next(iter(schema.get("examples", [])), {"kind": kind})
    model = _build(example)
    varies = kind in DEPENDENT or model is None or model.open_parameters
    return ForwardModelDetail(
        kind=kind,
        description=_first_lines(spec),
        json_schema=schema,
        example=None if model is None else example,
        depends_on_section=varies,
        note=UNKNOWN if model is None else VARIES if varies else None,
        parameters=[] if model is None else [Parameter.model_validate(info) for info in model.parameters],
        series=[] if model is None else [Series.model_validate(info) for info in model.series],
    )


def _summary(kind: str) -> ForwardModelSummary:
    try:
        return ForwardModelSummary(kind=kind, description=_first_lines(find_spec(kind)))
    except BrokenForwardModelError as error:
        return ForwardModelSummary(kind=kind, description=str(error))


def _build(section: dict[str, Any]) -> ForwardModel | None:
    try:
        return built(parse_spec(section))
    except (ValidationError, ProblemError, ExpressionError, BrokenForwardModelError):
        return None


def _first_lines(spec: type[ForwardModelSpec]) -> str:
    """First paragraph of the section's documentation, without markup."""
    paragraph = (inspect.getdoc(spec) or "").partition("\n\n")[0]
    return " ".join(paragraph.replace("``", "").split())
