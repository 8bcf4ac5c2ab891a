"""``geoswarm prune``: deletes old jobs for good."""

from __future__ import annotations

import click

from geoswarm.cli.databases import existing_store
from geoswarm.cli.options import SPAN, database_option, json_option
from geoswarm.cli.serve import logging_options, prepare
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import echo_json, echo_table, note, record_json
from geoswarm.records.states import ENDED_STATES

__all__ = ["prune_command"]

SHORTEST_ROUND = 1.0  # s


@click.command("prune")
@click.option("--older-than", type=SPAN, required=True, metavar="SPAN", help="Time since a job ended, e.g. 90d or 12h.")
@click.option(
    "--state", "states", type=click.Choice(ENDED_STATES), multiple=True, help="Only jobs that ended like this."
)
@click.option("--dry-run", is_flag=True, help="Only show what would be deleted.")
@click.option("--every", type=SPAN, metavar="SPAN", help="Repeat at this interval until Ctrl-C.")
@json_option
@database_option
@logging_options
def prune_command(
    older_than: float,
    states: tuple[str, ...],
    dry_run: bool,
    every: float | None,
    as_json: bool,
    database: str | None,
    log_level: str,
    log_format: str,
) -> None:
    """Delete old jobs permanently.

    Works on the database of a service, even while it runs. Deletes jobs that have ended, with everything that belongs
    to them, and frees the space. In an SQLite file, deleted data are overwritten; backups are not changed. With --every
    the command keeps running, for containers, which have no timer.
    """
    from geoswarm.workers.operations.retention import prune, run_prune
    from geoswarm.workers.settings import Settings

    if every is not None:
        if dry_run or as_json:
            raise BadInputError("--every runs until it is stopped and goes with neither --dry-run nor --json")
        if every < SHORTEST_ROUND:
            raise BadInputError(f"--every must be at least {SHORTEST_ROUND:g}s, for example 24h; got {every:g}s")
        settings = Settings.from_environment(database_url=database)
        prepare("prune", log_level, log_format, settings)
        note("geoswarm prune; Ctrl-C stops it.")
        run_prune(settings, older_than, states or ENDED_STATES, every)
        return
    store = existing_store(database)
    try:
        pruned = prune(store, older_than, states or ENDED_STATES, dry_run=dry_run)
    finally:
        store.close()
    if as_json:
        echo_json({"dry_run": dry_run, "items": [record_json(job) for job in pruned]})
        return
    if pruned:
        rows = [(job.id, job.name, job.state, str(job.evaluations)) for job in pruned]
        echo_table(None, ("id", "name", "state", "evaluations"), rows, right=(3,))
    verb = "would be deleted" if dry_run else "deleted"
    click.echo(f"{len(pruned)} {'job' if len(pruned) == 1 else 'jobs'} {verb}.")
