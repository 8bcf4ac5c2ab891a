"""One page of a listing."""

from __future__ import annotations

from typing import Generic, TypeVar

from geoswarm.records.record import record

__all__ = ["Page"]

Item = TypeVar("Item")


@record
class Page(Generic[Item]):
    """Some items of a list; ``next_cursor`` gets the next page, None at the end."""

    items: list[Item]
    next_cursor: str | None
