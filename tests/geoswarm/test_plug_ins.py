"""The plug-in of the documentation: installed, found and run as its author would."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.installation import uv

PAGE = (Path(__file__).parents[2] / "docs" / "plug-ins.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    """The first one on the page; that of a soil law is in tests/solver/laws."""
    return str(re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[0])


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which the package is installed."""
    source, target = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("target")
    (source / "pyproject.toml").write_text(block("toml"), encoding="utf-8")
    (source / "geoswarm_terzaghi.py").write_text(block("python"), encoding="utf-8")
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--python", sys.executable, "--target", str(target))
    uv("pip", "install", *options, source)
    return target


def geoswarm(installed: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment: Mapping[str, str] = {**os.environ, "PYTHONPATH": str(installed)}
    return subprocess.run(
        [sys.executable, "-m", "geoswarm", *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_its_problem_is_calibrated(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "problem.yaml").write_text(block("yaml"), encoding="utf-8")
    done = geoswarm(installed, tmp_path, "run", "problem.yaml", "--seed", "1", "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    # Early on s = s_end sqrt(4 c_v t / (pi d^2)): the points lie on 0.0056 sqrt(t) up to half of the settlement.
    product = result["parameters"]["s_end"] * (4.0 * result["parameters"]["c_v"] / 3.14159265 / 2.0**2) ** 0.5
    assert product == pytest.approx(0.0056, rel=0.03)


def test_it_settles_as_the_tables_say(installed: Path, tmp_path: Path) -> None:
    """Degree of consolidation 50 % at T = 0.197, 90 % at T = 0.848 (any textbook)."""
    document = {
        "name": "table",
        "forward_model": {"kind": "terzaghi", "drainage_path": 1.0},
        "parameters": {"s_end": {"value": 1.0}, "c_v": {"lower": 0.5, "upper": 2.0}},
        "observations": [{"series": "settlement", "points": {"x": [0.0, 0.197, 0.848], "y": [0.0, 0.5, 0.9]}}],
        "method": {"kind": "monte_carlo", "samples": 1},
    }
    (tmp_path / "problem.json").write_text(json.dumps(document), encoding="utf-8")
    done = geoswarm(installed, tmp_path, "evaluate", "problem.json", "--set", "c_v=1", "--json")
    assert done.returncode == 0, done.stderr
    calculated = json.loads(done.stdout)["responses"]["settlement"]["y"]
    assert calculated == pytest.approx([0.0, 0.5, 0.9], abs=2e-3)


def test_a_mistake_in_its_section_is_reported(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "problem.yaml").write_text(block("yaml").replace("2.0}", "-2.0}"), encoding="utf-8")
    done = geoswarm(installed, tmp_path, "check", "problem.yaml")
    assert done.returncode == 2
    assert "forward_model.drainage_path" in done.stderr
