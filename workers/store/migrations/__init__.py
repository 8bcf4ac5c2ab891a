"""Alembic migrations of the database; applied by ``workers.store.migrate``."""
