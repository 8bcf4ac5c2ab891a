"""``geoswarm hooks``: notifications of a service when a job has ended."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from geoswarm.cli.options import connection_options, json_option
from geoswarm.cli.service.connection import connect, find_job
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, note, record_json
from geoswarm.records.states import ENDED_STATES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geoswarm.client import Client, Hook, NewHook
    from geoswarm.records.states import EndedState

__all__ = ["add_hook", "hooks_command", "tell_secret"]

_REFUSED = 422


@click.group("hooks")
def hooks_command() -> None:
    """Notify an address when jobs end.

    The service sends a signed request to an address that begins with https://, or an e-mail if its operator has
    configured a mail server. Without --job, a hook applies to all jobs of the API key's owner.
    """


@hooks_command.command("add")
@click.argument("target", metavar="ADDRESS")
@click.option("--job", metavar="ID", help="Only this job; if it has ended, the message is sent at once.")
@click.option(
    "--state",
    "states",
    multiple=True,
    type=click.Choice(ENDED_STATES),
    help="Only jobs that ended in this state; may be repeated.",
)
@json_option
@connection_options
def add_command(
    target: str, job: str | None, states: tuple[EndedState, ...], as_json: bool, url: str, api_key: str | None
) -> None:
    """Create a hook and print its id; the secret that signs its requests is shown once."""
    with connect(url, api_key) as client:
        job_id = None if job is None else find_job(client, job).id
        made = add_hook(client, target, job_id, states or ENDED_STATES)
    if as_json:
        echo_json({"secret": made.secret} | record_json(made.view))
        return
    click.echo(made.view.id)
    tell_secret(made)


def add_hook(client: Client, target: str, job: str | None, states: Sequence[EndedState] = ENDED_STATES) -> NewHook:
    """Make a hook.

    Raises
    ------
    BadInputError
        When the service refuses the address.
    """
    from geoswarm.client import HttpError

    try:
        return client.create_hook(target, job=job, states=states)
    except HttpError as error:
        if error.status == _REFUSED:
            raise BadInputError(error.detail) from error
        raise


def tell_secret(made: NewHook) -> None:
    """Show what requests are signed with, where they are."""
    if made.secret is not None:
        note(f"Requests to {made.view.target} are signed with {made.secret}")
        note("Keep it now: it is not shown again.")


@hooks_command.command("list")
@json_option
@connection_options
def list_hooks_command(as_json: bool, url: str, api_key: str | None) -> None:
    """List the hooks and the state of the last message of each."""
    with connect(url, api_key) as client:
        hooks = client.hooks()
    if as_json:
        echo_json({"items": [record_json(hook) for hook in hooks]})
        return
    if not hooks:
        click.echo("No hooks. Make one with 'geoswarm hooks add https://example.org/hook'.")
        return
    rows = [(h.id, h.target, h.job or "all", ", ".join(h.states), _last(h)) for h in hooks]
    echo_table(None, ("id", "address", "job", "when", "last message"), rows)


@hooks_command.command("test")
@click.argument("hook_id", metavar="ID")
@json_option
@connection_options
def test_command(hook_id: str, as_json: bool, url: str, api_key: str | None) -> None:
    """Send a test message; 'geoswarm hooks list' shows whether it arrived."""
    with connect(url, api_key) as client:
        hook = client.test_hook(hook_id)
    if as_json:
        echo_json(record_json(hook))
        return
    echo_facts(None, {"id": hook.id, "address": hook.target, "last message": _last(hook)})


@hooks_command.command("remove")
@click.argument("hook_id", metavar="ID")
@connection_options
def remove_command(hook_id: str, url: str, api_key: str | None) -> None:
    """Remove a hook; messages not sent yet are dropped."""
    with connect(url, api_key) as client:
        client.delete_hook(hook_id)
    click.echo(f"{hook_id} is removed")


def _last(hook: Hook) -> str:
    if hook.last_state is None or hook.last_at is None:
        return "-"
    state = hook.last_state.replace("_", " ")
    tries = f", {hook.last_tries} tries" if (hook.last_tries or 0) > 1 else ""
    why = f": {hook.last_error}" if hook.last_error else ""
    return f"{hook.last_at:%Y-%m-%d %H:%M} {state}{tries}{why}"
