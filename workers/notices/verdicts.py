"""What the data say about each parameter of a job, for messages; found in a process of its own, within limits.

A history is data of a stranger's, and statistics take time and memory: neither may hold up the process that delivers.
Called as a program: reads settings and job from standard input, writes JSON.
"""

from __future__ import annotations

import json
import logging
import resource
import subprocess
import sys
from dataclasses import dataclass
from typing import Any

from geoswarm.solver.system.processes import die_with_parent
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker

__all__ = ["NOTHING", "Found", "find_verdicts"]

log = logging.getLogger(__name__)

SECONDS = 120.0
MEMORY_BYTES = 4 * 2**30


@dataclass(frozen=True, slots=True)
class Found:
    """Unit of the objective, whether the model describes the data, and what they say about each free parameter."""

    unit: str
    fit: str | None
    verdicts: dict[str, str]


NOTHING = Found("", None, {})


def find_verdicts(settings: Settings, job_id: str, seconds: float = SECONDS) -> Found:
    """Return what can be found within some time [s]; what cannot is missing, as a message must not hang on it."""
    asked = json.dumps({"database_url": settings.database_url, "job": job_id})
    try:
        done = subprocess.run(
            [sys.executable, "-m", "geoswarm.workers.notices.verdicts"],
            input=asked,
            capture_output=True,
            text=True,
            timeout=seconds,
            check=True,
        )
        return Found(**json.loads(done.stdout.splitlines()[-1]))
    except (OSError, subprocess.SubprocessError, ValueError, TypeError, IndexError) as error:
        log.warning("no verdicts for the message about job %s: %s", job_id, error, extra={"job": job_id})
        return NOTHING


def main() -> None:
    """Answer one question."""
    die_with_parent()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    asked = json.load(sys.stdin)
    settings = Settings(database_url=asked["database_url"])
    store = Store(settings)
    service = JobService(store, NoWaker(), settings)
    try:
        from geoswarm.solver.report.curves import objective_unit

        report = service.statistics.report(asked["job"])
        answer: dict[str, Any] = {"unit": objective_unit(report.problem), "fit": None, "verdicts": {}}
        if report.statistics is not None:
            told = report.statistics.to_json()
            answer["fit"] = told["fit"]["sentence"]
            answer["verdicts"] = {verdict["parameter"]: verdict["words"] for verdict in told["verdicts"]}
        sys.stdout.write(json.dumps(answer) + "\n")
    finally:
        service.close()
        store.close()


if __name__ == "__main__":
    main()
