"""The database of a service, for commands that only make sense where there is one."""

from __future__ import annotations

from pathlib import Path
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
    from sqlalchemy.engine import make_url

    from geoswarm.workers.settings import Settings
    from geoswarm.workers.store import Store

    settings = Settings.from_environment(database_url=database)
    url = make_url(settings.database_url)
    if url.get_backend_name() == "sqlite" and url.database and not Path(url.database).is_file():
        raise BadInputError(
            f"there is no database {Path(url.database).absolute()}; name that of the service: --database "
            "sqlite:///FILE, or GEOSWARM_DATABASE_URL"
        )
    return Store(settings)
