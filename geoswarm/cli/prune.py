"""``geoswarm prune``: deletes old jobs for good."""

from __future__ import annotations

import click

from geoswarm.cli.databases import existing_store
from geoswarm.cli.jobs import jsonable
from geoswarm.cli.options import database_option, json_option
from geoswarm.cli.output import echo_json, echo_table
from geoswarm.cli.spans import SPAN

__all__ = ["prune_command"]

ENDED = ("finished", "failed", "cancelled")


@click.command("prune")
@click.option("--older-than", type=SPAN, required=True, metavar="SPAN", help="Time since a job ended, e.g. 90d or 12h.")
@click.option("--state", "states", type=click.Choice(ENDED), multiple=True, help="Only jobs that ended like this.")
@click.option("--dry-run", is_flag=True, help="Only show what would be deleted.")
@json_option
@database_option
def prune_command(
    older_than: float, states: tuple[str, ...], dry_run: bool, as_json: bool, database: str | None
) -> None:
    """Delete old jobs for good.

    Works on the database of a service, which may run meanwhile. Deleted are jobs that ended, with everything that
    belongs to them; then the space is given back. Deleted data are overwritten in an SQLite file; backups are not
    touched.
    """
    from geoswarm.workers.retention import prune

    store = existing_store(database)
    try:
        pruned = prune(store, older_than, states or ENDED, dry_run=dry_run)
    finally:
        store.close()
    if as_json:
        echo_json({"dry_run": dry_run, "items": [jsonable(job) for job in pruned]})
        return
    if pruned:
        rows = [(job.id, job.name, job.state, str(job.evaluations)) for job in pruned]
        echo_table(None, ("id", "name", "state", "evaluations"), rows, right=(3,))
    verb = "would be deleted" if dry_run else "deleted"
    click.echo(f"{len(pruned)} {'job' if len(pruned) == 1 else 'jobs'} {verb}.")
