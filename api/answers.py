"""Documents of the solver as the records that are answered."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, TypeVar

from pydantic import TypeAdapter

from geoswarm.solver.report.jsonable import jsonable

__all__ = ["read_record"]

T = TypeVar("T")


def read_record(kind: type[T], document: Mapping[str, Any]) -> T:
    """Return a document as a record; what is not finite in it is None.

    Raises
    ------
    ValueError
        When a field is missing, or is not of its type.
    """
    record: Any = kind
    found: T = _adapter(record).validate_python(jsonable(document))
    return found


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)
