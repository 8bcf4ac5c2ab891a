"""Variants of one test: a few by default, all of them in the long run."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest

__all__ = ["variants"]


def variants(cases: Iterable[Any], default: Collection[Any]) -> list[Any]:
    """Cases for ``pytest.mark.parametrize``; slow are those whose value, or first value, is not in ``default``.

    For variants that go the same way through what is slow, such as a browser, and whose differences other tests see.
    """
    found = []
    for case in cases:
        values = case if isinstance(case, tuple) else (case,)
        found.append(pytest.param(*values, marks=[] if values[0] in default else [pytest.mark.slow]))
    return found
