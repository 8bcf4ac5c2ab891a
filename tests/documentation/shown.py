"""Compare JSON that a page shows with what is printed: numbers to the digits shown, ``...`` as a wildcard."""

from __future__ import annotations

import json
import re
from decimal import Decimal
from typing import Any

__all__ = ["agrees", "as_shown"]


def as_shown(text: str) -> Any:
    """Read JSON of a page; what ``...`` or ``…`` stands for is left out, numbers keep the digits that are shown."""
    whole = re.sub(r"(, *)?(\.\.\.|…)(?=\s*[\]}])", "", text)
    return json.loads(whole, parse_float=Decimal, parse_int=Decimal)


def agrees(shown: Any, printed: Any) -> bool:
    """Return whether what is printed begins with, or contains, what is shown."""
    if isinstance(shown, dict):
        return shown.keys() <= printed.keys() and all(agrees(value, printed[name]) for name, value in shown.items())
    if isinstance(shown, list):
        return len(shown) <= len(printed) and all(map(agrees, shown, printed))
    if isinstance(shown, Decimal):
        digits = len(shown.as_tuple().digits)
        return Decimal(f"{printed:.{digits - 1}e}") == shown
    return bool(shown == printed)
