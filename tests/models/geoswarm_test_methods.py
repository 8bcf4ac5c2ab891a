"""A method of another package: the points of a grid, in the order of the first parameter first."""

from __future__ import annotations

import os
import sys
import time
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from geoswarm import FloatArray
from geoswarm.solver.methods.base import Maker, Method, Role, Task

__all__ = ["GridMethod"]


class GridMethod(Method):
    """All combinations of equally spaced values; with a fault where the second generation is closed."""

    role: ClassVar[Role] = "sampling"
    title: ClassVar[str] = "grid"

    kind: Literal["grid"] = "grid"
    levels: int = 4
    fault: Literal["none", "exit", "hang"] = "none"

    def planned(self, free: int) -> int | None:
        """Levels to the power of the number of parameters."""
        return int(self.levels**free)

    def in_words(self) -> str:
        """Levels."""
        return f"grid of {self.levels} levels"

    def end_reason(self, search: Any, evaluations: int, *, over: bool) -> str | None:  # noqa: ARG002
        """It ends with its last point."""
        return "grid_completed" if over else None

    def maker(self, task: Task) -> Maker:
        """Prepare."""
        return _GridMaker(task, self.levels, self.fault)


@dataclass(frozen=True)
class _GridMaker:
    task: Task
    levels: int
    fault: str

    def start(self, slots: int) -> _Grid:  # noqa: ARG002
        return _Grid(self.task, self.levels, self.fault, 0)

    def restore(self, snapshot: dict[str, Any]) -> _Grid:
        return _Grid(self.task, self.levels, self.fault, snapshot["generation"])


@dataclass
class _Grid:
    task: Task
    levels: int
    fault: str
    generation: int

    def ask(self) -> FloatArray | None:
        axes = [(np.arange(self.levels) + 0.5) / self.levels] * self.task.space.dimension
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))
        rows = points[self.generation * self.levels : (self.generation + 1) * self.levels]
        return self.task.space.from_unit(rows) if len(rows) else None

    def tell(self, objectives: FloatArray, runs: Any = None) -> None:  # noqa: ARG002
        if self.generation == 1 and "pytest" not in sys.modules:  # it must not end the tests
            if self.fault == "exit":
                os._exit(0)
            if self.fault == "hang":
                time.sleep(1e6)
        self.generation += 1

    def snapshot(self) -> dict[str, Any]:
        return {"generation": self.generation}
