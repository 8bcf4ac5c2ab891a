"""Where the runs of a function are made: limits, scripts with and without main guard, interrupts."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

import geoswarm as gs
from tests.geoswarm.python_models import OPTIONS, module, problem_file
from tests.integration.engines import PATIENCE, wait_for
from tests.variants import variants


@pytest.mark.parametrize(
    ("function", "limits", "reason", "message"),
    variants(
        [
            ("slow", {"seconds_per_evaluation": 0.5}, "timeout", "limits.seconds_per_evaluation"),
            ("large", {"memory_mb": 200}, "killed_memory", "limits.memory_mb"),
        ],
        {"slow"},
    ),
)
def test_a_run_that_exceeds_its_limits_is_killed(
    tmp_path: Path, function: str, limits: dict[str, float], reason: str, message: str
) -> None:
    options = OPTIONS | {"stopping": {"max_evaluations": 6}, "limits": limits}
    result = gs.calibrate(getattr(module(tmp_path), function), **options)
    failed = result.runs["reason"] == reason
    assert 0 < failed.sum() == (result.runs["a"] > 0).sum()
    assert message in result.runs["message"][failed][0]


SCRIPT = """
import sys
import geoswarm as gs
def line(x, a, b):
    return a + b * x
def run(workers):
    return gs.calibrate(line, parameters={"a": gs.free(-5, 5), "b": gs.free(0, 4)},
        observations=gs.observed([0, 1, 2], [1, 3, 5]), stopping={"max_evaluations": 60}, seed=7, workers=workers)
"""


def ran(folder: Path, source: str, *options: str) -> subprocess.CompletedProcess[str]:
    path = folder / "script.py"
    path.write_text(source)
    command = [sys.executable, *options, str(path)] if options != ("-",) else [sys.executable, "-"]
    given = source if options == ("-",) else None
    return subprocess.run(command, input=given, capture_output=True, text=True, check=False, timeout=120)


@pytest.mark.slow  # tests/solver/test_local.py has the same workers
def test_a_script_with_guard_uses_its_workers(tmp_path: Path) -> None:
    done = ran(tmp_path, SCRIPT + "print('read')\nif __name__ == '__main__':\n    print(run(2))\n", "-W", "error")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == "read"
    assert "<Result max_evaluations: objective" in done.stdout
    assert done.stdout.count("read") == 1


@pytest.mark.parametrize("how", ["", "-"])
def test_a_script_without_guard_says_what_to_do(tmp_path: Path, how: str) -> None:
    done = ran(tmp_path, SCRIPT + "print(run(2))\n", *([how] if how else []))
    assert done.returncode == 0, done.stderr
    assert "<Result max_evaluations: objective" in done.stdout
    told = "was not written in a file" if how else 'put the call below if __name__ == "__main__":'
    assert told in done.stderr
    assert "It runs with one worker and without limits" in done.stderr


def test_a_function_of_a_file_that_calibrates_when_it_is_imported(tmp_path: Path) -> None:
    found = module(tmp_path, SCRIPT)
    path = Path(found.__file__ or "")
    path.write_text(SCRIPT + "run(1)\n")
    with pytest.raises(gs.ProblemError) as caught:
        gs.calibrate(gs.load_problem(problem_file(tmp_path, found.line)))
    assert "calls geoswarm.calibrate while it is imported" in str(caught.value)
    assert 'below if __name__ == "__main__":' in str(caught.value)


def test_an_interrupt_ends_all_processes_at_once(tmp_path: Path) -> None:
    mark = f"open('{tmp_path}/begun' + str(__import__('os').getpid()), 'w').close()"
    source = SCRIPT.replace("return a + b * x", f"{mark}; print(__import__('time').sleep(600))")
    heard = (
        "    import signal\n    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background\n"
    )
    (tmp_path / "script.py").write_text(f"{source}if __name__ == '__main__':\n{heard}    run(2)\n")
    process = subprocess.Popen([sys.executable, str(tmp_path / "script.py")], stderr=subprocess.PIPE, text=True)
    try:
        wait_for(lambda: len(list(tmp_path.glob("begun*"))) == 2, "two runs under way")
        children = psutil.Process(process.pid).children(recursive=True)
        assert len(children) >= 4  # two fork servers, two evaluation processes
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
        process.wait()
    gone, alive = psutil.wait_procs(children, timeout=PATIENCE)
    assert alive == []
    assert len(gone) >= 4
    assert "KeyboardInterrupt" in told
    assert process.returncode != 0
