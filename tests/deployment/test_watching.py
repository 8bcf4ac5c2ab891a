"""Alerts and dashboard name metrics that the service has; Prometheus and Grafana accept the files (slow)."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from prometheus_client.parser import text_string_to_metric_families
from ruamel.yaml import YAML

from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import App, service, settings
from tests.contracts.repository import ROOT
from tests.servers import find_program

__all__ = ["service", "settings"]

RULES = ROOT / "deploy" / "prometheus" / "geoswarm.rules.yml"
DASHBOARD = ROOT / "deploy" / "grafana" / "geoswarm.json"
TOOLS = Path.home() / ".cache" / "geoswarm-tests"
METRIC = re.compile(r"\bgeoswarm_\w+")
LABEL = re.compile(r"(geoswarm_\w+)\{([^}]*)\}")
MATCHER = re.compile(r'(\w+)\s*(=~|!~|!=|=)\s*"([^"]*)"')


def rules() -> list[dict[str, Any]]:
    document = YAML(typ="safe").load(RULES.read_text(encoding="utf-8"))
    return [rule for group in document["groups"] for rule in group["rules"]]


def panels() -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads(DASHBOARD.read_text(encoding="utf-8"))["panels"]
    return found


def expressions() -> list[str]:
    return [rule["expr"] for rule in rules()] + [
        target["expr"] for panel in panels() for target in panel.get("targets", [])
    ]


@pytest.fixture
def samples(service: JobService) -> dict[str, list[dict[str, str]]]:
    """Labels of all samples of each metric that the service tells."""
    app = App(service)
    app.get("/metrics")
    found: dict[str, list[dict[str, str]]] = {}
    for family in text_string_to_metric_families(app.get("/metrics").text):
        for sample in family.samples:
            found.setdefault(sample.name, []).append(sample.labels)
    return found


def test_every_metric_and_label_that_is_named_exists(samples: dict[str, list[dict[str, str]]]) -> None:
    for expression in expressions():
        names = set(METRIC.findall(expression))
        assert names <= set(samples), expression
        for name, labels in LABEL.findall(expression):
            for label, kind, value in MATCHER.findall(labels):
                known = {labels[label] for labels in samples[name]}
                if kind in ("=", "=~") and label in ("state", "action", "outcome"):
                    assert set(value.split("|")) <= known, expression
    assert len(expressions()) > 30


def test_every_metric_of_the_installation_is_on_the_dashboard(samples: dict[str, list[dict[str, str]]]) -> None:
    shown = {
        name for panel in panels() for target in panel.get("targets", []) for name in METRIC.findall(target["expr"])
    }
    families = {re.sub("_(bucket|sum|count|created)$", "", name) for name in samples if name.startswith("geoswarm_")}
    assert families == {re.sub("_bucket$", "", name) for name in shown}


def test_every_alert_says_what_is_wrong_how_bad_and_what_to_look_at() -> None:
    documentation = (ROOT / "docs" / "watching.md").read_text(encoding="utf-8")
    names = [rule["alert"] for rule in rules()]
    assert len(names) == len(set(names)) > 8
    for rule in rules():
        assert rule["labels"]["severity"] in ("critical", "warning", "info")
        assert set(rule["annotations"]) == {"summary", "description"}
        assert f"`{rule['alert']}`" in documentation


def test_panels_have_their_own_numbers_and_do_not_overlap() -> None:
    assert len({panel["id"] for panel in panels()}) == len(panels())
    taken: set[tuple[int, int]] = set()
    for panel in panels():
        place = panel["gridPos"]
        cells = {
            (x, y)
            for x in range(place["x"], place["x"] + place["w"])
            for y in range(place["y"], place["y"] + place["h"])
        }
        assert place["x"] + place["w"] <= 24
        assert not cells & taken, panel["title"]
        taken |= cells
        assert panel["type"] == "row" or (panel["targets"] and panel["fieldConfig"]["defaults"]["unit"])


def promtool() -> Path:
    """Prometheus's own checker, out of Debian's package, which is not installed: it would start a server."""
    folder = TOOLS / "promtool"
    program = folder / "usr" / "bin" / "promtool"
    if not program.exists():
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(["apt-get", "download", "prometheus"], cwd=folder, check=True, capture_output=True)
        (package,) = folder.glob("prometheus_*.deb")
        subprocess.run(["dpkg", "-x", str(package), str(folder)], check=True)
        package.unlink()
    return program


@pytest.mark.slow
def test_prometheus_accepts_the_rules_and_alerts_as_it_should(tmp_path: Path) -> None:
    given = (Path(__file__).parent / "alerts.yml").read_text(encoding="utf-8").replace("RULES", str(RULES))
    (tmp_path / "alerts.yml").write_text(given, encoding="utf-8")
    (tmp_path / "geoswarm.rules.yml").write_text(RULES.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "geoswarm.key").write_text("key")
    example = (RULES.parent / "prometheus.example.yml").read_text(encoding="utf-8")
    (tmp_path / "prometheus.yml").write_text(
        example.replace("/etc/prometheus/geoswarm.key", str(tmp_path / "geoswarm.key")), encoding="utf-8"
    )
    for arguments in (
        ["check", "rules", str(RULES)],
        ["check", "config", "prometheus.yml"],
        ["test", "rules", "alerts.yml"],
    ):
        done = subprocess.run([promtool(), *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_the_dashboard_has_the_types_of_grafanas_schema(tmp_path: Path) -> None:
    folder = TOOLS / "grafana-schema"
    if not (folder / "node_modules" / "@grafana" / "schema").exists():
        folder.mkdir(parents=True, exist_ok=True)
        packages = ["@grafana/schema@13", "typescript@5"]
        install = [find_program("npm"), "install", "--no-audit", "--no-fund", "--ignore-scripts", *packages]
        subprocess.run(install, cwd=folder, check=True, capture_output=True)
    (tmp_path / "node_modules").symlink_to(folder / "node_modules")
    # An enumeration of TypeScript takes no text, although its values are texts.
    text = DASHBOARD.read_text(encoding="utf-8").replace('"absolute"', "ThresholdsMode.Absolute")
    head = "import { type Dashboard, ThresholdsMode } from '@grafana/schema';\n"
    options = ["--noEmit", "--strict", "--skipLibCheck", "--module", "esnext", "--moduleResolution", "bundler"]

    def check(dashboard: str) -> str:
        (tmp_path / "dashboard.ts").write_text(f"{head}export const dashboard: Dashboard = {dashboard};\n")
        compiler = folder / "node_modules" / ".bin" / "tsc"
        command = [compiler, *options, "--target", "es2022", "dashboard.ts"]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout

    assert check(text) == ""
    wrong = check(text.replace("schemaVersion", "schemaVersions"))
    assert re.search(r"schemaVersions.* does not exist in type 'Dashboard'", wrong)
