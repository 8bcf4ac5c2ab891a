"""Registered models whose program misbehaves where the slope is positive, and why their runs must fail then."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.text.writing import problem_yaml

__all__ = ["ZOO", "Behaviour", "register", "zoo_problem"]

PROGRAM = Path(__file__).parents[2] / "models" / "programs" / "zoo.py"


@dataclass(frozen=True)
class Behaviour:
    """``reason`` None: the run succeeds. ``words`` must be in the message. ``section`` changes the forward model."""

    reason: str | None
    words: str = ""
    section: dict[str, Any] = field(default_factory=dict)


ZOO = {
    "good": Behaviour(None),
    "missing": Behaviour("not_started", "was not found on PATH", {"run": ["no-such-program", "x"]}),
    "not_executable": Behaviour("not_started", "is not executable", {"run": ["./zoo.py"]}),
    "exit_1": Behaviour("program_failed", "*ERROR: no convergence"),
    "exit_3": Behaviour("diverged", "exit status 3", {"fail": {"exit": {"3": "diverged"}}}),
    "error_text": Behaviour("diverged", "zero pivot", {"fail": {"text": {"job.log": {r"\*ERROR": "diverged"}}}}),
    "killed": Behaviour("program_failed", "SIGKILL"),
    "no_output": Behaviour("no_output", "has not written out.csv"),
    "old_output": Behaviour("no_output", "older than the run", {"files": ["zoo.py", "out.csv"]}),
    "truncated": Behaviour("bad_output", "out.csv"),
    "not_finite": Behaviour("not_finite", "out.csv"),
    "too_few": Behaviour("bad_output", "observed from 0 to 4"),
    "encoding": Behaviour("bad_output", "out.csv"),
    "loud": Behaviour(None, section={"seconds": 120}),
    "children": Behaviour(None),
    "hangs": Behaviour("timeout", "was killed after", {"seconds": 5.0}),
    "licence": Behaviour(None, section={"fail": {"exit": {"4": "no_licence"}}, "licence_pause": 0.05, "slots": 1}),
    "disk_full": Behaviour("program_failed", "No space left on device"),
    "fallback": Behaviour(
        None,
        "counted: {python} zoo.py good, after program_failed: false ended",
        section={"run": ["false"], "then": [["{python}", "zoo.py", "good"]]},
    ),
}
"""By behaviour. The program of "fallback", "missing" and "not_executable" does nothing wrong itself."""


def register(models: Path) -> None:
    """Put a registered model for each behaviour below a folder."""
    for name, behaviour in ZOO.items():
        folder = models / name
        folder.mkdir(parents=True)
        shutil.copy(PROGRAM, folder / "zoo.py")
        (folder / "zoo.py").chmod(0o644)
        (folder / "input.in").write_text("{{slope}}\n")
        (folder / "out.csv").write_text("x,y\n0,0\n4,4\n")  # of an earlier run
        own = name if "run" not in behaviour.section else "good"
        section = {
            "kind": "command",
            "run": ["{python}", "zoo.py", own],
            "files": ["zoo.py"],
            "templates": {"input.txt": "input.in"},
            "environment": {"ZOO_TRIES": str(models.parent / "tries")},
            "series": {"y": {"file": "out.csv", "x": "x", "y": "y"}},
            **behaviour.section,
        }
        model = {"forward_model": section, "parameters": {"slope": {"lower": -10, "upper": 10}}}
        (folder / "model.yaml").write_text(problem_yaml(model))


def zoo_problem(name: str, **changes: Any) -> Problem:
    """A problem on a registered model: four samples, of which two have a positive slope."""
    document: dict[str, Any] = {
        "name": name,
        "forward_model": {"kind": "registered", "model": name},
        "parameters": {"slope": {"lower": -1, "upper": 1}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2, 4], "y": [0, 0.5, 1, 2]}}],
        "method": {"kind": "monte_carlo", "samples": 4, "batch": 4, "sampling": "latin_hypercube"},
        "seed": 3,
    }
    return parse_problem(document | changes)
