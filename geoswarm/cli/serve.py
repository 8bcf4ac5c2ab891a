"""``geoswarm serve``, ``worker`` and ``sweep``: the processes of a service."""

from __future__ import annotations

import click

from geoswarm.cli.failures import BadInputError
from geoswarm.cli.options import api_key_option, broker_option, database_option
from geoswarm.cli.output import note

__all__ = ["LOOPBACK", "refuse_open_door", "serve_command", "sweep_command", "worker_command"]

LOOPBACK = ("127.0.0.1", "::1", "localhost")


log_level_option = click.option(
    "--log-level",
    type=click.Choice(("debug", "info", "warning", "error")),
    default="warning",
    show_default=True,
    help="What to write to stderr.",
)


def start_logging(level: str) -> None:
    """Write log records to stderr, one a line."""
    import logging

    logging.basicConfig(level=level.upper(), format="%(asctime)s %(levelname)s %(name)s: %(message)s")


@click.command("serve")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8765, show_default=True, help="Port; 0 takes a free one."
)
@click.option(
    "--workers",
    type=click.IntRange(min=0),
    help="Worker processes of the embedded engine; one a processor core when not given. Not with --broker.",
)
@database_option
@broker_option
@api_key_option
@log_level_option
def serve_command(
    host: str,
    port: int,
    workers: int | None,
    database: str | None,
    broker: str | None,
    api_key: str | None,
    log_level: str,
) -> None:
    """Serve jobs over HTTP, with workers of its own or remote ones.

    Without a broker, forward runs are done by worker processes that this command starts and watches (embedded
    engine). With one, start 'geoswarm worker' on any number of machines. Without a database URL, jobs are kept in
    geoswarm.db in the working folder.
    """
    start_logging(log_level)
    from api import ApiSettings, bind, serve
    from workers.engine import open_engine
    from workers.settings import Settings

    settings = Settings.from_environment(database_url=database, broker_url=broker, workers=workers)
    refuse_open_door(host, api_key)
    api_settings = ApiSettings.from_environment(api_key=api_key)
    listener = bind(host, port)  # before the engine: a port in use must not start workers
    try:
        with open_engine(settings) as engine:
            engine_name = "remote workers" if settings.broker_url else f"{settings.workers} worker processes"
            serve(
                engine.service,
                settings=api_settings,
                listener=listener,
                on_started=lambda url: note(f"geoswarm serves at {url} with {engine_name}; Ctrl-C stops it."),
            )
    finally:
        listener.close()
    note("Stopped.")


def refuse_open_door(host: str, api_key: str | None) -> None:
    """Refuse to listen for other machines without a key.

    Raises
    ------
    BadInputError
        When ``host`` is no loopback address and there is no API key.
    """
    if host not in LOOPBACK and not host.startswith("127.") and not api_key:
        raise BadInputError(
            f"--host {host} lets other machines in, but there is no API key. Set one first:\n"
            '  export GEOSWARM_API_KEY="$(openssl rand -hex 24)"\n'
            "and give the same key to 'geoswarm submit' and the other commands, or keep --host 127.0.0.1"
        )


@click.command("worker")
@click.option("--concurrency", type=click.IntRange(min=1), help="Processes; one a processor core when not given.")
@database_option
@broker_option
@log_level_option
def worker_command(concurrency: int | None, database: str | None, broker: str | None, log_level: str) -> None:
    """Run forward calculations for a service with a broker.

    Give the same database and broker as to 'geoswarm serve'. Ctrl-C or SIGTERM stops it; what it was calculating is
    given to other workers.
    """
    start_logging(log_level)
    from workers.celery_app import run_celery_worker
    from workers.settings import Settings

    settings = Settings.from_environment(database_url=database, broker_url=broker)
    if settings.broker_url is None:
        raise BadInputError(
            "a worker needs the broker of its service: --broker redis://HOST:6379/0 or GEOSWARM_BROKER_URL "
            "(without a broker 'geoswarm serve' runs the workers itself)"
        )
    note(f"geoswarm worker with {concurrency or settings.workers} processes; Ctrl-C stops it.")
    run_celery_worker(settings, concurrency or settings.workers)


@click.command("sweep")
@database_option
@broker_option
@log_level_option
def sweep_command(database: str | None, broker: str | None, log_level: str) -> None:
    """Look after jobs: re-dispatch what is overdue.

    Every service and worker does this, too. A sweep of its own keeps jobs going while no service runs.
    """
    start_logging(log_level)
    from workers.settings import Settings
    from workers.sweep import run_sweep

    settings = Settings.from_environment(database_url=database, broker_url=broker)
    note("geoswarm sweep; Ctrl-C stops it.")
    run_sweep(settings)
