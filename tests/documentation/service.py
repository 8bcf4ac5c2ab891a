"""The service that a page takes for granted: ``geoswarm serve`` on a free port, in the folder of the reader."""

from __future__ import annotations

import json
import re
import ssl
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import httpx

from scripts.blocks import Block
from scripts.reader import Reader
from tests.api.conftest import line_problem
from tests.servers import free_port

__all__ = ["USUAL", "followed", "serving", "typed", "write_line_problem"]

USUAL = "http://127.0.0.1:8765"
NO_TLS = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
"""Else each question reads the authorities of TLS, which takes longer than the answer."""


def write_line_problem(folder: Path) -> None:
    """Write a problem that is calibrated within a second, as ``problem.yaml`` and ``problem.json``."""
    for name in ("problem.yaml", "problem.json"):
        (folder / name).write_text(json.dumps(line_problem()), encoding="utf-8")


def typed(text: str, port: int) -> str:
    """Return commands as they are typed here: the service on a port of its own, which is waited for."""
    ready = f"until curl -sf {USUAL}/health/ready >/dev/null; do sleep 0.1; done"
    text = re.sub(r"^(geoswarm serve)( &.*)$", rf"\1 --port {port} --workers 1\2\n{ready}", text, flags=re.MULTILINE)
    return text.replace(USUAL, f"http://127.0.0.1:{port}")


def followed(reader: Reader, block: Block) -> str:
    """Type a block as it stands; return what it printed."""
    return reader.python(block.text) if block.kind == "python" else reader.shell(block.text)


@contextmanager
def serving(folder: Path, variables: Mapping[str, str] | None = None) -> Iterator[tuple[Reader, str]]:
    """Run a service with one worker; give a reader of the same folder, whose client finds it, and its address."""
    port = free_port()
    url = f"http://127.0.0.1:{port}"
    given = {"GEOSWARM_DATABASE_URL": f"sqlite:///{folder}/geoswarm.db", "GEOSWARM_URL": url, **(variables or {})}
    with Reader(folder, given) as reader:
        command = [sys.executable, "-m", "geoswarm", "serve", "--port", str(port), "--workers", "1"]
        with (folder / "service.log").open("w") as log:
            service = subprocess.Popen(command, cwd=folder, env=reader.variables, stdout=log, stderr=log)
        try:
            deadline = time.monotonic() + 60.0
            while not answers(url):
                assert service.poll() is None, (folder / "service.log").read_text()
                assert time.monotonic() < deadline, "the service does not answer"
                time.sleep(0.05)
            yield reader, url
        finally:
            service.terminate()
            service.wait(60.0)


def answers(url: str) -> bool:
    """Return whether a service is ready."""
    try:
        return httpx.get(f"{url}/health/ready", timeout=5.0, verify=NO_TLS).is_success
    except httpx.TransportError:
        return False
