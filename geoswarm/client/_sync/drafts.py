# Generated from geoswarm/client/_async/drafts.py by scripts/generate_client.py; `make format` renews it.
"""Problems before they are jobs: drafts, files of measurements, examples, and what a problem would do and cost."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import quote

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import API, JSON_BODY, Call, Problem, present, problem_text, reader
from geoswarm.client.models import CheckResult, WarmStart

__all__ = [
    "check",
    "example",
    "examples",
    "problem_schema",
    "read_measurements",
    "read_problem",
    "warm_starts",
]

_Object = dict[str, Any]


def check(self: Connection, problem: Problem) -> CheckResult:
    """Validate a problem, let the service make one test run and estimate the cost."""
    content = problem_text(problem)
    call = Call("POST", f"{API}/problems/check", reader(CheckResult), headers=JSON_BODY, content=content)
    return self._send(call)


def warm_starts(self: Connection, problem: Problem) -> tuple[WarmStart, ...]:
    """Return earlier jobs of the same forward model whose stored evaluations a search could learn from."""
    content = problem_text(problem)
    read = reader(tuple[WarmStart, ...], "items")
    return self._send(Call("POST", f"{API}/problems/warm-starts", read, headers=JSON_BODY, content=content))


def read_problem(self: Connection, text: str) -> _Object:
    """Read a problem as YAML: the document, all mistakes with their lines, the forward model's parameters."""
    headers = {"Content-Type": "application/yaml"}
    return self._send(Call("POST", f"{API}/problems/read", reader(_Object), headers=headers, content=text))


def read_measurements(self: Connection, path: str | Path, sheet: str | None = None) -> _Object:
    """Let the service read a CSV, XLSX or ODS file: columns, numbers and probable units."""
    path = Path(path)
    query = present(name=path.name, sheet=sheet)
    headers = {"Content-Type": "application/octet-stream"}
    content = path.read_bytes()
    return self._send(Call("POST", f"{API}/measurements", reader(_Object), query, headers, content))


def examples(self: Connection) -> list[_Object]:
    """List the examples that the service has."""
    return self._send(Call("GET", f"{API}/examples", reader(list[_Object], "items")))


def example(self: Connection, name: str) -> _Object:
    """Show an example; its ``problem`` can be submitted."""
    return self._send(Call("GET", f"{API}/examples/{quote(name, safe='')}", reader(_Object)))


def problem_schema(self: Connection) -> _Object:
    """Show the JSON schema of the problem file with all forward models of the service."""
    return self._send(Call("GET", f"{API}/problems/schema", reader(_Object)))
