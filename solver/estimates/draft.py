"""Estimates for a problem in the making: of its readings as soon as it is sound, of index properties before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from geoswarm.solver.correlations.section import IndexSection
from geoswarm.solver.estimates.index import index_estimates, name_among, with_index
from geoswarm.solver.estimates.proposal import candidates_of, of_correlation
from geoswarm.solver.estimates.value import Candidate
from geoswarm.solver.problem import Draft

__all__ = ["DraftEstimate", "estimates_of_draft"]


@dataclass(frozen=True, slots=True)
class DraftEstimate:
    """A value that a parameter may have, in its unit, with the ends of the published scatter."""

    parameter: str
    unit: str
    lower: float
    value: float
    upper: float
    source: str
    measured: bool


def estimates_of_draft(draft: Draft) -> tuple[DraftEstimate, ...]:
    """Estimates of all parameters of a draft, under the names that it uses."""
    if draft.model is None:
        return ()
    units = {info.name: info.unit for info in draft.model.parameters}
    found = candidates_of(draft.problem) if draft.problem is not None else _of_index(draft)
    return tuple(
        DraftEstimate(
            name, units.get(name, ""), min(one.ends), one.value, max(one.ends), one.source, measured=one.reading
        )
        for name, candidates in found.items()
        for one in candidates
    )


def _of_index(draft: Draft) -> dict[str, list[Candidate]]:
    """Of the index properties alone, as far as these are sound."""
    document = draft.document or {}
    if draft.model is None or draft.spec is None:
        return {}
    soil = None
    if isinstance(document.get("index_properties"), dict):
        try:
            soil = IndexSection.model_validate(document["index_properties"]).properties()
        except ValidationError:
            soil = None
    sections: Any = document.get("parameters")
    given = sections if isinstance(sections, dict) else {}
    fixed = {
        str(name): float(section["value"])
        for name, section in given.items()
        if isinstance(section, dict) and isinstance(section.get("value"), int | float)
    }
    found: dict[str, list[Candidate]] = {}
    for test, known in with_index(draft.spec, draft.model, soil):
        for one in index_estimates(test, test.own(fixed), known):
            candidates = found.setdefault(name_among(given, test, one.parameter), [])
            candidate = of_correlation(one)
            if not one.told.outside and candidate not in candidates:
                candidates.append(candidate)
    return found
