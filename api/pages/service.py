"""Pages of the service itself: signing in with an API key, workers and operations."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse

from geoswarm.api.pages.shell import render
from geoswarm.solver.system.versions import versions

__all__ = ["own_address", "router"]

router = APIRouter()


@router.get("/sign-in")
def sign_in_page(request: Request, go_on: Annotated[str, Query(alias="next", max_length=2000)] = "/") -> HTMLResponse:
    """Ask for the API key, then continue to the requested page."""
    needed = request.app.state.authenticator.asks_here()
    return render(request, "sign_in", key_needed=needed, go_on=own_address(go_on))


def own_address(address: str) -> str:
    """The address when it leads to a page of this service, else the first page."""
    own = address.startswith("/") and not address.startswith("//") and "\\" not in address and address.isprintable()
    return address if own else "/"


@router.get("/workers")
def workers_page(request: Request) -> HTMLResponse:
    """Show workers and their work."""
    return render(request, "workers", version=versions()["geoswarm"])
