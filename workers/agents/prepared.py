"""Jobs made ready for exchanges with agents: what they need from a worker, and what is kept in this process."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cachetools import LRUCache

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.registry import BUILT_IN
from geoswarm.solver.problem import Problem
from geoswarm.solver.registered.spec import RegisteredSpec
from geoswarm.solver.warm import OTHER_LAWS, groups_of
from geoswarm.workers.execution.sandbox import limits_of
from geoswarm.workers.queries.jobs import get_problem
from geoswarm.workers.queries.offers import read_offer
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.problems import problem_of

__all__ = ["Prepared", "PreparedJobs", "frame_of", "is_need", "needs_of", "registered_need"]

KEPT = 256


MOST_LETTERS = 100_000


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """A job made ready.

    Parameters
    ----------
    frame, shared
        What all its runs share, and a name for it.
    turn
        Held while this process speaks to the database about the job: what was learned of its runs is shared.
    """

    id: str
    course: Course
    frame: str
    shared: Mapping[str, Any]
    turn: threading.Lock = field(default_factory=threading.Lock)

    @property
    def values(self) -> int:
        """Numbers that a run brings."""
        return sum(len(x) for x in self.shared["points"].values())


class PreparedJobs:
    """The jobs of one store; safe to use from several threads."""

    def __init__(self, store: Store, settings: Settings) -> None:
        self._store = store
        self._settings = settings
        self._kept: LRUCache[str, Prepared] = LRUCache(KEPT)
        self._lock = threading.Lock()

    def get(self, job_id: str) -> Prepared | None:
        """Return a job made ready; None: there is no such job.

        Raises
        ------
        ProblemError
            When this version cannot read its problem any more.
        StoreUnavailableError
        """
        with self._lock:
            if job_id in self._kept:
                return self._kept[job_id]
        row = self._store.read(lambda connection: get_problem(connection, job_id))
        if row is None:
            return None
        problem = problem_of(row.problem)
        offer = self._store.read(lambda connection: read_offer(connection, job_id)) if problem.warm_start else None
        frame, shared = frame_of(problem, self._settings)
        made = Prepared(job_id, Course(Calibration(problem, row.seed, offer)), frame, shared)
        with self._lock:
            return self._kept.setdefault(job_id, made)


def frame_of(problem: Problem, settings: Settings) -> tuple[str, dict[str, Any]]:
    """Return what all runs of a problem share, and a name for it: no measurement, no name, no owner.

    ``forward_model`` is its section, ``points`` are the x of each series in base units, ``inputs`` what a formula is
    given besides at these points, ``limits`` those of a run, ``keeps_parts`` whether a failed run brings the series of
    the parts that succeeded.
    """
    limits = limits_of(problem, settings)
    shared = {
        "forward_model": problem.forward_model.model_dump(mode="json"),
        "points": {observation.series: observation.x.tolist() for observation in problem.observations},
        "inputs": {
            observation.series: {name: values.tolist() for name, values in observation.inputs.items()}
            for observation in problem.observations
            if observation.inputs
        },
        "limits": {"seconds": limits.seconds, "memory_mb": limits.memory_mb, "of_time": limits.of_time},
        "keeps_parts": problem.method.keeps_parts,
    }
    text = json.dumps(shared, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:32], shared


def needs_of(spec: ForwardModelSpec) -> str:
    """Return what a forward model needs, one word each, in order: it runs where all of them are offered.

    A model or soil law of another package is what no agent offers: which version of it would have to be the same is
    not known.
    """
    needs: set[str] = {spec.kind} if spec.kind == "combined" else set()
    for part in spec.by_part().values():
        if isinstance(part, RegisteredSpec):
            needs.add(registered_need(part.model, part.version or ""))
        elif part.kind in BUILT_IN and not part.runs_programs:
            needs.add(part.kind)
        else:
            needs.add(f"foreign:{part.kind}")
        if OTHER_LAWS in groups_of(part):
            needs.add("foreign:law")
    return " ".join(sorted(needs))


def registered_need(model: str, version: str) -> str:
    """Return what a registered model is as a need."""
    return f"registered:{model}:{version}"


def is_need(text: str) -> bool:
    """Whether an agent may offer it."""
    return text in BUILT_IN or text.startswith("registered:")
