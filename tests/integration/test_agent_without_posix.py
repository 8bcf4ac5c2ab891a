"""An agent on a system that has nothing of POSIX: Windows cannot be tried here, so what it lacks is taken away.

Every process of the agent starts with a ``sitecustomize`` that refuses the modules to geoswarm and removes the calls.
What stays untried is said in docs/agents.md.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.chaos.fleet import Fleet
from tests.integration.agents import Installation, assert_nothing_left, ended, registered_line
from tests.integration.engines import wait_for
from tests.workers.problems import expected_history, line

WITHOUT_POSIX = """
import builtins, os, select, signal, sys
MODULES = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"}
CALLS = (
    "fork", "forkpty", "setsid", "getsid", "killpg", "getpgid", "setpgid", "getpgrp", "getuid", "geteuid", "setuid",
    "getgid", "register_at_fork", "memfd_create", "pidfd_open", "waitid", "set_blocking", "mkfifo", "chown", "WNOHANG",
)
usual = builtins.__import__

def refuse(name, globals=None, locals=None, fromlist=(), level=0):
    # what geoswarm itself asks for: the libraries have other parts for the same there
    if name.partition(".")[0] in MODULES and (globals or {}).get("__name__", "").startswith("geoswarm"):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)
    return usual(name, globals, locals, fromlist, level)

builtins.__import__ = refuse
import subprocess, platformdirs.unix  # these have other parts for Windows: they may keep what they have taken
for name in CALLS:
    if name != "WNOHANG":
        delattr(os, name)
for name in ("poll", "epoll"):
    delattr(select, name)
for name in ("SIGHUP", "pidfd_send_signal", "setitimer", "alarm", "pthread_kill"):
    delattr(signal, name)
"""


@pytest.fixture
def elsewhere(tmp_path: Path) -> dict[str, str]:
    """Environment of a process that finds nothing of POSIX."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(WITHOUT_POSIX)
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {"PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}


def test_the_agent_is_imported_without_anything_of_posix(elsewhere: dict[str, str]) -> None:
    modules = ", ".join(
        f"geoswarm.agent.{name}" for name in ("agent", "slot", "run_main", "trees.tree", "trees.job_object", "outbox")
    )
    program = (
        f"import os; assert not hasattr(os, 'fork'); import {modules}, geoswarm.cli.service.agent;"
        "import geoswarm.solver.registered.model; import geoswarm.agent.inventory as i; print(i.built_in_kinds())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], env=os.environ | elsewhere, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "oedometer" in done.stdout


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_an_agent_runs_a_program_without_anything_of_posix(
    tmp_path: Path, elsewhere: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    place = Installation.with_line(tmp_path, monkeypatch, seconds=0.05)
    problem = registered_line(36)
    with place.running({"api": place.serve()}) as (_service, client):
        environment = place.environment | elsewhere
        with Fleet({"agent": place.agent("--slots", "2", "--grace", "1")}, tmp_path, environment) as agents:
            wait_for(lambda: len(place.slots(client)) == 2, f"an agent\n{agents.logs()}", 600.0)
            job_id = client.submit(problem.document()).id
            wait_for(lambda: ended(client, job_id), "the end of the job", 600.0)
            assert client.get(job_id).state == "finished", agents.logs()
            slow = client.submit({**problem.document(), "limits": {"seconds_per_evaluation": 0.01}}).id
            wait_for(lambda: client.get(slow).evaluations >= 6, "killed runs", 300.0)
            client.cancel(slow)
            reasons = {evaluation.reason for evaluation in client.iterate_evaluations(slow) if evaluation.reason}
            assert agents.stop() == {"agent": 0}, agents.logs()
            assert_nothing_left(agents)
    assert reasons == {"timeout"}
    method = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
    assert place.history(job_id) == expected_history(line(method=method, stopping={"max_evaluations": 36}))
