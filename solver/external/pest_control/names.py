"""Names that a problem accepts, of the same length where they stand in templates."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable
from itertools import chain, product

__all__ = ["new_name", "same_length", "word"]

_SIGNS = "abcdefghijklmnopqrstuvwxyz0123456789"


def word(text: str) -> str:
    """Return a text as a name: other signs become ``_``, and a letter comes first.

    >>> word("hk-1:a"), word("1st")
    ('hk_1_a', '_1st')
    """
    found = re.sub(r"[^A-Za-z0-9_]", "_", text)
    return found if re.match(r"[A-Za-z_]", found) else f"_{found}"


def new_name(base: str, taken: Collection[str]) -> str:
    """Return ``base``, or ``base_2`` and so on where it is taken."""
    number, name = 1, base
    while name in taken:
        number += 1
        name = f"{base}_{number}"
    return name


def same_length(names: Iterable[str], accepted: Callable[[str], bool]) -> dict[str, str]:
    """Return new names, for those that are not accepted, that are as long as the old ones.

    A parameter space of a template is as wide as it is: a longer name might not fit, and would change the number's
    digits.

    >>> same_length(["hk-1", "hk_1", "k"], str.isidentifier)
    {'hk-1': 'hk_a'}
    """
    listed = list(names)
    taken = {name for name in listed if accepted(name)}
    found: dict[str, str] = {}
    for name in listed:
        if name in taken:
            continue
        plain = re.sub(r"\W", "_", name, flags=re.ASCII)
        if plain[:1].isdigit():
            plain = "_" + plain[1:]
        endings = ((plain[:-count], ending) for count in (1, 2, 3) for ending in product(_SIGNS, repeat=count))
        candidates = chain([plain], (start + "".join(ending) for start, ending in endings if start or ending))
        found[name] = next(new for new in candidates if len(new) == len(name) and accepted(new) and new not in taken)
        taken.add(found[name])
    return found
