"""The examples as files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from geoswarm.cli.failures import BadInputError
from geoswarm.solver.examples import example_file, example_names

__all__ = ["example_problem"]


@contextmanager
def example_problem(name: str) -> Iterator[Path]:
    """Give the problem file of an example, its data beside it, while the body runs.

    Raises
    ------
    BadInputError
        When the installation lacks the example.
    """
    if name not in example_names():
        raise BadInputError(f"the example '{name}' is missing in this installation; install geoswarm again")
    with example_file(name) as path:
        yield path
