"""``geoswarm export``: all evaluations of a job."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.options import connection_options, job_argument
from geoswarm.cli.service.connection import connect, find_job
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note, record_json

if TYPE_CHECKING:
    from geoswarm.client import Client

__all__ = ["export_command"]


@click.command("export")
@job_argument
@click.option(
    "--format",
    "form",
    type=click.Choice(("csv", "json", "parquet")),
    help="csv unless --output ends in .json or .parquet, which also contain the responses.",
)
@click.option(
    "--output", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="File; stdout if not given."
)
@connection_options
def export_command(job: str, form: str | None, output: Path | None, url: str, api_key: str | None) -> None:
    """Write all evaluations of a job as CSV, JSON or Parquet.

    One row or object for each evaluation, ordered by generation and particle. A file appears only when it is complete.
    """
    ending = "" if output is None else output.suffix.lower()[1:]
    if form is None and ending not in ("", "csv", "json", "parquet", "txt"):
        raise BadInputError(
            f"--output {output}: the file could be .csv, .json or .parquet; --format csv writes CSV text into it anyway"
        )
    chosen = form or (ending if ending in ("json", "parquet") else "csv")
    if chosen == "parquet" and output is None:
        raise BadInputError("--format parquet needs --output FILE: it cannot be shown on a terminal")
    with connect(url, api_key) as client:
        found = find_job(client, job)
        if output is not None:
            if not output.absolute().parent.is_dir():
                raise BadInputError(f"--output {output}: there is no folder {output.absolute().parent}")
            _write(client, found.id, chosen, output)
            note(f"Written to {output}")
            return
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "evaluations"
            _write(client, found.id, chosen, file)
            _print(file)


def _write(client: Client, job_id: str, form: str, path: Path) -> None:
    if form == "csv":
        client.download_evaluations(job_id, path)
        return
    if form == "parquet":
        client.download_evaluations(job_id, path, form="parquet", responses=True)
        return
    from geoswarm.client.files import partial_file

    with partial_file(path) as file:
        file.write(b"[")
        separator = "\n"
        for evaluation in client.iterate_evaluations(job_id, responses=True):
            text = json.dumps(record_json(evaluation), ensure_ascii=False, allow_nan=False)
            file.write(f"{separator}{text}".encode())
            separator = ",\n"
        file.write(b"\n]\n")


def _print(path: Path) -> None:
    """Copy a file to stdout in pieces: an export may be larger than memory."""
    with path.open(encoding="utf-8", newline="") as stream:
        while piece := stream.read(1 << 20):
            sys.stdout.write(piece)
