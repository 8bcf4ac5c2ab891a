"""The own services of docker-compose.yml, started from a replayed image against real servers."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy.engine import make_url

from tests.deployment.composition import OWN, service
from tests.deployment.replay import Image
from tests.servers import free_port

__all__ = ["Containers", "running"]

HEALTHY_SECONDS = 400.0  # also on a machine that is busy with something else
PORT = "8765"


@dataclass(frozen=True, slots=True)
class Containers:
    """Running services."""

    image: Image
    url: str
    processes: Mapping[str, subprocess.Popen[bytes]]

    def geoswarm(self, *words: str) -> Any:
        """Run a command about jobs in a container, and return what it printed as JSON."""
        done = self.image.run([*words, "--json", "--url", self.url], {"GEOSWARM_API_KEY_FILE": "/run/secrets/api_key"})
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)


@contextmanager
def running(image: Image, database_url: str, broker_url: str, logs: Path) -> Iterator[Containers]:
    """Start all own services by command and environment, and go on when every healthcheck is green.

    At the end they are asked to stop, and must.
    """
    database = make_url(database_url).set(drivername="postgresql").render_as_string(hide_password=False)
    contents = {"database_url": database, "broker_url": broker_url, "api_key": secrets.token_hex(24)}
    for name, content in contents.items():
        path = image.machine.secrets / name
        path.write_text(content + "\n")
        path.chmod(0o444)
    port = str(free_port())
    processes: dict[str, subprocess.Popen[bytes]] = {}
    try:
        for name in OWN:
            section = service(name)
            assert set(section.secrets) == {
                Path(value).name for variable, value in section.environment.items() if variable.endswith("_FILE")
            }
            words = [port if word == PORT else word for word in section.command]
            processes[name] = image.start(words, section.environment, logs / f"{name}.log")
        _wait_until_healthy(image, processes, port, logs)
        yield Containers(image, f"http://127.0.0.1:{port}", processes)
        for process in processes.values():
            process.terminate()
        codes = {name: process.wait(60) for name, process in processes.items()}
        assert codes == dict.fromkeys(OWN, 0), _tails(logs)
    finally:
        for process in processes.values():
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _wait_until_healthy(image: Image, processes: Mapping[str, subprocess.Popen[bytes]], port: str, logs: Path) -> None:
    deadline = time.monotonic() + HEALTHY_SECONDS
    for name in OWN:
        section = service(name)
        while (done := image.healthy(section, {PORT: port})).returncode != 0:
            ended = {other: process.returncode for other, process in processes.items() if process.poll() is not None}
            assert not ended, f"ended: {ended}\n{_tails(logs)}"
            assert time.monotonic() < deadline, f"{name} is not healthy: {done.stderr[-1000:]}\n{_tails(logs)}"
            time.sleep(0.5)


def _tails(logs: Path) -> str:
    return "\n".join(f"--- {log.name}\n{log.read_text(errors='replace')[-2500:]}" for log in sorted(logs.glob("*.log")))
