"""``geoswarm verify``: the verification cases on this machine, and the manual as pages."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.local.reports import figures_missing
from geoswarm.cli.options import json_option
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.kernels import all_ready
from geoswarm.cli.words.output import duration, echo_facts, echo_json, echo_table, note

if TYPE_CHECKING:
    from geoswarm.verification.case import Case
    from geoswarm.verification.run import CaseResult

__all__ = ["verify_command"]


@click.command("verify")
@click.argument("names", nargs=-1, metavar="[CASE ...]")
@click.option("--list", "listing", is_flag=True, help="List the cases with their sources and run none.")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder for the pages: index.html, Markdown with figures, results.json.",
)
@json_option
def verify_command(names: tuple[str, ...], listing: bool, output: Path | None, as_json: bool) -> None:
    """Verify this installation against closed forms and published numbers.

    Runs all cases, or those named by case or chapter, and prints a line for each: the check that is nearest to its
    allowed difference, with both values. Exit code 1 when one fails. It takes about a minute, and once after an
    installation another one to compile the kernels.
    """
    if output is not None and (missing := figures_missing("geoswarm verify --output")):
        raise BadInputError(missing)
    from geoswarm.verification.catalogue import UnknownCaseError, find_cases

    try:
        cases = find_cases(names)
    except UnknownCaseError as error:
        from geoswarm.solver.words import did_you_mean

        raise BadInputError(
            f"there is no case '{error.name}'{did_you_mean(error.name, error.known)}; geoswarm verify --list names them"
        ) from None
    if listing:
        _list(cases, as_json)
        return
    if output is not None:
        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInputError(f"--output {output}: {error.strerror}") from error
    if not names:
        all_ready()
    _run(cases, output, as_json)


def _list(cases: Sequence[Case], as_json: bool) -> None:
    if as_json:
        echo_json({"items": [{"name": one.name, "title": one.title, "source": one.source} for one in cases]})
        return
    echo_table(None, ("case", "what it verifies", "source"), [(one.name, one.title, one.source) for one in cases])


def _run(cases: Sequence[Case], output: Path | None, as_json: bool) -> None:
    from geoswarm.verification.provenance import provenance
    from geoswarm.verification.results import outcomes_json, summary
    from geoswarm.verification.run import run_cases

    where, outcomes = provenance(), []
    width = max(len(one.name) for one in cases)
    if not as_json:
        click.echo(
            f"{'case':<{width}}  {'ours':>13}  {'reference':>13}  {'difference':>10}  {'allowed':>8}      quantity"
        )
    for outcome in run_cases(cases):
        outcomes.append(outcome)
        if not as_json:
            click.echo(_line(outcome, width))
    page = None
    if output is not None:
        from geoswarm.verification.pages import write_pages

        page = write_pages(outcomes, where, output)
    if as_json:
        echo_json(outcomes_json(outcomes, where))
    else:
        facts = {"result": summary(outcomes), "time": duration(sum(one.seconds for one in outcomes))}
        echo_facts(None, facts | ({} if page is None else {"pages": str(page)}))
    failed = [one.case.name for one in outcomes if one.state == "fails"]
    if failed:
        raise FailedRunError(f"{summary(outcomes)}: {', '.join(failed)}")
    if any(one.state == "left out" for one in outcomes):
        note("What was left out needs an extra; its line names it.")


def _line(outcome: CaseResult, width: int) -> str:
    """One line: the worst check with both values, or why there is none."""
    from geoswarm.verification.results import check_row

    state = {"holds": "ok", "fails": "FAIL", "left out": "-"}[outcome.state]
    name = f"{outcome.case.name:<{width}}"
    if outcome.worst is None:
        return f"{name}  {state}: {outcome.problem}"
    row = check_row(outcome.worst, plain=True)
    difference, _, over = row.difference.partition(" ")
    allowed = row.allowed.partition(" ")[0]
    quantity = row.quantity + (f", {over}" if over else "")
    return f"{name}  {row.ours:>13}  {row.reference:>13}  {difference:>10}  {allowed:>8}  {state:<4}  {quantity}"
