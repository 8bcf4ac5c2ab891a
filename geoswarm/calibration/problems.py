"""From a function or a problem, and options, to a checked problem: the options are the sections of the problem file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from geoswarm.calibration.functions import function_section
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.methods.registry import UnknownMethodError, find_method
from geoswarm.solver.problem import Problem, parse_problem

__all__ = ["DEFAULT_STOPPING", "Model", "Observations", "Options", "options_of", "problem", "problem_of"]

Model: TypeAlias = Callable[..., Any] | Problem | Mapping[str, Any]
"""A function, a checked problem, or the sections of one as a mapping."""

Observations: TypeAlias = Mapping[str, Any] | Sequence[Mapping[str, Any]]
"""One :func:`geoswarm.observed`, one for each series by name, or the list of a problem file."""

Options: TypeAlias = dict[str, Any]
"""Sections of a problem file by name, those that are given."""

DEFAULT_STOPPING: Mapping[str, int] = {"stagnation_generations": 50, "max_evaluations": 10_000}
"""Stop criteria of a function when none are given; ``result.stop_reasons`` names those that applied.

Examples
--------
>>> import geoswarm as gs
>>> gs.DEFAULT_STOPPING["stagnation_generations"]
50
"""

_ONE_SERIES = "y"
_OF_FUNCTIONS = ("series", "quick_runs")


def options_of(**given: Any) -> Options:
    """Return the options that are not None."""
    return {name: value for name, value in given.items() if value is not None}


def problem(
    model: Model,
    *,
    parameters: Mapping[str, Any] | None = None,
    observations: Observations | None = None,
    constraints: Sequence[str] | None = None,
    series: Mapping[str, Any] | None = None,
    method: Mapping[str, Any] | None = None,
    stopping: Mapping[str, Any] | None = None,
    limits: Mapping[str, Any] | None = None,
    failures: Mapping[str, Any] | None = None,
    answer: Mapping[str, Any] | None = None,
    weighting: str | None = None,
    noise: Mapping[str, Any] | None = None,
    quick_runs: bool | None = None,
    seed: int | None = None,
    name: str | None = None,
) -> Problem:
    """Check a problem without running it; the arguments are those of :func:`geoswarm.calibrate`.

    Raises
    ------
    ProblemError
        Lists every mistake with its path.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def line(x, a, b):
    ...     return a + b * x
    >>> parameters = {"a": gs.free(0, 10), "b": gs.free(0, 10)}
    >>> problem = gs.problem(line, parameters=parameters, observations=gs.observed([0, 1], [1, 3]))
    >>> problem.free_names
    ('a', 'b')
    """
    options = options_of(
        parameters=parameters,
        observations=observations,
        constraints=constraints,
        series=series,
        method=method,
        stopping=stopping,
        limits=limits,
        failures=failures,
        answer=answer,
        weighting=weighting,
        noise=noise,
        quick_runs=quick_runs,
        seed=seed,
        name=name,
    )
    return problem_of(model, options)[0]


def problem_of(model: Model, options: Options) -> tuple[Problem, str | None]:
    """Return the problem, and why its function stays in this process; None: it does not.

    Raises
    ------
    ProblemError, TypeError
    """
    if isinstance(model, Problem):
        return _changed(model, options), None
    if isinstance(model, Mapping):
        _refuse_those_of_functions(options)
        return parse_problem({**model, **_sections(options)}, programs=True), None
    if not callable(model):
        raise TypeError(
            f"model is a {type(model).__name__}: a function, a problem (geoswarm.load_problem) or a mapping with the "
            "sections of one is accepted"
        )
    return _of_function(model, options)


def _of_function(function: Callable[..., Any], options: Options) -> tuple[Problem, str | None]:
    observations = _by_series(options.get("observations"))
    declared = options.get("series")
    series = {name: _read_as(section) for name, section in observations.items()} if declared is None else declared
    if not isinstance(series, Mapping):
        raise ProblemError([Issue("series", f"must be a mapping of names, not a {type(series).__name__}")])
    if declared is not None and len(observations) == 1 and set(observations) == {_ONE_SERIES} and len(series) == 1:
        observations = {next(iter(series)): observations[_ONE_SERIES]}
    section, reason = function_section(function, series)
    section["quick_runs"] = options.get("quick_runs", False)
    document = {
        "name": section["function"].strip("<>") or "calibration",
        **_sections(options),
        "forward_model": section,
        "observations": [{"series": name, **one} for name, one in observations.items()],
    }
    if "stopping" not in options and _needs_stopping(document.get("method")):
        document["stopping"] = dict(DEFAULT_STOPPING)
    return parse_problem(document, programs=True), reason


def _refuse_those_of_functions(options: Options) -> None:
    wrong = [Issue(name, "is for a function; a problem says it under forward_model") for name in _OF_FUNCTIONS]
    if found := [issue for issue in wrong if issue.path in options]:
        raise ProblemError(found)


def _changed(problem: Problem, options: Options) -> Problem:
    _refuse_those_of_functions(options)
    if not options:
        return problem
    document = {**problem.document(), **_sections(options)}
    return parse_problem(document, programs=problem.forward_model.runs_programs)


def _sections(options: Options) -> Options:
    """The options as a problem file writes them."""
    sections = {name: value for name, value in options.items() if name not in _OF_FUNCTIONS}
    if "observations" in sections:
        sections["observations"] = [
            {"series": name, **one} for name, one in _by_series(sections["observations"]).items()
        ]
    return sections


def _by_series(observations: Any) -> dict[str, Mapping[str, Any]]:
    if observations is None:
        raise ProblemError([Issue("observations", "is missing; give observations=geoswarm.observed(x, y)")])
    if isinstance(observations, Mapping) and _is_one(observations):
        return {str(observations.get("series", _ONE_SERIES)): dict(observations)}
    if isinstance(observations, Mapping):
        found = dict(observations)
    elif isinstance(observations, Sequence) and not isinstance(observations, str):
        found = {one.get("series"): one for one in observations if isinstance(one, Mapping)}
        if len(found) != len(observations) or None in found:
            raise ProblemError([Issue("observations", "each of a list must name its series, a different one")])
    else:
        found = {}
    wrong = [name for name, one in found.items() if not isinstance(one, Mapping)]
    if not found or wrong:
        place = f"observations.{wrong[0]}" if wrong else "observations"
        raise ProblemError([Issue(place, "must be geoswarm.observed(x, y), or {series: geoswarm.observed(x, y)}")])
    return found


def _is_one(section: Mapping[str, Any]) -> bool:
    """Whether it is an observation, not a mapping of some by series, of which one may be called points."""
    points = section.get("points")
    return isinstance(section.get("file"), str) or (isinstance(points, Mapping) and "points" not in points)


def _read_as(section: Mapping[str, Any]) -> dict[str, Any]:
    """A series in the units of its observation."""
    return {name: section[name] for name in ("x_unit", "y_unit") if section.get(name) is not None}


def _needs_stopping(method: Any) -> bool:
    """Whether a method does not end by itself; its mistakes are reported elsewhere."""
    kind = method.get("kind") if isinstance(method, Mapping) else None if method else "particle_swarm"
    try:
        return isinstance(kind, str) and find_method(kind).role == "search"
    except UnknownMethodError:
        return False
