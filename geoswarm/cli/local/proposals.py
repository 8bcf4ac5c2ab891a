"""Proposals of ``geoswarm statistics`` by the key that ``--accept`` takes, each key one proposal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

__all__ = ["proposals_by_key"]

_KINDS = ("fix", "link", "widen")


def proposals_by_key(found: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the proposals that can be accepted, by ``KIND:NAME``, strongest first.

    Several of one kind about one parameter have the partner behind it: ``link:POP:OCR``.
    """
    proposals = [p for verdict in found["verdicts"] for p in verdict["proposals"] if p["kind"] in _KINDS]
    alike = Counter((p["kind"], p["parameter"]) for p in proposals)
    keyed: dict[str, dict[str, Any]] = {}
    for p in proposals:
        key = f"{p['kind']}:{p['parameter']}"
        if alike[p["kind"], p["parameter"]] > 1 and p["line"] is not None:
            key = f"{key}:{p['line']['partner']}"
        keyed[key] = p
    return keyed
