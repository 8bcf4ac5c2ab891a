"""Hooks: whom to tell when a job has ended."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Path
from fastapi.responses import Response

from geoswarm.api.dependencies import Service, problems_of
from geoswarm.api.schemas.administration import HookList, NewHookRequest
from geoswarm.records.account import Hook, NewHook
from geoswarm.workers.notices.hooks import Hooks

__all__ = ["router"]

router = APIRouter(prefix="/hooks", tags=["hooks"])


async def _hooks(service: Service) -> Hooks:
    """The hooks that the sender may see."""
    return Hooks(service.store, service.principal)


Own = Annotated[Hooks, Depends(_hooks)]
HookId = Annotated[str, Path(pattern=r"^[0-9a-f]{16}$", description="id that POST /hooks answered with")]


@router.get("", responses=problems_of())
def list_hooks(hooks: Own) -> HookList:
    """List your own hooks (administrators: all), with the state of the last message of each."""
    return HookList(items=hooks.list())


@router.post("", status_code=201, responses=problems_of(404, 408, 413, 422))
def create_hook(wanted: NewHookRequest, hooks: Own) -> NewHook:
    """Notify an address when jobs end; the answer is the only place where its secret can be read."""
    return hooks.create(wanted.target, job_id=wanted.job, states=wanted.states)


@router.post("/{hook_id}/test", status_code=202, responses=problems_of(404, 422))
def test_hook(hook_id: HookId, hooks: Own) -> Hook:
    """Send a test message to a hook; the list shows whether it arrived."""
    return hooks.test(hook_id)


@router.delete("/{hook_id}", status_code=204, responses=problems_of(404, 422))
def delete_hook(hook_id: HookId, hooks: Own) -> Response:
    """Remove a hook; messages not sent yet are dropped."""
    hooks.delete(hook_id)
    return Response(status_code=204)
