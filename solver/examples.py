"""The examples: problem files with their data, from a wheel or from a source tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path

__all__ = ["ExampleSummary", "describe_example", "example_file", "example_names"]

_PROBLEM, _EXPLANATION = "problem.yaml", "README.md"
_ENGINES = ("command", "python", "registered")


@dataclass(frozen=True, slots=True)
class ExampleSummary:
    """What an example shows.

    ``forward_model`` and ``method`` are the kinds in its problem; ``needs_engine`` says whether it runs a program
    beside geoswarm: one that must be installed, a compiler for instance, or a Python function of its own.
    """

    name: str
    title: str
    forward_model: str
    method: str
    needs_engine: bool


def example_names(*, engines: bool = True) -> tuple[str, ...]:
    """Names of the examples that this installation has, in alphabetical order.

    Parameters
    ----------
    engines
        Also those that run a program, which their explanations name.
    """
    names = sorted(one.name for one in _folder().iterdir() if one.joinpath(_PROBLEM).is_file())
    return tuple(name for name in names if engines or not describe_example(name).needs_engine)


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


@cache
def describe_example(name: str) -> ExampleSummary:
    """Tell what an example shows: the heading of its explanation, and the kinds of its forward model and method.

    Raises
    ------
    KeyError
        There is no such example.
    """
    from geoswarm.solver.problem.text.reading import read_problem_file

    with example_file(name) as path:
        document = read_problem_file(path)
        heading = path.with_name(_EXPLANATION).read_text(encoding="utf-8").partition("\n")[0]
    kind, method = document["forward_model"]["kind"], document["method"]["kind"]
    library = isinstance(document["forward_model"].get("material"), Mapping)  # a law in one, which is compiled first
    needs_engine = library or kind in _ENGINES
    return ExampleSummary(name, heading.lstrip("# ").replace("\\", ""), kind, method, needs_engine)


def _folder() -> Traversable:
    return files("geoswarm").joinpath("examples")
