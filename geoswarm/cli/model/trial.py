"""``geoswarm model try``: one run of a program, with what was written and the lines that each number was read from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.local.evaluate import given_values, parameter_values
from geoswarm.cli.options import json_option, problem_argument, values_option
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError, facts_of_run
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, number

if TYPE_CHECKING:
    from geoswarm.solver.external.trial import SeriesTrial, TrialRun
    from geoswarm.solver.problem import Problem

__all__ = ["echo_run", "try_command"]

_ROWS = 12
_LONGEST = 100


@click.command("try")
@problem_argument
@values_option("Value of a free or fixed parameter, else 'initial', or the middle of the bounds")
@click.option("--all", "whole", is_flag=True, help=f"Show all points of each series, not the first {_ROWS} only.")
@json_option
def try_command(problem: Path, given: tuple[str, ...], whole: bool, as_json: bool) -> None:
    """Run the program of a problem once, and show what it read and wrote.

    Shows for each point of a series the line of the file that it was read from. The run folder is kept. Exit code 1
    when the run fails.
    """
    from geoswarm.solver.calibration import Calibration
    from geoswarm.solver.external.trial import watched
    from geoswarm.solver.problem import load_problem

    loaded = load_problem(problem)
    calibration = Calibration(loaded, loaded.seed or 0)
    values = _values(loaded, calibration, given)
    with watched() as runs:
        evaluation = calibration.evaluate_values(values)
    if not runs:
        kind = loaded.forward_model.kind
        raise BadInputError(f"{problem}: kind: {kind} runs no program; geoswarm evaluate shows what it calculates")
    if as_json:
        echo_json({"parameters": values, "runs": [_document(run) for run in runs], "reason": evaluation.reason})
    else:
        echo_table(
            None, ("parameter", "value"), [(name, f"{value:.10g}") for name, value in values.items()], right=(1,)
        )
        for run in runs:
            echo_run(run, whole=whole)
    if evaluation.reason is not None:
        raise FailedRunError(f"the run failed ({evaluation.reason}): {evaluation.message}")


def _values(problem: Problem, calibration: Any, given: tuple[str, ...]) -> dict[str, float]:
    """Given values, else initial ones, else the middle of the bounds."""
    from geoswarm.solver.methods.base import by_name
    from geoswarm.solver.runs.check import middle

    free = by_name(calibration.space, middle(calibration))
    return parameter_values(problem, {**free, **given_values(problem, given)})


def echo_run(run: TrialRun, *, whole: bool) -> None:
    """Show a run: what was written, printed and read; ``whole``: all points, not the first of each series."""
    echo_facts("Run", facts_of_run(run))
    if run.printed.strip():
        click.echo("  it printed:")
        for line in run.printed.rstrip().splitlines()[-_ROWS:]:
            click.echo(f"    {line}")
    for series in run.series:
        _show_series(series, whole)


def _show_series(series: SeriesTrial, whole: bool) -> None:
    title = f"{series.name}, from {series.file}"
    if series.error is not None:
        echo_facts(title, {"not read": series.error})
        return
    shown = len(series.x) if whole else min(len(series.x), _ROWS)
    rows = [
        (number(float(x), 8), number(float(y), 8), str(line) if line else "-", text[:_LONGEST])
        for x, y, (line, text) in list(zip(series.x, series.y, series.lines, strict=True))[:shown]
    ]
    columns = (f"x [{series.x_unit}]", f"y [{series.y_unit}]", "line", "read from")
    echo_table(title, columns, rows, right=(0, 1, 2))
    if shown < len(series.x):
        click.echo(f"  ... and {len(series.x) - shown} more points (--all shows them)")


def _document(run: TrialRun) -> dict[str, Any]:
    return {
        "call": list(run.call),
        "folder": str(run.folder),
        "written": list(run.written),
        "made": list(run.made),
        "ended": run.ended,
        "printed": run.printed,
        "failure": run.failure,
        "series": {
            one.name: {
                "file": one.file,
                "x": one.x.tolist(),
                "y": one.y.tolist(),
                "x_unit": one.x_unit,
                "y_unit": one.y_unit,
                "lines": [[line, text] for line, text in one.lines],
                "error": one.error,
            }
            for one in run.series
        },
    }
