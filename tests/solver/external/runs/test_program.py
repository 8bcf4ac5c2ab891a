"""Programs are started without a shell, watched, bounded and ended with all that they have started."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from geoswarm.solver.external.runs.program import TAIL, Ended, NotStartedError, run_program
from tests.integration.engines import PATIENCE, process_exists, wait_for

PATH = {"PATH": os.environ["PATH"]}


def run(folder: Path, *arguments: str, seconds: float | None = 60.0) -> Ended:
    return run_program(arguments, folder, PATH, seconds, folder / "output.txt")


def python(folder: Path, code: str, seconds: float | None = 60.0) -> Ended:
    return run(folder, sys.executable, "-c", code, seconds=seconds)


def wait_until_gone(pid: int) -> None:
    wait_for(lambda: not process_exists(pid), f"the end of process {pid}")


def test_a_program_gets_its_arguments_as_they_are(tmp_path: Path) -> None:
    ended = run(tmp_path, "printf", "%s|", "a b", "$HOME; rm -rf x", "*")
    assert (ended.status, ended.tail) == (0, "a b|$HOME; rm -rf x|*|")
    assert (tmp_path / "output.txt").read_text() == ended.tail


def test_exit_status_and_signals_are_reported(tmp_path: Path) -> None:
    assert python(tmp_path, "raise SystemExit(7)").words == "ended with exit status 7"
    ended = python(tmp_path, "import os; os.kill(os.getpid(), 11)")
    assert (ended.status, ended.words) == (-signal.SIGSEGV, "was ended by SIGSEGV")


def test_both_streams_are_kept_in_order_and_only_their_ends(tmp_path: Path) -> None:
    ended = python(tmp_path, "import sys; print('first'); sys.stdout.flush(); sys.stderr.write('second\\n')")
    assert ended.tail == "first\nsecond\n"
    loud = python(tmp_path, "import os\nfor _ in range(100): os.write(1, b'x' * 100_000)\nos.write(1, b'end')")
    assert len(loud.tail) == TAIL
    assert loud.tail.endswith("xend")
    kept = (tmp_path / "output.txt").read_bytes()
    assert 5 * 1024 * 1024 < len(kept) < 5 * 1024 * 1024 + 100
    assert b"bytes are left out here" in kept
    assert kept.endswith(b"xend")


def test_what_is_not_text_is_shown(tmp_path: Path) -> None:
    assert "\ufffd" in run(tmp_path, "printf", r"\377").tail


def test_a_program_that_is_not_there_or_may_not_run_is_named(tmp_path: Path) -> None:
    (tmp_path / "tool.sh").write_text("#!/bin/sh\n")
    with pytest.raises(NotStartedError, match="no-such was not found on PATH"):
        run(tmp_path, "no-such")
    with pytest.raises(NotStartedError, match=r"tool.sh is in the run folder, but not on PATH; write ./tool.sh"):
        run(tmp_path, "tool.sh")
    with pytest.raises(NotStartedError, match=r"./other.sh is not in the run folder; list it under files"):
        run(tmp_path, "./other.sh")
    with pytest.raises(NotStartedError, match=r"./tool.sh is not executable; use chmod \+x"):
        run(tmp_path, "./tool.sh")
    (tmp_path / "broken").write_text("#!/no/such/interpreter\n")
    (tmp_path / "broken").chmod(0o755)
    with pytest.raises(NotStartedError, match=r"./broken cannot be started: No such file or directory"):
        run(tmp_path, "./broken")


def test_the_limit_ends_a_program_with_all_that_it_has_started(tmp_path: Path) -> None:
    code = "sleep 600 & echo $! > same; setsid sleep 600 & echo $! > other; echo ready; wait"
    ended = run(tmp_path, "sh", "-c", code, seconds=5.0)
    assert ended.status is None
    assert ended.words.startswith("was killed after ")
    assert ended.seconds >= 5.0
    assert ended.tail == "ready\n"
    for name in ("same", "other"):
        wait_until_gone(int((tmp_path / name).read_text()))


def test_a_child_that_holds_the_output_open_does_not_hold_up_the_end(tmp_path: Path) -> None:
    ended = python(tmp_path, "import subprocess; subprocess.Popen(['sleep', '600']); print('done')")
    assert (ended.status, ended.tail) == (0, "done\n")


def test_an_interrupt_ends_the_program(tmp_path: Path) -> None:
    code = (
        "import signal, sys; from pathlib import Path\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)  # which who runs tests in the background ignores\n"
        "from geoswarm.solver.external.runs.program import run_program\n"
        "folder = Path(sys.argv[1])\n"
        "code = 'echo $$ > pid; head -c 100000 /dev/zero; exec sleep 600'\n"
        "run_program(['sh', '-c', code], folder, {'PATH': sys.argv[2]}, None, folder / 'o')"
    )
    command = [sys.executable, "-c", code, str(tmp_path), os.environ["PATH"]]
    with subprocess.Popen(command, stderr=subprocess.PIPE) as ours:
        try:
            # What it prints is being read, so it is waited for.
            wait_for(lambda: (tmp_path / "o").exists() and (tmp_path / "o").stat().st_size > 0, "the program's output")
            ours.send_signal(signal.SIGINT)
            ours.communicate(timeout=PATIENCE)
        finally:
            ours.kill()
    wait_until_gone(int((tmp_path / "pid").read_text()))


MANY = """
import sys, threading
from pathlib import Path
import psutil
from geoswarm.solver.external.runs.program import run_program
ends = []
def several(number):
    folder = Path(sys.argv[1]) / str(number)
    folder.mkdir()
    ends.extend(run_program(["true"], folder, {"PATH": sys.argv[2]}, 60, folder / "o").status for _ in range(20))
before = psutil.Process().num_fds()
threads = [threading.Thread(target=several, args=(number,)) for number in range(4)]
for thread in threads: thread.start()
for thread in threads: thread.join()
print(ends == [0] * 80, psutil.Process().num_fds() - before)
"""


def test_many_at_once_leave_nothing(tmp_path: Path) -> None:
    """In a process of its own, where nothing else opens files."""
    command = [sys.executable, "-c", MANY, str(tmp_path), os.environ["PATH"]]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True 0"


AT_ONCE = """
import sys, threading
from pathlib import Path
from geoswarm.solver.external.runs.program import run_program
from geoswarm.solver.system.processes import adopt_orphans
adopt_orphans()
ends = []
def run(number):
    folder = Path(sys.argv[1]) / str(number)
    folder.mkdir()
    code = f"setsid sleep 600 & sleep {0.3 * number}; exit {number}"
    ends.append((number, run_program(["sh", "-c", code], folder, {"PATH": sys.argv[2]}, 60, folder / "o").status))
threads = [threading.Thread(target=run, args=(number,)) for number in range(4)]
for thread in threads: thread.start()
for thread in threads: thread.join()
print(sorted(ends))
"""


def test_runs_at_once_in_one_process_do_not_end_each_other(tmp_path: Path) -> None:
    command = [sys.executable, "-c", AT_ONCE, str(tmp_path), os.environ["PATH"]]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[(0, 0), (1, 1), (2, 2), (3, 3)]"
    assert not [one for one in psutil.process_iter() if one.name() == "sleep" and str(tmp_path) in _folder_of(one)]


def _folder_of(process: psutil.Process) -> str:
    try:
        return str(process.cwd())
    except psutil.Error:
        return ""
