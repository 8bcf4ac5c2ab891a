"""Run the tests in parallel, then those marked ``timing`` one by one, then once more, alone, what failed.

A correct test can fail on a busy machine. The run is green if at most ten tests failed and all of them pass when run
alone. The last lines, above pytest's closing line, name them: a test that needs a second look is a defect to be fixed.

    .venv/bin/python scripts/run_tests.py --jobs 3 -m "not slow"          # passes other arguments to pytest
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MOST_FAILURES = 10


class SecondLook:
    """Lists the tests of the second look above pytest's closing line."""

    def __init__(self, tests: list[str]) -> None:
        self._tests = tests

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter, exitstatus: int) -> None:
        if exitstatus == pytest.ExitCode.OK:
            terminalreporter.section("passed only at the second look")
            for test in self._tests:
                terminalreporter.line(test)


def timing_files(folder: Path) -> list[str]:
    """Return the test files in which a test is marked ``timing``: looked for in the text, as collecting takes long."""
    return sorted(str(file) for file in folder.rglob("test_*.py") if "mark.timing" in file.read_text(encoding="utf-8"))


def look(arguments: list[str]) -> tuple[int, list[str]]:
    """Run pytest in a process of its own; return its exit code and the tests that failed."""
    with tempfile.TemporaryDirectory() as cache:  # pytest's own would also name failures of earlier runs
        command = [sys.executable, "-m", "pytest", "-q", "-o", f"cache_dir={cache}", *arguments]
        code = subprocess.run(command, check=False).returncode
        record = Path(cache) / "v" / "cache" / "lastfailed"
        return code, sorted(json.loads(record.read_text(encoding="utf-8"))) if record.exists() else []


def main() -> int:
    """Return the exit code of pytest: that of the second look if there was one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", default="3", help="test processes of the first look")
    parser.add_argument("--folder", type=Path, default=Path("tests"), help="where the tests are")
    parser.add_argument("-m", dest="marks", default="not slow", help="which tests, as in pytest")
    parser.add_argument("--no-timing", dest="timing", action="store_false", help="leave out the tests marked timing")
    options, further = parser.parse_known_args()
    marks = f"({options.marks})"
    code, failed = look(
        [
            *further,
            "-m",
            f"{marks} and not timing",
            "-n",
            options.jobs,
            "--dist",
            "loadfile",
            "--no-loadscope-reorder",
            str(options.folder),
        ]
    )
    goes_on = (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)
    if options.timing and code in goes_on and (files := timing_files(options.folder)):
        print("the tests marked timing, one by one", flush=True)
        timing, more = look([*further, "-m", f"{marks} and timing", "-n", "0", *files])
        if timing != pytest.ExitCode.NO_TESTS_COLLECTED:
            code, failed = max(code, timing), failed + more
    if code != pytest.ExitCode.TESTS_FAILED:
        return code
    if not 0 < len(failed) <= MOST_FAILURES:
        print(f"no second look: {len(failed)} tests failed, at most {MOST_FAILURES} are run again")
        return code
    print(f"second look: {len(failed)} tests failed and are run again, one by one", flush=True)
    sys.path[0] = str(ROOT)  # as `python -m pytest` does
    return pytest.main(["-q", "-n", "0", "-p", "no:cacheprovider", *failed], plugins=[SecondLook(failed)])


if __name__ == "__main__":
    sys.exit(main())
