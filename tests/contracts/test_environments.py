"""Fresh environments: the lock gives the same files twice; the lowest and the newest versions pass the tests.

uv makes the environments, so that its settings say where packages come from. What runs in those of other versions:
everything but the long studies, the finite elements, the verification by published numbers, browsers and what
looks at the repository itself: the same code runs in the locked environment, and its time is better spent there.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.installation import uv

pytestmark = [pytest.mark.slow, pytest.mark.timeout(3600)]

EXTRAS = ("server", "plots", "mesh", "statistics", "parquet", "dev")
COPIED = ("api", "docs", "examples", "geoswarm", "requirements", "scripts", "solver", "tests", "workers")
TESTS = (
    *("tests/solver/problem", "tests/solver/expressions", "tests/solver/element_test", "tests/solver/constitutive"),
    *("tests/solver/search", "tests/solver/test_calibration.py", "tests/solver/test_local.py", "tests/solver/report"),
    *("tests/geoswarm", "tests/workers", "tests/api"),
)
VARIES = re.compile(r"(^|/)(__pycache__/.*|[^/]+\.dist-info/(RECORD|direct_url\.json|uv_cache\.json))$")
"""Byte code holds times of files; RECORD lists the scripts of bin/, whose first line is the environment's own path."""


def environment(folder: Path) -> Path:
    """Make an empty environment; return its interpreter."""
    uv("venv", "--quiet", "--python", sys.executable, folder)
    return folder / "bin" / "python"


def installed(python: Path) -> str:
    return uv("pip", "freeze", "--python", python)


def hashes(folder: Path) -> dict[str, str]:
    (packages,) = folder.glob("lib/python*/site-packages")
    files = {path.relative_to(packages).as_posix(): path for path in packages.rglob("*") if path.is_file()}
    return {
        name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items() if not VARIES.search(name)
    }


def test_two_installations_from_the_lock_are_identical(tmp_path: Path) -> None:
    frozen, files = [], []
    for name in ("one", "two"):
        python = environment(tmp_path / name)
        uv("pip", "install", "--python", python, "--require-hashes", "-r", ROOT / "requirements" / "image.txt")
        uv("pip", "install", "--python", python, "--no-deps", "--no-build-isolation", ROOT)
        frozen.append(re.sub(r"^geoswarm @ .*$", "geoswarm", installed(python), flags=re.MULTILINE))
        files.append(hashes(tmp_path / name))
    assert frozen[0] == frozen[1]
    assert files[0] == files[1]
    assert len(files[0]) > 5000


@pytest.mark.parametrize("resolution", ["lowest-direct", "highest"])
def test_the_tests_pass_with_other_versions(tmp_path: Path, resolution: str) -> None:
    python = environment(tmp_path / "environment")
    extras = [word for extra in EXTRAS for word in ("--extra", extra)]
    uv("pip", "install", "--python", python, "--resolution", resolution, "-r", ROOT / "pyproject.toml", *extras)
    checkout = copy_of_the_checkout(tmp_path / "checkout")  # kernels of other versions are cached beside the sources
    uv("pip", "install", "--python", python, "--no-deps", "--no-build-isolation", "--editable", checkout)
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "NUMBA_CACHE"))}
    expect_success([python, "-m", "geoswarm.solver.warm"], checkout, clean)
    options = ("-q", "-m", "not slow", "-p", "no:cacheprovider", "-p", "no:xdist", "--tb=short")
    expect_success([python, "-m", "pytest", *options, *TESTS], checkout, clean)


def copy_of_the_checkout(folder: Path) -> Path:
    for name in COPIED:
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, symlinks=True, ignore=ignored)
    for path in ROOT.iterdir():
        if path.is_file() and path.name != ".git":
            shutil.copy2(path, folder / path.name)
    return folder


def expect_success(command: list[str | Path], folder: Path, variables: dict[str, str]) -> None:
    done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-20_000:] + done.stderr[-4000:]
