"""A draft of a problem: its mistakes by line, and parameters and series of its forward model so far."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from geoswarm.solver.errors import Issue, ProblemError, SolverError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.problem.assembly import parse_problem
from geoswarm.solver.problem.issues import validated
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.points import known_spec, read_points, units_found
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.problem.test_table.expansion import without_table
from geoswarm.solver.problem.text.lines import line_of, lines_of
from geoswarm.solver.problem.text.reading import plain_document, read_document, read_problem_file
from geoswarm.solver.problem.text.writing import problem_yaml
from geoswarm.solver.sentences import Sentence

__all__ = [
    "Draft",
    "LocatedIssue",
    "draft_of_document",
    "document_of_tests",
    "draft_of_text",
    "inlined_document",
    "located",
]

_TAKEN_IN = {
    "sort",
    "repeated_x",
    "resample",
    "y_zero",
    "x_factor",
    "y_factor",
    "decimal_sign",
    "incomplete_rows",
    "no_reading",
    "sheet",
    "where",
}
_TAKEN_IN |= {"x_column", "y_column", "y_minus", "weight_column", "inputs", "gross_error_column", "x_dates"}
_TAKEN_IN |= {"x_time_column", "x_origin", "file", "blocks"}
_LINE = re.compile(r" in line (\d+)")
MAX_YAML_BYTES = 200_000
"""Longest text that a draft is written as or read from: the YAML reader takes some 15 s of a core for a megabyte."""


@dataclass(frozen=True, slots=True)
class LocatedIssue:
    """A mistake, and its line in the draft's YAML, counted from 1; None where there is no such place."""

    path: str
    message: str
    line: int | None
    parts: Sentence = ()


@dataclass(frozen=True, slots=True)
class Draft:
    """A problem that may still have mistakes.

    Parameters
    ----------
    document
        Plain values as they were given; None when the text cannot be read.
    yaml
        The same as text: the one that was given, else one written for it; None when that were too long.
    issues
        All mistakes; empty when the problem could be submitted.
    problem
        None with mistakes.
    model, spec
        The forward model of the draft and its section, as soon as that is sound.
    """

    document: dict[str, Any] | None
    yaml: str | None
    issues: tuple[LocatedIssue, ...]
    problem: Problem | None
    model: ForwardModel | None
    spec: ForwardModelSpec | None = None


def draft_of_text(text: str) -> Draft:
    """Read and check a draft written as YAML."""
    try:
        document = read_document(text, "yaml")
    except ProblemError as error:
        return Draft(None, text, tuple(_syntax(issue) for issue in error.issues), None, None)
    return _judged(document, text)


def draft_of_document(document: Mapping[str, Any]) -> Draft:
    """Check a draft given as a document, and write it as YAML.

    Raises
    ------
    ProblemError
        A value is nothing that JSON knows.
    """
    plain = plain_document(document)
    text = problem_yaml(plain)
    return _judged(plain, text if len(text.encode()) <= MAX_YAML_BYTES else None)


def _judged(document: dict[str, Any], text: str | None) -> Draft:
    spec, model = _model(json.dumps(document.get("forward_model")))
    try:
        return Draft(document, text, (), parse_problem(document), model, spec)
    except ProblemError as error:
        return Draft(document, text, located(error.issues, text), None, model, spec)


def located(issues: Iterable[Issue], text: str | None) -> tuple[LocatedIssue, ...]:
    """Mistakes with their lines in the draft's YAML, where that is known."""
    lines = {} if text is None else lines_of(text)
    return tuple(LocatedIssue(one.path, one.message, line_of(one.path, lines), one.parts) for one in issues)


def _syntax(issue: Issue) -> LocatedIssue:
    """Messages about syntax name the line themselves."""
    found = _LINE.search(issue.message)
    return LocatedIssue(issue.path, issue.message, int(found[1]) if found else None)


def _model(section: str) -> tuple[ForwardModelSpec | None, ForwardModel | None]:
    try:
        spec = parse_spec(json.loads(section))
        if spec.runs_programs:
            return None, None
        spec = spec.with_files(None, "forward_model")
        return spec, _built(spec.model_dump_json())
    except (ValidationError, SolverError, ValueError):
        return None, None


@lru_cache(maxsize=16)  # drafts are judged at every change, most of which are elsewhere; a section plans a mesh
def _built(section: str) -> ForwardModel:
    return built(parse_spec(json.loads(section)))


def document_of_tests(document: dict[str, Any], files: Mapping[str, bytes]) -> dict[str, Any]:
    """The same problem with parts and observations for its table of tests; it may lack what is not of the tests.

    Raises
    ------
    ProblemError
        Mistakes in the table, its rows or their files.
    """
    made: dict[str, Any] | None = None
    try:
        with without_table(document, files) as made:
            parse_problem(made)
    except ProblemError as error:
        of_tests = [issue for issue in error.issues if re.match(r"tests\b", issue.path)]
        if of_tests or made is None:
            raise ProblemError(of_tests or error.issues) from None
    return made


def inlined_document(path: Path) -> dict[str, Any]:
    """Read a problem file that may lack what another problem gives; only its measurement files are read.

    Raises
    ------
    ProblemError
        A file cannot be read.
    """
    with without_table({"name": path.stem, **read_problem_file(path)}, path.parent) as document:
        return _inlined(document, path.parent)


def _inlined(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    observations = document.get("observations")
    spec = known_spec(document.get("forward_model"))
    if not isinstance(observations, list):
        return document
    found: list[Any] = []
    for index, given in enumerate(observations):
        if not isinstance(given, dict) or "file" not in given:
            found.append(given)
            continue
        place = f"observations[{index}]"
        section, issues = validated(ObservationSection, given, place)
        if section is None:
            raise ProblemError(issues)
        points, issues = read_points(section, place, folder, spec)
        if points is None or issues:
            raise ProblemError(issues)
        kept = {key: value for key, value in given.items() if key not in _TAKEN_IN}
        found.append(units_found(points) | kept | {"points": points.document()})
    return document | {"observations": found}
