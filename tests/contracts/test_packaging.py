"""The wheel holds all that an installation needs, and nothing else."""

from __future__ import annotations

import re
import subprocess
import sys
import zipfile
from email.parser import Parser
from importlib import import_module
from pathlib import Path

import pytest

from tests.contracts.repository import PACKAGES, ROOT, project

NEEDED_BESIDE_PYTHON = (
    *(f"{package}/py.typed" for package in PACKAGES),
    "workers/store/migrations/script.py.mako",
)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built as pip would."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (made,) = folder.glob("*.whl")
    return made


def names(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def metadata(wheel: Path, name: str) -> str:
    with zipfile.ZipFile(wheel) as archive:
        (path,) = (entry for entry in archive.namelist() if entry.endswith(f".dist-info/{name}"))
        return archive.read(path).decode()


def test_wheel_has_the_four_packages_and_nothing_else(wheel: Path) -> None:
    tops = {name.split("/")[0] for name in names(wheel) if ".dist-info/" not in name}
    assert tops == set(PACKAGES)


def test_wheel_has_every_source_and_every_file_beside_it(wheel: Path) -> None:
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *PACKAGES],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout.splitlines()
    present = {path for path in listed if (ROOT / path).exists()}
    assert present - names(wheel) == set()
    assert set(NEEDED_BESIDE_PYTHON) <= names(wheel)


def test_every_folder_of_sources_is_a_package() -> None:
    folders = {path.parent for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    scripts = {ROOT / "workers/store/migrations/versions"}  # Alembic loads these by path
    assert sorted(folder for folder in folders - scripts if not (folder / "__init__.py").exists()) == []


def test_metadata_is_complete(wheel: Path) -> None:
    fields = Parser().parsestr(metadata(wheel, "METADATA"))
    assert fields["Name"] == "geoswarm"
    assert fields["Version"] == project()["project"]["version"]
    assert fields["License-Expression"] == "Apache-2.0"
    extras = {"server", "tracing", "plots", "mesh", "statistics", "parquet", "bench", "dev"}
    assert set(fields.get_all("Provides-Extra", [])) == extras
    assert "# " in fields.get_payload()
    assert "Apache License" in metadata(wheel, "licenses/LICENSE")


def test_entry_points_lead_somewhere() -> None:
    section = project()["project"]
    targets = [*section["scripts"].values(), *section["entry-points"]["geoswarm.forward_models"].values()]
    for target in targets:
        module, _, name = target.partition(":")
        assert callable(getattr(import_module(module), name)), target


def test_changelog_knows_the_version() -> None:
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    version = re.escape(project()["project"]["version"])
    assert re.search(rf"^## \[{version}\]|^## \[Unreleased\]\n\nWill be {version}\.$", changelog, flags=re.MULTILINE)
