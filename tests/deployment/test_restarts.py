"""What starts a process of a service also starts another one when it ends."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("process", ["api", "worker", "sweep"])
def test_systemd_and_compose_start_another_process(process: str) -> None:
    unit = (ROOT / "deploy" / "systemd" / f"geoswarm-{process}.service").read_text(encoding="utf-8")
    assert "Restart=always" in unit
    composition = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
    assert composition["services"][process]["restart"] == "unless-stopped"
