"""Nothing unpickles, nothing tells a secret, and secrets that everybody knows open nothing."""

from __future__ import annotations

import json
import logging
import re
import subprocess
import sys
from pathlib import Path

import pytest

from geoswarm.workers.errors import SettingsError
from geoswarm.workers.hosts.celery_app import create_celery
from geoswarm.workers.logs import JsonFormatter, TextFormatter
from geoswarm.workers.secrets import is_loopback, redact, refuse_known_secrets, refuse_weak_key
from geoswarm.workers.settings import Settings
from tests.contracts.repository import PACKAGES, ROOT, python_files
from tests.integration.engines import PATIENCE

KEY = "gsw_0123456789ab_" + "Ab1_-" * 8 + "xyz"
UNPICKLING = re.compile(
    r"\b(import|from)\s+(pickle|cPickle|_pickle|dill|cloudpickle|shelve|marshal|joblib|jsonpickle)\b"
    r"|allow_pickle\s*=\s*True|\byaml\.(unsafe_)?load\(|typ=.unsafe|\beval\(|\bexec\("
)


def test_nothing_is_unpickled_or_evaluated() -> None:
    found = [
        f"{path.relative_to(ROOT)}: {match[0]}"
        for path in python_files(*PACKAGES)
        for match in UNPICKLING.finditer(path.read_text(encoding="utf-8"))
    ]
    assert found == []
    reader = (ROOT / "solver" / "problem" / "text" / "yaml_nodes.py").read_text(encoding="utf-8")
    assert 'YAML(typ="safe"' in reader


def test_celery_takes_json_only() -> None:
    conf = create_celery(Settings(broker_url="redis://127.0.0.1:1/0")).conf
    assert list(conf.accept_content) == ["json"]
    assert list(conf.result_accept_content or ["json"]) == ["json"]
    assert (conf.task_serializer, conf.result_serializer, conf.event_serializer) == ("json", "json", "json")
    assert conf.worker_enable_remote_control is False


@pytest.mark.parametrize(
    ("text", "hidden", "kept"),
    [
        (f"key {KEY} refused", KEY[17:], "gsw_0123456789ab"),
        ("postgresql+psycopg://geoswarm:hunter22@db/jobs", "hunter22", "@db/jobs"),
        ("redis://:hunter22@redis:6379/0", "hunter22", "@redis:6379/0"),
        ("Authorization: Bearer hunter22-token", "hunter22", "Authorization"),
        ("{'x-api-key': 'hunter22'}", "hunter22", "x-api-key"),
        ("password=hunter22 host=db", "hunter22", "host=db"),
        ("Authorization: Basic aHVudGVyMjI=", "aHVudGVyMjI", "Authorization"),
    ],
)
def test_logs_hide_secrets(text: str, hidden: str, kept: str) -> None:
    assert hidden not in redact(text)
    assert kept in redact(text)
    try:
        raise ValueError(text)
    except ValueError:
        record = logging.LogRecord("geoswarm", logging.ERROR, __file__, 1, "%s", (text,), sys.exc_info())
    record.job, record.generation, record.evaluation = "abc", 3, 4
    for form in (JsonFormatter(), TextFormatter()):
        written = form.format(record)
        assert hidden not in written
        assert "Traceback" in written
    entry = json.loads(JsonFormatter().format(record))
    assert (entry["job"], entry["generation"], entry["evaluation"], entry["level"]) == ("abc", 3, 4, "error")
    assert "\n" not in JsonFormatter().format(record)
    assert "[job=abc generation=3 evaluation=4]" in TextFormatter().format(record)


def test_ordinary_text_is_logged_as_it_is() -> None:
    for text in ("job 0123 finished", "http://127.0.0.1:8765/jobs", "3 secrets of the trade", "a: b@c"):
        assert redact(text) == text


@pytest.mark.parametrize(
    "password", ["postgres", "changeme", "Password1", "geoswarm", "secret123", "aaaaaaaa", "redis"]
)
def test_passwords_that_everybody_knows_are_refused(password: str, monkeypatch: pytest.MonkeyPatch) -> None:
    remote = Settings(database_url=f"postgresql://geoswarm:{password}@db.example/jobs")
    with pytest.raises(SettingsError, match=r"password of the database on .* is publicly known") as error:
        refuse_known_secrets(remote)
    assert f":{password}@" not in str(error.value)
    with pytest.raises(SettingsError, match="password of the broker"):
        refuse_known_secrets(Settings(broker_url=f"redis://:{password}@redis.example/0"))
    with pytest.raises(SettingsError, match="GEOSWARM_API_KEY"):
        refuse_weak_key(password)
    monkeypatch.setenv("GEOSWARM_ENVIRONMENT", "development")
    refuse_known_secrets(remote)
    refuse_weak_key(password)


def test_good_passwords_and_those_of_this_machine_are_accepted() -> None:
    for url in (
        "postgresql://geoswarm:8f3b1d0e52a94c7788@db.example/jobs",
        "postgresql://geoswarm:postgres@127.0.0.1/jobs",
        "postgresql://geoswarm@db.example/jobs",
        "sqlite:///jobs.db",
    ):
        refuse_known_secrets(Settings(database_url=url))
    assert refuse_weak_key("8f3b1d0e52a94c7788" * 2) is None
    assert is_loopback("localhost")
    assert is_loopback("[::1]")
    assert not is_loopback("db.example")


def test_a_short_key_is_for_this_machine_only(monkeypatch: pytest.MonkeyPatch) -> None:
    short = "8f3b1d0e52a94c7788"
    with pytest.raises(SettingsError, match="GEOSWARM_API_KEY has 18 characters; at least 32 are accepted") as error:
        refuse_weak_key(short)
    assert short not in str(error.value)
    assert "at least 32" in str(refuse_weak_key(short, open_to_others=False))
    monkeypatch.setenv("GEOSWARM_ENVIRONMENT", "development")
    assert refuse_weak_key(short) is None


@pytest.mark.slow
def test_a_service_with_a_known_secret_does_not_start(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "geoswarm", "serve", "--port", "0", "--api-key", "changeme1"],
        cwd=tmp_path,
        env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 2
    assert "publicly known" in done.stderr
    assert "changeme1" not in done.stderr


def test_the_settings_hide_their_secrets() -> None:
    with pytest.raises(SettingsError) as error:
        Settings.from_environment(database_url="mysql://u:hunter22@h/x", broker_url="amqp://u:hunter22@h")
    assert "hunter22" not in str(error.value)
