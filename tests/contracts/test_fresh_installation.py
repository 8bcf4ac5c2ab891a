"""From an empty folder, with nothing but Python: the wheel is installed with pip, and the demo works."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.installation import build, install


@pytest.mark.slow  # fetches every package of the server, compiles the kernels
@pytest.mark.timeout(900)
def test_the_demo_works_in_a_new_installation(tmp_path: Path) -> None:
    installed = install(build("wheel", ROOT, tmp_path), tmp_path / "environment", extras="server")
    home, empty = tmp_path / "home", tmp_path / "empty"
    home.mkdir()
    empty.mkdir()
    done = subprocess.run(
        [installed.geoswarm, "demo", "--no-wait", "--port", "0", "--workers", "1"],
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
