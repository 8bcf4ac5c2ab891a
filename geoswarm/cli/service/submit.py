"""``geoswarm submit`` and ``watch``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.options import (
    accept_option,
    accepting,
    connection_options,
    job_argument,
    json_option,
    problem_argument,
)
from geoswarm.cli.service.connection import connect, find_job
from geoswarm.cli.service.hooks import add_hook, tell_secret
from geoswarm.cli.service.jobs import problem_of, show_job, statistics_of
from geoswarm.cli.service.progress import progress_bar
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.kernels import note_event
from geoswarm.cli.words.output import echo_json, note, record_json

if TYPE_CHECKING:
    from geoswarm.client import Client, Event, Job, NewHook

__all__ = ["follow", "submit_command", "watch_command"]

_NAMED = 3


@click.command("submit")
@problem_argument
@click.option("--watch", is_flag=True, help="Follow the job until it ends, as 'geoswarm watch' does.")
@click.option(
    "--idempotency-key",
    metavar="KEY",
    help="Submitting again with the same key and problem gives the same job instead of a second one.",
)
@click.option(
    "--warm-start",
    "earlier",
    multiple=True,
    metavar="ID",
    help="Earlier job with the same forward model; the search learns from its runs. May be repeated.",
)
@click.option(
    "--notify",
    multiple=True,
    metavar="ADDRESS",
    help="Address to notify when the job ends: https://... or an e-mail address; may be repeated.",
)
@accept_option
@json_option
@connection_options
def submit_command(
    problem: Path,
    watch: bool,
    idempotency_key: str | None,
    earlier: tuple[str, ...],
    notify: tuple[str, ...],
    accept: tuple[str, ...],
    as_json: bool,
    url: str,
    api_key: str | None,
) -> None:
    """Submit a problem as a job.

    Data files that the problem names are read here and sent along. Prints the job's id. Earlier jobs with the same
    forward model, whose stored evaluations the search could have learnt from, are named.
    """
    with connect(url, api_key) as client:
        if earlier:
            given: Path | dict[str, Any] = _learning_from([find_job(client, one).id for one in earlier], problem)
        else:
            given = problem
            _tell_of_earlier(client, problem)
        if accept:
            given = _accepting(accept, given)
        job = client.submit(given, idempotency_key=idempotency_key)
        for target in notify:  # a job that has ended meanwhile is announced at once
            tell_secret(_hooked(client, target, job))
        if watch:
            note(f"Job {job.id}; Ctrl-C stops watching; the job continues.")
            _end(client, follow(client, job), as_json)
        elif as_json:
            echo_json(record_json(job))
        else:
            click.echo(job.id)


def _hooked(client: Client, target: str, job: Job) -> NewHook:
    try:
        return add_hook(client, target, job.id)
    except BadInputError as error:
        raise BadInputError(f"job {job.id} is submitted, but its end will not be announced: {error}") from error


def _learning_from(jobs: list[str], problem: Path) -> dict[str, Any]:
    from geoswarm.solver.problem import load_problem

    return load_problem(problem).document() | {"warm_start": {"jobs": jobs}}


def _accepting(series: tuple[str, ...], problem: Path | dict[str, Any]) -> dict[str, Any]:
    from geoswarm.solver.problem.draft import inlined_document

    return accepting(series)(problem if isinstance(problem, dict) else inlined_document(problem))


def _tell_of_earlier(client: Client, problem: Path) -> None:
    """Name, in one remark, the jobs that the search could learn from."""
    found = client.warm_starts(problem)
    if not found:
        return
    named = ", ".join(f"{one.job} ({one.name}, {one.evaluations} evaluations)" for one in found[:_NAMED])
    more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    note(
        f"The search could learn from stored evaluations of the same forward model: {named}{more}. "
        f"To do so: geoswarm submit {problem} --warm-start {found[0].job}"
    )


@click.command("watch")
@job_argument
@json_option
@connection_options
def watch_command(job: str, as_json: bool, url: str, api_key: str | None) -> None:
    """Follow a job until it ends.

    Exit code 0 when it finished, 1 when it failed or was cancelled. Ctrl-C stops watching; the job continues.
    """
    with connect(url, api_key) as client:
        _end(client, follow(client, find_job(client, job)), as_json)


def follow(client: Client, job: Job) -> Job:
    """Show the progress of a job until it ends; return how it ended."""
    from geoswarm.client import JobFailedError

    with progress_bar(job.name, job.max_evaluations) as update:
        update(job.evaluations, job.generations, job.objective, job.search_evaluations, job.answer_evaluations)

        def on_event(event: Event) -> None:
            if event.kind == "generation":
                told = event.data
                stage = told.get("search_evaluations"), told.get("answer_evaluations")  # none in events of 0.1
                update(told["evaluations"], told["number"], told["objective"], *stage)
            elif event.kind == "versions":
                note(f"Warning: {event.data['message']}")
            elif event.kind == "kernels":
                note_event(event.data)

        try:
            return client.wait(job.id, on_event=on_event)
        except JobFailedError as error:
            return error.job


def _end(client: Client, job: Job, as_json: bool) -> None:
    """Write how a job ended; of a search that finished, its values with intervals and verdicts."""
    if as_json:
        echo_json(record_json(job))
    else:
        show_job(job, problem=problem_of(client, job), statistics=statistics_of(client, job))
    if job.state != "finished":
        raise FailedRunError(f"job {job.id} {job.state}: {job.error}" if job.error else f"job {job.id} was {job.state}")
