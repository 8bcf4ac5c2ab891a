"""Outcomes as plain JSON values and as rows of words, the same for terminal, pages and scripts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from geoswarm.solver.words import number
from geoswarm.verification.case import Check
from geoswarm.verification.provenance import Provenance
from geoswarm.verification.run import CaseResult

__all__ = ["Row", "check_row", "outcomes_json", "summary"]

_DIGITS = 7


@dataclass(frozen=True, slots=True)
class Row:
    """A check where its difference is largest, in words; ``values`` counts what was compared."""

    quantity: str
    values: str
    ours: str
    reference: str
    difference: str
    allowed: str
    holds: bool


def check_row(one: Check, *, plain: bool = False) -> Row:
    """Return the words of a check; ``plain`` as programs and terminals write numbers."""
    worst = one.worst
    over = {"": "", "absolute": " absolute"}.get(one.of, f" of {one.of}")

    def written(value: float, digits: int) -> str:
        return number(float(value), digits, plain=plain) if math.isfinite(value) else str(value)

    return Row(
        quantity=one.quantity + (f" [{one.unit}]" if one.unit else ""),
        values=str(one.ours.size),
        ours=written(one.ours[worst], _DIGITS),
        reference=written(one.reference[worst], _DIGITS),
        difference=written(one.difference, 2) + over,
        allowed=written(one.allowed, 2) + over,
        holds=one.holds,
    )


def outcomes_json(outcomes: Sequence[CaseResult], where: Provenance) -> dict[str, Any]:
    """Return all outcomes with where they come from; a value that is not finite is None."""
    return {
        "holds": all(one.state != "fails" for one in outcomes),
        "provenance": asdict(where),
        "cases": [
            {
                "name": one.case.name,
                "title": one.case.title,
                "state": one.state,
                "problem": one.problem,
                "seconds": round(one.seconds, 3),
                "checks": [_check_json(c) for c in one.answer.checks] if one.answer else [],
            }
            for one in outcomes
        ],
    }


def _check_json(one: Check) -> dict[str, Any]:
    at = one.worst
    numbers = {"ours": one.ours[at], "reference": one.reference[at], "difference": one.difference}
    finite = {name: float(value) if math.isfinite(value) else None for name, value in numbers.items()}
    rest = {"allowed": one.allowed, "of": one.of or "the reference", "values": one.ours.size, "holds": one.holds}
    return {"quantity": one.quantity, "unit": one.unit, **finite, **rest}


def summary(outcomes: Sequence[CaseResult]) -> str:
    """Say how many cases there are and how they ended."""
    count = {state: sum(one.state == state for one in outcomes) for state in ("holds", "fails", "left out")}
    words = f"{count['holds']} of {len(outcomes)} cases hold"
    words += f", {count['fails']} fail" if count["fails"] else ""
    return words + (f", {count['left out']} left out" if count["left out"] else "")
