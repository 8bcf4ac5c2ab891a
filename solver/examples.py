"""The examples: problem files with their data, from a wheel or from a source tree."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path

__all__ = ["example_file", "example_names"]

_PROBLEM = "problem.yaml"


def example_names() -> tuple[str, ...]:
    """Names of the examples that this installation has, in alphabetical order."""
    return tuple(sorted(one.name for one in _folder().iterdir() if one.joinpath(_PROBLEM).is_file()))


@contextmanager
def example_file(name: str) -> Iterator[Path]:
    """Give the problem file of an example, its data beside it, while the body runs.

    Raises
    ------
    KeyError
        There is no such example.
    """
    if name not in example_names():
        raise KeyError(name)
    with as_file(_folder().joinpath(name)) as folder:
        yield folder / _PROBLEM


def _folder() -> Traversable:
    return files("geoswarm").joinpath("examples")
