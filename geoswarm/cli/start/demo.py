"""``geoswarm demo``: the published oedometer test, calibrated by a service that is started for it."""

from __future__ import annotations

import signal
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.service.connection import connect
from geoswarm.cli.service.submit import follow
from geoswarm.cli.start.examples import example_problem
from geoswarm.cli.words.error_messages import FailedRunError
from geoswarm.cli.words.output import duration, echo_facts, echo_table, note, number, reasons_in_words

if TYPE_CHECKING:
    import socket

    from geoswarm.client import Job
    from geoswarm.workers.service.job_service import JobService

__all__ = ["LABORATORY", "PUBLISHED", "demo_command"]

PUBLISHED = {"lambda_star": 0.082, "kappa_star": 0.051, "c": 25.0}
"""Identified set of Meier et al. (2008), application A; c in kPa."""
LABORATORY = {"lambda_star": 0.064, "kappa_star": 0.035, "c": 27.0}
"""Laboratory set of the same paper."""
_LABELS = {"lambda_star": ("λ*", "-"), "kappa_star": ("κ*", "-"), "c": ("c", "kPa")}
_PUBLISHED_RUNS = 1590
_START_SECONDS = 30.0


@click.command("demo")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8765, show_default=True, help="Port; a free one if taken."
)
@click.option("--workers", type=click.IntRange(min=1), default=2, show_default=True, help="Worker processes.")
@click.option("--no-wait", is_flag=True, help="End after the search instead of serving until Ctrl-C.")
def demo_command(port: int, workers: int, no_wait: bool) -> None:
    """Start a service and calibrate the published oedometer test.

    Runs on this machine: a service with its own worker processes and a database in a temporary folder, one job, and a
    dashboard. The reference data are synthetic: the model at the published identified parameters plus noise. On a
    terminal, the service runs until Ctrl-C; otherwise the command ends after the search.
    """
    from geoswarm.workers.hosts.engine import open_engine
    from geoswarm.workers.settings import Settings

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # stop the workers as on Ctrl-C
    with example_problem("oedometer") as problem, tempfile.TemporaryDirectory(prefix="geoswarm-demo-") as folder:
        note("Oedometer test of Meier et al. (2008). The reference data are SYNTHETIC: the model at the published")
        note("identified parameters plus noise of 0.05 mm. Starting a service with its workers ...")
        settings = Settings(database_url=f"sqlite:///{Path(folder).as_posix()}/demo.db", workers=workers)
        listener = _listen(port)
        try:
            with open_engine(settings) as engine, _serving(engine.service, listener) as url:
                with connect(url, None) as client:
                    job = follow(client, client.submit(problem))
                waits = not no_wait and sys.stdout.isatty()
                _show(job, url if waits else None)
                if waits:
                    _wait_for_interrupt()
        finally:
            listener.close()


def _listen(port: int) -> socket.socket:
    from geoswarm.api import PortInUseError, bind

    try:
        return bind("127.0.0.1", port)
    except PortInUseError:
        return bind("127.0.0.1", 0)


@contextmanager
def _serving(service: JobService, listener: socket.socket) -> Iterator[str]:
    """Serve in a thread while the body runs; give the address."""
    from geoswarm.api import ApiSettings
    from geoswarm.api.server import base_url, build_server

    started = threading.Event()
    server = build_server(service, listener, ApiSettings(), lambda _url: started.set())
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, name="http", daemon=True)
    thread.start()
    try:
        if not started.wait(_START_SECONDS):
            raise FailedRunError(f"the service did not start within {_START_SECONDS:g} s")
        yield base_url(listener)
    finally:
        server.should_exit = True
        thread.join(_START_SECONDS)


def _show(job: Job, url: str | None) -> None:
    if job.state != "finished" or job.parameters is None:
        raise FailedRunError(f"the job {job.state}: {job.error}" if job.error else f"the job was {job.state}")
    rows = [
        (name, symbol, number(job.parameters[name], 3), number(PUBLISHED[name]), number(LABORATORY[name]), unit)
        for name, (symbol, unit) in _LABELS.items()
    ]
    columns = ("parameter", "", "identified here", "published, identified", "laboratory", "unit")
    echo_table("Oedometer test, soft soil creep (synthetic reference data)", columns, rows, right=(2, 3, 4))
    echo_facts(
        None,
        {
            "objective": f"{number(job.objective)} m² (published target 5e-9 m², noise alone about 2.5e-9 m²)",
            "stopped": reasons_in_words(job.stop_reasons),
            "evaluations": f"{job.evaluations} in {job.generations} generations (the paper: {_PUBLISHED_RUNS})",
            "search": duration(job.seconds),
        }
        | ({} if url is None else {"page": f"{url}/jobs/{job.id}"}),  # no page is served when the command has ended
    )


def _wait_for_interrupt() -> None:
    click.echo("\nThe service keeps running; open the page, or press Ctrl-C to stop it.")
    try:
        threading.Event().wait()
    except KeyboardInterrupt:
        click.echo("\nStopped.")
