"""Process trees: who belongs to one, and how much memory it uses."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from geoswarm.solver.system import processes
from geoswarm.solver.system.processes import descendants, kill_session, memory_below, memory_of

TREE = """
import os, signal
below = os.fork()
if below == 0:
    zombie = os.fork()
    if zombie == 0:
        os._exit(0)
    os.waitid(os.P_PID, zombie, os.WEXITED | os.WNOWAIT)  # and not collected
os.write(1, f"{os.getpid()}\\n".encode())  # in one piece: two processes write here
signal.pause()
"""

CHURN = """
import os, signal, threading, time
if os.fork() == 0:
    print(os.getpid(), flush=True)
    signal.pause()
def end():
    time.sleep(0.0005)
while True:
    threads = [threading.Thread(target=end) for _ in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
"""

HIDDEN = """
import ctypes, os, signal, sys, time
from geoswarm.solver.system.processes import memory_below, memory_of
if os.getuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
reader, writer = os.pipe()
child = os.fork()
if child == 0:
    ctypes.CDLL(None).prctl(4, 0, 0, 0, 0)  # PR_SET_DUMPABLE: nobody may look into this process
    held = bytearray(os.urandom(1)) * 60_000_000
    os.write(writer, b"x")
    signal.pause()
os.read(reader, 1)
print(memory_below(os.getpid()), memory_of(child))
os.kill(child, signal.SIGKILL)
"""


def test_children_grandchildren_and_no_zombies(monkeypatch: pytest.MonkeyPatch) -> None:
    with subprocess.Popen([sys.executable, "-c", TREE], stdout=subprocess.PIPE, start_new_session=True) as started:
        try:
            assert started.stdout is not None
            pids = {int(started.stdout.readline()) for _ in range(2)}
            found = descendants(os.getpid())
            assert pids <= set(found)
            assert found.index(started.pid) < found.index((pids - {started.pid}).pop())
            assert set(descendants(started.pid)) == pids - {started.pid}
            assert memory_of(started.pid) > 1.0
            assert 0.1 < memory_below(started.pid) < memory_of(started.pid) + memory_of(*pids - {started.pid})
            monkeypatch.setattr(processes, "CHILDREN_ARE_LISTED", False)  # as on other systems
            assert set(descendants(started.pid)) == pids - {started.pid}
            kill_session(started.pid)
            assert started.wait(60) == -signal.SIGKILL
        finally:
            started.kill()
    assert descendants(started.pid) == []
    assert (memory_below(started.pid), memory_of(started.pid)) == (0.0, 0.0)


@pytest.mark.slow
def test_children_are_seen_while_threads_come_and_go() -> None:
    with subprocess.Popen([sys.executable, "-c", CHURN], stdout=subprocess.PIPE, start_new_session=True) as started:
        try:
            assert started.stdout is not None
            child = int(started.stdout.readline())
            assert all(child in descendants(started.pid) for _ in range(2000))
        finally:
            kill_session(started.pid)


def test_memory_of_a_process_that_lets_nobody_look() -> None:
    done = subprocess.run([sys.executable, "-c", HIDDEN], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    below, resident = map(float, done.stdout.split())
    assert resident > 57.0
    assert below == pytest.approx(resident, rel=0.1)
