"""Units, timer and Procfile in deploy/ start commands that exist, with the rights that they need and no more."""

from __future__ import annotations

import configparser
import re
import shlex
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.contracts.test_compose import parsed

UNITS = ROOT / "deploy" / "systemd"
SERVICES = sorted(UNITS.glob("*.service"))


def read(path: Path) -> configparser.ConfigParser:
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read(path, encoding="utf-8")
    return unit


@pytest.mark.parametrize("path", SERVICES, ids=lambda path: path.name)
def test_units_start_commands_that_exist(path: Path) -> None:
    program, *arguments = shlex.split(read(path)["Service"]["ExecStart"])
    assert program == "/opt/geoswarm/bin/geoswarm"
    assert parsed(arguments).info_name == path.stem.partition("-")[2].replace("api", "serve")


@pytest.mark.parametrize("path", SERVICES, ids=lambda path: path.name)
def test_units_run_without_privileges(path: Path) -> None:
    section = read(path)["Service"]
    assert section["User"] == "geoswarm"
    assert section["NoNewPrivileges"] == section["ProtectHome"] == section["PrivateTmp"] == "yes"
    assert section["ProtectSystem"] == "strict"
    assert section["CapabilityBoundingSet"] == ""
    assert section["EnvironmentFile"] == "/etc/geoswarm/geoswarm.env"
    assert "PASSWORD" not in path.read_text(encoding="utf-8")


def test_the_three_processes_are_there_and_start_again() -> None:
    lasting = {path.stem for path in SERVICES if read(path)["Service"].get("Restart") == "always"}
    assert lasting == {"geoswarm-api", "geoswarm-worker", "geoswarm-sweep"}
    timer = read(UNITS / "geoswarm-prune.timer")
    assert "OnCalendar" in timer["Timer"]
    assert (UNITS / "geoswarm-prune.service").is_file()


def test_the_procfile_starts_the_same() -> None:
    """That they work with the environment of the example: tests/deployment/test_procfile.py."""
    lines = dict(line.split(": ", 1) for line in (ROOT / "deploy" / "Procfile").read_text().splitlines() if line)
    assert set(lines) == {"api", "worker", "sweep", "prune"}
    for command in lines.values():
        program, *arguments = shlex.split(re.sub(r"\$\{\w+:-(\w+)\}", r"\1", command))
        assert program == "geoswarm"
        assert parsed(arguments).info_name in ("serve", "worker", "sweep", "prune")


def test_the_example_of_the_environment_holds_no_secret() -> None:
    text = (ROOT / "deploy" / "geoswarm.env.example").read_text(encoding="utf-8")
    assert set(re.findall(r":([^:@/\s]+)@", text)) == {"PASSWORD"}
    assert re.search(r"^GEOSWARM_API_KEY=$", text, flags=re.MULTILINE)
