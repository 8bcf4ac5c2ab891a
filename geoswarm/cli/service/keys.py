"""``geoswarm keys``: API keys, in the database itself, so that the first one needs none."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from geoswarm.cli.databases import existing_store
from geoswarm.cli.options import SPAN, database_option, json_option
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, note, record_json

if TYPE_CHECKING:
    from datetime import datetime

    from geoswarm.records.account import Role

__all__ = ["keys_command"]


@click.group("keys")
def keys_command() -> None:
    """Create, list and revoke API keys.

    Works on the database of a service, even while it runs. Roles: 'read' sees the owner's jobs, 'submit' also
    submits and controls them, 'admin' sees and controls all jobs. 'agent' is for 'geoswarm agent': it runs calculations
    of all jobs and sees nothing else.
    """


@keys_command.command("create")
@click.option("--owner", required=True, help="Owner whose jobs the key can access; several keys may have one owner.")
@click.option(
    "--role",
    type=click.Choice(("agent", "read", "submit", "admin")),
    default="submit",
    show_default=True,
    help="What the key permits.",
)
@click.option("--label", default="", help="What the key is for, shown in the list.")
@click.option(
    "--expires", type=SPAN, metavar="SPAN", help="How long it is valid, e.g. 90d or 12h; unlimited if not given."
)
@json_option
@database_option
def create_command(
    owner: str, role: Role, label: str, expires: float | None, as_json: bool, database: str | None
) -> None:
    """Create a key and print it once; only its hash is stored."""
    from geoswarm.workers.access.keys import ApiKeys
    from geoswarm.workers.settings import Settings, mask_url
    from geoswarm.workers.store import Store

    settings = Settings.from_environment(database_url=database)
    store = Store(settings)
    try:
        key, view = ApiKeys(store).create(owner, role, label=label, valid_seconds=expires)
    finally:
        store.close()
    if as_json:
        echo_json({"key": key} | record_json(view))
        return
    click.echo(key)
    note(f"Made in {mask_url(settings.database_url)}.")
    note("Keep it now: it is not shown again. A service on this database asks for a key from now on.")


@keys_command.command("list")
@json_option
@database_option
def list_keys_command(as_json: bool, database: str | None) -> None:
    """List the keys: everything but the keys themselves."""
    from geoswarm.workers.access.keys import ApiKeys
    from geoswarm.workers.settings import mask_url

    store = existing_store(database)
    try:
        views = ApiKeys(store).list()
    finally:
        store.close()
    if as_json:
        echo_json({"items": [record_json(view) for view in views]})
        return
    if not views:
        click.echo(f"No keys in {mask_url(store.url)}. Make one with 'geoswarm keys create --owner NAME --role admin'.")
        return
    rows = [
        (v.id, v.owner, v.role, v.state, _day(v.created_at), _day(v.expires_at), _day(v.used_at), v.label)
        for v in views
    ]
    echo_table(None, ("id", "owner", "role", "state", "created", "expires", "last used", "label"), rows)


@keys_command.command("revoke")
@click.argument("key_id", metavar="ID")
@json_option
@database_option
def revoke_command(key_id: str, as_json: bool, database: str | None) -> None:
    """Revoke a key, at once and permanently."""
    from geoswarm.workers.access.keys import KEY_PATTERN, ApiKeys

    whole = KEY_PATTERN.fullmatch(key_id)
    store = existing_store(database)
    try:
        view = ApiKeys(store).revoke(whole["id"] if whole else key_id)
    finally:
        store.close()
    if as_json:
        echo_json(record_json(view))
        return
    echo_facts(None, {"id": view.id, "owner": view.owner, "state": view.state})


def _day(moment: datetime | None) -> str:
    return "-" if moment is None else f"{moment:%Y-%m-%d %H:%M}"
