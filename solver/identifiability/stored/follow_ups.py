"""The problems of follow-ups: the problem of a job with another ``method``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, search_space
from geoswarm.solver.identifiability.errors import NotExaminedError, StatisticsError
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.optimum.profiles import profile_settings
from geoswarm.solver.identifiability.prediction.question import OWN_KEYS, question_hash
from geoswarm.solver.methods.base import FollowUpMethod, by_name
from geoswarm.solver.methods.jackknife import lacks_tests, most_runs
from geoswarm.solver.problem import Problem, parse_problem

__all__ = [
    "at_minimum",
    "follow_up",
    "follow_up_of",
    "global_problem",
    "jackknife_problem",
    "profile_problem",
    "same_question",
    "sensitivity_problem",
]

_LONGEST_NAME = 200
_NOT_THERE = "the sensitivities at the optimum are needed first: start the follow-up sensitivity"
_MISPLACED = (
    "the sensitivities are those of a point {far:.1f} standard errors from the minimum: start the follow-up "
    "sensitivity again, which goes there first"
)
_SHORTEST_STEP, _LONGEST_STEP = 1e-4, 0.05  # first moves of a jackknife, parts of the range


def follow_up_of(problem: Problem) -> FollowUpMethod | None:
    """The method of a follow-up; None for a search or a sampling."""
    method = problem.method
    return method if isinstance(method, FollowUpMethod) else None


def same_question(problem: Problem, other: Problem) -> bool:
    """Whether two problems differ at most in name, method, stop criteria and seed, so that results can be joined.

    Of a problem made with the parameters of another one it is that other one that counts.
    """
    asked = getattr(other.method, "question", None)
    if asked is not None:
        return bool(asked == question_hash(problem))
    documents = [{k: v for k, v in p.document().items() if k not in OWN_KEYS} for p in (problem, other)]
    return documents[0] == documents[1]


def sensitivity_problem(
    problem: Problem,
    optimum: FloatArray,
    *,
    seed: int,
    step: float | None = None,
    polish: bool = False,
    of: str | None = None,
) -> Problem:
    """The problem that evaluates the sensitivities at an optimum.

    Parameters
    ----------
    optimum
        Shape (d,), natural values.
    seed
        Of the job.
    step
        Largest difference in parts of the range; the default of the method when None.
    polish
        Go to the minimum first.
    of
        Id of the job.

    Raises
    ------
    ProblemError
        When there are fewer measured points than free parameters, or the optimum is not admissible.
    """
    method = {"kind": "sensitivity", "at": _at(problem, optimum), "step": step, "polish": polish, "of": of}
    return follow_up(problem, method, seed)


def profile_problem(
    problem: Problem,
    linearisation: Linearisation,
    *,
    seed: int,
    parameters: Sequence[str] | None = None,
    of: str | None = None,
) -> Problem:
    """The problem that evaluates profiles around the optimum of a linearisation, of all parameters unless named.

    Raises
    ------
    StatisticsError
        When the noise is neither known nor could be estimated, or a name is unknown.
    """
    settings = profile_settings(Calibration(problem, seed), linearisation, parameters=parameters)
    names = problem.free_names
    rise = {name: float(r) for name, r in zip(names, settings.rise, strict=True) if np.isfinite(r)}
    step = {name: float(s) for name, s in zip(names, settings.step, strict=True) if name in rise}
    method = {"kind": "profile", "at": _at(problem, settings.optimum), "rise": rise, "step": step, "of": of}
    return follow_up(problem, method, seed)


def at_minimum(found: Linearisation | None) -> Linearisation:
    """Return the sensitivities of a run where they are those of a minimum; else raise NotExaminedError."""
    if found is None:
        raise NotExaminedError(_NOT_THERE)
    if found.misplaced:
        raise NotExaminedError(_MISPLACED.format(far=found.far))
    return found


def jackknife_problem(
    problem: Problem, linearisation: Linearisation | None, *, seed: int, runs: int | None = None, of: str | None = None
) -> Problem:
    """The problem that fits the parameters without each test, from the optimum of a linearisation.

    Parameters
    ----------
    runs
        Evaluations at most; as many as suffice by experience when None.

    Raises
    ------
    StatisticsError
        When there are fewer than three tests.
    NotExaminedError
        When there are no sensitivities at a minimum.
    ProblemError
        When ``runs`` is wrong.
    """
    lacking = lacks_tests(problem)
    if lacking is not None:
        raise StatisticsError(lacking)
    linearisation = at_minimum(linearisation)
    without = linearisation.without
    tests = 0 if without is None else len(without.tests)
    step = {}
    if without is not None:
        linear = without.moves if without.linear_moves is None else without.linear_moves
        typical = np.sqrt(np.mean(linear**2, axis=0)).tolist()
        step = {
            name: float(np.clip(length, _SHORTEST_STEP, _LONGEST_STEP))
            for name, length in zip(problem.free_names, typical, strict=True)
            if np.isfinite(length)
        }
    runs = most_runs(len(problem.free_names), tests) if runs is None else runs
    at = _at(problem, linearisation.optimum)
    return follow_up(problem, {"kind": "jackknife", "at": at, "step": step, "runs": runs, "of": of}, seed)


def global_problem(
    problem: Problem,
    *,
    seed: int,
    kind: Literal["sobol", "morris"] = "sobol",
    samples: int | None = None,
    of: str | None = None,
) -> Problem:
    """The problem that evaluates the design of Sobol or Morris.

    Raises
    ------
    ProblemError
        When SALib is not installed, or ``samples`` is wrong.
    """
    return follow_up(problem, {"kind": kind, "samples": samples, "of": of}, seed)


def _at(problem: Problem, optimum: FloatArray) -> dict[str, float]:
    return by_name(search_space(problem), np.asarray(optimum, dtype=np.float64))


def follow_up(problem: Problem, method: Mapping[str, Any], seed: int) -> Problem:
    """The problem with another method; entries that are None are left out."""
    given = {key: value for key, value in method.items() if value is not None}
    name = f"{problem.name}, {method['kind']}"[:_LONGEST_NAME]
    document = problem.document() | {"name": name, "method": given, "stopping": {}, "seed": seed}
    return parse_problem(document, programs=problem.forward_model.runs_programs)
