"""Evaluations of earlier calibrations that a new one can learn from without running them again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration, WarmStartRuns
from geoswarm.solver.problem import Problem

__all__ = [
    "MOST_OFFERED",
    "OTHER_MODEL",
    "EarlierRuns",
    "best_of",
    "forward_model_hash",
    "offer_of",
    "usable_runs",
]

OTHER_MODEL = "has another forward model"

MOST_OFFERED = 2000
"""Runs that one calibration takes over at most: the better half are the best, the others spread over the rest."""

_EQUAL = 1e-12  # relative difference of parameter values that only rounding explains


@dataclass(frozen=True, slots=True)
class EarlierRuns:
    """Successful evaluations of an earlier problem.

    Parameters
    ----------
    problem
        The calibrated problem.
    parameters
        Natural values of its free parameters, shape (n, d).
    responses
        Calculated values of its observed series, n of them.
    """

    problem: Problem
    parameters: FloatArray
    responses: Sequence[Mapping[str, FloatArray]]


def forward_model_hash(problem: Problem) -> str:
    """SHA-256 of the section that describes the forward model, with its defaults written out."""
    section = problem.forward_model.model_dump(mode="json")
    return hashlib.sha256(json.dumps(section, sort_keys=True, allow_nan=False).encode()).hexdigest()


def offer_of(problem: Problem, earlier: EarlierRuns) -> WarmStartRuns | str:
    """Return the runs that earlier problems offer to a problem, or why there are none.

    A run can be taken over when the forward model is the same, its curves have all points that are observed now, and
    its parameters are a point of the new search: all values that are not free now are equal, the others lie between
    the bounds and satisfy the constraints. Measured values and weights may differ: objectives are calculated anew.
    """
    if forward_model_hash(problem) != forward_model_hash(earlier.problem):
        return OTHER_MODEL
    usable = usable_runs(problem, earlier.problem, earlier.parameters)
    if isinstance(usable, str):
        return usable
    places, chosen, parameters = usable
    responses = [{series: earlier.responses[i][series][at] for series, at in places.items()} for i in chosen]
    return WarmStartRuns(parameters, responses)


def usable_runs(
    problem: Problem, earlier: Problem, runs: FloatArray
) -> tuple[dict[str, IntArray], list[int], FloatArray] | str:
    """Return the runs of an earlier problem with the same forward model that can be reused, or why none can.

    Parameters
    ----------
    runs
        Natural values of the free parameters of the earlier problem, shape (n, d).

    Returns
    -------
    tuple or str
        Indices of the observed points in the earlier curves by series, numbers of the k runs, and their values of the
        parameters that are free now, shape (k, e).
    """
    places = _places(problem, earlier)
    if isinstance(places, str):
        return places
    chosen, parameters = [], []
    for number, free in enumerate(runs):
        point = _point(problem, earlier.values(free.tolist()))
        if point is not None:
            chosen.append(number)
            parameters.append(point)
    if not chosen:
        return "has no run inside the bounds with the same values of all parameters that are not free here"
    return places, chosen, np.array(parameters)


def best_of(problem: Problem, offers: Sequence[WarmStartRuns]) -> WarmStartRuns | None:
    """Join offers, each point once, and keep at most :data:`MOST_OFFERED` runs; None if there are none."""
    if not offers:
        return None
    parameters = np.concatenate([offer.parameters for offer in offers])
    responses = [response for offer in offers for response in offer.responses]
    objectives = Calibration(problem, 0, WarmStartRuns(parameters, responses)).offered
    order = np.argsort(np.array([] if objectives is None else objectives.objectives), kind="stable")
    _, first = np.unique(parameters[order], axis=0, return_index=True)
    order = order[np.sort(first)]
    if order.size > MOST_OFFERED:
        half = MOST_OFFERED // 2
        rest = np.linspace(half, order.size - 1, MOST_OFFERED - half).round().astype(np.int64)
        order = np.concatenate([order[:half], order[rest]])
    return WarmStartRuns(parameters[order], [responses[i] for i in order])


def _places(problem: Problem, earlier: Problem) -> dict[str, IntArray] | str:
    """Indices of the observed points in the earlier curves, by series."""
    known = {observation.series: observation.x.tolist() for observation in earlier.observations}
    inputs = {observation.series: observation.inputs for observation in earlier.observations}
    places: dict[str, IntArray] = {}
    for observation in problem.observations:
        x = known.get(observation.series)
        if observation.inputs or inputs.get(observation.series):  # a point is then more than its x
            if x != observation.x.tolist() or not _same(observation.inputs, inputs[observation.series]):
                return f"has other points or inputs of {observation.series}"
            places[observation.series] = np.arange(len(x))
            continue
        first = {value: place for place, value in reversed(list(enumerate(x or ())))}
        if not all(value in first for value in observation.x.tolist()):
            return f"has no responses at all observed points of {observation.series}"
        places[observation.series] = np.array([first[value] for value in observation.x.tolist()], dtype=np.int64)
    return places


def _same(inputs: Mapping[str, FloatArray], others: Mapping[str, FloatArray]) -> bool:
    return inputs.keys() == others.keys() and all(np.array_equal(inputs[name], others[name]) for name in inputs)


def _point(problem: Problem, values: Mapping[str, float]) -> FloatArray | None:
    """Return the free parameters at which a run of the earlier problem would be one of this one, None: nowhere."""
    defaults = {info.name: info.default for info in problem.model.parameters}
    complete = {name: value for name, value in defaults.items() if value is not None} | dict(values)
    if any(name not in complete for name in problem.free_names):
        return None
    point = np.array([complete[name] for name in problem.free_names], dtype=np.float64)
    lower = np.array([p.lower for p in problem.free])
    upper = np.array([p.upper for p in problem.free])
    integer = np.array([p.integer for p in problem.free])
    if ((point < lower) | (point > upper) | (integer & (point != np.rint(point)))).any():
        return None
    now = problem.values(point.tolist())
    if not problem.satisfies(now):
        return None
    then = {name: value for name, value in defaults.items() if value is not None} | now
    names = set(then) | set(complete) if problem.model.open_parameters else set(defaults)
    same = all(
        name in then and name in complete and abs(then[name] - complete[name]) <= _EQUAL * abs(complete[name])
        for name in names
    )
    return point if same else None
