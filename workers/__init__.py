"""The distributed engine: store, coordinator, worker processes and the service that the API sees."""

from __future__ import annotations

if __name__ != "geoswarm.workers":  # from a checkout Python would find the folder by its bare name, as a second copy
    raise ImportError("import geoswarm.workers: workers is a part of geoswarm and has no name of its own")
