"""``make setup`` tells uv what pip's configuration says, and leaves the work to pip where that cannot be told."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

import pytest

from tests.contracts.repository import ROOT

CONFIGURATION = """\
[global]
index-url = https://packages.example/simple
extra-index-url =
    https://one.example/simple
    https://two.example/simple
find-links = /srv/wheels /srv/more
timeout = 60
[install]
proxy = http://proxy.example:3128
trusted-host = packages.example
"""
LOCKED = "numpy==2.3.4 \\\n    --hash=sha256:00\nruff==0.9.1 \\\n    --hash=sha256:00\n"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    for name in [name for name in os.environ if name.startswith(("UV_", "PIP_"))]:
        monkeypatch.delenv(name)
    found = importlib.util.spec_from_file_location("install_locked", ROOT / "scripts" / "install_locked.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_pips_configuration_is_told_to_uv(script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "pip.conf"
    file.write_text(CONFIGURATION, encoding="utf-8")
    for name in ("XDG_CONFIG_DIRS", "XDG_CONFIG_HOME"):  # the machine's and the user's own configuration
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setenv("PIP_CONFIG_FILE", str(file))
    monkeypatch.setenv("PIP_CERT", "/srv/roots.pem")
    own = {"find-links", "cert", "index-url", "extra-index-url", "proxy", "trusted-host"}
    found = {name: value for name, value in script.pip_settings().items() if name in own}  # /etc/pip.conf may have more
    told = script.uv_environment(found, LOCKED)
    expected = {
        "UV_DEFAULT_INDEX": "https://packages.example/simple",
        "UV_INDEX": "https://one.example/simple https://two.example/simple",
        "UV_FIND_LINKS": "/srv/wheels,/srv/more",
        "UV_INSECURE_HOST": "packages.example",
        "HTTP_PROXY": "http://proxy.example:3128",
        "HTTPS_PROXY": "http://proxy.example:3128",
        "SSL_CERT_FILE": "/srv/roots.pem",
    }
    assert expected.items() <= told.items()


@pytest.mark.parametrize("name", ["client-cert", "keyring-provider", "no-index", "constraint", "something-new"])
def test_what_uv_cannot_be_told_is_left_to_pip(
    script: ModuleType, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    assert script.uv_environment({"timeout": "9", name: "x"}, LOCKED) is None
    assert name in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "bound"),
    [
        ("# a cap\ntorch<=2.14.1  # and why\n\nTorchVision ~= 0.29\n", None),
        ("torch<=2.14.1\nNumPy<2\n", "NumPy<2"),
        ("-c more.txt\n", "-c more.txt"),
        ("numpy @ https://packages.example/numpy.whl\n", "numpy @ https://packages.example/numpy.whl"),
    ],
)
def test_constraints_matter_if_they_bound_what_is_locked(
    script: ModuleType, capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, bound: str | None
) -> None:
    file = tmp_path / "constraints.txt"
    file.write_text(text, encoding="utf-8")
    found = script.uv_environment({"constraint": str(file)}, LOCKED)
    assert (found is None) is (bound is not None)
    if bound is not None:
        assert f"bounds {bound}, " in capsys.readouterr().out


def test_own_settings_of_uv_win(script: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UV_DEFAULT_INDEX", "https://own.example")
    assert (
        script.uv_environment({"index-url": "https://pip.example"}, LOCKED)["UV_DEFAULT_INDEX"] == "https://own.example"
    )


def test_pip_installs_the_lock_where_uv_fails(script: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[list[str]] = []

    class Done:
        returncode = 1
        stderr = "no such index"

    def refuse_uv(command: list[str], **_: object) -> Done:
        ran.append(command)
        return Done()

    monkeypatch.setattr(script, "pip_settings", dict)
    monkeypatch.setattr(script, "install_uv", lambda _: True)
    monkeypatch.setattr(script.subprocess, "run", refuse_uv)
    script.main()
    assert [command[:3] == [sys.executable, "-m", "uv"] for command in ran] == [True, False, False]
    assert "--require-hashes" in ran[1]
    assert str(script.LOCK) in ran[1]
    assert {"--no-deps", "--no-build-isolation", "--editable"} <= set(ran[2])
