"""Makes a worker process ready before its first evaluation."""

from __future__ import annotations

import logging
from importlib.metadata import entry_points

__all__ = ["warm_up"]

log = logging.getLogger(__name__)


def warm_up() -> None:
    """Import every forward model, and with them the compiled kernels, which come from Numba's cache on the disk."""
    for entry in entry_points(group="geoswarm.forward_models"):
        try:
            entry.load()
        except (ImportError, AttributeError) as error:
            # A broken plug-in concerns only jobs that name it; they will say so.
            log.warning("forward model %r cannot be imported: %s", entry.name, error)
