"""Measured and calculated values of the diagrams that tests declare: one series over another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import SolverError
from geoswarm.solver.forward.base import ForwardModel, SeriesInfo
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.forward.diagram import Diagram
from geoswarm.solver.parameter_estimates.observed_curves import observed
from geoswarm.solver.problem import Observation, Problem

__all__ = ["DiagramCurve", "diagram_curves"]

_FULL = ("time_", "")
"""Prefixes of series whose axes can show the whole test, the better one first: over time loops are seen."""


_CLOSER = 100
"""Places of a calculated line over a logarithm."""


@dataclass(frozen=True, slots=True)
class DiagramCurve:
    """A diagram with its numbers.

    Parameters
    ----------
    part
        Name of the test in a combined model; empty otherwise.
    x_info, y_info
        What the axes show.
    x, y
        Calculated, shape (n,), base units; nan between stages that are not joined.
    measured_x, measured_y
        Shape (m,), base units.
    derived
        Whether one of both follows from other readings.
    """

    part: str
    diagram: Diagram
    x_info: SeriesInfo
    y_info: SeriesInfo
    x: FloatArray
    y: FloatArray
    measured_x: FloatArray
    measured_y: FloatArray
    derived: bool


def diagram_curves(problem: Problem, values: Mapping[str, float]) -> tuple[DiagramCurve, ...]:
    """Return the diagrams of all tests that readings allow; none of a test that cannot be calculated.

    Parameters
    ----------
    values
        Value of every parameter.
    """
    found = []
    if problem.forward_model.runs_outside:
        return ()
    for part in parts_of(problem.forward_model, problem.model):
        read = observed(problem, part.name)
        for diagram in part.spec.diagrams():
            try:
                curve = _curve(part.name, diagram, part.model, part.values(values), read)
            except SolverError:
                continue
            if curve is not None:
                found.append(curve)
    return tuple(found)


def _curve(
    part: str,
    diagram: Diagram,
    model: ForwardModel,
    values: Mapping[str, float],
    observed: Mapping[str, Observation],
) -> DiagramCurve | None:
    infos = {info.name: info for info in model.series}
    wanted = {diagram.x, diagram.y, *(name for one in diagram.derived for name in one.needs)}
    prefixes = dict.fromkeys(
        series.removesuffix(name)
        for series in observed
        for name in wanted
        if series == name or series.endswith((f"_{name}", f".{name}"))
    )
    readings = [found for prefix in prefixes if (found := _readings(prefix, wanted, infos, observed))]
    axes = [prefix for prefix in _FULL if _has(prefix, diagram, infos)]
    if not readings or not axes:
        return None
    calculated = _whole(axes, diagram, model, values, infos, observed)
    if calculated is None:
        return None
    x, y = calculated
    start = {diagram.x: float(x[0]), diagram.y: float(y[0])}
    points, derived = [], False
    for found in readings:
        both = [_reading(name, diagram, found, start) for name in (diagram.x, diagram.y)]
        if both[0] is not None and both[1] is not None:
            points.append((both[0], both[1]))
            derived = derived or not {diagram.x, diagram.y} <= found.keys()
    if not points:
        return None
    measured_x, measured_y = (np.concatenate(values) for values in zip(*points, strict=True))
    if diagram.log:
        x, y = np.where(x > 0.0, x, np.nan), np.where(x > 0.0, y, np.nan)
        known = (measured_x > 0.0) & np.isfinite(measured_y)
        measured_x, measured_y = measured_x[known], measured_y[known]
    if not (np.isfinite(x).any() and measured_x.size):
        return None
    if diagram.small is not None and not measured_x.min() <= diagram.small:
        return None
    x_info, y_info = _info(diagram.x, axes[0], infos), _info(diagram.y, axes[0], infos)
    return DiagramCurve(part, diagram, x_info, y_info, x, y, measured_x, measured_y, derived)


def _axis_of(info: SeriesInfo) -> str:
    """Name of what a series runs over, as series are called."""
    return info.x_quantity.replace(" ", "_")


def _is(series: str, prefix: str, wanted: set[str]) -> bool:
    return series.startswith(prefix) and series.removeprefix(prefix) in wanted


def _has(prefix: str, diagram: Diagram, infos: Mapping[str, SeriesInfo]) -> bool:
    """Whether both quantities are known along an axis; one of them may be the axis."""
    known = [name for name in (diagram.x, diagram.y) if f"{prefix}{name}" in infos]
    axis = {_axis_of(infos[f"{prefix}{name}"]) for name in known}
    return bool(known) and {diagram.x, diagram.y} <= {*known, *axis}


def _info(name: str, prefix: str, infos: Mapping[str, SeriesInfo]) -> SeriesInfo:
    """What is said of a quantity."""
    return infos.get(f"{prefix}{name}") or next(info for key, info in infos.items() if key.endswith(f"_{name}"))


def _readings(
    prefix: str, wanted: set[str], infos: Mapping[str, SeriesInfo], observed: Mapping[str, Observation]
) -> dict[str, FloatArray]:
    """Readings along one axis at the same moments: those of the first series, others between theirs."""
    own = {name: observed[f"{prefix}{name}"] for name in sorted(wanted) if f"{prefix}{name}" in observed}
    if not own:
        return {}
    first = next(iter(own.values()))
    low = max(float(o.x.min()) for o in own.values())
    high = min(float(o.x.max()) for o in own.values())
    at = np.sort(first.x[(first.x >= low) & (first.x <= high)])
    found = {}
    for name, one in own.items():
        order = np.argsort(one.x, kind="stable")
        found[name] = np.interp(at, one.x[order], one.y[order])
    return {_axis_of(infos[f"{prefix}{next(iter(own))}"]): at} | found


def _reading(
    name: str, diagram: Diagram, readings: Mapping[str, FloatArray], start: Mapping[str, float]
) -> FloatArray | None:
    if name in readings:
        return readings[name]
    for one in diagram.derived:
        if one.quantity == name and all(need in readings for need in one.needs):
            return one.of(readings, start)
    return None


def _whole(
    axes: Sequence[str],
    diagram: Diagram,
    model: ForwardModel,
    values: Mapping[str, float],
    infos: Mapping[str, SeriesInfo],
    observed: Mapping[str, Observation],
) -> tuple[FloatArray, FloatArray] | None:
    """The calculated line: over time, else stage by stage, else where the strain is first reached or was read."""
    stages = sorted({_stage(name) for name in infos if _stage(name)})
    branches = [f"branch_{number}." for number in stages if _has(f"branch_{number}.", diagram, infos)]
    ways = [[axis] for axis in axes]
    ways[1:1] = [branches] if len(branches) == len(stages) > 0 else []
    for way in ways:
        grids = [_closer(model.grid(_series(prefix, diagram, infos)), prefix, diagram, observed) for prefix in way]
        if all(grid.size for grid in grids):
            pieces = [
                _calculated(prefix, diagram, model, values, infos, grid)
                for prefix, grid in zip(way, grids, strict=True)
            ]
            return tuple(_joined(column) for column in zip(*pieces, strict=True))  # type: ignore[return-value]  # two
    for axis in axes:
        read = [o.x for name, o in observed.items() if _is(name, axis, {diagram.x, diagram.y}) or axis == ""]
        if read:
            return _calculated(axis, diagram, model, values, infos, np.unique(np.concatenate(read)))
    return None


def _closer(grid: FloatArray, prefix: str, diagram: Diagram, observed: Mapping[str, Observation]) -> FloatArray:
    """The grid of a test, with places from the smallest reading on where a diagram is of small values."""
    if diagram.small is None or not grid.size or prefix:
        return grid
    wanted = {diagram.x, diagram.y, *(name for one in diagram.derived for name in one.needs)}
    read = np.concatenate([np.empty(0), *(o.x for name, o in observed.items() if name in wanted)])
    read = read[(read > 0.0) & (read < grid.max())]
    if not read.size:
        return grid
    return np.unique(np.concatenate([grid, np.geomspace(read.min(), grid.max(), _CLOSER)]))


def _joined(pieces: Sequence[FloatArray]) -> FloatArray:
    """One array; nan between pieces, where no line is drawn."""
    parts = [part for piece in pieces for part in (piece, np.array([np.nan]))]
    return np.concatenate(parts[:-1])


def _stage(series: str) -> int:
    """Number of the stage of a series of one stage alone; 0 of others."""
    start, _, rest = series.partition("branch_")
    number = rest.partition(".")[0]
    return int(number) if not start and number.isdigit() else 0


def _series(prefix: str, diagram: Diagram, infos: Mapping[str, SeriesInfo]) -> str:
    return next(name for name in (f"{prefix}{diagram.y}", f"{prefix}{diagram.x}") if name in infos)


def _calculated(
    prefix: str,
    diagram: Diagram,
    model: ForwardModel,
    values: Mapping[str, float],
    infos: Mapping[str, SeriesInfo],
    grid: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    series = [f"{prefix}{name}" for name in (diagram.x, diagram.y)]
    with np.errstate(all="ignore"):
        found = model.prepare({name: grid for name in series if name in infos})(values)
    x, y = (np.asarray(found.get(name, grid), dtype=np.float64) for name in series)
    finite = np.isfinite(x) & np.isfinite(y)
    return x[finite], y[finite]
