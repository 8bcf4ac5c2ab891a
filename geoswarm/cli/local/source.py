"""Where statistics and reports come from: a job of a service, or a folder of ``geoswarm run --output``."""

from __future__ import annotations

from pathlib import Path

import click

from geoswarm.cli.words.error_messages import BadInputError

__all__ = ["as_folder", "known_noise", "named_numbers", "noise_option", "threshold_check"]

noise_option = click.option(
    "--noise",
    multiple=True,
    metavar="[SERIES=]VALUE",
    help="Known standard deviation of a reading, base units (m, kPa, ...); that of the problem if not given.",
)


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
            raise BadInputError(f"{option} must be NAME=NUMBER, for example {option} settlement=2; got {item}")
    return found or None


def known_noise(items: tuple[str, ...]) -> dict[str, float] | float | None:
    """Return the --noise options: one number for all series, or one each; None without any.

    Raises
    ------
    BadInputError
        When an item is not of that form.
    """
    if len(items) == 1 and "=" not in items[0]:
        try:
            return float(items[0])
        except ValueError:
            raise BadInputError(f"--noise must be a number, or SERIES=NUMBER; got {items[0]}") from None
    return named_numbers("--noise", items)


def threshold_check(threshold: float | None) -> None:
    """Refuse a threshold that is not above 0."""
    if threshold is not None and not 0.0 < threshold < float("inf"):
        raise BadInputError(f"--threshold must be above 0, got {threshold:g}")
