"""The wheel holds all that an installation needs, and nothing else."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from email.parser import Parser
from importlib import import_module
from pathlib import Path

import pytest

from hatch_build import LEFT_OUT, SHOWN
from tests.contracts.repository import PACKAGES, ROOMS, ROOT, project
from tests.installation import build

LINKED = (*ROOMS, "examples")
NEEDED_BESIDE_PYTHON = (
    "geoswarm/py.typed",
    *(f"geoswarm/{room}/py.typed" for room in ROOMS),
    "geoswarm/workers/store/migrations/script.py.mako",
    "geoswarm/api/templates/base.html",
    "geoswarm/examples/oedometer/problem.yaml",
    "geoswarm/docs/tutorials/README.md",
)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build("wheel", ROOT, tmp_path_factory.mktemp("wheel"))


def names(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def metadata(wheel: Path, name: str) -> str:
    (path,) = (entry for entry in names(wheel) if entry.endswith(f".dist-info/{name}"))
    return contents(wheel)[path].decode()


def installed_name(path: str) -> str:
    """Return the place in the wheel of a file of the repository."""
    return f"geoswarm/{path}" if path.partition("/")[0] in LINKED else path


def test_the_wheel_has_one_package_and_its_metadata(wheel: Path) -> None:
    tops = {name.partition("/")[0] for name in names(wheel)}
    assert tops == {"geoswarm", f"geoswarm-{project()['project']['version']}.dist-info"}


def test_the_wheel_has_every_source_and_every_file_beside_it(wheel: Path) -> None:
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *PACKAGES, "examples"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout.splitlines()
    present = {installed_name(path) for path in listed if (ROOT / path).is_file()}
    docs = (path.relative_to(ROOT) for kind in SHOWN for path in (ROOT / "docs").rglob(f"*{kind}"))
    present |= {f"geoswarm/{path.as_posix()}" for path in docs if path.parts[1] not in LEFT_OUT}
    made_for_the_examples = {installed_name(str(path.relative_to(ROOT))) for path in (ROOT / "examples").glob("*.py")}
    assert {name for name in names(wheel) if ".dist-info/" not in name} == present - made_for_the_examples
    assert set(NEEDED_BESIDE_PYTHON) <= names(wheel)


# two more builds; the tests above read a wheel of the same sources
@pytest.mark.slow
def test_a_wheel_from_the_source_archive_is_the_same(wheel: Path, tmp_path: Path) -> None:
    archive = build("sdist", ROOT, tmp_path)
    with tarfile.open(archive) as opened:  # of our own making; filters came with Python 3.11.4
        opened.extraction_filter = getattr(tarfile, "data_filter", None)
        opened.extractall(tmp_path)
    again = build("wheel", tmp_path / archive.name.removesuffix(".tar.gz"), tmp_path)
    assert contents(again) == contents(wheel)


def test_a_build_without_links_says_what_is_wrong(tmp_path: Path) -> None:
    for name in ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tmp_path)
    (tmp_path / "geoswarm").mkdir()
    for name in LINKED:  # what git writes where it may make no links
        (tmp_path / "geoswarm" / name).write_text(f"../{name}")
    with pytest.raises(subprocess.CalledProcessError) as stopped:
        build("wheel", tmp_path, tmp_path)
    said = stopped.value.stderr
    assert "geoswarm/api, geoswarm/examples, geoswarm/solver, geoswarm/workers must be links" in said
    assert "git clone -c core.symlinks=true" in said
    assert "Traceback" not in said


@pytest.mark.parametrize("name", LINKED)
def test_links_are_relative_and_tracked(name: str) -> None:
    link = ROOT / "geoswarm" / name
    assert str(link.readlink()) == f"../{name}"
    listed = subprocess.run(["git", "ls-files", "-s", str(link)], cwd=ROOT, check=True, capture_output=True, text=True)
    assert listed.stdout.startswith("120000 ")


@pytest.mark.parametrize(
    "statement", [f"import {room}" for room in ROOMS] + ["import solver.search", "from api import app"]
)
def test_a_room_cannot_be_imported_by_its_bare_name(statement: str) -> None:
    code = [sys.executable, "-c", f"import geoswarm.solver\n{statement}"]
    done = subprocess.run(code, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert re.search(r"ImportError: import geoswarm\.(api|workers|solver): ", done.stderr), done.stderr


def test_every_folder_of_sources_is_a_package() -> None:
    folders = {path.parent for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    scripts = {ROOT / "workers/store/migrations/versions"}  # Alembic loads these by path
    assert sorted(folder for folder in folders - scripts if not (folder / "__init__.py").exists()) == []


def test_metadata_is_complete(wheel: Path) -> None:
    fields = Parser().parsestr(metadata(wheel, "METADATA"))
    assert fields["Name"] == "geoswarm"
    assert fields["Version"] == project()["project"]["version"]
    assert fields["License-Expression"] == "Apache-2.0"
    extras = {"server", "tracing", "plots", "mesh", "statistics", "parquet", "pest", "mfront", "bench", "dev"}
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
