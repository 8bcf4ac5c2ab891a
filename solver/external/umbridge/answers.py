"""What a server answers, checked and as numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.umbridge.client import PROTOCOL
from geoswarm.solver.words import did_you_mean

__all__ = ["checked_info", "checked_sizes", "vectors"]


def checked_info(answer: Any, name: str, url: str) -> None:
    """Look at the answer to ``/Info``.

    Raises
    ------
    RunFailedError
        ``bad_output``: another version of the protocol, or no model of that name.
    """
    version = answer.get("protocolVersion") if isinstance(answer, dict) else None
    models = answer.get("models") if isinstance(answer, dict) else None
    if not isinstance(version, int | float) or not abs(version) < 1e6 or not isinstance(models, list):
        raise RunFailedError("bad_output", f"{url} is not an UM-Bridge server: {str(answer)[:100]}")
    if int(version) != int(PROTOCOL):
        raise RunFailedError("bad_output", f"{url} speaks version {version:g} of the protocol, not {PROTOCOL:g}")
    names = [str(one) for one in models]
    if name not in names:
        hint = did_you_mean(name, names)
        raise RunFailedError("bad_output", f"{url} has no model '{name}'{hint}; it has {', '.join(names[:50])}")


def checked_sizes(answer: Any, key: str, url: str) -> list[int]:
    """Sizes of vectors, of the answer to ``/InputSizes`` or ``/OutputSizes``.

    Raises
    ------
    RunFailedError
        ``bad_output``: they are something else.
    """
    found = answer.get(key) if isinstance(answer, dict) else None
    if not isinstance(found, list) or not all(isinstance(one, int) and not isinstance(one, bool) for one in found):
        raise RunFailedError("bad_output", f"{url} answered without {key}: {str(answer)[:100]}")
    return list(found)


def vectors(answer: Any, sizes: Sequence[int], url: str) -> list[FloatArray]:
    """Output vectors, of the answer to ``/Evaluate``; each of its size, all finite.

    Raises
    ------
    RunFailedError
        ``bad_output``: other sizes, or no numbers. ``not_finite``: a number is NaN or infinite.
    """
    output = answer.get("output") if isinstance(answer, dict) else None
    if not isinstance(output, list) or not all(isinstance(one, list) for one in output):
        raise RunFailedError(
            "bad_output", f"{url} answered with an output that is not a list of lists: {str(answer)[:100]}"
        )
    got = [len(one) for one in output]
    if got != list(sizes):
        raise RunFailedError("bad_output", f"{url} answered output vectors of {_list(got)} numbers, not {_list(sizes)}")
    found = []
    for index, one in enumerate(output):
        if any(isinstance(value, bool) or not isinstance(value, int | float | None) for value in one):
            raise RunFailedError("bad_output", f"{url}: output {index} contains what is not a number: {str(one)[:100]}")
        values = np.array([_number(value) for value in one], dtype=np.float64)
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            place = int(wrong[0])
            raise RunFailedError("not_finite", f"{url}: output {index} is {values[place]} at number {place + 1}")
        found.append(values)
    return found


def _number(value: float | None) -> float:
    """NaN for null, which stands for it in some JSON; infinity for whole numbers beyond all floats."""
    try:
        return np.nan if value is None else float(value)
    except OverflowError:
        return np.inf


def _list(sizes: Sequence[int]) -> str:
    return ", ".join(map(str, sizes[:20])) or "none"
