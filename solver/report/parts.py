"""Parts of a report that can be left out; title, facts, alarm and summary are in every one.

Apart from what makes reports: the API names the parts without loading it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

__all__ = ["LABELS", "PARTS", "Part"]

Part: TypeAlias = Literal["verdicts", "figures", "classical", "tables", "provenance"]

LABELS: Mapping[Part, str] = {
    "verdicts": "Verdicts",
    "figures": "Figures",
    "classical": "Classical evaluation",
    "tables": "Tables",
    "provenance": "Provenance and problem",
}
"""Part, in the order of the report -> how a page names it. The classical evaluation has its construction."""

PARTS: tuple[Part, ...] = tuple(LABELS)
