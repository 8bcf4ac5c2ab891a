"""Parts of a report that can be left out; title, facts, alarm and summary are in every one.

Apart from what makes reports: the API names the parts without loading it.
"""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

__all__ = ["PARTS", "Part"]

Part: TypeAlias = Literal["verdicts", "figures", "classical", "tables", "provenance"]

PARTS: tuple[Part, ...] = get_args(Part)
"""In the order of the report; ``classical``: the classical evaluation with its construction."""
