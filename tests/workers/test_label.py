"""Databases whose tables and label (the schema version) disagree are refused in words."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store


def damaged(folder: Path, change: str) -> Settings:
    settings = Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=1)
    Store(settings).close()
    with sqlite3.connect(folder / "jobs.db") as connection:
        connection.execute(change)
    connection.close()
    return settings


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("UPDATE alembic_version SET version_num = '0003'", r"says 0003\): table offers already exists"),
        ("UPDATE alembic_version SET version_num = '0005'", r"says 0005\): duplicate column name"),
        ("DELETE FROM alembic_version", r"is empty\): there are tables already"),
        ("DROP TABLE sessions", r"it has no table sessions"),
    ],
)
def test_a_label_that_does_not_fit_is_reported(tmp_path: Path, change: str, said: str) -> None:
    settings = damaged(tmp_path, change)
    with pytest.raises(StoreUnavailableError, match=said) as told:
        Store(settings)
    assert "jobs.db" in str(told.value)
    assert "restore a backup of all its tables, or use an empty database" in str(told.value)


def test_serve_says_so_before_it_names_an_address(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    settings = damaged(tmp_path, "UPDATE alembic_version SET version_num = '0003'")
    assert main(["serve", "--port", "0", "--database", settings.database_url]) != 0
    said = capfd.readouterr()
    assert "serves at" not in said.out + said.err
    assert "do not fit its schema version" in said.err
    assert "Traceback" not in said.err
