"""Secrets come from a variable or from a file, never from both, and no message tells them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from pydantic import SecretStr

from geoswarm import Client, GeoswarmError
from geoswarm.api import ApiSettings
from geoswarm.api.errors import ApiSettingsError
from geoswarm.cli import main
from geoswarm.environment import SecretFileError, secret
from geoswarm.workers.errors import SettingsError
from geoswarm.workers.settings import Settings

KEY = "8f3b1d0e52a94c7788"


def written(folder: Path, content: str | bytes) -> str:
    path = folder / "secret"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return str(path)


def test_the_variable_or_the_one_line_of_the_file(tmp_path: Path) -> None:
    assert secret("KEY", {}) is None
    assert secret("KEY", {"KEY": "", "KEY_FILE": ""}) is None
    assert secret("KEY", {"KEY": "a b"}) == "a b"
    for content in (KEY, f"{KEY}\n", f"{KEY}\r\n"):
        assert secret("KEY", {"KEY_FILE": written(tmp_path, content)}) == KEY


@pytest.mark.parametrize("content", ["", "\n", "   \n", f"{KEY}\n{KEY}\n", KEY * 300, b"\xff\xfe" + KEY.encode()])
def test_a_file_that_holds_no_single_line_is_refused(content: str | bytes, tmp_path: Path) -> None:
    path = written(tmp_path, content)
    with pytest.raises(SecretFileError, match=r"^KEY_FILE: ") as caught:
        secret("KEY", {"KEY_FILE": path})
    assert path in str(caught.value)
    assert KEY not in str(caught.value)


def test_a_missing_file_and_two_sources_are_named(tmp_path: Path) -> None:
    with pytest.raises(SecretFileError, match=r"KEY_FILE: .*/nothing cannot be read: No such file"):
        secret("KEY", {"KEY_FILE": f"{tmp_path}/nothing"})
    with pytest.raises(SecretFileError, match="KEY and KEY_FILE are both set"):
        secret("KEY", {"KEY": KEY, "KEY_FILE": written(tmp_path, KEY)})


def test_settings_of_engine_service_and_client_read_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, content in (
        ("DATABASE_URL", "postgresql://u:hunter22@db/jobs"),
        ("BROKER_URL", "redis://:hunter22@broker:6379/0"),
        ("API_KEY", KEY),
    ):
        path = tmp_path / name
        path.write_text(content + "\n")
        monkeypatch.setenv(f"GEOSWARM_{name}_FILE", str(path))
    settings = Settings.from_environment()
    assert settings.database_url == "postgresql+psycopg://u:hunter22@db/jobs"
    assert settings.broker_url == "redis://:hunter22@broker:6379/0"
    assert ApiSettings.from_environment().api_key == SecretStr(KEY)
    with Client() as client:
        assert client._http.headers["Authorization"] == f"Bearer {KEY}"
    assert Settings.from_environment(database_url="sqlite:///a.db").database_url == "sqlite:///a.db"

    os.truncate(tmp_path / "DATABASE_URL", 0)
    os.truncate(tmp_path / "API_KEY", 0)
    with pytest.raises(SettingsError, match="GEOSWARM_DATABASE_URL_FILE"):
        Settings.from_environment()
    with pytest.raises(ApiSettingsError, match="GEOSWARM_API_KEY_FILE"):
        ApiSettings.from_environment()
    with pytest.raises(GeoswarmError, match="GEOSWARM_API_KEY_FILE"):
        Client()


def test_commands_read_files_and_the_command_line_wins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GEOSWARM_DATABASE_URL_FILE", written(tmp_path, f"sqlite:///{tmp_path}/jobs.db"))
    assert main(["keys", "create", "--owner", "anna"]) == 0
    assert (tmp_path / "jobs.db").exists()
    monkeypatch.setenv("GEOSWARM_DATABASE_URL", "sqlite:///elsewhere.db")
    assert main(["keys", "list"]) == 2
    assert "both set" in capsys.readouterr().err
    assert main(["keys", "list", "--database", f"sqlite:///{tmp_path}/jobs.db"]) == 0
    assert "anna" in capsys.readouterr().out
    monkeypatch.setenv("GEOSWARM_API_KEY_FILE", f"{tmp_path}/nothing")
    assert main(["list"]) == 2
    error = capsys.readouterr().err
    assert f"GEOSWARM_API_KEY_FILE: {tmp_path}/nothing cannot be read" in error
    assert "Traceback" not in error
