"""Where statistics and reports come from: a job of a service, or a folder of ``geoswarm run --output``."""

from __future__ import annotations

from pathlib import Path

from geoswarm.cli.failures import BadInputError

__all__ = ["as_folder", "named_numbers", "threshold_check"]


def as_folder(source: str) -> Path | None:
    """Return the folder that an argument names; None when it must be the id of a job."""
    folder = Path(source)
    if folder.is_dir():
        return folder
    if folder.is_file():
        raise BadInputError(
            f"{source} is a file; give the id of a job or the folder of a run (geoswarm run PROBLEM --output DIR)"
        )
    return None


def named_numbers(option: str, items: tuple[str, ...]) -> dict[str, float] | None:
    """Return NAME=NUMBER options as a mapping; None without any.

    Raises
    ------
    BadInputError
        When an item is not of that form.
    """
    found = {}
    for item in items:
        name, sign, text = item.partition("=")
        try:
            found[name.strip()] = float(text)
        except ValueError:
            sign = ""
        if not sign or not name.strip():
            raise BadInputError(f"{option} {item}: NAME=NUMBER is accepted, for example {option} settlement=2")
    return found or None


def threshold_check(threshold: float | None) -> None:
    """Refuse a threshold that is not above 0."""
    if threshold is not None and not 0.0 < threshold < float("inf"):
        raise BadInputError(f"--threshold {threshold:g}: a number above 0 is accepted")
