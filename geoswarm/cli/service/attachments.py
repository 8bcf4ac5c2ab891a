"""``geoswarm attachments``: files of a job."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.options import connection_options, job_argument, json_option
from geoswarm.cli.service.connection import connect, find_job
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import echo_json, echo_table, note, record_json

if TYPE_CHECKING:
    from geoswarm.client import Attachment, Client

__all__ = ["attachments_command"]

_REFUSED = 422
_UNUSABLE = re.compile(r'[<>:"|?*/\\]')  # in names of files


@click.group("attachments")
def attachments_command() -> None:
    """Attach files to a job: a photo of the specimen, the laboratory's PDF.

    Images (PNG, JPEG, WebP), PDF, text, CSV, AGS and workbooks (XLSX, ODS) are accepted. Everybody who can see the job
    can read them; they are deleted with it.
    """


@attachments_command.command("add")
@job_argument
@click.argument(
    "files", nargs=-1, required=True, metavar="FILE...", type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@json_option
@connection_options
def add_command(job: str, files: tuple[Path, ...], as_json: bool, url: str, api_key: str | None) -> None:
    """Attach files; those before one that is refused stay attached."""
    from geoswarm.client import HttpError

    with connect(url, api_key) as client:
        job_id = find_job(client, job).id
        made = []
        for file in files:
            try:
                made.append(client.attach(job_id, file))
            except HttpError as error:
                if error.status == _REFUSED:
                    raise BadInputError(error.detail) from error
                raise
            if not as_json:
                click.echo(f"{made[-1].name} is attached to {job_id}")
    if as_json:
        echo_json({"items": [record_json(one) for one in made]})


@attachments_command.command("list")
@job_argument
@json_option
@connection_options
def list_command(job: str, as_json: bool, url: str, api_key: str | None) -> None:
    """List the files of a job."""
    with connect(url, api_key) as client:
        found = client.attachments(find_job(client, job).id)
    if as_json:
        echo_json({"items": [record_json(one) for one in found]})
        return
    if not found:
        click.echo("No files. Attach one with 'geoswarm attachments add JOB FILE'.")
        return
    rows = [
        (one.sha256[:12], one.name, one.media_type, f"{one.size}", f"{one.created_at:%Y-%m-%d %H:%M}") for one in found
    ]
    echo_table(None, ("SHA-256", "name", "type", "bytes", "attached"), rows, right=(3,))


@attachments_command.command("save")
@job_argument
@click.argument("file", metavar="[FILE]", required=False)
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path(),
    metavar="DIR",
    help="Folder; the current one if not given.",
)
@connection_options
def save_command(job: str, file: str | None, output: Path, url: str, api_key: str | None) -> None:
    """Save the files of a job, or the one with this name or SHA-256; no file is overwritten."""
    with connect(url, api_key) as client:
        job_id = find_job(client, job).id
        chosen = list(client.attachments(job_id)) if file is None else [_find(client, job_id, file)]
        output.mkdir(parents=True, exist_ok=True)
        for one in chosen:
            path = _free(output / _UNUSABLE.sub("_", one.name))
            client.download_attachment(job_id, one.sha256, path)
            note(f"Written to {path}")


@attachments_command.command("remove")
@job_argument
@click.argument("file", metavar="FILE")
@connection_options
def remove_command(job: str, file: str, url: str, api_key: str | None) -> None:
    """Remove the file of a job with this name or SHA-256, for good."""
    with connect(url, api_key) as client:
        job_id = find_job(client, job).id
        chosen = _find(client, job_id, file)
        client.delete_attachment(job_id, chosen.sha256)
    click.echo(f"{chosen.name} is removed")


def _find(client: Client, job_id: str, file: str) -> Attachment:
    """The only file of a job with a name, or whose hash begins like this."""
    there = client.attachments(job_id)
    found = [one for one in there if one.name == file] or [one for one in there if one.sha256.startswith(file.lower())]
    if len(found) == 1:
        return found[0]
    names = ", ".join(f"{one.name} ({one.sha256[:12]})" for one in found or there)
    if found:
        raise BadInputError(f"several files of job {job_id} are called '{file}'; give the SHA-256 of one: {names}")
    raise BadInputError(f"job {job_id} has no file '{file}'; it has {names or 'none'}")


def _free(path: Path) -> Path:
    """The path, or one beside it with a number where that is taken."""
    number, free = 1, path
    while free.exists():
        number += 1
        free = path.with_stem(f"{path.stem}-{number}")
    return free
