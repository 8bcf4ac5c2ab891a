"""How a record is written: a frozen dataclass whose fields say what they mean, also in the schemas of the API."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, TypeAlias, TypeVar, dataclass_transform, overload

__all__ = ["Number", "Page", "described", "record"]

Made = TypeVar("Made")

Number: TypeAlias = float | None
"""A number; None where it is not known or not finite, as JSON knows no NaN."""


def described(description: str, **options: Any) -> Any:
    """Return a field with its description; ``options`` as for :func:`dataclasses.field`."""
    return field(metadata={"description": description}, **options)


@overload
def record(made: type[Made]) -> type[Made]: ...


@overload
def record(*, eq: bool = True, closed: bool = False) -> Callable[[type[Made]], type[Made]]: ...


@dataclass_transform(eq_default=True, kw_only_default=True, frozen_default=True, field_specifiers=(field, described))
def record(made: type[Made] | None = None, *, eq: bool = True, closed: bool = False) -> Any:
    """Make a class a record: frozen, with slots, made by names only, so that fields stand in the order of the JSON.

    Parameters
    ----------
    eq
        False: two are the same only if they are one, for records of arrays.
    closed
        The schema says that the API answers these fields and no others. Readers ignore what a newer one adds.
    """

    def make(made: type[Made]) -> type[Made]:
        if closed:
            # pydantic reads this of any class; it is set so that records need not import pydantic
            strict = {"json_schema_extra": {"additionalProperties": False}}
            made.__pydantic_config__ = strict  # type: ignore[attr-defined]  # no class declares it
        return dataclass(frozen=True, slots=True, kw_only=True, eq=eq)(made)

    return make if made is None else make(made)


Item = TypeVar("Item")


@record
class Page(Generic[Item]):
    """Some items of a list; ``next_cursor`` gets the next page, None at the end."""

    items: list[Item]
    next_cursor: str | None
