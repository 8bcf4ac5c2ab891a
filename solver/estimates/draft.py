"""Estimates for a problem in the making: of its readings as soon as it is sound, of index properties before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from geoswarm.solver.correlations.section import IndexSection
from geoswarm.solver.estimates.index import index_estimates, soils_of
from geoswarm.solver.estimates.proposal import Candidate, candidates_of, of_correlation
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
    if draft.model is None or draft.spec is None or not isinstance(document.get("index_properties"), dict):
        return {}
    try:
        soil = IndexSection.model_validate(document["index_properties"]).properties()
    except ValidationError:
        return {}
    sections: Any = document.get("parameters")
    given = sections if isinstance(sections, dict) else {}
    fixed = {
        str(name): float(section["value"])
        for name, section in given.items()
        if isinstance(section, dict) and isinstance(section.get("value"), int | float)
    }
    found: dict[str, list[Candidate]] = {}
    for test in soils_of(draft.spec, draft.model):
        own = fixed | {name.removeprefix(f"{test.part}."): value for name, value in fixed.items()}
        for one in index_estimates(test, own, soil):
            name = f"{test.part}.{one.parameter}"
            candidates = found.setdefault(name if name in given else one.parameter, [])
            candidate = of_correlation(one)
            if not one.told.outside and candidate not in candidates:
                candidates.append(candidate)
    return found
