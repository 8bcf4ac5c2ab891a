"""What users of a service see of the messages of a registered model: nothing of the folders of its machine."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterable
from pathlib import Path

__all__ = ["without_paths"]

_BEGINS = r"(?:(?<![\w./~-])|(?<=\s-[A-Za-z]))"  # no part of a relative path, of an address or of a unit
_SIGNS = r"\s'\"`<>|:;,()\[\]{}="
_ENDS = rf"(?=[/{_SIGNS}]|\.?(?:\s|$))"
_ABSOLUTE = re.compile(rf"{_BEGINS}/(?P<first>[^/{_SIGNS}]+)(?:/[^/{_SIGNS}]*)*")


def without_paths(text: str, model: str, folders: Iterable[Path] = ()) -> str:
    """Return a text in which paths are relative: to the model by its name, else the name of a file alone.

    Parameters
    ----------
    model, folders
        Name of the model, and folders that stand for it.

    Examples
    --------
    >>> without_paths("/srv/m/deck.inp, /usr/bin/env: 3 kN/m", "footing", [Path("/srv/m")])
    'footing/deck.inp, env: 3 kN/m'
    """
    text = text.replace("file://", "")
    for folder in sorted({str(one) for one in folders}, key=len, reverse=True):
        text = re.sub(_BEGINS + re.escape(folder) + _ENDS, lambda _: model, text)
    temporary = tempfile.gettempdir().rstrip(os.sep)
    text = re.sub(_BEGINS + re.escape(temporary) + r"/(?=[^/\s])", "", text)
    return _ABSOLUTE.sub(_last, text)


def _last(found: re.Match[str]) -> str:
    """The last part of a path, where there is such a folder at all."""
    if not os.path.lexists(f"/{found['first']}"):
        return found[0]
    return found[0].rstrip("/").rpartition("/")[2]
