"""Finds what is installed by its kind: what this package has, and what others offer as entry points of a group.

A thing is loaded only when it is used, so one that is broken never harms the others; and no other package can put
itself in the place of a built-in one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from geoswarm.solver.errors import SolverError
from geoswarm.solver.words import did_you_mean

__all__ = ["Installed", "load_after"]

Found = TypeVar("Found")

_trial: Callable[[str, str], str | None] | None = None


def load_after(trial: Callable[[str, str], str | None] | None) -> None:
    """Load from other packages only what a trial, given group and kind, says nothing against from now on."""
    global _trial
    _trial = trial


class Installed(Generic[Found]):
    """What is installed of one sort.

    Parameters
    ----------
    noun
        What one is called, as "law".
    group
        Of the entry points.
    built_in
        Places by kind, so that a source tree works without being installed.
    base
        Gives the class that each must derive from; it is imported with the first.
    made
        Makes what is given of the class that was found.
    refusal
        What is said of a ``{kind}`` that is unknown, with a ``{hint}`` at the nearest and all that are ``{known}``.
    unknown, broken
        Raised then, and when one cannot be loaded.
    """

    def __init__(
        self,
        noun: str,
        group: str,
        built_in: Mapping[str, str],
        base: Callable[[], type],
        made: Callable[[Any], Found],
        refusal: str,
        unknown: type[SolverError],
        broken: type[SolverError],
    ) -> None:
        self._noun = noun
        self._group = group
        self._built_in = built_in
        self._base = base
        self._made = made
        self._refusal = refusal
        self._unknown = unknown
        self._broken = broken
        self._entries = cache(self._look)
        self._loaded = cache(self._load)

    def kinds(self) -> tuple[str, ...]:
        """Return what is installed, loaded or not, the built-in ones first."""
        return tuple(self._entries())

    def find(self, kind: str) -> Found:
        """Return the one of a kind; raises what the parameters name."""
        entry = self._entries().get(kind)
        if entry is None:
            known = self.kinds()
            hint = did_you_mean(kind, known)
            raise self._unknown(self._refusal.format(kind=kind, hint=hint, known=", ".join(known)))
        return self._loaded(entry)

    def forget(self) -> None:
        """Look anew on the next use, for example after a package was installed."""
        self._entries.cache_clear()
        self._loaded.cache_clear()

    def _look(self) -> dict[str, EntryPoint]:
        built_in = {kind: EntryPoint(kind, place, self._group) for kind, place in self._built_in.items()}
        found = {entry.name: entry for entry in entry_points(group=self._group)}
        return built_in | {kind: entry for kind, entry in sorted(found.items()) if kind not in built_in}

    def _load(self, entry: EntryPoint) -> Found:
        source = f"{self._noun} '{entry.name}' ({entry.value}) is installed but"
        if _trial is not None and entry.name not in self._built_in:
            why = _trial(self._group, entry.name)
            if why is not None:
                raise self._broken(f"{source} cannot be loaded: it {why}")
        try:
            found: Any = import_module(entry.module)
            for attribute in entry.attr.split("."):
                found = getattr(found, attribute)
        except Exception as error:  # anybody's code; a fault of our own is shown as one
            if entry.name in self._built_in:
                raise
            raise self._broken(f"{source} cannot be loaded: {error}") from error
        base = self._base()
        if not (isinstance(found, type) and issubclass(found, base)):
            raise self._broken(f"{source} is not a subclass of {base.__module__}.{base.__qualname__}")
        return self._made(found)
