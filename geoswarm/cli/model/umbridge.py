"""``geoswarm umbridge``: the forward model of a problem for clients of UM-Bridge."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.options import problem_argument
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.kernels import ready
from geoswarm.cli.words.output import echo_table, note

if TYPE_CHECKING:
    from http.server import ThreadingHTTPServer

    from geoswarm.cli.model.umbridge_server import Bridge

__all__ = ["umbridge_command"]

_HERE = ("127.0.0.1", "localhost", "::1")


@click.command("umbridge")
@problem_argument
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="Address to listen on; there is no authentication.",
)
@click.option(
    "--port", type=click.IntRange(0, 65535), default=4242, show_default=True, help="Port; 0 takes a free one."
)
@click.option(
    "--workers", type=click.IntRange(min=1), default=1, show_default=True, help="Evaluations at the same time."
)
def umbridge_command(problem: Path, host: str, port: int, workers: int) -> None:
    """Serve the forward model of a problem to UM-Bridge clients.

    Model 'forward' of the protocol 1.0: one input vector, the free parameters in the order of the problem; one output
    vector for each observed series, at the observed points and in the units of the observations. Ctrl-C stops it.
    """
    from geoswarm.cli.model.umbridge_server import Bridge
    from geoswarm.solver.problem import load_problem

    loaded = load_problem(problem)
    ready(loaded)
    try:
        with Bridge(loaded, workers) as bridge, _bound(bridge, host, port) as server:
            _tell(bridge, host, server.server_address[1])
            if host not in _HERE:
                note(f"Warning: anyone who reaches {host} can run this model; there is no key.")
            server.serve_forever(poll_interval=0.1)
    except KeyboardInterrupt:
        note("Stopped.")


def _bound(bridge: Bridge, host: str, port: int) -> ThreadingHTTPServer:
    from geoswarm.cli.model.umbridge_server import make_server

    try:
        return make_server(bridge, host, port)
    except OSError as error:
        raise BadInputError(f"{host}:{port} cannot be used: {error.strerror or error}; give another --port") from None


def _tell(bridge: Bridge, host: str, port: int) -> None:
    rows = [("input 0", f"{len(bridge.problem.free_names)}", ", ".join(bridge.problem.free_names), "")]
    rows += [
        (f"output {index}", str(one.points), one.series, one.y_unit or "-") for index, one in enumerate(bridge.outputs)
    ]
    echo_table("Model forward", ("vector", "numbers", "what", "unit"), rows, right=(1,))
    note(f"geoswarm serves UM-Bridge at http://{f'[{host}]' if ':' in host else host}:{port}; Ctrl-C stops it.")
