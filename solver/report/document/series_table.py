"""The table of the series in the objective, with the shares of their tests."""

from __future__ import annotations

from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.weighting import by_test, series_shares, weight_shares
from geoswarm.solver.report.curves import objective_unit
from geoswarm.solver.report.document.parts import Table
from geoswarm.solver.report.record import BestFit
from geoswarm.solver.words import number

__all__ = ["series_table"]


def series_table(problem: Problem, best: BestFit) -> Table:
    """Return a line for each series; of several tests with the share of its test."""
    unit, shares = objective_unit(problem), series_shares(problem, best.misfits)
    tests = by_test(shares)
    counted = [one.readings for one in weight_shares(problem)] if problem.weighting == "by_error" else []
    rows = [
        (
            s.series,
            number(s.weight),
            number(s.misfit),
            _percent(s.share),
            *((_percent(tests[s.test]),) if tests else ()),
            f"{number(s.root_mean_square, 3)} {s.unit}".rstrip(),
            *((number(counted[place]),) if counted else ()),
        )
        for place, s in enumerate(shares)
    ]
    misfit = f"misfit f′ [{unit}]" if unit else "misfit f′ [(unit of the series)²]"
    of_test = ("share of its test",) if tests else ()
    readings = ("independent readings",) if counted else ()
    columns = ("series", "weight w", misfit, "share of the objective", *of_test, "root mean square", *readings)
    losses = ", ".join(f"{o.series} ({o.loss.kind})" for o in problem.observations if o.loss is not None)
    note = f"Of series with a loss, the root of the mean loss: {losses}." if losses else ""
    title = "Series in the objective of the best evaluation"
    return Table(title, columns, tuple(rows), tuple(range(1, len(columns))), note)


def _percent(share: float) -> str:
    return f"{share:.1%}".replace("%", " %")
