"""The examples that come with the program."""

from __future__ import annotations

from fastapi import APIRouter

from geoswarm.api.dependencies import problems_of
from geoswarm.api.drafts import find_examples
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.drafts import Example, ExampleList, ExampleSummary

__all__ = ["router"]

router = APIRouter(prefix="/examples", tags=["problems"])


@router.get("", responses=problems_of())
def list_examples() -> ExampleList:
    """List the examples."""
    return ExampleList(items=[ExampleSummary.model_validate(one.model_dump()) for one in find_examples().values()])


@router.get("/{name}", responses=problems_of(404))
def show_example(name: str) -> Example:
    """Show an example with its problem, which can be submitted as it is."""
    found = find_examples().get(name)
    if found is None:
        known = ", ".join(find_examples())
        raise DetailError(404, f"There is no example '{name[:80]}'; known: {known}.", kind="unknown-example")
    return found
