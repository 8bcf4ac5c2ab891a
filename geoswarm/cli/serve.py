"""``geoswarm serve``, ``worker`` and ``sweep``: the processes of a service."""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from geoswarm.cli.databases import refuse_missing_database
from geoswarm.cli.options import api_key_option, broker_option, database_option
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note

if TYPE_CHECKING:
    from geoswarm.workers.settings import Settings

__all__ = ["refuse_open_door", "serve_command", "sweep_command", "worker_command"]

LAST_SECONDS = 1.0
LONGEST_END_SECONDS = 15.0
REQUEST_THREAD = "AnyIO worker"

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


def logging_options(function: Decorated) -> Decorated:
    """Add ``--log-level`` and ``--log-format`` to a command."""
    decorated: Decorated = _level_option(_format_option(function))
    return decorated


_level_option = click.option(
    "--log-level",
    type=click.Choice(("debug", "info", "warning", "error")),
    default="warning",
    show_default=True,
    help="Level of messages written to stderr.",
)
_format_option = click.option(
    "--log-format",
    type=click.Choice(("text", "json")),
    envvar="GEOSWARM_LOG_FORMAT",
    show_envvar=True,
    default="text",
    show_default=True,
    help="Plain lines, or one JSON object a line.",
)


def prepare(part: str, level: str, form: str, settings: Settings) -> None:
    """Begin with logs and traces, and refuse secrets that everybody knows."""
    from geoswarm.workers.logs import start_logging
    from geoswarm.workers.secrets import refuse_known_secrets
    from geoswarm.workers.tracing import start_tracing

    start_logging(level, "json" if form == "json" else "text")
    refuse_known_secrets(settings)
    start_tracing(part)


def group_options(function: Decorated) -> Decorated:
    """Add ``--kinds`` and ``--slots`` to a command that runs workers."""
    decorated: Decorated = _kinds_option(_slots_option(function))
    return decorated


_kinds_option = click.option(
    "--kinds",
    metavar="KIND,...",
    help="Kinds of forward model that the workers run; all when not given.",
)
_slots_option = click.option(
    "--slots",
    metavar="KIND=NUMBER,...",
    help="How many evaluations of a kind may run at once here (licences), if fewer than there are workers.",
)


def group_settings(kinds: str | None, slots: str | None) -> dict[str, Any]:
    """Return the settings that ``--kinds`` and ``--slots`` stand for; None: not given.

    Raises
    ------
    BadInputError
        When a number of slots cannot be read, or a kind is not installed here.
    """
    from geoswarm.solver.forward.registry import kinds as installed

    chosen = None if kinds is None else tuple(kind.strip() for kind in kinds.split(",") if kind.strip())
    limits: dict[str, int] | None = None
    for part in (slots or "").split(","):
        if part.strip():
            kind, _, count = (text.strip() for text in part.partition("="))
            if not count.isdecimal() or int(count) < 1:
                raise BadInputError(f"--slots {part.strip()!r}: write KIND=NUMBER, for example oedometer=2")
            limits = {**(limits or {}), kind: int(count)}
    for kind in (*(chosen or ()), *(limits or ())):
        if kind not in installed():
            raise BadInputError(f"no forward model {kind!r} is installed here; known: {', '.join(installed())}")
    return {"kinds": chosen, "slots": limits}


@click.command("serve")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8765, show_default=True, help="Port; 0 takes a free one."
)
@click.option(
    "--workers",
    type=click.IntRange(min=0),
    help="Worker processes of the embedded engine; one per CPU core when not given. Not with --broker.",
)
@database_option
@broker_option
@api_key_option
@group_options
@logging_options
def serve_command(
    host: str,
    port: int,
    workers: int | None,
    database: str | None,
    broker: str | None,
    api_key: str | None,
    kinds: str | None,
    slots: str | None,
    log_level: str,
    log_format: str,
) -> None:
    """Serve jobs over HTTP, with local or remote workers.

    Without a broker, this command starts and monitors worker processes for the forward runs (embedded
    engine). With one, start 'geoswarm worker' on any number of machines. Without a database URL, jobs are kept in
    geoswarm.db in the working folder.

    On this machine alone and without a broker no API key is needed; otherwise make one with 'geoswarm keys create
    --owner NAME --role admin' on the same database, or give GEOSWARM_API_KEY.
    """
    from geoswarm.api import ApiSettings, bind, serve
    from geoswarm.solver.runner.isolated import isolate_foreign_models
    from geoswarm.workers.access.keys import ApiKeys
    from geoswarm.workers.hosts.engine import open_engine
    from geoswarm.workers.settings import Settings

    group = group_settings(kinds, slots)
    settings = Settings.from_environment(database_url=database, broker_url=broker, workers=workers, **group)
    prepare("serve", log_level, log_format, settings)
    api_settings = ApiSettings.from_environment(api_key=api_key)
    if not settings.broker_url:  # with one, an unreachable broker is reported first
        refuse_open_door(host, api_key, settings)
    listener = bind(host, port)  # before the engine: a port in use must not start workers
    try:
        with open_engine(settings) as engine:
            if settings.broker_url:
                refuse_open_door(host, api_key, settings)
            keys = ApiKeys(engine.service.store).used()
            api_settings = api_settings.model_copy(update={"require_key": keys})
            if settings.isolate and api_settings.compute_processes:  # else requests that calculate are answered here
                isolate_foreign_models(settings.build_memory_mb, settings.passed_environment)
            engine_name = "remote workers" if settings.broker_url else f"{settings.workers} worker processes"
            serve(
                engine.service,
                settings=api_settings,
                listener=listener,
                compute=True,
                on_started=lambda url: note(f"geoswarm serves at {url} with {engine_name}; Ctrl-C stops it."),
            )
            leave_at_last(settings.grace_seconds + LONGEST_END_SECONDS)
    finally:
        listener.close()
    note("Stopped.")
    leave_busy_threads()


def leave_at_last(seconds: float) -> None:
    """End the process after a time [s] if its parts do not end by themselves; workers end with it."""

    def leave() -> None:
        note("Something did not end in time and was abandoned.")
        os._exit(1)

    timer = threading.Timer(seconds, leave)
    timer.daemon = True
    timer.start()


def leave_busy_threads() -> None:
    """End the process when an abandoned request still occupies a thread; else return."""
    deadline = time.monotonic() + LAST_SECONDS
    busy = [thread for thread in threading.enumerate() if thread.name.startswith(REQUEST_THREAD)]
    for thread in busy:
        thread.join(max(0.0, deadline - time.monotonic()))
    if any(thread.is_alive() for thread in busy):  # the interpreter would wait for it
        logging.shutdown()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)


def refuse_open_door(host: str, api_key: str | None, settings: Settings) -> None:
    """Refuse to serve others than this machine's user without a key, or with one that everybody knows.

    Raises
    ------
    BadInputError
        When ``host`` is no loopback address, or a broker lets other machines in, and there is no key.
    SettingsError
        When the key could be guessed.
    """
    from geoswarm.workers.access.keys import ApiKeys
    from geoswarm.workers.secrets import is_loopback, refuse_weak_key
    from geoswarm.workers.store import Store

    if api_key:
        warning = refuse_weak_key(api_key, open_to_others=not is_loopback(host))
        if warning is not None:
            note(f"Warning: {warning}.")
        return
    if is_loopback(host) and not settings.broker_url:
        return
    store = Store(settings)
    try:
        keys = ApiKeys(store).used()
    finally:
        store.close()
    if not keys:
        why = "a service with a broker" if is_loopback(host) else f"--host {host} admits other machines, so it"
        raise BadInputError(
            f"{why} needs an API key, and there is none. Make the first one in its database:\n"
            "  geoswarm keys create --owner NAME --role admin\n"
            "or give one to this command and the others:\n"
            '  export GEOSWARM_API_KEY="$(openssl rand -hex 24)"'
        )


@click.command("worker")
@click.option("--concurrency", type=click.IntRange(min=1), help="Processes; one per CPU core when not given.")
@database_option
@broker_option
@group_options
@logging_options
def worker_command(
    concurrency: int | None,
    database: str | None,
    broker: str | None,
    kinds: str | None,
    slots: str | None,
    log_level: str,
    log_format: str,
) -> None:
    """Run forward calculations for a service with a broker.

    Give the same database and broker as to 'geoswarm serve'. Ctrl-C or SIGTERM stops it; what it was calculating is
    given to other workers.
    """
    from geoswarm.workers.hosts.celery_app import run_celery_worker
    from geoswarm.workers.settings import Settings

    group = group_settings(kinds, slots)
    settings = Settings.from_environment(database_url=database, broker_url=broker, **group)
    if settings.broker_url is None:
        raise BadInputError(
            "a worker needs the broker of its service: --broker redis://HOST:6379/0 or GEOSWARM_BROKER_URL "
            "(without a broker 'geoswarm serve' runs the workers itself)"
        )
    prepare("worker", log_level, log_format, settings)
    note(f"geoswarm worker with {concurrency or settings.workers} processes; Ctrl-C stops it.")
    run_celery_worker(settings, concurrency or settings.workers)


@click.command("sweep")
@database_option
@broker_option
@logging_options
def sweep_command(database: str | None, broker: str | None, log_level: str, log_format: str) -> None:
    """Monitor jobs and redispatch overdue evaluations.

    Every service and worker does this, too. A separate sweep keeps jobs running while no service runs.
    """
    from geoswarm.workers.hosts.alone import run_sweep
    from geoswarm.workers.settings import Settings

    settings = Settings.from_environment(database_url=database, broker_url=broker)
    refuse_missing_database(settings)
    prepare("sweep", log_level, log_format, settings)
    note("geoswarm sweep; Ctrl-C stops it.")
    run_sweep(settings)
