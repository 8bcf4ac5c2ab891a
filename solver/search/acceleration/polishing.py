"""The end of a polished search that knows objectives alone: when nothing is left to gain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

__all__ = ["Polishing"]

_WORTH = 1e-3  # a relative decrease of the objective that counts
_PATIENCE = 2
_LONGEST = 10  # generations


@dataclass(frozen=True, slots=True)
class Polishing:
    """``best`` objective so far, ``generations`` polished, and how many of them gained nothing in a row."""

    best: float
    generations: int = 0
    waiting: int = 0

    @property
    def done(self) -> bool:
        """Whether the last generations gained nothing, or it went on for long enough."""
        return self.waiting >= _PATIENCE or self.generations >= _LONGEST

    def after(self, best: float) -> Polishing:
        """Return the state after a generation."""
        gained = best < self.best * (1.0 - _WORTH)
        return Polishing(min(best, self.best), self.generations + 1, 0 if gained else self.waiting + 1)

    def to_json(self) -> dict[str, Any]:
        """Return a JSON-able form."""
        return {"best": self.best, "generations": self.generations, "waiting": self.waiting}
