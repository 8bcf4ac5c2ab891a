"""The store: tables, migrations, and the queries on them."""

from __future__ import annotations

from geoswarm.workers.store.database import Store

__all__ = ["Store"]
