"""Checks drafts of problems, and finds the starter examples."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from geoswarm.api.schemas.drafts import DraftEstimate, DraftIssue, DraftObservation, DraftSketch, Example, ProblemDraft
from geoswarm.api.views import record_of
from geoswarm.records.problem import Parameter, Series
from geoswarm.solver.examples import example_file, example_names
from geoswarm.solver.forward.registry import sketches_of
from geoswarm.solver.plausibility import impossible, to_be_accepted
from geoswarm.solver.problem import Draft, Problem, load_problem
from geoswarm.solver.problem.draft import located
from geoswarm.solver.problem.weighting import weight_shares
from geoswarm.solver.runs.check import warnings_of
from geoswarm.solver.sentences import parts_json, plain
from geoswarm.solver.sketches.svg import svg_element
from geoswarm.solver.units import convert

__all__ = ["describe_draft", "find_examples"]

MAX_LISTED = 2000


def describe_draft(draft: Draft) -> ProblemDraft:
    """What the form shows of a draft."""
    model, problem = draft.model, draft.problem
    warnings = () if problem is None else warnings_of(problem)
    issues = draft.issues if problem is None else located(impossible(problem), draft.yaml)
    return ProblemDraft(
        valid=problem is not None and not issues,
        document=draft.document,
        yaml=draft.yaml,
        issues=[DraftIssue.model_validate(issue) for issue in issues],
        warnings=[plain(sentence) for sentence in warnings],
        warning_parts=[parts_json(sentence) for sentence in warnings],
        parameters=None if model is None else [record_of(Parameter, one) for one in model.parameters[:MAX_LISTED]],
        series=None if model is None else [record_of(Series, one) for one in model.series[:MAX_LISTED]],
        open_parameters=model is not None and model.open_parameters,
        sketches=_sketches(draft),
        estimates=_estimates(draft),
        observations=[] if problem is None else _observations(problem),
        to_be_accepted=[] if problem is None else to_be_accepted(problem),
        free_parameters=[] if problem is None else list(problem.free_names),
        planned_evaluations=None if problem is None else problem.planned_evaluations,
    )


def _sketches(draft: Draft) -> list[DraftSketch] | None:
    if draft.spec is None:
        return None if draft.model is None else []
    return [
        DraftSketch(part=part, heading=one.heading, words=one.words, svg=svg_element(one.drawing, one.words))
        for part, sketch in sketches_of(draft.spec).items()
        for one in sketch.drawings
    ]


def _estimates(draft: Draft) -> list[DraftEstimate]:
    from geoswarm.solver.parameter_estimates.proposal import (
        estimates_of_draft,  # with Numba, for which a formula should not wait
    )

    return [DraftEstimate.model_validate(one) for one in estimates_of_draft(draft)]


def _observations(problem: Problem) -> list[DraftObservation]:
    infos = {info.name: info for info in problem.model.series}
    described = []
    for one, weighed in zip(problem.observations, weight_shares(problem), strict=True):
        info = infos[one.series]
        x_unit, y_unit = one.x_unit or info.x_unit, one.y_unit or info.y_unit
        described.append(
            DraftObservation(
                series=one.series,
                points=one.x.size,
                weight=one.weight,
                share=weighed.share,
                x_unit=x_unit,
                y_unit=y_unit,
                x_factor=float(convert(1.0, x_unit, info.x_unit)),
                y_factor=float(convert(1.0, y_unit, info.y_unit)),
            )
        )
    return described


@cache
def find_examples() -> dict[str, Example]:
    """The examples that need no third-party program, by name, with points instead of files."""
    return {name: _example(name) for name in example_names(engines=False)}


def _example(name: str) -> Example:
    from geoswarm.solver.problem.text.reading import read_problem_file

    with example_file(name) as path:
        text = path.read_text(encoding="utf-8")
        document = read_problem_file(path)
        problem = load_problem(path)
    comment = [line.lstrip("# ") for line in text.partition("\nname:")[0].splitlines() if line.startswith("#")]
    pairs = zip(document["observations"], problem.observations, strict=True)
    document["observations"] = [_with_points(section, one.points.document()) for section, one in pairs]
    return Example(
        name=name,
        title=problem.name,
        forward_model=problem.forward_model.kind,
        description=re.sub(r"[,:] see README.md|; see README.md", "", " ".join(comment)),
        problem=document,
    )


def _with_points(section: dict[str, Any], points: dict[str, list[float]]) -> dict[str, Any]:
    left = {key: value for key, value in section.items() if key != "file" and not key.endswith("_column")}
    return {"series": left.pop("series"), **left, "points": points}
