"""A release names one version everywhere, and its notes are those of the changelog."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from scripts.check_release import PLACES, disagreements, notes, version
from tests.contracts.repository import ROOT

WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def copy(folder: Path) -> Path:
    for name in (*PLACES, "pyproject.toml", "CHANGELOG.md"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes((ROOT / name).read_bytes())
    return folder


def test_the_version_is_the_same_in_every_place() -> None:
    assert disagreements() == []
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert notes(version()) is not None or f"Will be {version()}." in text


@pytest.mark.parametrize("name", PLACES)
def test_a_place_with_another_version_is_named(tmp_path: Path, name: str) -> None:
    root = copy(tmp_path)
    path = root / name
    path.write_text(path.read_text(encoding="utf-8").replace(version(), "9.9.9"), encoding="utf-8")
    assert disagreements(root) == [f"{name}: version 9.9.9, but pyproject.toml has {version()}"]


def test_notes_are_the_part_of_the_changelog(tmp_path: Path) -> None:
    (tmp_path / "CHANGELOG.md").write_text(
        "# Changelog\n\n## [Unreleased]\n\n- later\n\n## [1.2.0] - 2026-01-02\n\n- new\n\n"
        "## [1.1.0] - 2025-01-02\n\n- old\n"
    )
    assert notes("1.2.0", tmp_path) == "- new\n"
    assert notes("1.1.0", tmp_path) == "- old\n"
    assert notes("Unreleased", tmp_path) is None
    assert notes("3.0.0", tmp_path) is None


def test_a_tag_that_is_not_the_version_is_refused() -> None:
    done = subprocess.run(
        [sys.executable, "scripts/check_release.py", "v9.9.9"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert f"tag v9.9.9: pyproject.toml has {version()}" in done.stderr
    assert "CHANGELOG.md: has no heading `## [9.9.9] - YYYY-MM-DD`" in done.stderr


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_workflows_give_no_more_rights_than_needed_and_name_what_they_use(path: Path) -> None:
    workflow = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert workflow["permissions"]["contents"] == "read"
    for job in workflow["jobs"].values():
        assert job["runs-on"]
        for step in job["steps"]:
            assert ("uses" in step) != ("run" in step)
            assert "uses" not in step or re.fullmatch(r"[\w.-]+/[\w.-]+@[\w./-]+", step["uses"])
            for script in re.findall(r"(?:^|\s)(scripts/\w+\.py|\.ci/run)", step.get("run", "")):
                assert (ROOT / script).is_file(), script
            for folder in re.findall(r"--output-file (\S+)/", step.get("run", "")):  # cyclonedx-py makes none
                assert f"mkdir {folder}\n" in step["run"]
