"""How the verdict on the fit is shown: before every result that does not hold without it."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.words.output import note

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.report.document.build import Report
    from geoswarm.solver.result import CalibrationResult

__all__ = ["fit_of_run", "interval_heading", "show_fit"]

_WIDTH = 100


def fit_of_run(problem: Problem, result: CalibrationResult, report: Report | None) -> dict[str, Any] | None:
    """Return the verdict on the fit: the report's, else from the runs of the search; None where nothing succeeded."""
    from geoswarm.solver.calibration import Calibration
    from geoswarm.solver.identifiability import Samples
    from geoswarm.solver.identifiability.stored.findings import follow_up_of
    from geoswarm.solver.identifiability.stored.stored_fit import fit_of_samples
    from geoswarm.solver.report.jsonable import jsonable

    if result.best is None or follow_up_of(problem) is not None:
        return None
    if report is not None and report.statistics is not None:
        found = report.statistics.fit
    else:
        found = fit_of_samples(Calibration(problem, result.seed), Samples.from_result(problem, result))
    document: dict[str, Any] = jsonable(found.to_json())
    return document


def show_fit(fit: Mapping[str, Any] | None) -> None:
    """Write what is wrong with the fit, and what to do, to stdout; a fit that could not be tested is a note."""
    if fit is None or fit["kind"] == "describes":
        return
    if fit["kind"] == "untested":
        note(f"Note: {fit['sentence']}")
        return
    click.secho(fit["headline"].upper(), bold=True, fg="red")
    click.echo(textwrap.fill(fit["sentence"], _WIDTH, initial_indent="  ", subsequent_indent="  "))
    click.echo("  What to do:")
    for number, remedy in enumerate(fit["remedies"], 1):
        click.echo(textwrap.fill(remedy, _WIDTH, initial_indent=f"  {number}. ", subsequent_indent="     "))


def interval_heading(level: float, fit: Mapping[str, Any] | None) -> tuple[str, str]:
    """Headings of the two ends of an interval; they say where it does not hold."""
    from geoswarm.solver.identifiability.misfits import SHORT

    doubt = SHORT.get("" if fit is None else fit["kind"], "")
    return f"{level:.0%} from" + (f" ({doubt})" if doubt else ""), "to"
