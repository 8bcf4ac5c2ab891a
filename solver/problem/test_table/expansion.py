"""A document with a table of tests made one with the parts and observations of a combined problem."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.forward.registry import find_spec, parse_spec
from geoswarm.solver.problem.issues import describe
from geoswarm.solver.problem.test_table.readings import SERIES, Curve, curves_of, loads_of, unknown_keys
from geoswarm.solver.problem.test_table.rows import Files, Row, rows_of, said_once

__all__ = ["without_table"]

_KEY = "tests"
_SPECIMEN = {"oedometer": {"height": 0.02}, "isotropic_compression": {"height": 0.1, "diameter": 0.05}, "triaxial": {}}
"""Dimensions in m that void ratio and strain do not depend on."""
_PLACE = re.compile(r"forward_model\.parts\.(\w+)\.?(.*)|observations\[(\d+)\]\.?(.*)")


@dataclass(frozen=True, slots=True)
class _Origins:
    """The row that each part and observation was made of, by its name or place."""

    parts: dict[str, Row] = field(default_factory=dict)
    observations: dict[int, Row] = field(default_factory=dict)

    def placed(self, issue: Issue) -> Issue:
        """A mistake in what a row was made into, at that row."""
        found = _PLACE.fullmatch(issue.path)
        if found is None:
            return issue
        row = self.parts.get(found[1]) if found[1] else self.observations.get(int(found[3]))
        return issue if row is None else row.issue(found[2] or found[4] or "", issue.message)


@contextmanager
def without_table(document: dict[str, Any], files: Files) -> Iterator[dict[str, Any]]:
    """Make each row of ``tests`` a part of the forward model and an observation for each of its curves.

    Each test counts alike (``weighting: by_test``) unless the document gives a weighting. Inside the context, mistakes
    in what was made are raised as mistakes in their rows.

    Parameters
    ----------
    files
        Where the files are.

    Raises
    ------
    ProblemError
        A row has a mistake, or its file.
    """
    if document.get(_KEY) is None:
        yield {key: value for key, value in document.items() if key != _KEY}
        return
    try:
        plain, origins = _without(document, files)
    except ProblemError as error:
        raise ProblemError(said_once(error.issues)) from None
    try:
        yield plain
    except ProblemError as error:
        raise ProblemError(said_once(map(origins.placed, error.issues))) from None


def _without(document: dict[str, Any], files: Files) -> tuple[dict[str, Any], _Origins]:
    given = document.get("forward_model", {"kind": "combined"})
    if not isinstance(given, dict) or given.get("kind") != "combined" or not isinstance(given.get("parts", {}), dict):
        message = f"with tests only kind: combined is accepted, with further parts or none; got {describe(given)}"
        raise ProblemError([Issue("forward_model", message)])
    if not isinstance(document.get("observations", []), list):
        raise ProblemError([Issue("observations", f"must be a list, got {describe(document['observations'])}")])
    parts: dict[str, Any] = dict(given.get("parts", {}))
    observations: list[Any] = list(document.get("observations", []))
    origins, issues = _Origins(), list[Issue]()
    for row in rows_of(document[_KEY], files):
        name = _name(row)
        if name in parts:
            issues.append(row.issue("name", f"is '{name}', which another test has; give each test a name of its own"))
            continue
        try:
            part, found = _part(row, files, _declared(document, name))
        except ProblemError as error:
            issues += error.issues
            continue
        parts[name], origins.parts[name] = part, row
        for one in found:
            origins.observations[len(observations)] = row
            observations.append({"series": f"{name}.{one['series']}", **one["observation"]})
    if issues:
        raise ProblemError(issues)
    rest = {key: value for key, value in document.items() if key not in (_KEY, "forward_model", "observations")}
    model = {"forward_model": given | {"parts": parts}, "observations": observations}
    return {"weighting": "by_test"} | rest | model, origins


def _name(row: Row) -> str:
    """The name of a test as that of a part."""
    section = row.section
    name = re.sub(r"\W", "_", section.name or section.sheet or Path(str(section.file)).stem, flags=re.ASCII)
    return name if re.match(r"[A-Za-z_]", name) else f"test_{name}"


def _declared(document: dict[str, Any], name: str) -> frozenset[str]:
    """Parameters of a test, under the names that its model knows."""
    parameters = document.get("parameters")
    return frozenset(key.removeprefix(f"{name}.") for key in (parameters if isinstance(parameters, dict) else ()))


def _part(row: Row, files: Files, declared: frozenset[str]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    section = row.section
    kind = str(section.kind)
    curves, extra = curves_of(row, files)
    fields = [key for key in find_spec(kind).model_fields if key not in ("kind", "stages", "shearing", "consolidation")]
    if issues := unknown_keys(row, extra, fields):
        raise ProblemError(issues)
    part = {"kind": kind, **_SPECIMEN[kind], **extra}
    part |= _sheared(row, curves) if kind == "triaxial" else _loaded(row, curves)
    if fault := _missing(row, part, declared):
        raise ProblemError([fault])
    points = [curve.points.document() for curve in curves]
    if kind != "triaxial":
        first = 0 if section.initial_stress is not None else 1
        points = [_over_stages(one, first) for one in points]
    found = []
    for curve, one in zip(curves, points, strict=True):
        observation = curve.observation | {"points": one}
        if kind != "triaxial":
            observation.pop("x_unit", None)
            marked = [place - first for place in observation.pop("gross_errors", []) if place > first]
            observation |= {"gross_errors": marked} if marked else {}
        found.append({"series": SERIES[kind][curve.name], "observation": observation})
    return part, found


def _sheared(row: Row, curves: list[Curve]) -> dict[str, Any]:
    """Consolidation to the cell pressure, unless the soil is placed under it, and shearing to the last reading."""
    section = row.section
    ends = [float(x) for curve in curves for x in (curve.x.min(), curve.x.max())]
    end = max(ends, key=abs)
    if end == 0.0:
        raise ProblemError([row.issue("x", "has the axial strain 0 only; readings of shearing are needed")])
    placed = section.initial_stress or section.cell_pressure
    pace = {} if section.rate is None else {"rate": section.rate}
    made: dict[str, Any] = {"initial_stress": placed}
    if placed != section.cell_pressure:
        made["consolidation"] = [{"axial": section.cell_pressure}]
    if section.initial_void_ratio is not None:
        made["initial_void_ratio"] = section.initial_void_ratio
    shearing = [{"kind": "monotonic", "axial_strain": float(f"{end:.12g}"), **pace}]
    return made | {"drainage": section.drainage or "drained", "shearing": shearing}


def _loaded(row: Row, curves: list[Curve]) -> dict[str, Any]:
    """Loads in the order of the readings; unloading is where they fall."""
    section = row.section
    loads, stress, voids, _ = loads_of(row, curves[0])
    if any(curve.x.tolist() != curves[0].x.tolist() for curve in curves[1:]):
        message = "has readings of its series at different stresses; give one series, or fill the empty cells"
        raise ProblemError([row.issue("file", message)])
    duration = 1.0 if section.stage_duration is None else section.stage_duration
    made = {"initial_stress": stress, "stages": [{"stress": load, "duration": duration} for load in loads]}
    made |= {} if voids is None else {"initial_void_ratio": voids}
    return made


def _missing(row: Row, part: dict[str, Any], declared: frozenset[str]) -> Issue | None:
    """What the law needs to know of the test and the row does not say."""
    from geoswarm.solver.forward.fields import OneMaterialSpec
    from geoswarm.solver.laws.initial_state import voids_column  # with Numba, which other problems need not load

    try:
        spec = parse_spec(part)
    except ValidationError:  # told when all parts are checked
        return None
    assert isinstance(spec, OneMaterialSpec)
    law, given = spec.law, row.section
    if law.depends_on_time and given.stage_duration is None and given.kind != "triaxial":
        message = f"is missing: time has an effect on material {law.kind}; the duration of a load in day is accepted"
        return row.issue("stage_duration", message)
    if voids_column(law) is not None and not declared & {"e0", *law.instead_of_e0} and "initial_void_ratio" not in part:
        message = f"is missing: material {law.kind} needs it; the void ratio at the beginning, above 0, is accepted"
        return row.issue("initial_void_ratio", message)
    return None


def _over_stages(points: dict[str, Any], first: int) -> dict[str, Any]:
    """Points of the readings after the first load, with the number of the stage as x."""
    kept = {key: values[first:] if isinstance(values, list) else values for key, values in points.items()}
    return kept | {"x": [float(number) for number in range(1, len(kept["y"]) + 1)]}
