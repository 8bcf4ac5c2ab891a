"""Configuration of other programs that pages show: those programs, or what is known of their form, accept it."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from geoswarm.client import errors
from tests.contracts.repository import ROOT
from tests.deployment.nginx import nginx_configuration
from tests.documentation.pages import block
from tests.servers import find_program


@pytest.mark.slow  # nginx is installed for the slow tests only
def test_nginx_accepts_the_proxy(tmp_path: Path) -> None:
    """As it is printed but for certificate and ports; tests/deployment sends requests through it."""
    configuration = tmp_path / "nginx.conf"
    configuration.write_text(nginx_configuration(tmp_path, 8443, 8765))
    nginx = find_program("nginx", [Path("/usr/sbin")])
    command = [str(nginx), "-t", "-p", str(tmp_path), "-c", str(configuration), "-e", "stderr"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_rule_of_the_adapter_has_the_metrics_of_the_service() -> None:
    """Its name is compared with the scaler's in tests/deployment."""
    ((rule,),) = YAML(typ="safe", pure=True).load(block("deploy/kubernetes/README.md", "rules:").text)["rules"].values()
    assert rule.keys() == {"seriesQuery", "name", "resources", "metricsQuery"}
    known = (ROOT / "deploy" / "grafana" / "geoswarm.json").read_text(encoding="utf-8")
    for metric in re.findall(r"geoswarm_\w+", rule["metricsQuery"]):
        assert metric in known


def test_errors_of_the_client_are_drawn_as_they_descend() -> None:
    tree = block("docs/python-client.md", "GeoswarmError").text.splitlines()
    above: list[type] = []
    drawn = set()
    for line in tree:
        drawing, name = re.match(r"([│├└─ ]*)(\w+)", line).groups()  # type: ignore[union-attr]
        depth = len(drawing) // 4
        kind = getattr(errors, name)
        assert depth == 0 or kind.__bases__ == (above[depth - 1],), name
        above[depth:] = [kind]
        drawn.add(name)
    assert drawn == set(errors.__all__) - {"Issue"}
