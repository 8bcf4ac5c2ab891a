"""Run by Alembic: applies the versions on the connection, and in the transaction, that the caller holds."""

from __future__ import annotations

from alembic import context

from geoswarm.workers.store.tables import metadata

context.configure(connection=context.config.attributes["connection"], target_metadata=metadata)
context.run_migrations()
