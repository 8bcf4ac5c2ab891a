"""From an empty folder, with nothing but Python: the wheel is installed with pip, and the demo works."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.installation import Installation, build, install


@pytest.mark.slow  # fetches every package of the server, compiles the kernels
@pytest.mark.timeout(900)
def test_the_demo_works_in_a_new_installation(tmp_path: Path) -> None:
    wheel = build("wheel", ROOT, tmp_path)
    installed = Installation(tmp_path / "environment")
    subprocess.run([sys.executable, "-m", "venv", installed.folder], check=True)
    pip = [installed.python, "-m", "pip", "--disable-pip-version-check", "install", "--quiet", f"{wheel}[server]"]
    subprocess.run(pip, check=True, capture_output=True, text=True)
    home, empty = tmp_path / "home", tmp_path / "empty"
    home.mkdir()
    empty.mkdir()
    done = subprocess.run(
        [installed.script, "demo", "--no-wait", "--port", "0", "--workers", "1"],
        cwd=empty,
        env={"HOME": str(home), "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert re.search(r"lambda_star +λ\* +0\.08\d", done.stdout), done.stdout
    assert "Traceback" not in done.stdout + done.stderr
    assert list(empty.iterdir()) == []


@pytest.mark.slow  # fetches every package of the server and of the figures, compiles the kernels, follows all tutorials
@pytest.mark.timeout(3600)
def test_tutorials_work_in_a_new_installation(tmp_path: Path) -> None:
    installed = install(tmp_path, "server", "plots")
    home = tmp_path / "home"
    home.mkdir()
    done = subprocess.run(
        [installed.python, ROOT / "scripts" / "try_installed.py", "--tutorials"],
        cwd=tmp_path,
        env=installed.environment(HOME=str(home)),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    pages = {path.stem for path in (ROOT / "docs" / "tutorials").glob("*.md")} - {"README", "own-program"}
    assert set(re.findall(r"^([\w-]+): done", done.stdout, re.MULTILINE)) == pages
