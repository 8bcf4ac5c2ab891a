"""The database of a service, for commands that only make sense where there is one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geoswarm.cli.words.error_messages import BadInputError

if TYPE_CHECKING:
    from geoswarm.workers.settings import Settings
    from geoswarm.workers.store import Store

__all__ = ["existing_store", "refuse_missing_database"]


def existing_store(database: str | None) -> Store:
    """Open a database that is there; an SQLite file is never made by looking for it.

    Raises
    ------
    BadInputError
        When there is no such file.
    """
    from geoswarm.workers.settings import Settings
    from geoswarm.workers.store import Store

    settings = Settings.from_environment(database_url=database)
    refuse_missing_database(settings)
    return Store(settings)


def refuse_missing_database(settings: Settings) -> None:
    """Refuse to make the SQLite database of a service that is elsewhere, or not there yet.

    Raises
    ------
    BadInputError
        When there is no such file.
    """
    from geoswarm.workers.store.file import missing_database

    missing = missing_database(settings)
    if missing is not None:
        raise BadInputError(
            f"there is no database {missing}; name that of the service: --database "
            "sqlite:///FILE, or GEOSWARM_DATABASE_URL"
        )
