"""The store: connections, tables, migrations. What is asked of the tables is in ``queries``."""

from __future__ import annotations

from geoswarm.workers.store.database import Store

__all__ = ["Store"]
