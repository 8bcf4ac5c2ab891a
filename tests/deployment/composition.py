"""docker-compose.yml as docker compose reads it: merged, with its variables filled in."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from ruamel.yaml import YAML

from tests.contracts.repository import ROOT

__all__ = ["FOREIGN", "OWN", "VARIABLE", "ServiceSection", "compose", "interpolated", "service"]

VARIABLE = re.compile(r"(?<!\$)\$\{(?P<name>\w+)(?P<kind>:-)(?P<rest>[^}]*)\}")
OWN = ("api", "worker", "sweep", "prune")
FOREIGN = ("postgres", "redis")


@dataclass(frozen=True, slots=True)
class ServiceSection:
    """What a container of a service is started with."""

    name: str
    command: tuple[str, ...]
    environment: dict[str, str]
    secrets: tuple[str, ...]
    healthcheck: tuple[str, ...]


def compose() -> dict[str, Any]:
    """Read the file as it is; anchors and merges are resolved."""
    document: dict[str, Any] = YAML(typ="safe").load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
    return document


def interpolated(node: Any) -> Any:
    """Put in the defaults of variables, everywhere below a node; ``$$`` is a dollar sign."""
    if isinstance(node, dict):
        return {key: interpolated(value) for key, value in node.items()}
    if isinstance(node, list):
        return [interpolated(value) for value in node]
    return VARIABLE.sub(r"\g<rest>", node).replace("$$", "$") if isinstance(node, str) else node


def service(name: str) -> ServiceSection:
    """Return one service with the defaults of its variables."""
    section = interpolated(compose())["services"][name]
    kind, *words = section["healthcheck"]["test"]
    assert kind in ("CMD", "CMD-SHELL"), kind
    return ServiceSection(
        name,
        tuple(section["command"]),
        dict(section.get("environment", {})),
        tuple(section.get("secrets", ())),
        tuple(words) if kind == "CMD" else ("/bin/sh", "-c", *words),
    )
