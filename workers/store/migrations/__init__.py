"""Alembic migrations of the database; applied by ``geoswarm.workers.store.migrate``."""
