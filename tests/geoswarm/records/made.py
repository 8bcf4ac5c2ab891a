"""Records as tests need them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from geoswarm.records.evaluation import Evaluation


def evaluation(**changes: Any) -> Evaluation:
    """A failed evaluation of which nothing is known but its place."""
    known: dict[str, Any] = dict.fromkeys(field.name for field in fields(Evaluation))
    known |= {"generation": 0, "particle": 0, "state": "failed", "parameters": {"a": 1.0}, "misfits": {}, "attempts": 1}
    return Evaluation(**known | changes)
