"""What the tests of the Python interface calibrate: a user's module with functions, and the same as a problem file."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import geoswarm as gs

__all__ = ["OPTIONS", "PARAMETERS", "SOURCE", "X", "Y", "module", "numbers", "problem_file", "rows"]

X = [0.0, 1.0, 2.0, 4.0]
Y = [1.0, 3.0, 5.0, 9.0]
SOURCE = """
import time

def line(x, a, b=2.0):
    return a + b * x

def slow(x, a, b):
    if a > 0:
        time.sleep(60)
    return a + b * x

def large(x, a, b):
    block = bytearray(400 * 2**20) if a > 0 else b""
    while block:  # until it is seen, however busy the machine is
        time.sleep(0.1)
    return a + b * x + 0.0 * len(block)

def wrong(x, a, b):
    if a > 0:
        raise ValueError(f"a = {a:.1f} is above 0")
    return a + b * x
"""
PARAMETERS = {"a": gs.free(-5, 5), "b": gs.free(0, 4)}
OPTIONS: dict[str, Any] = {
    "parameters": PARAMETERS,
    "observations": gs.observed(X, Y, error=0.1),
    "method": {"kind": "particle_swarm", "particles": 6},
    "stopping": {"max_evaluations": 60},
    "seed": 7,
}
NUMBER = iter(range(1000))


def module(folder: Path, source: str = SOURCE) -> ModuleType:
    """A new module of a user's."""
    name = f"model_of_tests_{next(NUMBER)}"
    (folder / f"{name}.py").write_text(source)
    sys.path.insert(0, str(folder))
    try:
        return import_module(name)
    finally:
        sys.path.remove(str(folder))


def problem_file(folder: Path, function: Callable[..., Any], **changes: Any) -> Path:
    """The same calibration as a problem file beside the function's."""
    points = {"x": X, "y": Y}
    document = {
        "name": function.__name__,
        "forward_model": {
            "kind": "python",
            "file": f"{function.__module__}.py",
            "function": function.__name__,
            "series": {"y": {}},
        },
        **OPTIONS,
        "observations": [{"series": "y", "points": points, "error": 0.1}],
    }
    path = folder / "problem.json"
    path.write_text(json.dumps(document | changes))
    return path


def rows(folder: Path) -> list[dict[str, str]]:
    """Evaluations of a run folder without their times."""
    with (folder / "evaluations.csv").open(encoding="utf-8") as file:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(file)]


def numbers(result: gs.Result) -> list[float | None]:
    return [r.evaluation.objective for r in result.history]
