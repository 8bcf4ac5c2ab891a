"""The store: connections, tables, migrations. Queries on the tables are in ``queries``."""

from __future__ import annotations

from geoswarm.workers.store.database import Store

__all__ = ["Store"]
