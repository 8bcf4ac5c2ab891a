"""Where, when and with what cases were run."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from geoswarm.solver.system.versions import versions

__all__ = ["Provenance", "provenance"]


@dataclass(frozen=True, slots=True)
class Provenance:
    """What a page says of its numbers.

    Parameters
    ----------
    machine
        Name, processor and number of cores, in words.
    system
        Operating system and architecture.
    versions
        Of all that calculates and draws.
    date
        Coordinated universal time, to the minute.
    """

    machine: str
    system: str
    versions: Mapping[str, str]
    date: str


def provenance(*, machine: str | None = None) -> Provenance:
    """Return that of this process; ``machine`` instead of the name and processor of this one."""
    found = dict(versions())
    system = found.pop("machine")
    for name in ("matplotlib", "SALib"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    if machine is None:
        machine = f"{platform.node() or 'unnamed'}, {_processor()}, {os.cpu_count()} cores"
    return Provenance(machine, system, found, f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC")


def _processor() -> str:
    """Return the model of the processor, as far as the system names it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:  # no Linux
        lines = []
    found = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return found[0] if found else platform.processor() or platform.machine()
