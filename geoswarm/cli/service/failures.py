"""Why evaluations failed, and another try: ``geoswarm show ID --failures``, ``--attempts`` and ``retry-failed``."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.options import connection_options, job_argument, json_option
from geoswarm.cli.service.connection import connect, find_job
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import duration, echo_json, echo_table, number, record_json
from geoswarm.solver.words import visible

if TYPE_CHECKING:
    from geoswarm.client import Attempt, Client, Evaluation, Job

__all__ = ["attempts_of", "failures_of", "retry_failed_command", "show_attempts", "show_failures"]

MOST_SHOWN = 20
LOG_LINES = 8


def failures_of(client: Client, job: Job) -> tuple[Counter[str], list[Evaluation]]:
    """Return the number of failed evaluations by reason, and the first of them."""
    failed = client.iterate_evaluations(job.id, state="failed")
    shown = list(itertools.islice(failed, MOST_SHOWN))
    reasons = Counter(evaluation.reason or "unknown" for evaluation in itertools.chain(shown, failed))
    return reasons, shown


def show_failures(reasons: Counter[str], failed: list[Evaluation]) -> None:
    """Write why evaluations failed: how many for which reason, then each with its parameters, message and output."""
    if not failed:
        click.echo("No evaluation has failed.")
        return
    echo_table("failures", ("reason", "evaluations"), [(r, str(n)) for r, n in reasons.most_common()], right=(1,))
    for evaluation in failed:
        place = f"generation {evaluation.generation}, particle {evaluation.particle}"
        tries = f", {evaluation.attempts} tries" if evaluation.attempts > 1 else ""
        click.secho(f"{place}: {evaluation.reason} after {duration(evaluation.seconds)}{tries}", bold=True)
        click.echo("  " + ", ".join(f"{name} = {number(value, 5)}" for name, value in evaluation.parameters.items()))
        if evaluation.message:
            click.echo(f"  {visible(evaluation.message)}")
        _echo_log(evaluation.log)
    hidden = reasons.total() - len(failed)
    if hidden:
        click.echo(f"{hidden} more: 'geoswarm export ID' writes all evaluations.")


def attempts_of(client: Client, job: Job, place: str) -> tuple[Attempt, ...]:
    """Return the tries at the evaluation ``GENERATION/PARTICLE``.

    Raises
    ------
    BadInputError
        When the place is not written like this, or there is no such evaluation.
    """
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", place)
    if match is None:
        raise BadInputError(f"--attempts {place!r}: write GENERATION/PARTICLE, for example 0/3")
    tries = client.attempts(job.id, int(match[1]), int(match[2]))
    if not tries:
        raise BadInputError(f"job {job.id} has not begun an evaluation {place} (generation/particle)")
    return tries


def show_attempts(tries: tuple[Attempt, ...]) -> None:
    """Write every try at an evaluation."""
    rows = [
        (
            str(t.number),
            f"{t.outcome}, counted" if t.counted else t.outcome,
            t.worker or "-",
            "-" if t.started_at is None else t.started_at.isoformat(sep=" ", timespec="seconds"),
            duration((t.finished_at - t.started_at).total_seconds()) if t.started_at and t.finished_at else "-",
            t.message or "",
        )
        for t in tries
    ]
    echo_table(None, ("try", "outcome", "worker", "began (UTC)", "took", "message"), rows, right=(0, 4))
    for t in tries:
        if t.log:
            click.echo(f"try {t.number} wrote:")
            _echo_log(t.log)


def _echo_log(log: str | None) -> None:
    lines = (log or "").rstrip().splitlines()
    for line in lines[-LOG_LINES:]:
        click.echo(f"  | {visible(line)}")


@click.command("retry-failed")
@job_argument
@json_option
@connection_options
def retry_failed_command(job: str, as_json: bool, url: str, api_key: str | None) -> None:
    """Rerun the failed evaluations of a job.

    And only them. The job must be paused or have ended. Positions that the search has proposed stay as they are; the
    best evaluation and the counts may change.
    """
    with connect(url, api_key) as client:
        retry = client.retry_failed(find_job(client, job).id)
    if as_json:
        data: dict[str, Any] = {"evaluations": retry.evaluations, "job": record_json(retry.job)}
        echo_json(data)
        return
    when = "when it is resumed" if retry.job.state == "paused" else "now"
    count = f"{retry.evaluations} failed evaluation" + ("" if retry.evaluations == 1 else "s")
    click.echo(f"{count} of {retry.job.id} ({retry.job.name}) run again {when}")
