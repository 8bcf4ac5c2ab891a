"""What the service hands to a child process on its standard input, and what the child makes of it."""

from __future__ import annotations

import json
import logging
import os
import sys
from collections.abc import Mapping
from typing import Any

from geoswarm.environment import without_secrets
from geoswarm.solver.system.environment import numerics
from geoswarm.workers.logs import start_logging
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

__all__ = ["child_environment", "hand_over", "open_store", "take_over"]


def child_environment() -> dict[str, str]:
    """Return the environment of a child: without secrets, which come over its standard input."""
    return without_secrets(os.environ) | numerics()


def hand_over(store: Store, settings: Settings, **further: object) -> bytes:
    """Return the line for a child's standard input: settings, database, log level and what else it needs."""
    given = {
        "path": sys.path,
        "settings": settings.model_dump(),
        "database_file": store.file,
        "log_level": logging.getLogger().getEffectiveLevel(),
        **further,
    }
    return json.dumps(given).encode() + b"\n"


def take_over(given: Mapping[str, Any]) -> Settings:
    """Start the child's log and return the settings of the parent."""
    start_logging(given["log_level"])
    return Settings(**given["settings"])


def open_store(given: Mapping[str, Any], settings: Settings) -> Store:
    """Open the database of the parent.

    Raises
    ------
    StoreUnavailableError
        It cannot be reached.
    """
    file = given["database_file"]
    return Store(settings, None if file is None else tuple(file))
