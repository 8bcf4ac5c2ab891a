"""The problem that evaluates the sensitivities of candidate tests: their forward models at once, as parts of one."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.identifiability.prediction.draws import Basin, draw_around
from geoswarm.solver.identifiability.prediction.question import identified_section, question_hash
from geoswarm.solver.identifiability.worth.candidates import Candidate, CandidateFile
from geoswarm.solver.methods.design import Criterion
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.parameters import missing_parameters

__all__ = ["MOST_DRAWS", "design_problem"]

MOST_DRAWS = 200
_FREE_VARIANCE = 1.0 / 12.0  # of a parameter that may be anywhere between its bounds, parts of the range
_STEP = 0.5  # standard deviations
_SMALLEST_STEP, _LARGEST_STEP = 1e-3, 0.05  # parts of the range
_LONGEST_NAME = 200


def design_problem(
    calibration: Calibration,
    basins: Sequence[Basin],
    candidates: CandidateFile,
    *,
    seed: int,
    quantile: float,
    draws: int = 8,
    predicted: tuple[Candidate, Mapping[str, Any]] | None = None,
    criterion: Criterion | None = None,
    alarm: str | None = None,
    remarks: Sequence[str] = (),
    of: str | None = None,
) -> Problem:
    """The problem of the worth of candidates.

    Parameters
    ----------
    basins
        Of the job, with how the parameters scatter around each.
    quantile
        For the half width of a 95 % interval.
    draws
        Further centres around the optima, over which the worth is averaged.
    predicted
        What is to be predicted, and sections of the parameters of its forward model.
    criterion
        What the candidates are put in order by; ``prediction`` where something is predicted, ``widths`` otherwise.
    of
        Id of the job.

    Raises
    ------
    ProblemError
        When a parameter of a candidate is neither in the job nor given.
    """
    problem = calibration.problem
    tests = [*candidates.candidates, *(() if predicted is None else (predicted[0],))]
    section, names, flattened = _combined(tests)
    given = {**(predicted[1] if predicted else {}), **candidates.parameters}
    parameters = _parameters(problem, section, given, flattened)
    grids = _grids(tests, names)
    used = [name for name in problem.free_names if name in parameters]
    centres, weights, owners = _centres(calibration, basins, draws, seed)
    points, plan = _plan(calibration, basins, centres, owners, used)
    readings = [_readings(test, renamed, grids) for test, renamed in zip(tests, names, strict=True)]
    wanted = [
        {"name": test.name, "readings": own} | ({} if test.cost is None else {"cost": test.cost})
        for test, own in zip(tests, readings, strict=True)
    ]
    free = {p.name: p for p in problem.free}
    undecided = basins[0].shape.undecided
    method: dict[str, Any] = {
        "kind": "design",
        "points": {name: points[:, problem.free_names.index(name)].tolist() for name in used},
        "plan": plan,
        "basins": owners,
        "weights": weights,
        "identified": {
            name: {
                "value": float(basins[0].optimum[i]),
                "lower": p.lower,
                "upper": p.upper,
                "scale": p.scale,
                "decided": not bool(undecided[i]),
            }
            for i, (name, p) in enumerate(free.items())
        },
        "covariances": [_covariance(basin).tolist() for basin in basins],
        "quantile": quantile,
        "candidates": wanted[: len(candidates.candidates)],
        "criterion": criterion or ("widths" if predicted is None else "prediction"),
        "remarks": list(remarks),
        "question": question_hash(problem),
    }
    if predicted is not None:
        method["prediction"] = wanted[-1]
    method |= {key: value for key, value in (("alarm", alarm), ("of", of)) if value is not None}
    document = {
        "name": f"{problem.name}, design"[:_LONGEST_NAME],
        "forward_model": section,
        "parameters": parameters,
        "observations": [
            {"series": series, "points": {"x": x.tolist(), "y": [0.0] * len(x)}} for series, x in grids.items()
        ],
        "method": method,
        "seed": seed,
    } | ({"limits": limits} if (limits := problem.document().get("limits")) else {})
    return parse_problem(document, programs=any(test.spec.runs_programs for test in tests))


def _covariance(basin: Basin) -> FloatArray:
    """What the data leave uncertain, parts of the ranges, where a parameter may be anywhere between its bounds at most.

    A normal prior with the variance of that range joins what the data say.
    """
    shape = basin.shape
    left, spread, _ = np.linalg.svd(shape.root, full_matrices=False)
    precision = (left / np.maximum(spread, 1e-12) ** 2) @ left.T
    return np.asarray(np.linalg.inv(precision + np.eye(len(precision)) / _FREE_VARIANCE))


def _key(spec: ForwardModelSpec) -> str:
    return json.dumps(spec.model_dump(mode="json"), sort_keys=True)


def _combined(tests: Sequence[Candidate]) -> tuple[dict[str, Any], list[dict[str, str]], dict[str, list[str]]]:
    """One section for all forward models, the new name of every series of every test, and the new names of parts."""
    different: dict[str, ForwardModelSpec] = {}
    for test in tests:
        different.setdefault(_key(test.spec), test.spec)
    if len(different) == 1:
        (spec,) = different.values()
        same = [{readings.series: readings.series for readings in test.readings} for test in tests]
        return spec.model_dump(mode="json"), same, {}
    parts: dict[str, Any] = {}
    prefixes: dict[str, str] = {}
    flattened: dict[str, list[str]] = {}
    for number, (key, spec) in enumerate(different.items(), start=1):
        inner = spec.by_part()
        prefixes[key] = f"m{number}" if set(inner) == {""} else f"m{number}_"
        for name, part in inner.items():
            parts[f"m{number}_{name}" if name else f"m{number}"] = part.model_dump(mode="json")
            if name:
                flattened.setdefault(name, []).append(f"m{number}_{name}")
    names = []
    for test in tests:
        prefix = prefixes[_key(test.spec)]
        dot = "" if prefix.endswith("_") else "."
        names.append({readings.series: f"{prefix}{dot}{readings.series}" for readings in test.readings})
    return {"kind": "combined", "parts": parts}, names, flattened


def _parameters(
    problem: Problem, section: Mapping[str, Any], given: Mapping[str, Any], flattened: Mapping[str, list[str]]
) -> dict[str, Any]:
    """Sections of all parameters that the candidates need: of the job, and those given beside them."""
    own = problem.document()["parameters"]
    known: dict[str, Any] = {
        name: identified_section(problem, name) if name in problem.free_names else one for name, one in own.items()
    }
    for name, one in given.items():
        fixed = isinstance(one, Mapping) and bool({"value", "expression"} & one.keys())
        if fixed:
            known[name] = dict(one)
        elif name not in known:
            raise ProblemError(
                [Issue(f"parameters.{name}", "must have a value or an expression: the job does not identify it")]
            )
    for name in tuple(known):  # of a part that has another name here
        part, _, rest = name.partition(".")
        for renamed in flattened.get(part, ()) if rest else ():
            known[f"{renamed}.{rest}"] = {"expression": name}
    model = built(parse_spec(section))
    wanted = {info.name for info in model.parameters}
    chosen: dict[str, Any] = {}
    pending = [name for name in known if name in wanted]
    while pending:
        name = pending.pop(0)
        if name in chosen:
            continue
        chosen[name] = known[name]
        text = str(known[name].get("expression", ""))
        pending += [other for other in known if re.search(rf"(?<![\w.]){re.escape(other)}(?![\w.])", text)]
    missing = missing_parameters(model, chosen)
    if missing:
        raise ProblemError(
            [
                Issue(
                    f"parameters.{info.name}",
                    "is needed by the forward model of a candidate, and the job has none; give its value under "
                    "parameters",
                )
                for info in missing
            ]
        )
    if not any(name in chosen for name in problem.free_names):
        raise ProblemError([Issue("candidates", "none depends on a parameter that the job identifies")])
    return {name: chosen[name] for name in known if name in chosen}


def _grids(tests: Sequence[Candidate], names: Sequence[Mapping[str, str]]) -> dict[str, FloatArray]:
    """All x that are wanted of each series."""
    grids: dict[str, FloatArray] = {}
    for test, renamed in zip(tests, names, strict=True):
        for readings in test.readings:
            series = renamed[readings.series]
            grids[series] = np.union1d(grids.get(series, np.empty(0)), readings.x)
    return grids


def _readings(test: Candidate, renamed: Mapping[str, str], grids: Mapping[str, FloatArray]) -> list[dict[str, Any]]:
    return [
        {"series": (series := renamed[one.series]), "at": np.searchsorted(grids[series], one.x).tolist()}
        | ({} if one.error is None else {"error": float(one.error)})
        for one in test.readings
    ]


def _centres(
    calibration: Calibration, basins: Sequence[Basin], draws: int, seed: int
) -> tuple[FloatArray, list[float], list[int]]:
    """Optima of the basins and draws around them, natural values; their weights, of sum 1; and their basins."""
    optima = np.array([basin.optimum for basin in basins])
    if draws < 1:
        return optima, [basin.share for basin in basins], list(range(len(basins)))
    sample = draw_around(calibration, basins, max(draws, len(basins)), seed)
    owners = [*range(len(basins)), *sample.basins.tolist()]
    counts = np.bincount(owners, minlength=len(basins))
    weights = [basins[b].share / int(counts[b]) for b in owners]
    return np.concatenate([optima, sample.parameters]), weights, owners


def _plan(
    calibration: Calibration, basins: Sequence[Basin], centres: FloatArray, owners: Sequence[int], used: Sequence[str]
) -> tuple[FloatArray, list[dict[str, Any]]]:
    """Points, shape (n, d), natural values: each centre, and two places along each parameter that is used.

    On both sides of the centre where these are inside the bounds and satisfy the constraints of the job, else on one.
    """
    space = calibration.space
    points: list[FloatArray] = []
    plan: list[dict[str, Any]] = []
    for number, (centre, owner) in enumerate(zip(centres, owners, strict=True)):
        unit = space.to_unit(centre)
        points.append(centre)
        plan.append({"centre": number})
        deviations = np.sqrt(np.diag(_covariance(basins[owner])))
        for name in used:
            index = space.names.index(name)
            step = float(np.clip(_STEP * deviations[index], _SMALLEST_STEP, _LARGEST_STEP))

            def at(offset: float, unit: FloatArray = unit, index: int = index) -> FloatArray | None:
                moved = unit.copy()
                moved[index] += offset
                natural = space.from_unit(np.clip(moved, 0.0, 1.0))
                return natural if 0.0 <= moved[index] <= 1.0 and space.feasible(natural) else None

            for pair in ((step, -step), (step, 2.0 * step), (-step, -2.0 * step), (0.1 * step, 0.2 * step)):
                places = [at(offset) for offset in pair]
                if all(place is not None for place in places):
                    break
            for offset, place in zip(pair, places, strict=True):
                if place is not None:
                    points.append(place)
                    plan.append({"centre": number, "parameter": name, "offset": offset})
    return np.array(points), plan
