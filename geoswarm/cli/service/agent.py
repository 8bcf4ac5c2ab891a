"""``geoswarm agent``: a worker that needs nothing but the address of its service and a key."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import click

from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.output import note
from geoswarm.environment import SecretFileError, listed, secret

if TYPE_CHECKING:
    from geoswarm.agent.agent import Agent

__all__ = ["agent_command"]

KEY_VARIABLE = "GEOSWARM_KEY"
PASS_VARIABLE = "GEOSWARM_PASS_ENVIRONMENT"
MODELS_VARIABLE = "GEOSWARM_MODELS"
LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
LONGEST_KEY_FILE = 4096


@click.command("agent")
@click.option(
    "--server",
    "url",
    required=True,
    envvar="GEOSWARM_SERVER",
    show_envvar=True,
    metavar="URL",
    help="Address of the service, e.g. https://calibration.example.org.",
)
@click.option(
    "--key",
    metavar="KEY",
    help=f"API key of role 'agent'. Other users of this machine can see it; prefer {KEY_VARIABLE} or --key-file.",
)
@click.option("--key-file", type=click.Path(path_type=Path), metavar="FILE", help="File with the key on its only line.")
@click.option(
    "--models",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help=f"Folder of registered models, beside those that {MODELS_VARIABLE} names.",
)
@click.option(
    "--fetch-models",
    "secret_file",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Fetch the models that the service hands out, if their list is signed with the secret in this file.",
)
@click.option(
    "--slots", type=click.IntRange(1, 1024), default=1, show_default=True, help="Runs at once on this machine."
)
@click.option(
    "--kinds",
    metavar="KIND,...",
    help="Kinds of forward model to offer, e.g. registered alone; all that are installed when not given.",
)
@click.option(
    "--idle-exit", type=click.FloatRange(min=0.0), metavar="S", help="End after this many seconds without work."
)
@click.option(
    "--until",
    metavar="TIME",
    help="End at this time, and take no run that ends later: +90m, 18:00, 2026-05-01T18:00, or seconds since 1970.",
)
@click.option(
    "--grace",
    type=click.FloatRange(0.0, 86_400.0),
    default=10.0,
    show_default=True,
    metavar="S",
    help="How long runs may continue after SIGTERM or Ctrl-C before they are handed back.",
)
@click.option(
    "--state",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where results wait while the service does not answer; a folder of this user when not given.",
)
@click.option(
    "--log-level",
    type=click.Choice(("debug", "info", "warning", "error")),
    default="warning",
    show_default=True,
    help="Level of messages written to stderr.",
)
def agent_command(
    url: str,
    key: str | None,
    key_file: Path | None,
    models: Path | None,
    secret_file: Path | None,
    slots: int,
    kinds: str | None,
    idle_exit: float | None,
    until: str | None,
    grace: float,
    state: Path | None,
    log_level: str,
) -> None:
    """Run forward calculations for a service over HTTPS, without access to its database.

    For a PC with licences, a node of a cluster, a machine behind a firewall: it needs the address of the service and a
    key of role 'agent' ('geoswarm keys create --owner NAME --role agent'), and no open port. It runs registered models
    that are here in the same version, or that it fetches, and built-in ones of the same version of geoswarm. It sees
    parameters and the points where values are wanted, never measurements.

    Ctrl-C or SIGTERM ends it: what runs may finish within --grace, the rest is handed back. See docs/agents.md.
    """
    from geoswarm.agent.agent import Agent, AgentOptions
    from geoswarm.agent.errors import KeyRefusedError
    from geoswarm.agent.outbox import default_folder
    from geoswarm.agent.spans import seconds_until
    from geoswarm.solver.forward.registry import kinds as installed

    logging.basicConfig(level=log_level.upper(), format="%(asctime)s %(levelname)s %(message)s")
    logging.getLogger("httpx").setLevel(logging.WARNING)  # a line for every request
    host = _host(url)
    if models is not None:
        _add_models(models)
    chosen = None if kinds is None else tuple(kind.strip() for kind in kinds.split(",") if kind.strip())
    for kind in chosen or ():
        if kind not in installed():
            raise BadInputError(
                f"--kinds: no forward model {kind!r} is installed here; known: {', '.join(installed())}"
            )
    seconds = None
    if until is not None:
        try:
            seconds = seconds_until(until, datetime.now().astimezone())
        except ValueError as error:
            raise BadInputError(f"--until: {error}") from None
    given = _key(key, key_file)
    models_secret = None if secret_file is None else _models_secret(secret_file)
    if given is not None and url.lower().startswith("http:") and host not in LOOPBACK:
        note(f"Warning: {url} is not encrypted; anyone in between can read the key.")
    options = AgentOptions(
        url,
        given,
        slots,
        state or default_folder(),
        idle_exit=idle_exit,
        seconds=seconds,
        grace=grace,
        kinds=chosen,
        passed=tuple(listed(os.environ.get(PASS_VARIABLE, ""))),
        models_secret=models_secret,
    )
    try:
        agent = Agent(options, note)
    except OSError as error:
        raise BadInputError(f"--state {options.folder}: {error.strerror or error}; name a folder to write to") from None
    _end_on_signals(agent)
    try:
        agent.serve()
    except KeyRefusedError as error:
        raise BadInputError(f"{error} Give a valid key of role 'agent': --key-file, or {KEY_VARIABLE}.") from None
    if agent.reason is not None:
        raise FailedRunError(agent.reason)
    note("Stopped.")


def _host(url: str) -> str:
    try:
        parts = urlsplit(url)
        host = parts.hostname or ""
    except ValueError:
        host, parts = "", None
    if parts is None or parts.scheme not in ("http", "https") or not host:
        raise BadInputError(f"--server {url!r}: write an address, for example https://calibration.example.org")
    return host


def _add_models(folder: Path) -> None:
    if not folder.is_dir():
        raise BadInputError(f"--models {folder}: there is no such folder; name the one that holds the models' folders")
    others = os.environ.get(MODELS_VARIABLE)
    os.environ[MODELS_VARIABLE] = os.pathsep.join([str(folder.resolve()), *([others] if others else [])])


def _models_secret(file: Path) -> bytes:
    from geoswarm.solver.errors import SignedListError
    from geoswarm.solver.registered.signed import read_secret

    try:
        return read_secret(file)
    except (OSError, SignedListError) as error:
        why = error.strerror or error if isinstance(error, OSError) else error
        raise BadInputError(f"--fetch-models {file}: {why}") from None


def _key(key: str | None, file: Path | None) -> str | None:
    """Return the key that is given, in one way only; None: none is."""
    if key is not None and file is not None:
        raise BadInputError("--key and --key-file are both given; one is enough")
    if file is None:
        try:
            found = key if key is not None else secret(KEY_VARIABLE)
        except SecretFileError as error:
            raise BadInputError(str(error)) from None
    else:
        try:
            found = file.read_bytes()[:LONGEST_KEY_FILE].decode("utf-8").strip()
        except (OSError, UnicodeDecodeError) as error:
            why = error.strerror if isinstance(error, OSError) else "it is not text in UTF-8"
            raise BadInputError(f"--key-file {file} cannot be read: {why}") from None
    if found is not None and (not found or len(found.split()) != 1 or not found.isascii() or not found.isprintable()):
        raise BadInputError("the key must be one word of printable ASCII characters, like gsw_...")
    return found


def _end_on_signals(agent: Agent) -> None:
    def end(name: str) -> Callable[[int, FrameType | None], None]:
        return lambda _number, _frame: agent.end(name)

    for name in ("SIGINT", "SIGTERM", "SIGBREAK"):  # the last one on Windows
        number = getattr(signal, name, None)
        if number is not None:
            signal.signal(number, end(f"{name} was received"))
