"""How fast a test goes, where neither the law nor a reading knows of it."""

from __future__ import annotations

from collections.abc import Iterator

from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.laboratory.pace import Hold
from geoswarm.solver.laboratory.shear.simple_shear import DirectSimpleShearSpec
from geoswarm.solver.laboratory.shear.triaxial import TriaxialSpec
from geoswarm.solver.problem import Problem
from geoswarm.solver.sentences import Key, Sentence

__all__ = ["pace_without_effect"]

_MOST_NAMED = 3


def pace_without_effect(problem: Problem) -> tuple[Sentence, ...]:
    """Rates, durations and periods of shear tests on laws that do not depend on time, with no reading over time."""
    x_units = {info.name: info.x_unit for info in problem.model.series}
    found: dict[tuple[str, str], list[str]] = {}
    for part in parts_of(problem.forward_model, problem.model):
        start = f"{part.name}." if part.name else ""
        timed = any(o.series.startswith(start) and x_units.get(o.series) == "day" for o in problem.observations)
        if not timed:
            place = f"forward_model.parts.{part.name}" if part.name else "forward_model"
            for material, stage, key in _given(part.spec):
                found.setdefault((material, key), []).append(f"{place}.{stage}")
    return tuple(_sentence(material, key, places) for (material, key), places in found.items())


def _given(spec: ForwardModelSpec) -> Iterator[tuple[str, str, str]]:
    """Material, stage and key of what is given of the pace of a test whose law does not depend on time."""
    if not isinstance(spec, DirectSimpleShearSpec | TriaxialSpec) or spec.law.depends_on_time:
        return
    for number, stage in enumerate(spec.consolidation):
        if stage.loading_time > 0.0:
            yield spec.law.kind, f"consolidation[{number}]", "loading_time"
    for number, one in enumerate(spec.shearing):
        keys = ("duration",) if isinstance(one, Hold) else ("rate", "duration", "period")
        for key in keys:
            if getattr(one, key, None) is not None:
                yield spec.law.kind, f"shearing[{number}]", key


def _sentence(material: str, key: str, places: list[str]) -> Sentence:
    named, more = ", ".join(places[:_MOST_NAMED]), len(places) - _MOST_NAMED
    named += f" and {more} more" if more > 0 else ""
    return (
        Key(f"{places[0]}.{key}", key),
        f" of {named} has no effect: material {material} does not depend on time, and no series over time is observed. "
        "Leave it out, or take a law with creep.",
    )
