"""Twelve jobs of mixed length, and the user that submits, pauses and resumes them while everything breaks."""

from __future__ import annotations

import logging
import random
import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from geoswarm import Client
from geoswarm.client.errors import ConflictError, GeoswarmError
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from tests.workers.problems import line

__all__ = ["Planned", "User", "plan"]

log = logging.getLogger(__name__)

Answer = TypeVar("Answer")

EXAMPLES = Path(__file__).parents[2] / "examples"
OEDOMETER = load_problem(EXAMPLES / "oedometer" / "problem.yaml").document()
ISOTROPIC = load_problem(EXAMPLES / "isotropic_compression" / "problem.yaml").document()
TRY_AGAIN_SECONDS = 0.5
# An evaluation may lose any number of workers here, and each time it must be run again.
NEVER_GIVE_UP: Mapping[str, int] = {"worker_lost": 1000}


@dataclass(frozen=True, slots=True)
class Planned:
    """A job, and when it is submitted, as a fraction of the time of faults."""

    at: float
    problem: Problem


def plan(scale: float, cured: Path) -> list[Planned]:
    """Return the jobs; ``scale`` 1 keeps four workers busy for some minutes. The slow ones are quick once ``cured``."""

    def size(evaluations: int, particles: int = 10) -> int:
        return max(4, round(scale * evaluations / particles)) * particles

    def swarm(evaluations: int, **method: Any) -> dict[str, Any]:
        stopping = {"max_evaluations": size(evaluations, method.get("particles", 10))}
        return {
            "method": {"kind": "particle_swarm", "particles": 10, "acceleration": "none", **method},
            "stopping": stopping,
        }

    def sampled(samples: int, batch: int) -> dict[str, Any]:
        return {"method": {"kind": "monte_carlo", "samples": size(samples, batch), "batch": batch}, "stopping": {}}

    def slow(behaviour: str, seconds: float, search: Mapping[str, Any], **changes: Any) -> dict[str, Any]:
        return {
            "forward_model": {
                "kind": "misbehaving",
                "behaviour": behaviour,
                "seconds": seconds,
                "above": -9,
                "cured": str(cured),
            },
            "parameters": {"slope": {"lower": -1, "upper": 3}},
            "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2.5]}}],
            "seed": 5,
            **search,
            **changes,
        }

    failing = {"forward_model": {"kind": "misbehaving", "behaviour": "diverge", "above": 1.5}}
    documents: dict[str, tuple[float, Mapping[str, Any]]] = {
        "oedometer, textbook": (0.0, OEDOMETER | swarm(3000)),
        "oedometer, accelerated": (0.0, OEDOMETER | swarm(600, acceleration="response_surface")),
        "isotropic, sampled": (0.1, ISOTROPIC | sampled(4000, 50)),
        "line, cheap": (0.3, line().document() | swarm(20_000)),
        "line, cheap, sampled": (0.5, line().document() | sampled(40_000, 200)),
        "sleeping 20 ms, urgent": (0.2, slow("sleep", 0.02, swarm(3000), priority=5)),
        "sleeping 100 ms": (0.0, slow("sleep", 0.1, swarm(2500, topology="ring"))),
        "sleeping 50 ms, sampled, not urgent": (0.0, slow("sleep", 0.05, sampled(3000, 20), priority=-5)),
        "sleeping 25 ms, overlapping": (
            0.4,
            slow("sleep", 0.025, swarm(1500, acceleration="response_surface", overlap=True)),
        ),
        "computing 30 ms": (0.6, slow("compute", 0.03, swarm(800))),
        "failing now and then, tried three times": (0.0, slow("diverge", 0, swarm(1500)) | failing),
        "failing often, sampled": (0.7, slow("diverge", 0, sampled(3000, 30)) | failing),
    }
    planned = []
    for name, (at, document) in documents.items():
        retry = dict(NEVER_GIVE_UP) | ({"diverged": 2} if "tried three times" in name else {})
        planned.append(Planned(at, parse_problem(dict(document) | {"name": name, "failures": {"retry": retry}})))
    return planned


class User(threading.Thread):
    """Submits each job at its time, and pauses and resumes some; asks again whenever the service does not answer.

    ``ids`` are the jobs in their order; ``counts`` tells what was asked, and how often there was no answer.
    """

    def __init__(self, client: Client, jobs: list[Planned], seconds: float, chance: random.Random) -> None:
        super().__init__(name="user", daemon=True)
        self.ids: list[str] = []
        self.counts: Counter[str] = Counter()
        self.problem: BaseException | None = None
        self._client = client
        self._jobs = jobs
        self._seconds = seconds
        self._chance = chance
        self._began = time.monotonic()
        self.leave = threading.Event()

    def run(self) -> None:
        """Do it all; what goes wrong is kept in ``problem``."""
        try:
            self._act()
        except BaseException as error:
            self.problem = error
            raise

    def _act(self) -> None:
        order = sorted(range(len(self._jobs)), key=lambda number: self._jobs[number].at)
        ids: dict[int, str] = {}
        for number in order:
            self._wait_until(self._jobs[number].at * self._seconds)
            job = self._jobs[number]
            ids[number] = self._insist(
                lambda job=job, number=number: (
                    self._client.submit(  # type: ignore[misc]
                        job.problem.document(), idempotency_key=f"chaos job {number}"
                    ).id
                )
            )
            self.counts["jobs submitted"] += 1
            self._pause_and_resume(self._chance.choice(list(ids.values())))
        self.ids = [ids[number] for number in range(len(self._jobs))]

    def _pause_and_resume(self, job_id: str) -> None:
        with suppress(ConflictError):  # it has ended meanwhile; or it is paused already, and an answer was lost
            self._insist(lambda: self._client.pause(job_id))
        self.leave.wait(self._chance.uniform(0.2, 1.5))
        with suppress(ConflictError):
            self._insist(lambda: self._client.resume(job_id))
            self.counts["jobs paused and resumed"] += 1

    def _wait_until(self, at: float) -> None:
        self.leave.wait(max(self._began + at - time.monotonic(), 0.0))

    def _insist(self, ask: Callable[[], Answer]) -> Answer:
        while True:
            try:
                return ask()
            except ConflictError:
                raise
            except GeoswarmError as error:
                if self.leave.is_set():
                    raise
                self.counts["requests without an answer"] += 1
                log.info("the service does not answer: %s", error)
                self.leave.wait(TRY_AGAIN_SECONDS)
