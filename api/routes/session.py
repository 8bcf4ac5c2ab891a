"""Signing in: a browser gives its API key once and is known by a cookie afterwards."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Body, Request, Response
from starlette.datastructures import Headers

from geoswarm.api.access.authentication import SESSION_COOKIE, Authenticator, Identity, given_token
from geoswarm.api.dependencies import problems_of
from geoswarm.api.errors import role_refused
from geoswarm.api.schemas.responses import SignIn
from geoswarm.records.service import Session
from geoswarm.workers.access.principal import LOCAL
from geoswarm.workers.access.sessions import SESSION_SECONDS

__all__ = ["router"]

router = APIRouter(prefix="/session", tags=["session"])

CHALLENGE = 'Bearer realm="geoswarm"'


@router.post("", status_code=201, responses=problems_of(408, 413, 422))
async def sign_in(given: Annotated[SignIn, Body()], request: Request, response: Response) -> Session:
    """Start a session: the answer sets an http-only cookie that replaces the key for twelve hours.

    If the service needs no key, there is no sign-in and no cookie.
    """
    authenticator: Authenticator = request.app.state.authenticator
    if not await authenticator.asks():
        return _session(Identity(LOCAL), key_needed=False)
    key = given.key.get_secret_value().encode()
    principal = await authenticator.sign_in(key, request.client.host if request.client else "", CHALLENGE)
    if principal.role == "agent":
        raise role_refused("agent", "it opens no pages: signing in needs 'read', 'submit' or 'admin'")
    token = await anyio.to_thread.run_sync(authenticator.sessions.open, key, principal)
    response.set_cookie(
        SESSION_COOKIE,
        token,
        max_age=int(SESSION_SECONDS),
        path="/",
        secure=request.url.scheme == "https",
        httponly=True,
        samesite="strict",
    )
    until = datetime.now(UTC) + timedelta(seconds=SESSION_SECONDS)
    return Session(owner=principal.owner, role=principal.role, key_needed=True, signed_in=True, expires_at=until)


@router.get("", responses=problems_of())
async def who_asks(request: Request) -> Session:
    """Show the owner and role of the key or session of a request."""
    authenticator: Authenticator = request.app.state.authenticator
    return _session(request.state.identity, key_needed=authenticator.needed)


@router.delete("", status_code=204, responses=problems_of())
async def sign_out(request: Request) -> Response:
    """End the session; nothing happens when there is none."""
    token = given_token(Headers(scope=request.scope))
    if token is not None:
        authenticator: Authenticator = request.app.state.authenticator
        await anyio.to_thread.run_sync(authenticator.sessions.close, token)
    response = Response(status_code=204)
    response.delete_cookie(
        SESSION_COOKIE, path="/", secure=request.url.scheme == "https", httponly=True, samesite="strict"
    )
    return response


def _session(identity: Identity, *, key_needed: bool) -> Session:
    principal, session = identity.principal, identity.session
    return Session(
        owner=principal.owner,
        role=principal.role,
        key_needed=key_needed,
        signed_in=session is not None,
        expires_at=None if session is None else session.expires_at,
    )
