"""The examples as files, from a wheel or from a source tree."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import as_file, files
from pathlib import Path

from geoswarm.cli.failures import BadInputError

__all__ = ["example_problem"]


@contextmanager
def example_problem(name: str) -> Iterator[Path]:
    """Give the problem file of an example, its data beside it, while the body runs.

    The build puts ``examples/<name>`` of the source tree into the wheel as ``geoswarm/examples/<name>``; a source
    tree that is used directly, or installed in editable mode, has them only at the first place.

    Raises
    ------
    BadInputError
        When the installation lacks the example.
    """
    packaged = files("geoswarm") / "examples" / name
    if packaged.joinpath("problem.yaml").is_file():
        with as_file(packaged) as folder:
            yield folder / "problem.yaml"
        return
    in_source_tree = Path(__file__).resolve().parents[2] / "examples" / name / "problem.yaml"
    if not in_source_tree.is_file():
        raise BadInputError(f"the example '{name}' is missing in this installation; install geoswarm again")
    yield in_source_tree
