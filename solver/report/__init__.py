"""Figures, tables and reports from results.

==================  ====================================================================
``build``           :class:`Report`: statistics, figures, HTML and PDF of one run
``record``          what a report tells of a run, wherever it was
``folder``          a run from the files of ``geoswarm run --output``
``run_folder``      those files, written as a run goes, and what a run that was cut off goes on from
``curves``          measured and calculated series in the units that the user gave
``tables``          result, evaluations and generations as JSON and CSV files
``uncertainty*``    what follow-ups and a posterior sample have found
``content``         what stands in a report, in order
``html``, ``pdf``   its two forms (need the ``plots`` extra)
``figures``         the figures of a run by name
``*_plot``          one module a figure (matplotlib, without a display and its global state)
``style``           palette, sizes, files
==================  ====================================================================
"""

from __future__ import annotations

from geoswarm.solver.report.build import Report, linearise_here, linearise_stored, report_of_result
from geoswarm.solver.report.curves import (
    SeriesCurve,
    SeriesShare,
    initial_values,
    objective_unit,
    series_curves,
    series_shares,
)
from geoswarm.solver.report.figures import FigureSet
from geoswarm.solver.report.folder import report_of_folder, run_of_folder
from geoswarm.solver.report.folder_findings import findings_of_folder
from geoswarm.solver.report.record import BestFit, RunRecord, record_of_result
from geoswarm.solver.report.reweighted import reweighted_document
from geoswarm.solver.report.style import figures_available, png_of, save_figure, svg_of
from geoswarm.solver.report.tables import (
    write_evaluations,
    write_generations,
    write_problem,
    write_responses,
    write_result,
)
from geoswarm.solver.report.uncertainty import NOTHING_FURTHER, Uncertainty

__all__ = [
    "NOTHING_FURTHER",
    "BestFit",
    "FigureSet",
    "Report",
    "RunRecord",
    "SeriesCurve",
    "SeriesShare",
    "Uncertainty",
    "figures_available",
    "findings_of_folder",
    "initial_values",
    "linearise_here",
    "linearise_stored",
    "objective_unit",
    "png_of",
    "record_of_result",
    "report_of_folder",
    "report_of_result",
    "reweighted_document",
    "run_of_folder",
    "save_figure",
    "series_curves",
    "series_shares",
    "svg_of",
    "write_evaluations",
    "write_generations",
    "write_problem",
    "write_responses",
    "write_result",
]
