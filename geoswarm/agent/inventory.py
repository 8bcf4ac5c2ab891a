"""What runs on this machine: built-in forward models that are installed, and registered ones with their hashes."""

from __future__ import annotations

import platform
import socket
from collections.abc import Collection
from typing import Any

from geoswarm.solver.errors import BrokenForwardModelError
from geoswarm.solver.forward.registry import BUILT_IN, find_spec
from geoswarm.solver.registered.folders import find_folder, registered_names, version_of
from geoswarm.solver.system.versions import versions

__all__ = ["announcement", "built_in_kinds", "models"]

REGISTERED = "registered"


def built_in_kinds() -> tuple[str, ...]:
    """Return the kinds of this package that can be used here, without those that run the author's own programs."""
    found = []
    for kind in BUILT_IN:
        if kind == REGISTERED:
            continue
        try:
            if not find_spec(kind).programs:
                found.append(kind)
        except BrokenForwardModelError:  # something that it needs is not installed
            continue
    return tuple(found)


def models() -> tuple[dict[str, str], dict[str, str]]:
    """Return the hash of every registered model by its name, and why others cannot be offered."""
    found, wrong = {}, {}
    for name in registered_names():
        try:
            found[name] = version_of(find_folder(name))
        except (OSError, ValueError) as error:
            wrong[name] = str(error)
    return found, wrong


def announcement(agent: str, pid: int, slots: int, kinds: Collection[str] | None) -> dict[str, Any]:
    """Return what is announced to the service.

    Parameters
    ----------
    kinds
        Only these, ``registered`` among them; None: all.
    """
    offered, _ = models()
    return {
        "agent": agent,
        "host": socket.gethostname()[:200],
        "system": f"{platform.system()} {platform.release()} {platform.machine()}"[:200],
        "pid": pid,
        "slots": slots,
        "versions": dict(versions()),
        "kinds": [kind for kind in built_in_kinds() if kinds is None or kind in kinds],
        "models": offered if kinds is None or REGISTERED in kinds else {},
    }
