"""The keeper of a run (POSIX): stands between an agent and the process that evaluates, and outlives neither's tree.

It adopts what its descendants leave behind. When its standard input ends, because the agent wants that or has died in
whatever way, it kills all that is below it and ends. When the process ends by itself, it does the same and reports how.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

from geoswarm.solver.system.processes import adopt_orphans, kill_descendants

__all__ = ["ENDING", "ENDING_SECONDS", "main"]

LOOK_SECONDS = 0.1
ENDING = b"e"  # sent by the agent before it closes: the answers have ended, and the exit code is about to be available
ENDING_SECONDS = 5.0


def main(given: Mapping[str, Any]) -> None:
    """Keep one process.

    Parameters
    ----------
    given
        Arguments of the process (``run``), and descriptors of its standard input and output (``in``, ``out``).
    """
    adopt_orphans()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):  # the agent decides about its end
        signal.signal(number, signal.SIG_IGN)
    requests, answers = given["in"], given["out"]
    run = subprocess.Popen(
        given["run"], stdin=requests, stdout=answers, stderr=subprocess.DEVNULL, restore_signals=True
    )
    os.close(requests)
    os.close(answers)
    code = None
    while True:
        ready, _, _ = select.select([0], [], [], LOOK_SECONDS)
        code = run.poll()
        if code is None and ready:
            if os.read(0, 1) == ENDING:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    code = run.wait(ENDING_SECONDS)
            break
        if code is not None:
            break
    kill_descendants(os.getpid())
    sys.stdout.write(json.dumps({"code": code}))
    sys.stdout.flush()
    os._exit(0)
