"""The process in which forward models of other packages are read, built and asked; see :mod:`.isolated`."""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import lru_cache
from importlib.metadata import entry_points
from typing import Any

import numpy as np
from pydantic import ValidationError

from geoswarm.solver.errors import ForwardError, ProblemError, SolverError, in_words, message_of
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec, TellsUnused
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.system.processes import die_with_parent, go_first_without_memory

__all__ = ["FACTS", "main"]

FACTS = ("assumptions", "kernels", "only_here", "quick", "runs_outside", "runs_programs")
"""Attributes of a section that a process keeps of it."""


def main(_given: Mapping[str, Any]) -> None:
    """Answer questions, one a line of JSON, until standard input ends."""
    die_with_parent()
    go_first_without_memory()
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what a model prints is no answer
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(sys.stdin, lines), daemon=True).start()
    while True:
        question = json.loads(lines.get())
        answer = {"number": question["number"], **_answer(question)}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def _read(stream: Any, lines: queue.SimpleQueue[str]) -> None:
    for line in stream:
        lines.put(line)
    os._exit(0)


def _answer(question: Mapping[str, Any]) -> dict[str, Any]:
    try:
        return {"found": _QUESTIONS[question["ask"]](question["section"], *question["given"])}
    except ValidationError as error:
        return {"errors": [[one["loc"], one["msg"]] for one in error.errors(include_url=False, include_input=False)]}
    except ProblemError as error:
        return {"issues": [[issue.path, issue.message] for issue in error.issues]}
    except ForwardError as error:
        return {"reason": error.reason, "message": message_of(error)}
    except (SolverError, ValueError) as error:
        return {"message": str(error)}
    except BaseException as error:  # noqa: BLE001  anybody's code
        return {"message": f"the forward model raised {in_words(error)}"}


@lru_cache(maxsize=64)
def _spec(section: str) -> ForwardModelSpec:
    return parse_spec(json.loads(section)).with_files(None, "forward_model")


@lru_cache(maxsize=64)
def _model(section: str) -> ForwardModel:
    return built(_spec(section))


def _described(section: str) -> dict[str, Any]:
    spec = parse_spec(json.loads(section))
    facts = {name: getattr(spec, name) for name in FACTS}
    plain = {name: list(fact) if isinstance(fact, frozenset | tuple) else fact for name, fact in facts.items()}
    return {"section": spec.model_dump(mode="json"), "facts": plain}


def _build(section: str) -> dict[str, Any]:
    model = _model(section)
    return {
        "parameters": [asdict(info) for info in model.parameters],
        "series": [asdict(info) for info in model.series],
        "open_parameters": bool(model.open_parameters),
        "tells_unused": isinstance(model, TellsUnused),
    }


def _prepare(section: str, points: Mapping[str, Any]) -> None:
    _model(section).prepare({name: np.array(x, dtype=np.float64) for name, x in points.items()})


def _run(section: str, points: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    run = _model(section).prepare({name: np.array(x, dtype=np.float64) for name, x in points.items()})
    return {name: np.asarray(y, dtype=np.float64).tolist() for name, y in run(values).items()}


def _load(group: str, kind: str) -> None:
    """Load what another package offers; the caller learns whether the process outlives it."""
    for entry in entry_points(group=group):
        if entry.name == kind:
            entry.load()


_QUESTIONS: dict[str, Callable[..., Any]] = {
    "describe": _described,
    "build": _build,
    "load": _load,
    "prepare": _prepare,
    "run": _run,
    "shown": lambda section, text: str(_spec(section).shown(text)),
    "unavailable": lambda section: _spec(section).unavailable(),
    "remedy_for": lambda section, series: str(_spec(section).remedy_for(series)),
    "at_once": lambda section, *given: int(_spec(section).at_once(*given)),
    "grid": lambda section, series: np.asarray(_model(section).grid(series), dtype=np.float64).tolist(),
    "check": lambda section, values: _model(section).check(values),
    "unused": lambda section, names: list(_model(section).unused(names)),  # type: ignore[attr-defined]
}
