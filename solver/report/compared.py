"""Another set of parameters, such as a published one, beside the result of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.given import values_from
from geoswarm.solver.problem.issues import describe
from geoswarm.solver.problem.text.reading import read_problem_file
from geoswarm.solver.report.record import BestFit
from geoswarm.solver.words import did_you_mean

__all__ = ["Compared", "Run", "compared_with", "read_set", "set_of", "with_values"]

Run: TypeAlias = Callable[[Problem, Mapping[str, float]], Evaluation]


@dataclass(frozen=True, slots=True)
class Compared:
    """A set of parameters by its name, and how it fits the readings."""

    name: str
    fit: BestFit


def _run(problem: Problem, values: Mapping[str, float]) -> Evaluation:
    return Calibration(problem, problem.seed or 0).evaluate_values(values)


def read_set(path: Path) -> tuple[str, dict[str, Any]]:
    """Name and values of a set in a YAML or JSON file: ``phi_c: 33.1`` a line, below ``parameters:`` or not.

    Raises
    ------
    ProblemError
        The file cannot be read.
    """
    return set_of(read_problem_file(path), path.stem)


def set_of(document: Mapping[str, Any], name: str) -> tuple[str, dict[str, Any]]:
    """Name and values of a set in a document; ``name``: of one that has none.

    Raises
    ------
    ProblemError
        Its parameters are no mapping.
    """
    values = document.get("parameters", document)
    if not isinstance(values, Mapping):
        raise ProblemError([Issue("parameters", f"must be a mapping of numbers by name, got {describe(values)}")])
    kept = {key: value for key, value in values.items() if values is not document or key != "name"}
    return str(document.get("name", name)), kept


def compared_with(problem: Problem, name: str, given: Mapping[str, Any], run: Run = _run) -> Compared:
    """Calculate the readings with a set of parameters.

    Fixed and linked parameters that it does not name are those of the problem; one that it names is as it says, also
    outside the bounds of the search.

    Parameters
    ----------
    run
        Makes the forward calculation with values of all parameters; here and now unless given.

    Raises
    ------
    ProblemError
        A parameter is unknown or missing, a value is no number, or the calculation fails.
    """
    issues, known = [], ", ".join(problem.parameters)
    values: dict[str, float] = {}
    for key, value in given.items():
        number = value.get("value") if isinstance(value, Mapping) else value
        if key not in problem.parameters:
            hint = did_you_mean(key, problem.parameters)
            issues.append(Issue(key, f"the problem has no such parameter{hint}; it has {known}"))
        elif isinstance(number, bool) or not isinstance(number, int | float):
            issues.append(Issue(key, f"must be a number, got {describe(value)}"))
        else:
            values[key] = float(number)
    if missing := [one.name for one in problem.free if one.name not in given]:
        issues.append(Issue("", f"the set must give every free parameter; {', '.join(missing)} is missing"))
    if issues:
        raise ProblemError(issues)
    whole = values_from(problem, values)
    evaluation = run(problem, whole)
    if evaluation.objective is None:
        raise ProblemError([Issue("", f"the calculation with this set failed: {evaluation.message}")])
    fit = BestFit(-1, -1, evaluation.objective, whole, dict(evaluation.misfits), dict(evaluation.responses))
    return Compared(name, fit)


def with_values(problem: Problem, values: Mapping[str, float]) -> Problem:
    """The problem with values of all parameters within its bounds, those that were fixed or linked fixed at them."""
    document = problem.document()
    free = {one.name: one for one in problem.free}
    parameters = {name: {"value": value} for name, value in values.items()}
    for name, one in free.items():
        bounds = {"lower": min(one.lower, values[name]), "upper": max(one.upper, values[name])}
        kept = {key: value for key, value in document["parameters"][name].items() if key not in ("initial", *bounds)}
        parameters[name] = kept | bounds
    return parse_problem(document | {"parameters": parameters, "constraints": []})
