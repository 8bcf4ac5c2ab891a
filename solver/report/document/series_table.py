"""The tables of the series in the objective: with the shares of their tests, and beside another set of parameters."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.weighting import SeriesShare, by_test, series_shares, weight_shares
from geoswarm.solver.report.compared import Compared
from geoswarm.solver.report.curves import objective_unit
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.report.record import BestFit
from geoswarm.solver.units import convert
from geoswarm.solver.words import number, per_cent

__all__ = ["comparison_table", "series_table"]


def series_table(problem: Problem, best: BestFit) -> Table:
    """Return a line for each series; of several tests with the share of its test."""
    unit, shares = objective_unit(problem), series_shares(problem, best.misfits)
    tests, largest = by_test(shares), _largest(problem, best)
    counted = [one.readings for one in weight_shares(problem)] if problem.weighting == "by_error" else []
    rows = [
        (
            s.series,
            number(s.weight),
            number(s.misfit),
            _percent(s.share),
            *((_percent(tests[s.test]),) if tests else ()),
            _deviation(s),
            largest[s.series],
            *((number(counted[place]),) if counted else ()),
        )
        for place, s in enumerate(shares)
    ]
    misfit = f"misfit f′ [{unit}]" if unit else "misfit f′ [(unit of the series)²]"
    of_test = ("share of its test",) if tests else ()
    columns = ("series", "weight w", misfit, "share of the objective", *of_test, "root mean square", "largest")
    columns += ("independent readings",) if counted else ()
    losses = ", ".join(f"{o.series} ({o.loss.kind})" for o in problem.observations if o.loss is not None)
    note = "Largest: calculated less measured, where it is furthest from 0."
    note += _of_distances(problem)
    note += f" Of series with a loss, the root of the mean loss: {losses}." if losses else ""
    title = "Series in the objective of the best evaluation"
    return Table(title, columns, tuple(rows), tuple(range(1, len(columns))), note)


def comparison_table(problem: Problem, best: BestFit, compared: Compared) -> Table:
    """Return a line for each series with its share and residuals by the best evaluation and by another set."""
    sides = [(series_shares(problem, fit.misfits), _largest(problem, fit)) for fit in (best, compared.fit)]
    rows = tuple(
        (
            o.series,
            *(
                cell
                for shares, largest in sides
                for cell in (_percent(shares[place].share), _deviation(shares[place]), largest[o.series])
            ),
        )
        for place, o in enumerate(problem.observations)
    )
    words, unit = ("share", "root mean square", "largest"), objective_unit(problem)
    columns = ("series", *words, *(f"{compared.name}: {word}" for word in words))
    both = [f"{number(fit.objective)} {unit}".rstrip() for fit in (best, compared.fit)]
    values = ", ".join(f"{name} {number(value)}" for name, value in compared.fit.parameters.items())
    note = f"Objective {both[0]} of the best evaluation, {both[1]} of {compared.name} ({values})."
    note += _of_distances(problem)
    return Table(f"Compared with {compared.name}", columns, rows, tuple(range(1, len(columns))), note)


def _of_distances(problem: Problem) -> str:
    """Which residuals are distances."""
    series = ", ".join(o.series for o in problem.observations if o.along is not None)
    return f" Distances from the calculated curve, x and y in parts of their ranges: {series}." if series else ""


def _largest(problem: Problem, fit: BestFit) -> dict[str, str]:
    """The largest residual of each series, in the unit of its readings."""
    base = {info.name: info.y_unit for info in problem.model.series}
    found = {}
    for o in problem.observations:
        residuals, unit = o.residuals(np.asarray(fit.responses[o.series])), o.y_unit or base[o.series]
        found[o.series] = _with_unit(
            float(convert(residuals[np.argmax(np.abs(residuals))], base[o.series], unit)), unit
        )
    return found


def _deviation(share: SeriesShare) -> str:
    return _with_unit(share.root_mean_square, share.unit)


def _with_unit(value: float, unit: str) -> str:
    return f"{number(value, 3)} {'' if unit == 'dimensionless' else unit}".rstrip()


def _percent(share: float) -> str:
    return per_cent(share)
