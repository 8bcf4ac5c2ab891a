"""The readings of a test: columns of its file found by their headings, and the loads that a curve over stress has."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem.issues import validated
from geoswarm.solver.problem.load_stages import in_base_unit
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.points import Points, points_of_file, units_found
from geoswarm.solver.problem.tables.measurements import Column, read_measurements
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.problem.test_table.rows import Files, Row, content_of
from geoswarm.solver.words import did_you_mean, listed

__all__ = ["SERIES", "Curve", "curves_of", "loads_of", "unknown_keys"]

_OVER_STRAIN = (
    *("q", "p", "volumetric_strain", "pore_pressure", "void_ratio", "stress_ratio"),
    *("radial_strain", "axial_stress", "radial_stress"),
)
SERIES: dict[str, dict[str, str]] = {
    "oedometer": {"void_ratio": "stage_void_ratio", "axial_strain": "stage_axial_strain"},
    "isotropic_compression": {"void_ratio": "stage_void_ratio", "volumetric_strain": "stage_volumetric_strain"},
    "triaxial": {name: name for name in _OVER_STRAIN},
}
"""What a file of each kind may hold, by the name in a row, and the series of the forward model that it is."""
_STRESS = ("axial_stress", "normal_stress", "effective_stress")
_X = {"oedometer": _STRESS, "isotropic_compression": ("p", *_STRESS), "triaxial": ("axial_strain", "vertical_strain")}
_X_BASE = {"oedometer": "kPa", "isotropic_compression": "kPa", "triaxial": "1"}
_FOUND: dict[tuple[str, str], tuple[tuple[str, ...], ...]] = {
    ("oedometer", "drained"): (("void_ratio", "axial_strain"),),
    ("isotropic_compression", "drained"): (("void_ratio", "volumetric_strain"),),
    ("triaxial", "drained"): (("q",), ("volumetric_strain", "void_ratio")),
    ("triaxial", "undrained"): (("q",), ("pore_pressure", "p")),
}
"""What is read where a row names no column: of each group the first that the file has."""
_OF_SERIES = {"unit": "y_unit", "factor": "y_factor", "error": "error", "weight": "weight", "distance": "distance"}
_OF_ALL = (
    *("decimal_sign", "incomplete_rows", "no_reading", "where", "sort", "repeated_x", "resample", "y_zero"),
    *("gross_error_column", "x_factor", "loss", "loss_scale"),
)
_KEPT = ("error", "weight", "distance", "loss", "loss_scale", "x_from", "x_to")
"""Keys of an observation that are not taken in with its readings."""
_OF_SHEARING = ("x_from", "x_to")
"""Keys of readings over strain: those of compression tests are over the number of a stage."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A measured curve of a test: its name in the row, x in kPa or without unit, and its observation."""

    name: str
    x: FloatArray
    points: Points
    observation: dict[str, Any]


def curves_of(row: Row, files: Files) -> tuple[list[Curve], dict[str, Any]]:
    """The curves of a test, and the keys of the row that are of its part.

    Raises
    ------
    ProblemError
        A column is unknown, missing or ambiguous, or its file cannot be read.
    """
    section = row.section
    kind = str(section.kind)
    extra = dict(section.model_extra or {})
    known = SERIES[kind]
    columns = {name: extra.pop(name) for name in known if name in extra}
    given = {key: extra.pop(key) for key in _of_all(kind) if key in extra}
    by_series = {
        name: {key: extra.pop(f"{name}_{word}") for word, key in _OF_SERIES.items() if f"{name}_{word}" in extra}
        for name in known
    }
    try:
        content = content_of(files, str(section.file))
        x, found = _found_columns(row, content, columns)
    except TableError as error:
        raise ProblemError([row.issue("file", message) for message in error.messages]) from None
    curves, issues = [], []
    for name, column in found.items():
        sheet = {} if section.sheet is None else {"sheet": section.sheet}
        unit = {} if section.x_unit is None else {"x_unit": section.x_unit}
        wanted = {"series": known[name], "file": section.file, "x_column": x, "y_column": column}
        try:
            curve = _curve(name, wanted | sheet | unit | given | by_series[name], content, _X_BASE[kind])
            curves.append(curve if kind == "triaxial" else _under_load(curve))
        except ProblemError as error:
            issues += [row.issue(_key(issue.path, name), issue.message) for issue in error.issues]
    if issues:
        raise ProblemError(issues)
    return curves, extra


def _of_all(kind: str) -> tuple[str, ...]:
    """Keys that all curves of a test share."""
    return (*_OF_ALL, *_OF_SHEARING) if kind == "triaxial" else _OF_ALL


def _key(path: str, name: str) -> str:
    """The key of a row for that of its observation."""
    own = {key: f"{name}_{word}" for word, key in _OF_SERIES.items()}
    return {"x_column": "x", "y_column": name, **own}.get(path, path)


def _curve(name: str, wanted: dict[str, Any], content: bytes, base: str) -> Curve:
    section, issues = validated(ObservationSection, wanted, "")
    if section is None:
        raise ProblemError([Issue(issue.path.removeprefix("."), issue.message) for issue in issues])
    points, issues = points_of_file(section, "", content, str(section.file))
    if points is None or issues:
        raise ProblemError([Issue(issue.path.removeprefix("."), issue.message) for issue in issues])
    x = in_base_unit("x", points.x, section.x_unit, base, points.x_heading)
    kept: dict[str, Any] = {key: wanted[key] for key in _KEPT if key in wanted}
    units = units_found(points) | {key: wanted[key] for key in ("x_unit", "y_unit") if key in wanted}
    if points.gross_errors:
        kept["gross_errors"] = [place + 1 for place in points.gross_errors]
    notes = [f"{section.file}, columns {section.x_column} and {section.y_column}", *points.notes]
    return Curve(name, x, points, units | kept | {"notes": notes})


def _under_load(curve: Curve) -> Curve:
    """A curve over stress without its readings at stress 0, under which no law has a stiffness."""
    loaded = curve.x != 0.0
    without = int((~loaded).sum())
    if not without or without == loaded.size:
        return curve
    notes = [*curve.observation["notes"], f"{without} readings without stress left out"]
    points = curve.points.chosen(loaded)
    marked = {"gross_errors": [place + 1 for place in points.gross_errors]} if points.gross_errors else {}
    rest = {key: value for key, value in curve.observation.items() if key != "gross_errors"}
    return Curve(curve.name, curve.x[loaded], points, rest | marked | {"notes": notes})


def _found_columns(row: Row, content: bytes, columns: dict[str, str]) -> tuple[str, dict[str, str]]:
    """The column of x and those of the series, as the row gives them or by what their headings mean."""
    section, kind = row.section, str(row.section.kind)
    wrong = [name for name, column in columns.items() if not isinstance(column, str)]
    if wrong:
        raise ProblemError([row.issue(name, "must be the heading of its column in the file") for name in wrong])
    if section.x is not None and columns:
        return section.x, columns
    there = read_measurements(content, str(section.file), section.sheet).columns
    x = section.x or _one(row, "x", there, _X[kind])
    if x is None:
        raise ProblemError([row.issue("x", _none("the " + _X[kind][0].replace("_", " "), there, "x"))])
    if not columns:
        groups = _FOUND[kind, section.drainage or "drained"]
        for group in groups:
            for name in group:
                column = _one(row, name, there, (name,))
                if column is not None and column != x:
                    columns = columns | {name: column}
                    break
    if not columns:
        names = [name for group in _FOUND[kind, section.drainage or "drained"] for name in group]
        raise ProblemError([row.issue("file", _none(listed(names, "or"), there, " or ".join(names)))])
    return x, columns


def _one(row: Row, key: str, there: Sequence[Column], meant: Iterable[str]) -> str | None:
    """The only column whose heading has one of the meanings, the first meaning that there is."""
    for quantity in meant:
        found = [column.name for column in there if column.kind == "number" and quantity in column.quantities]
        if len(found) > 1:
            message = f"{row.section.file} has several columns for it: {', '.join(found)}; give the heading of one"
            raise ProblemError([row.issue(key, message)])
        if found:
            return found[0]
    return None


def _none(what: str, there: Sequence[Column], key: str) -> str:
    names = ", ".join(column.name for column in there)
    return f"no heading of the file means {what} (headings: {names}); name its column in {key}"


def unknown_keys(row: Row, extra: Iterable[str], of_part: Iterable[str]) -> list[Issue]:
    """Keys that neither a row nor its part has."""
    section = row.section
    known = SERIES[str(section.kind)]
    accepted = [*type(section).model_fields, *known, *of_part]
    said = f"also {', '.join(f'SERIES_{word}' for word in _OF_SERIES)} and {', '.join(_of_all(str(section.kind)))}"
    return [
        row.issue(key, f"unknown key{did_you_mean(key, accepted)}; accepted: {', '.join(accepted)}; {said}")
        for key in extra
        if key not in of_part
    ]


def loads_of(row: Row, curve: Curve) -> tuple[list[float], float, float | None, int]:
    """Loads of the stages [kPa], stress and void ratio before them, and how many readings are before the first load.

    Raises
    ------
    ProblemError
        A stress is not above 0, or there are too few readings.
    """
    section = row.section
    first = 0 if section.initial_stress is not None else 1
    if len(curve.x) <= first:
        raise ProblemError([row.issue("file", f"has {len(curve.x)} readings; at least {first + 1} are needed")])
    if (low := float(curve.x.min())) <= 0.0:
        raise ProblemError([row.issue("file", f"holds the stress {low:g} kPa; stresses are above 0")])
    stress = float(curve.x[0]) if section.initial_stress is None else section.initial_stress
    voids = section.initial_void_ratio
    if voids is None and first == 1 and curve.name == "void_ratio":
        given = curve.observation.get("y_unit")
        voids = float(in_base_unit("y", curve.points.y[:1], given, "1", curve.points.y_heading)[0])
    return [float(f"{x:.12g}") for x in curve.x[first:]], stress, voids, first
