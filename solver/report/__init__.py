"""Figures and tables from results.

==============  =====================================================================
``curves``      measured and calculated series in the units that the user gave
``figures``     fit and convergence (needs the ``plots`` extra: matplotlib)
``tables``      result, evaluations and generations as JSON and CSV files
==============  =====================================================================
"""

from __future__ import annotations

from solver.report.curves import SeriesCurve, SeriesShare, objective_unit, series_curves, series_shares
from solver.report.figures import convergence_figure, figures_available, fit_figure, save_figure
from solver.report.tables import write_evaluations, write_generations, write_problem, write_result

__all__ = [
    "SeriesCurve",
    "SeriesShare",
    "convergence_figure",
    "figures_available",
    "fit_figure",
    "objective_unit",
    "save_figure",
    "series_curves",
    "series_shares",
    "write_evaluations",
    "write_generations",
    "write_problem",
    "write_result",
]
