"""What a calibration knows between two generations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.methods.base import Method
from geoswarm.solver.progress.answer import Answer
from geoswarm.solver.search.base import Snapshot

__all__ = ["Best", "Progress", "Step"]

_STAGNANT_RUNS = 10  # that count as a generation at least, where a generation may be as small as one run


@dataclass(frozen=True, slots=True)
class Best:
    """The best evaluation so far; of equal objectives the earliest, then the lowest particle."""

    objective: float
    generation: int
    particle: int
    parameters: FloatArray


@dataclass(frozen=True, slots=True)
class Progress:
    """Everything a calibration knows between two generations.

    Parameters
    ----------
    generation
        Number of the generation that is being evaluated, from 0.
    positions
        Natural values of its particles, shape (n, d).
    evaluations, failed
        Counted so far, finished generations only.
    best
        None while no evaluation has succeeded.
    stagnation
        Finished generations since the best objective was last lowered.
    snapshot
        State of the search.
    ahead, ahead_begun
        Positions of the generation after this one where it is asked for already, and whether it is under way as well.
    lowered_at
        Number of evaluations when the best objective was last lowered.
    widths
        Where the size of generations follows the free slots: particles, whether asked ahead (0, 1), and how many
        generations of that kind followed each other, up to the last one that was asked for.
    lengths
        There, too: what the last runs took [s].
    answer
        The runs after the search, once they have begun.
    """

    generation: int
    positions: FloatArray
    evaluations: int
    failed: int
    best: Best | None
    stagnation: int
    snapshot: Snapshot
    ahead: FloatArray | None = None
    ahead_begun: bool = False
    lowered_at: int = 0
    widths: tuple[tuple[int, int, int], ...] = ()
    lengths: tuple[float, ...] = ()
    answer: Answer | None = None

    def going_on(self) -> Progress:
        """Return the search after the runs that followed it: it asks for what it would have asked for."""
        if self.answer is None:
            return self
        ahead = None if self.answer.ahead is None else np.array(self.answer.ahead)
        return replace(self, positions=np.array(self.answer.positions), ahead=ahead, ahead_begun=False, answer=None)

    def stagnant(self, method: Method) -> int:
        """Generations without a lower objective; where their size follows the slots, of ten runs each at least."""
        if not method.follows_slots:
            return self.stagnation
        return min(self.stagnation, (self.evaluations - self.lowered_at) // _STAGNANT_RUNS)

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form that :meth:`from_json` restores exactly."""
        best = self.best
        more: dict[str, Any] = {"ahead_begun": self.ahead_begun, "lowered_at": self.lowered_at}
        more |= {"widths": list(self.widths), "lengths": list(self.lengths)}
        if self.ahead is not None:
            more["ahead"] = self.ahead.tolist()
        if self.answer is not None:
            more["answer"] = asdict(self.answer)
        return {name: value for name, value in more.items() if value} | {
            "generation": self.generation,
            "positions": self.positions.tolist(),
            "evaluations": self.evaluations,
            "failed": self.failed,
            "best": best
            and {
                "objective": best.objective,
                "generation": best.generation,
                "particle": best.particle,
                "parameters": best.parameters.tolist(),
            },
            "stagnation": self.stagnation,
            "snapshot": self.snapshot,
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Progress:
        """Restore from :meth:`to_json`."""
        best, ahead, answer = data["best"], data.get("ahead"), data.get("answer")
        return cls(
            **{**data, "positions": np.array(data["positions"], dtype=np.float64)}
            | {"best": best and Best(**{**best, "parameters": np.array(best["parameters"], dtype=np.float64)})}
            | {
                "answer": answer and Answer.from_json(answer),
                "ahead": None if ahead is None else np.array(ahead, dtype=np.float64),
                "widths": tuple((n, a, count) for n, a, count in data.get("widths", ())),
                "lengths": tuple(data.get("lengths", ())),
            }
        )


@dataclass(frozen=True, slots=True)
class Step:
    """What follows a finished generation: with no ``stop_reasons`` the next one, ``progress.positions``, is due."""

    progress: Progress
    stop_reasons: tuple[str, ...]
