"""The database of a service, for commands that only make sense where there is one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geoswarm.cli.failures import BadInputError

if TYPE_CHECKING:
    from geoswarm.workers.store import Store

__all__ = ["existing_store"]


def existing_store(database: str | None) -> Store:
    """Open a database that is there; an SQLite file is never made by looking for it.

    Raises
    ------
    BadInputError
        When there is no such file.
    """
    from geoswarm.workers.settings import Settings
    from geoswarm.workers.store import Store
    from geoswarm.workers.store.file import missing_database

    settings = Settings.from_environment(database_url=database)
    missing = missing_database(settings)
    if missing is not None:
        raise BadInputError(
            f"there is no database {missing}; name that of the service: --database "
            "sqlite:///FILE, or GEOSWARM_DATABASE_URL"
        )
    return Store(settings)
