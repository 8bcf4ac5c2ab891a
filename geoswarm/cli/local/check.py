"""``geoswarm check``: validate a problem, run it once and estimate its cost."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.options import accept_option, accepting, json_option, problem_argument
from geoswarm.cli.words.error_messages import FailedRunError, facts_of_run, warn_of_many_points
from geoswarm.cli.words.kernels import ready
from geoswarm.cli.words.output import duration, echo_facts, echo_json, echo_table, note, number
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from geoswarm.solver.external.trial import TrialRun
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.runs.check import CheckReport

__all__ = ["check_command"]


@click.command("check")
@problem_argument
@accept_option
@json_option
def check_command(problem: Path, accept: tuple[str, ...], as_json: bool) -> None:
    """Validate a problem, run it once and estimate its cost.

    Every mistake in the file is listed with its path. The test run uses the 'initial' values of the free parameters
    and the middle of the bounds of those without. Exit code 1 when the test run fails, 2 when the problem has mistakes.
    """
    from geoswarm.solver.problem import load_problem

    loaded = load_problem(problem, accepting(accept))
    from geoswarm.solver.external.trial import watched
    from geoswarm.solver.runs.check import check_problem  # after a mistake in the problem is reported

    compile_seconds = ready(loaded)
    warn_of_many_points(loaded)
    with watched() as runs:
        check = check_problem(loaded)
    if as_json:
        echo_json({"valid": True, **asdict(check), "compile_seconds": compile_seconds})
    else:
        _show(loaded, check)
        for run in runs:
            _show_program(run)
    if check.test_run.reason is not None:
        raise FailedRunError(f"the test run failed ({check.test_run.reason}): {check.test_run.message}")


def _show_program(run: TrialRun) -> None:
    """What a program of the user's wrote, and what was read of it."""
    read = {
        f"read {one.name}": one.error
        or f"{len(one.x)} points of {one.file}, x from {number(float(one.x.min()))} to {number(float(one.x.max()))} "
        f"{one.x_unit}"
        for one in run.series
    }
    echo_facts("Program", facts_of_run(run) | read)


def _show(problem: Problem, check: CheckReport) -> None:
    from geoswarm.cli.words.output import parameter_rows, root_mean_square, with_unit
    from geoswarm.solver.problem.weighting import by_test, series_shares
    from geoswarm.solver.report.curves import objective_unit

    run = check.test_run
    shares = series_shares(problem, run.misfits) if run.misfits else []
    rms = [f"{one.series} {root_mean_square(one)}" for one in shares]
    planned = check.planned_evaluations
    cost = "not limited by a number of evaluations"
    if planned is not None:
        cost = f"at most {planned} evaluations"
        if check.estimated_seconds is not None:
            cost += f", about {duration(check.estimated_seconds)} on one worker, the search's own time included"
            cost += " but not report and figures"
        if check.left_to_answer:
            cost += f"; the search leaves {check.left_to_answer} of them for minimum and intervals"
    echo_facts(
        f"{check.name}: valid",
        {
            "forward model": check.forward_model,
            "method": check.method.replace("_", " "),
            "free parameters": ", ".join(check.free_parameters),
            "measured points": f"{check.data_points}{_left_out(problem)}",
            **{f"readings of {o.series}": "; ".join(o.notes) for o in problem.observations if o.notes},
            **({"assumed": " ".join(check.assumptions)} if check.assumptions else {}),
            "test run": f"{run.state} in {duration(run.seconds)}",
            "objective there": with_unit(number(run.objective), objective_unit(problem)),
            **({"root mean square": ", ".join(rms)} if rms else {}),
            "cost": cost,
        },
    )
    for warning in check.warnings:
        note(f"Warning: {warning}")
    if len(check.shares) > 1:
        tests, counted = by_test(check.shares), any(one.readings is not None for one in check.shares)
        rows = [
            (
                one.series,
                number(one.weight),
                per_cent(round(one.share, 9)),
                *((per_cent(round(tests[one.test], 9)),) if tests else ()),
                *((number(one.readings),) if counted else ()),
            )
            for one in check.shares
        ]
        more = [name for name, shown in (("of its test", tests), ("readings", counted)) if shown]
        columns = ("series", "weight", "share", *more)
        echo_table("Shares", columns, rows, right=tuple(range(1, len(columns))))
        echo_facts(None, {"shares": "of the objective, if every series is missed by the same part of its range"})
    echo_table("Test run", ("parameter", "", "value", "unit"), parameter_rows(problem, run.parameters), right=(2,))


def _left_out(problem: Problem) -> str:
    count = sum(observation.left_out for observation in problem.observations)
    gross = sum(observation.gross_x.size for observation in problem.observations)
    which = f", {gross} of them as gross errors" if gross else ""
    return f" ({count} more take no part{which})" if count else ""
