"""The part of both clients about problems in the making: drafts, files of measurements, examples."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import quote

from geoswarm.client.calls import API, Call, present, reader

__all__ = ["AsyncDrafts", "Drafts"]

T = TypeVar("T")

_Object = dict[str, Any]


def _read_problem(text: str) -> Call[_Object]:
    return Call(
        "POST",
        f"{API}/problems/read",
        reader(_Object),
        headers={"Content-Type": "application/yaml"},
        content=text,
    )


def _measurements(path: str | Path, sheet: str | None) -> Call[_Object]:
    path = Path(path)
    return Call(
        "POST",
        f"{API}/measurements",
        reader(_Object),
        present(name=path.name, sheet=sheet),
        headers={"Content-Type": "application/octet-stream"},
        content=path.read_bytes(),
    )


def _examples() -> Call[list[_Object]]:
    return Call("GET", f"{API}/examples", reader(list[_Object], "items"))


def _example(name: str) -> Call[_Object]:
    return Call("GET", f"{API}/examples/{quote(name, safe='')}", reader(_Object))


def _schema() -> Call[_Object]:
    return Call("GET", f"{API}/problems/schema", reader(_Object))


class Drafts(ABC):
    """Problems in the making; part of :class:`geoswarm.client.Client`."""

    @abstractmethod
    def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    def read_problem(self, text: str) -> _Object:
        """Read a problem as YAML: the document, all mistakes with their lines, the forward model's parameters."""
        return self._send(_read_problem(text))

    def read_measurements(self, path: str | Path, sheet: str | None = None) -> _Object:
        """Let the service read a CSV or XLSX file: columns, numbers and probable units."""
        return self._send(_measurements(path, sheet))

    def examples(self) -> list[_Object]:
        """List the examples that the service has."""
        return self._send(_examples())

    def example(self, name: str) -> _Object:
        """Show an example; its ``problem`` can be submitted."""
        return self._send(_example(name))

    def problem_schema(self) -> _Object:
        """Show the JSON schema of the problem file with all forward models of the service."""
        return self._send(_schema())


class AsyncDrafts(ABC):
    """Problems in the making; part of :class:`geoswarm.client.AsyncClient`."""

    @abstractmethod
    async def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    async def read_problem(self, text: str) -> _Object:
        """Read a problem as YAML: the document, all mistakes with their lines, the forward model's parameters."""
        return await self._send(_read_problem(text))

    async def read_measurements(self, path: str | Path, sheet: str | None = None) -> _Object:
        """Let the service read a CSV or XLSX file: columns, numbers and probable units."""
        return await self._send(_measurements(path, sheet))

    async def examples(self) -> list[_Object]:
        """List the examples that the service has."""
        return await self._send(_examples())

    async def example(self, name: str) -> _Object:
        """Show an example; its ``problem`` can be submitted."""
        return await self._send(_example(name))

    async def problem_schema(self) -> _Object:
        """Show the JSON schema of the problem file with all forward models of the service."""
        return await self._send(_schema())
