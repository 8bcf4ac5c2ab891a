from __future__ import annotations

import pytest

from geoswarm.workers.errors import SettingsError
from geoswarm.workers.execution.sandbox import limits_of
from geoswarm.workers.settings import Settings, mask_url
from tests.workers.problems import line


def test_defaults_need_nothing() -> None:
    settings = Settings.from_environment()
    assert settings.database_url == "sqlite:///geoswarm.db"
    assert settings.broker_url is None
    assert settings.workers >= 1


def test_environment_and_overrides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_DATABASE_URL", "postgresql://u:p@db/jobs")
    monkeypatch.setenv("GEOSWARM_BROKER_URL", "redis://broker:6379/0")
    monkeypatch.setenv("GEOSWARM_WORKERS", "3")
    settings = Settings.from_environment(workers=None, broker_url="redis://other:6379/1")
    assert settings.database_url == "postgresql+psycopg://u:p@db/jobs"
    assert settings.broker_url == "redis://other:6379/1"
    assert settings.workers == 3


@pytest.mark.parametrize(
    ("given", "limit"), [(None, 3600.0), ("none", None), ("None", None), ("0", None), ("0.0", None), ("90", 90.0)]
)
def test_an_evaluation_has_a_limit_of_time_unless_none_is_wanted(
    given: str | None, limit: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    if given is not None:
        monkeypatch.setenv("GEOSWARM_EVALUATION_SECONDS", given)
    settings = Settings.from_environment()
    assert settings.evaluation_seconds == limit
    assert Settings(**settings.model_dump()).evaluation_seconds == limit  # as workers get it
    assert limits_of(line(), settings).seconds == limit
    assert limits_of(line(limits={"seconds_per_evaluation": 7}), settings).seconds == 7


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("database_url", "mysql://u:secret@h/d", "names the database 'mysql'; accepted: sqlite, postgresql"),
        ("database_url", "sqlite://", "must name a file"),
        ("database_url", "sqlite:///:memory:", "must name a file"),
        ("database_url", "no address", "is not an address; accepted: sqlite"),
        ("broker_url", "amqp://u:secret@h", "must be a Redis address; accepted: redis://"),
        ("workers", "many", "workers .*valid integer"),
        ("workers", -1, "workers .*greater than or equal to 0"),
        ("evaluation_seconds", "long", "evaluation_seconds .*valid number"),
        ("evaluation_seconds", -1, "evaluation_seconds .*greater than 0"),
        ("heartbeat_seconds", 10.0, "at most half of lease_seconds"),
    ],
)
def test_mistakes_name_the_field_and_what_is_accepted(field: str, value: object, message: str) -> None:
    with pytest.raises(SettingsError, match=message) as caught:
        Settings.from_environment(**{field: value})
    assert field in str(caught.value)
    assert "secret" not in str(caught.value)
    assert "\n" not in str(caught.value)


def test_mistakes_name_variable_and_value(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_QUOTA_JOBS", "many")
    monkeypatch.setenv("GEOSWARM_BROKER_URL", "amqp://u:hunter2@h")
    with pytest.raises(SettingsError) as caught:
        Settings.from_environment(disk_reserve_mb=-1, workers=None)
    assert str(caught.value) == (
        "GEOSWARM_BROKER_URL must be a Redis address; accepted: redis://, rediss://, redis+socket://, unix://; "
        "disk_reserve_mb -1: Input should be greater than or equal to 0; "
        "GEOSWARM_QUOTA_JOBS 'many': Input should be a valid integer, unable to parse string as an integer"
    )


def test_only_what_an_operator_chooses_comes_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_ISOLATE", "no")
    monkeypatch.setenv("GEOSWARM_WORKERS", "")
    assert Settings.from_environment() == Settings()
    monkeypatch.setenv("GEOSWARM_WORKERS", "1000")
    assert Settings().workers != 1000  # what code makes reads nothing


def test_masked_addresses_hold_no_password() -> None:
    assert mask_url("postgresql://me:secret@host/db") == "postgresql://me:***@host/db"
    assert mask_url("redis://:secret@host:6379/0") == "redis://:***@host:6379/0"
    assert "secret" not in mask_url("::secret")
