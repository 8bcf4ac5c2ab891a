"""``geoswarm export``: all evaluations of a job."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.connection import connect, find_job
from geoswarm.cli.jobs import jsonable
from geoswarm.cli.options import connection_options, job_argument
from geoswarm.cli.output import note

if TYPE_CHECKING:
    from geoswarm.client import Client

__all__ = ["export_command"]

_PAGE = 500


@click.command("export")
@job_argument
@click.option(
    "--format",
    "form",
    type=click.Choice(("csv", "json")),
    help="csv unless --output ends in .json; json also holds the responses.",
)
@click.option("--output", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="File; stdout if not given.")
@connection_options
def export_command(job: str, form: str | None, output: Path | None, url: str, api_key: str | None) -> None:
    """Write all evaluations of a job as CSV or JSON.

    Ordered by generation and particle, one row or object an evaluation. A file appears only when it is complete.
    """
    chosen = form or ("json" if output is not None and output.suffix.lower() == ".json" else "csv")
    with connect(url, api_key) as client:
        found = find_job(client, job)
        if output is None:
            with tempfile.TemporaryDirectory() as folder:
                _print(_write(client, found.id, chosen, Path(folder) / "evaluations"))
        else:
            partial = output.with_name(f".{output.name}.part")
            try:
                _write(client, found.id, chosen, partial).replace(output)
            finally:
                partial.unlink(missing_ok=True)
            note(f"Written to {output}")


def _write(client: Client, job_id: str, form: str, path: Path) -> Path:
    if form == "csv":
        client.download_evaluations(job_id, path)
        return path
    with path.open("w", encoding="utf-8") as stream:
        stream.write("[")
        separator = "\n"
        for text in _objects(client, job_id):
            stream.write(separator + text)
            separator = ",\n"
        stream.write("\n]\n")
    return path


def _objects(client: Client, job_id: str) -> Iterator[str]:
    cursor: str | None = None
    while True:
        page = client.evaluations(job_id, limit=_PAGE, cursor=cursor, responses=True)
        for evaluation in page.items:
            yield json.dumps(jsonable(evaluation), ensure_ascii=False, allow_nan=False)
        cursor = page.next_cursor
        if cursor is None:
            return


def _print(path: Path) -> None:
    """Copy a file to stdout in pieces: an export may be larger than memory."""
    with path.open(encoding="utf-8", newline="") as stream:
        while piece := stream.read(1 << 20):
            sys.stdout.write(piece)
