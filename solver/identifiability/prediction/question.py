"""The problem of a prediction: another problem, with a sample of the identified parameters of a job."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from geoswarm.solver.errors import Issue, ProblemError, SolverError
from geoswarm.solver.forward.base import ForwardModel
from geoswarm.solver.forward.fields import OneMaterialSpec
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.identifiability.prediction.draws import ParameterSample
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.problem.parameters import missing_parameters
from geoswarm.solver.problem.test_table.expansion import without_table
from geoswarm.solver.words import listed

__all__ = ["MOST_RUNS", "predict_problem", "problem_of_tests", "question_hash"]

MOST_RUNS = 10_000
OWN_KEYS = ("name", "method", "stopping", "seed", "priority")
"""What a follow-up has of its own."""

_DROPPED = ("method", "stopping", "warm_start", "weighting", "index_properties", "priority")
_LONGEST_NAME = 200


def question_hash(problem: Problem) -> str:
    """Name a problem but for name, method, stop criteria, seed and priority."""
    document = {key: value for key, value in problem.document().items() if key not in OWN_KEYS}
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def predict_problem(
    problem: Problem,
    other: Mapping[str, Any] | Path,
    sample: ParameterSample,
    *,
    seed: int,
    level: float = 0.9,
    readings: Mapping[str, float] | None = None,
    alarm: str | None = None,
    remarks: Sequence[str] = (),
    of: str | None = None,
    programs: bool = False,
) -> Problem:
    """The problem that runs a sample of the parameters of ``problem`` through the forward model of another one.

    Parameters
    ----------
    other
        A problem document, or the file of one. Its observations say where the series are wanted; they need no y. Of its
        parameters, those that are free or left out are taken from the sample by name; all others keep the value or the
        expression that it gives. What else it says of method and stop criteria is of no account.
    sample
        Of the identified parameters.
    readings
        Standard deviation of a reading by series of the problem, base units, for series of the same name.
    alarm, remarks
        Why the band cannot be relied on, and what it contains.
    of
        Id of the job.
    programs
        Whether ``other`` may run programs of this machine.

    Raises
    ------
    ProblemError
        Lists every mistake with its path.
    """
    folder = None if not isinstance(other, Path) else other.parent
    kept: list[str] = []
    unmeasured: list[str] = []

    def completed(document: dict[str, Any]) -> dict[str, Any]:
        found = {key: value for key, value in document.items() if key not in _DROPPED}
        found["parameters"] = _parameters(problem, found, sample, folder, kept)
        found["observations"], without = _observations(found.get("observations"))
        unmeasured.extend(without)
        found["method"] = {"kind": "monte_carlo", "samples": 10}  # until the units of the readings are known
        return found

    if isinstance(other, Path):
        parsed = load_problem(other, completed)
    else:
        parsed = parse_problem({"name": "prediction", **other}, programs=programs, completed=completed)
    infos = {info.name: info for info in problem.model.series}
    predicted = {info.name: info for info in parsed.model.series}
    errors = {o.series: o.error for o in parsed.observations if o.error is not None}
    for series, deviation in (readings or {}).items():
        same = series in predicted and series in infos and infos[series].y_unit == predicted[series].y_unit
        if same and any(o.series == series for o in parsed.observations):
            errors.setdefault(series, float(deviation))
    points = [*sample.optima.tolist(), *sample.parameters.tolist()]
    names = list(parsed.free_names)
    columns = [sample.names.index(name) for name in names]
    told = list(remarks)
    if kept:
        told.append(
            f"{', '.join(kept)}: the predicted problem gives a value or an expression, so what the job found of it "
            "takes no part"
        )
    method = {
        "kind": "predict",
        "points": {name: [row[column] for row in points] for name, column in zip(names, columns, strict=True)},
        "shares": sample.shares.tolist(),
        "weights": sample.weights.tolist(),
        "basins": sample.basins.tolist(),
        "noise_factors": sample.noise_factors.tolist(),
        "level": level,
        "readings": errors,
        "unmeasured": unmeasured,
        "basis": sample.basis,
        "undecided": [name for name in sample.undecided if name in names],
        "remarks": told,
        "question": question_hash(problem),
    }
    method |= {key: value for key, value in (("alarm", alarm), ("of", of)) if value is not None}
    document = parsed.document() | {
        "name": parsed.name[:_LONGEST_NAME],
        "method": method,
        "stopping": {},
        "seed": seed,
    }
    return parse_problem(document, programs=parsed.forward_model.runs_programs)


def problem_of_tests(problem: Problem, table: Path) -> dict[str, Any]:
    """The tests of a table as a problem to be predicted, with the law of a problem and what it fixes and links.

    The initial void ratio is that of each test, and what holds for one test of the problem alone is left out.

    Raises
    ------
    ProblemError
        The tests of the problem have no law, or not the same one; or the table has mistakes.
    """
    specs = [spec for spec in problem.forward_model.by_part().values() if isinstance(spec, OneMaterialSpec)]
    dumped = [spec.model_dump(mode="json") for spec in specs]
    own = {json.dumps({key: one[key] for key in ("material", "settings") if one.get(key)}) for one in dumped}
    if len(own) != 1:
        found = listed([spec.law.kind for spec in specs]) if specs else "none"
        message = f"the tests of the job must have one law that those of a table take, got {found}"
        raise ProblemError([Issue("tests", f"{message}; write a problem file with tests and material")])
    law = specs[0].law
    free = set(problem.free_names) | law.derived
    given = {name: one for name, one in problem.document()["parameters"].items() if name not in free}
    wanted = [name for name in given if name in {info.name for info in law.parameters}]
    parameters: dict[str, Any] = {}
    while wanted:
        name = wanted.pop(0)
        if name not in parameters:
            parameters[name] = given[name]
            names = re.findall(r"[A-Za-z_]\w*", str(given[name].get("expression", "")))
            wanted += [one for one in names if one in given]
    document = {"name": table.stem, "tests": {"table": table.name, **json.loads(own.pop())}, "parameters": parameters}
    with without_table(document, table.parent) as plain:
        return plain


def model_of(section: Any, folder: Path | None) -> ForwardModel | None:
    """The forward model of a section; None if it is wrong, which is reported when the whole is read."""
    try:
        return built(parse_spec(section).with_files(folder, "forward_model"))
    except (SolverError, ValueError):
        return None


def identified_section(problem: Problem, name: str) -> dict[str, Any]:
    """A free parameter of a problem as a section, without an initial value."""
    section: dict[str, Any] = dict(problem.document()["parameters"][name])
    section.pop("initial", None)
    return section


def _parameters(
    problem: Problem, document: Mapping[str, Any], sample: ParameterSample, folder: Path | None, kept: list[str]
) -> Any:
    given = document.get("parameters", {})
    if not isinstance(given, Mapping):
        return given
    model = model_of(document.get("forward_model"), folder)
    identified = dict.fromkeys(sample.names)
    issues = []
    parameters: dict[str, Any] = {}
    for name, section in given.items():
        is_free = not isinstance(section, Mapping) or not {"value", "expression"} & section.keys()
        if not is_free:
            parameters[name] = section
            if name in identified:
                kept.append(name)
        elif name in identified:
            parameters[name] = identified_section(problem, name)
        else:
            message = (
                f"is not identified by the job (it identifies {', '.join(identified)}); give its value or an expression"
            )
            issues.append(Issue(f"parameters.{name}", message + _hint(problem, name)))
    texts = " ".join(str(section.get("expression", "")) for section in given.values() if isinstance(section, Mapping))
    texts += " ".join(map(str, document.get("constraints") or ()))
    wanted = set() if model is None else {info.name for info in model.parameters}
    for name in identified:
        if name not in parameters and (name in wanted or re.search(rf"\b{re.escape(name)}\b", texts)):
            parameters[name] = identified_section(problem, name)
    if model is not None:
        for info in missing_parameters(model, {*parameters, *given}):
            message = (
                f"is needed by the forward model, and the job does not identify it ({', '.join(identified)}); give its "
                "value or an expression"
            )
            issues.append(Issue(f"parameters.{info.name}", message + _hint(problem, info.name)))
    if issues:
        raise ProblemError(issues)
    if model is not None and not any(name in identified and name not in kept for name in parameters):
        raise ProblemError(
            [
                Issue(
                    "parameters",
                    f"none of the parameters that the job identifies ({', '.join(identified)}) is left to be predicted "
                    "with; leave out those that are to be taken from it",
                )
            ]
        )
    return parameters


def _hint(problem: Problem, name: str) -> str:
    section = problem.document()["parameters"].get(name, {})
    if "value" in section:
        return f"; the job had the value {section['value']:g}"
    if "expression" in section:
        return f"; the job had the expression {section['expression']}"
    return ""


def _observations(given: Any) -> tuple[Any, list[str]]:
    """Observations with y where none is given, and the series of which none is."""
    if not isinstance(given, list):
        return given, []
    found, without = [], []
    for section in given:
        points = section.get("points") if isinstance(section, Mapping) else None
        lacks = isinstance(points, Mapping) and isinstance(points.get("x"), list) and points.get("y") is None
        if lacks:
            assert isinstance(points, Mapping)
            without.append(str(section.get("series")))
            filled = {**{k: v for k, v in points.items() if k != "y"}, "y": [0.0] * len(points["x"])}
            section = {**{k: v for k, v in section.items() if k not in ("y_zero", "y_factor")}, "points": filled}
        found.append(section)
    return found, without
