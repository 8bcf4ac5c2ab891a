"""``make test`` runs what failed once more, alone, and tests that judge by the clock after the others, one by one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT

UNLUCKY = """
from pathlib import Path

def test_unlucky():
    seen = Path(__file__).with_name("seen")
    before = seen.exists()
    seen.touch()
    assert before
"""
BROKEN = "def test_broken():\n    assert 1 == 2\n"
ELEVEN = """
import pytest
from pathlib import Path

@pytest.mark.parametrize("number", range(11))
def test_unlucky(number):
    seen = Path(__file__).with_name(f"seen {number}")
    before = seen.exists()
    seen.touch()
    assert before
"""
TIMED = """
import os
import pytest

@pytest.mark.timing
def test_timed():
    assert "PYTEST_XDIST_WORKER" not in os.environ
"""
TIMED_BROKEN = TIMED.replace(" not in ", " in ")
RIGHT = "def test_right():\n    assert True\n"
IN_TEARDOWN = """
import pytest

@pytest.fixture
def broken():
    yield
    assert 1 == 2

def test_teardown(broken):
    pass
"""


@pytest.mark.parametrize(
    ("tests", "green", "named"),
    [
        ([RIGHT], True, None),
        ([RIGHT, UNLUCKY], True, "test_unlucky"),
        pytest.param([RIGHT, TIMED], True, None, marks=pytest.mark.slow),
        ([RIGHT, TIMED_BROKEN], False, None),
        pytest.param([RIGHT, UNLUCKY, BROKEN], False, None, marks=pytest.mark.slow),
        ([RIGHT, ELEVEN], False, None),
        pytest.param([IN_TEARDOWN], False, None, marks=pytest.mark.slow),
        pytest.param(["import nothing_of_this_name"], False, None, marks=pytest.mark.slow),
        pytest.param([], False, None, marks=pytest.mark.slow),
    ],
    ids=[
        "right",
        "unlucky",
        "timed",
        "timed and broken",
        "broken",
        "eleven",
        "teardown",
        "import",
        "none",
    ],
)
def test_what_fails_again_is_red(tmp_path: Path, tests: list[str], green: bool, named: str | None) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers =\n  timing: clock\n  slow: long\n")
    for number, text in enumerate(tests):
        (tmp_path / f"test_{number}.py").write_text(text)
    jobs = "1" if TIMED in tests or TIMED_BROKEN in tests else "0"  # a process for the tests takes as long as the rest
    command = [sys.executable, str(ROOT / "scripts" / "run_tests.py"), "--jobs", jobs, "--folder", "."]
    outer = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_XDIST")}
    only = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": "-p xdist.plugin"}  # others take seconds to load
    ran = subprocess.run(command, cwd=tmp_path, env=outer | only, capture_output=True, text=True, check=False)
    assert (ran.returncode == 0) is green, ran.stdout
    *above, last = ran.stdout.splitlines()
    if green:
        assert " passed in " in last
    heading = [number for number, line in enumerate(above) if "passed only at the second look" in line]
    assert bool(heading) is (named is not None)
    if named is not None:
        assert above[heading[0] + 1 :] == [f"test_1.py::{named}"]
