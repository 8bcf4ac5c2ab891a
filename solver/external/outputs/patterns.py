"""Regular expressions that users write.

They are Python's, matched within single lines. A pattern has at most 1000 characters and a line on which it is tried at
most 10 000 bytes: these sections come from whoever owns the machine, and a pattern such as ``(a+)+b`` can still take
long: reading has a limit of time (:mod:`geoswarm.solver.external.reading_time`).
"""

from __future__ import annotations

import re
import warnings

__all__ = ["LONGEST_MATCHED", "compiled"]

LONGEST_MATCHED = 10_000
"""Bytes of a line in a file that is searched with a regular expression."""

LONGEST_PATTERN = 1000
"""Characters of a regular expression."""


def compiled(pattern: str) -> re.Pattern[str]:
    """Compile a regular expression.

    Raises
    ------
    ValueError
        It is too long or wrong; the message says where.
    """
    if len(pattern) > LONGEST_PATTERN:
        raise ValueError(f"regular expression has {len(pattern)} characters; at most {LONGEST_PATTERN} are accepted")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return re.compile(pattern)
    except (re.error, Warning, RecursionError, OverflowError) as error:
        raise ValueError(f"'{pattern[:80]}' is not a regular expression: {error}") from None
