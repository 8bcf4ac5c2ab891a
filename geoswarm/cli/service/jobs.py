"""``geoswarm list``, ``show``, ``cancel``, ``pause``, ``resume`` and ``workers``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Literal

import click

from geoswarm.cli.options import connection_options, job_argument, json_option
from geoswarm.cli.service.connection import connect, find_job
from geoswarm.cli.words.output import (
    duration,
    echo_facts,
    echo_json,
    echo_table,
    note,
    number,
    reasons_in_words,
    record_json,
    root_mean_square,
    with_unit,
)
from geoswarm.cli.words.result import show_fit, show_values, values_json
from geoswarm.records.states import JOB_STATES

if TYPE_CHECKING:
    from geoswarm.client import Client, Job
    from geoswarm.solver.problem import Problem

__all__ = [
    "cancel_command",
    "list_command",
    "pause_command",
    "problem_of",
    "resume_command",
    "show_command",
    "show_job",
    "statistics_of",
    "workers_command",
]


def _searches(method: str) -> bool:
    """Whether a method of the service, which need not be installed here, is a search."""
    from geoswarm.solver.methods.registry import UnknownMethodError, find_method

    try:
        return find_method(method).role == "search"
    except UnknownMethodError:
        return False


def _age(moment: datetime) -> str:
    return duration(max((datetime.now(UTC) - moment).total_seconds(), 0.0))


@click.command("list")
@click.option("--state", type=click.Choice(JOB_STATES), help="Only jobs in this state.")
@click.option("--tag", help="Only jobs with this tag.")
@click.option("--limit", type=click.IntRange(1, 200), default=20, show_default=True, help="Number of jobs.")
@click.option("--cursor", help="Where to continue: 'next_cursor' of the previous page.")
@json_option
@connection_options
def list_command(
    state: str | None, tag: str | None, limit: int, cursor: str | None, as_json: bool, url: str, api_key: str | None
) -> None:
    """List jobs, newest first."""
    with connect(url, api_key) as client:
        page = client.list(state=state, tag=tag, limit=limit, cursor=cursor)
    if as_json:
        echo_json({"items": [record_json(job) for job in page.items], "next_cursor": page.next_cursor})
        return
    if not page.items:
        found = [f"is {state}"] * (state is not None) + [f"has the tag {tag!r}"] * (tag is not None)
        click.echo(f"No job {' and '.join(found)}." if found else "No jobs.")
        return
    rows = [
        (j.id, j.name, j.state, _count(j), number(j.objective), duration(j.seconds), _age(j.created_at))
        for j in page.items
    ]
    columns = ("id", "name", "state", "evaluations", "objective", "running time", "age")
    echo_table(None, columns, rows, right=(3, 4, 5, 6))
    if page.next_cursor is not None:
        click.echo(f"More: --cursor {page.next_cursor}")


@click.command("show")
@job_argument
@click.option("--failures", is_flag=True, help="Why evaluations failed: parameters, message, end of the output.")
@click.option("--attempts", metavar="GENERATION/PARTICLE", help="Every attempt at one evaluation.")
@json_option
@connection_options
def show_command(job: str, failures: bool, attempts: str | None, as_json: bool, url: str, api_key: str | None) -> None:
    """Show a job with its best parameters.

    With --json also 'best': the best evaluation with misfits and responses in base units, or null; 'diversity': how
    widely the particles of the last generation are scattered, or null; 'intervals' (95 %) and 'verdicts' by parameter,
    'fit' and 'shares' of the series, null before a search is finished; with --failures
    'failures': how many for which 'reasons', and the first 20 as 'items'; with --attempts 'attempts'.
    """
    from geoswarm.cli.service.failures import attempts_of, failures_of, show_attempts, show_failures
    from geoswarm.client import NotFoundError

    more: dict[str, Any] = {}
    with connect(url, api_key) as client:
        found = find_job(client, job)
        if attempts is not None:
            tries = attempts_of(client, found, attempts)
            more["attempts"] = [record_json(attempt) for attempt in tries]
        if failures:
            reasons, failed = failures_of(client, found)
            more["failures"] = {"reasons": dict(reasons), "items": [record_json(evaluation) for evaluation in failed]}
        last = client.generations(found.id, after=max(-1, found.generations - 2), limit=1, diversity=True)
        scatter = last[0].diversity if last and _searches(found.method) else None
        try:
            best = client.best(found.id)
        except NotFoundError:
            best = None
        problem = None if best is None or as_json else problem_of(client, found)
        statistics = statistics_of(client, found)
    if as_json:
        document = record_json(found) | {"best": best and record_json(best), "diversity": scatter}
        echo_json(document | values_json(statistics) | more)
        return
    show_job(found, diversity=scatter, problem=problem, statistics=statistics)
    if attempts is not None:
        show_attempts(tries)
    if failures:
        show_failures(reasons, failed)
    if more:
        return
    if best is not None:
        rows = _misfit_rows(problem, best.misfits)
        echo_table(None, ("series", "misfit", "root mean square"), rows, right=(1, 2))


def _misfit_rows(problem: Problem | None, misfits: Mapping[str, float | None]) -> list[tuple[str, str, str]]:
    """Series, misfit and root mean square."""
    from geoswarm.solver.problem.weighting import series_shares

    known = {series: misfit for series, misfit in misfits.items() if misfit is not None}
    if problem is None or len(known) < len(misfits):
        return [(series, number(misfit), "-") for series, misfit in misfits.items()]
    return [(share.series, number(share.misfit), root_mean_square(share)) for share in series_shares(problem, known)]


def problem_of(client: Client, job: Job) -> Problem | None:
    """The problem of a job, for units; None where this installation lacks its forward model."""
    from geoswarm.solver.errors import SolverError
    from geoswarm.solver.problem import parse_problem

    try:
        return parse_problem(client.problem(job.id))
    except SolverError:
        return None


def statistics_of(client: Client, job: Job) -> dict[str, Any] | None:
    """Statistics of a search that is finished, as plain JSON; None for other jobs."""
    from geoswarm.client import HttpError

    if job.state != "finished" or not _searches(job.method):
        return None
    try:
        return asdict(client.statistics(job.id))
    except HttpError as error:
        note(f"Note: there are no intervals and verdicts: {error}")
        return None


def show_job(
    job: Job,
    *,
    diversity: float | None = None,
    problem: Problem | None = None,
    statistics: Mapping[str, Any] | None = None,
) -> None:
    """Write what a job is and has found.

    Parameters
    ----------
    diversity
        Of its last generation, where it is known.
    problem
        For symbols and units; None where this installation lacks its forward model.
    statistics
        As plain JSON; None before a search is finished.
    """
    unit = ""
    if problem is not None:
        from geoswarm.solver.report.curves import objective_unit

        unit = objective_unit(problem)
    why = " (--failures says why)" if job.failed_evaluations else ""
    facts = {
        "id": job.id,
        "state": job.state,
        "forward model": job.forward_model,
        "method": job.method.replace("_", " "),
        "evaluations": f"{_count(job)} in {job.generations} generations, {job.failed_evaluations} failed{why}",
        "running time": duration(job.seconds),
        "stopped": reasons_in_words(job.stop_reasons),
        "seed": str(job.seed),
        "objective": with_unit(number(job.objective), unit),
    }
    if diversity is not None:
        facts["diversity"] = f"{number(diversity, 2)} (1: all over the space, 0: at one point)"
    if job.tags:
        facts["tags"] = ", ".join(job.tags)
    if job.note:
        facts["note"] = job.note
    if job.versions is not None:
        facts["versions"] = ", ".join(f"{name} {number}" for name, number in job.versions.items())
    if job.warnings:
        facts["warning"] = "; ".join(job.warnings)
    if job.error:
        facts["error"] = job.error
    echo_facts(job.name, facts)
    if job.parameters is not None and problem is not None and job.ended:
        if statistics is not None:
            show_fit(statistics["fit"])
        show_values(problem, job.parameters, statistics)
    elif job.parameters is not None:
        rows = [
            (name, number(value, 5), "" if name in job.free_parameters else "fixed or linked")
            for name, value in job.parameters.items()
        ]
        heading = "identified" if job.ended else "best so far"
        echo_table(None, ("parameter", heading, ""), rows, right=(1,))


def _count(job: Job) -> str:
    return (
        f"{job.evaluations}" if job.max_evaluations is None else f"{job.evaluations} of at most {job.max_evaluations}"
    )


def _change(action: Literal["cancel", "pause", "resume"], words: str) -> click.Command:
    """A command that changes a job; ``words`` are its help."""

    @click.command(action, help=words)
    @job_argument
    @json_option
    @connection_options
    def change(job: str, as_json: bool, url: str, api_key: str | None) -> None:
        with connect(url, api_key) as client:
            found = find_job(client, job)
            changed = getattr(client, action)(found.id)
        if as_json:
            echo_json(record_json(changed))
        else:
            click.echo(f"{changed.id} ({changed.name}) is {changed.state}")

    return change


cancel_command = _change("cancel", "Cancel a job; its finished evaluations are kept.")
pause_command = _change("pause", "Pause a job.")
resume_command = _change("resume", "Resume a paused job.")


@click.command("label")
@job_argument
@click.option("--name", metavar="TEXT", help="Name, instead of the previous one.")
@click.option("--tag", "tags", multiple=True, metavar="TAG", help="Tag, instead of all previous ones; may be repeated.")
@click.option("--no-tags", is_flag=True, help="Remove all tags.")
@click.option("--note", metavar="TEXT", help="Note in Markdown, instead of the previous one; '' removes it.")
@json_option
@connection_options
def label_command(
    job: str,
    name: str | None,
    tags: tuple[str, ...],
    no_tags: bool,
    note: str | None,
    as_json: bool,
    url: str,
    api_key: str | None,
) -> None:
    """Give a job another name, tags and a note, to find it again.

    'geoswarm list --tag TAG' lists the jobs with a tag, for example those of one project.
    """
    if tags and no_tags:
        raise click.UsageError("Give --tag or --no-tags, not both.")
    if not tags and not no_tags and note is None and name is None:
        raise click.UsageError("Nothing to change: give --name, --tag, --no-tags or --note.")
    with connect(url, api_key) as client:
        wanted = list(tags) if tags or no_tags else None
        changed = client.label(find_job(client, job).id, name=name, tags=wanted, note=note)
    if as_json:
        echo_json(record_json(changed))
    else:
        words = f"has the tags {', '.join(changed.tags)}" if changed.tags else "has no tags"
        click.echo(f"{changed.id} ({changed.name}) {words}{' and a note' if changed.note else ''}")


@click.command("workers")
@json_option
@connection_options
def workers_command(as_json: bool, url: str, api_key: str | None) -> None:
    """List the workers of a service.

    Shows what each worker runs, and since when. An id begins with host and process number.
    """
    with connect(url, api_key) as client:
        workers = client.workers()
    if as_json:
        echo_json({"items": [record_json(worker) for worker in workers]})
        return
    if not workers:
        click.echo("No workers. Start some with 'geoswarm worker' or 'geoswarm agent'.")
        return
    rows = [
        (
            w.id,
            w.engine,
            w.state,
            w.job or "-",
            "-" if w.generation is None else str(w.generation),
            "-" if w.evaluations is None else str(w.evaluations),
            "-" if w.busy_since is None else _age(w.busy_since),
            _age(w.started_at),
            _age(w.seen_at),
        )
        for w in workers
    ]
    columns = ("id", "engine", "state", "job", "generation", "evaluations", "busy for", "up for", "last seen")
    echo_table(None, columns, rows, right=(4, 5, 6, 7, 8))
