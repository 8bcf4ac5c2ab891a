"""Where in a JSON text a key is given twice: the decoder of the standard library tells no place."""

from __future__ import annotations

import json
import re
from itertools import chain, pairwise

__all__ = ["duplicate_place"]

# A string that does not end reaches to the end of the text, so that each character is looked at once.
_PIECE = re.compile(r'"(?:[^"\\]|\\.)*+"?|[{}\[\]:,]', re.DOTALL)


def duplicate_place(text: str) -> str:
    """Return `` in line L, column C`` of the first key that its mapping has already; empty where there is none.

    Parameters
    ----------
    text
        JSON, valid up to that place.
    """
    open_ones: list[set[str] | None] = []  # keys of the mappings around a place, None for lists
    for piece, following in pairwise(chain(_PIECE.finditer(text), [None])):
        assert piece is not None  # only the last one is
        sign = piece.group()
        if sign in "{[":
            open_ones.append(set() if sign == "{" else None)
        elif sign in "}]":
            open_ones.pop()
        elif sign[0] == '"' and following is not None and following.group() == ":" and open_ones:
            keys = open_ones[-1]
            key = json.loads(sign, strict=False)
            if keys is not None and key in keys:
                line = text.count("\n", 0, piece.start()) + 1
                return f" in line {line}, column {piece.start() - text.rfind(chr(10), 0, piece.start())}"
            if keys is not None:
                keys.add(key)
    return ""
