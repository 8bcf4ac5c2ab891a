"""The file of candidates: possible tests or measuring points, without values; or a table of tests, each a candidate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue, ProblemError, SolverError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.registry import PROGRAMS_REFUSED, built, find_spec, parse_spec
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.issues import issues_of, validated
from geoswarm.solver.problem.test_table.expansion import without_table
from geoswarm.solver.problem.text.reading import read_problem_file
from geoswarm.solver.section import Section
from geoswarm.solver.units import UnitError, convert
from geoswarm.solver.words import did_you_mean

__all__ = ["Candidate", "CandidateFile", "Readings", "read_candidates", "read_predicted"]

_MOST = 200
_OF_TESTS = ("forward_model", "observations", "weighting")
"""What a table of tests becomes."""


class _PointsSection(Section):
    x: list[float] = Field(min_length=1, max_length=10_000, description="a place twice: two readings")
    y: list[float] | None = None


class _ReadingsSection(Section):
    series: str
    points: _PointsSection
    x_unit: str | None = None
    y_unit: str | None = None
    error: float | None = Field(None, gt=0)


class _CandidateSection(Section):
    name: str = Field(min_length=1, max_length=200)
    forward_model: dict[str, Any] | None = None
    observations: list[_ReadingsSection] = Field(min_length=1, max_length=100)
    cost: float | None = Field(None, gt=0)


class _FileSection(Section):
    candidates: list[_CandidateSection] = Field(min_length=1, max_length=_MOST)
    parameters: dict[str, Any] = Field(default={})


@dataclass(frozen=True, slots=True)
class Readings:
    """Readings of a series at x, shape (m,), with their standard deviation, base units; None: not wanted."""

    series: str
    x: FloatArray
    error: float | None


@dataclass(frozen=True, slots=True)
class Candidate:
    """A test: its forward model, and what would be read. ``spec`` None: that of the job."""

    name: str
    spec: ForwardModelSpec
    readings: tuple[Readings, ...]
    cost: float | None = None


@dataclass(frozen=True, slots=True)
class CandidateFile:
    """Candidates, and sections of the parameters that their forward models need beyond those of the job."""

    candidates: tuple[Candidate, ...]
    parameters: Mapping[str, Any]


def read_candidates(
    problem: Problem, source: Mapping[str, Any] | Path, noise: Mapping[str, float], *, programs: bool = False
) -> CandidateFile:
    """Check a document of candidates, or a file of one.

    Parameters
    ----------
    problem
        Of the job, whose forward model candidates have that name none.
    noise
        Standard deviation of a reading by series of the job, base units, for readings of the same series of the same
        forward model without an error of their own.
    programs
        Whether candidates may run programs of this machine; a file may.

    Raises
    ------
    ProblemError
        Lists mistakes with their paths.
    """
    folder = source.parent if isinstance(source, Path) else None
    document = read_problem_file(source) if isinstance(source, Path) else dict(source)
    with without_table(document, folder) as plain:
        return _candidates(problem, plain, noise, folder, programs)


def _candidates(
    problem: Problem, document: dict[str, Any], noise: Mapping[str, float], folder: Path | None, programs: bool
) -> CandidateFile:
    tests = _tests_of(document)
    if tests:
        rest = {key: value for key, value in document.items() if key not in _OF_TESTS}
        document = rest | {"candidates": [*rest.get("candidates", ()), *tests.values()]}
    section, issues = validated(_FileSection, document, "")
    if section is None:
        raise ProblemError(issues)
    names = [candidate.name for candidate in section.candidates]
    doubled = sorted({name for name in names if names.count(name) > 1})
    issues += [Issue("candidates", f"two are called {name}; give each a name of its own") for name in doubled]
    listed = len(names) - len(tests)
    places = [*(f"candidates[{index}]" for index in range(listed)), *(f"forward_model.parts.{name}" for name in tests)]
    found = []
    for index, (one, path) in enumerate(zip(section.candidates, places, strict=True)):
        place = f"{path}.forward_model" if index < listed else path
        spec, model, wrong = _model(problem, one.forward_model, place, folder, programs)
        issues += wrong
        if model is None or spec is None:
            continue
        own = noise if spec is problem.forward_model else {}
        readings, wrong = _all_readings(one.observations, model, own, path, wanted=True)
        issues += wrong
        found.append(Candidate(one.name, spec, readings, one.cost))
    costs = [candidate.name for candidate in found if candidate.cost is None]
    if costs and len(costs) < len(found):
        issues.append(Issue("candidates", f"some have a cost; give all of them one ({', '.join(costs)} have none)"))
    if issues:
        raise ProblemError(issues)
    return CandidateFile(tuple(found), section.parameters)


def _tests_of(document: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The parts of a combined model as candidates by name, each with the observations of its series; none without.

    Raises
    ------
    ProblemError
        The forward model is not combined, or has no observations.
    """
    model, observations = document.get("forward_model"), document.get("observations")
    if model is None and observations is None:
        return {}
    parts = model.get("parts") if isinstance(model, Mapping) and model.get("kind") == "combined" else None
    if not isinstance(parts, Mapping) or not isinstance(observations, list):
        message = "of a file of candidates must be combined, with observations: each of its parts is a candidate"
        raise ProblemError([Issue("forward_model", message)])
    found: dict[str, dict[str, Any]] = {}
    for name, part in parts.items():
        own = [_wanted(one, f"{name}.") for one in observations if _series(one).startswith(f"{name}.")]
        found[str(name)] = {"name": str(name), "forward_model": part, "observations": own}
    return found


def _series(observation: Any) -> str:
    return str(observation.get("series", "")) if isinstance(observation, Mapping) else ""


def _wanted(observation: Any, prefix: str = "") -> Any:
    """What an observation of a problem says of where a series is wanted; its series without a prefix."""
    if not isinstance(observation, Mapping):
        return observation
    kept = {key: value for key, value in observation.items() if key in _ReadingsSection.model_fields}
    if isinstance(points := kept.get("points"), Mapping):
        kept["points"] = {key: value for key, value in points.items() if key in ("x", "y")}
    if isinstance(kept.get("series"), str):
        kept["series"] = kept["series"].removeprefix(prefix)
    return kept


def read_predicted(
    problem: Problem, source: Mapping[str, Any] | Path, *, programs: bool = False
) -> tuple[Candidate, Mapping[str, Any]]:
    """Check the problem of a prediction: its forward model and the points that are wanted; and its parameters."""
    folder = source.parent if isinstance(source, Path) else None
    document = read_problem_file(source) if isinstance(source, Path) else dict(source)
    document.setdefault("name", source.stem if isinstance(source, Path) else "prediction")
    with without_table(document, folder) as plain:
        return _predicted(problem, plain, folder, programs)


def _predicted(
    problem: Problem, document: Mapping[str, Any], folder: Path | None, programs: bool
) -> tuple[Candidate, Mapping[str, Any]]:
    spec, model, issues = _model(problem, document.get("forward_model"), "forward_model", folder, programs)
    sections = []
    for index, given in enumerate(document.get("observations") or ()):
        section, wrong = validated(_ReadingsSection, _wanted(given), f"observations[{index}]")
        issues += wrong
        if section is not None:
            sections.append(section)
    if not sections and not issues:
        issues.append(Issue("observations", "must say where the series are wanted: points: {x: [..]}"))
    readings: tuple[Readings, ...] = ()
    if model is not None and not issues:
        readings, issues = _all_readings(sections, model, {}, "", wanted=False)
    if issues or spec is None:
        raise ProblemError(issues)
    parameters = document.get("parameters", {})
    return Candidate(str(document["name"])[:200], spec, readings), parameters if isinstance(parameters, Mapping) else {}


def _model(
    problem: Problem, section: Any, path: str, folder: Path | None, programs: bool
) -> tuple[ForwardModelSpec | None, ForwardModel | None, list[Issue]]:
    if section is None:
        return problem.forward_model, problem.model, []
    from pydantic import ValidationError

    try:
        spec = parse_spec(section)
    except ValidationError as error:
        return None, None, issues_of(error, section, path, lambda: find_spec(str(section["kind"])).model_json_schema())
    if spec.runs_programs and folder is None and not programs:
        return None, None, [Issue(path, PROGRAMS_REFUSED)]
    try:
        spec = spec.with_files(folder, path)
        if spec == problem.forward_model:
            return problem.forward_model, problem.model, []
        return spec, built(spec), []
    except ProblemError as error:
        return None, None, list(error.issues)
    except (SolverError, ValueError) as error:
        return None, None, [Issue(path, str(error))]


def _all_readings(
    sections: list[_ReadingsSection], model: ForwardModel, noise: Mapping[str, float], path: str, *, wanted: bool
) -> tuple[tuple[Readings, ...], list[Issue]]:
    """Readings in base units; ``wanted``: each needs an error."""
    infos = {info.name: info for info in model.series}
    found, issues = [], []
    for index, given in enumerate(sections):
        place = f"{path}.observations[{index}]".lstrip(".")
        info = infos.get(given.series)
        if info is None:
            known = ", ".join(list(infos)[:20])
            message = f"unknown series '{given.series[:60]}'{did_you_mean(given.series, infos)}; known: {known}"
            issues.append(Issue(f"{place}.series", message))
            continue
        try:
            x = np.sort(convert(given.points.x, given.x_unit or info.x_unit, info.x_unit))
            low, high = convert([0.0, given.error or 0.0], given.y_unit or info.y_unit, info.y_unit).tolist()
        except UnitError as error:
            issues.append(Issue(f"{place}.x_unit", str(error)))
            continue
        try:
            info.require(x)
        except ProblemError as error:
            issues += [Issue(f"{place}.points.x", issue.message) for issue in error.issues]
            continue
        deviation = high - low if given.error is not None else noise.get(given.series)
        if wanted and deviation is None:
            message = f"is missing: the job has no error of a reading of {given.series} of this model"
            issues.append(Issue(f"{place}.error", message))
            continue
        found.append(Readings(given.series, x, deviation))
    return tuple(found), issues
