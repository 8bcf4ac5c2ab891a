# Generated from geoswarm/client/_async/service.py by scripts/generate_client.py; `make format` renews it.
"""The service itself: forward models, workers, health, links and hooks, keys and operations for administrators."""

from __future__ import annotations

import json
from collections.abc import Sequence
from urllib.parse import quote

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import API, JSON_BODY, Call, job_path, nothing, present, reader
from geoswarm.records.account import Hook, Key, NewHook, NewKey, NewLink, Role
from geoswarm.records.problem import ForwardModelDetail, ForwardModelSummary
from geoswarm.records.service import Health, Operations, Session, Worker
from geoswarm.records.states import ENDED_STATES, EndedState

__all__ = [
    "create_hook",
    "create_key",
    "create_link",
    "delete_hook",
    "forward_model",
    "forward_models",
    "health",
    "hooks",
    "keys",
    "links",
    "operations",
    "revoke_key",
    "revoke_link",
    "session",
    "test_hook",
    "workers",
]


def forward_models(self: Connection) -> tuple[ForwardModelSummary, ...]:
    """List the kinds of forward model that the service has.

    Examples
    --------
    >>> kinds = [model.kind for model in client.forward_models()]
    >>> "oedometer" in kinds
    True
    """
    return self._send(Call("GET", f"{API}/forward-models", reader(tuple[ForwardModelSummary, ...], "items")))


def forward_model(self: Connection, kind: str) -> ForwardModelDetail:
    """Show a kind of forward model: schema, parameters, series, units.

    Examples
    --------
    >>> model = client.forward_model("formula")
    >>> model.kind
    'formula'
    """
    return self._send(Call("GET", f"{API}/forward-models/{quote(kind, safe='')}", reader(ForwardModelDetail)))


def workers(self: Connection) -> tuple[Worker, ...]:
    """List the workers.

    Examples
    --------
    >>> workers = client.workers()
    >>> len(workers)
    1
    """
    return self._send(Call("GET", f"{API}/workers", reader(tuple[Worker, ...], "items")))


def health(self: Connection) -> Health:
    """Show whether the service can work.

    Examples
    --------
    >>> health = client.health()
    >>> health.status
    'ok'
    """
    unavailable = frozenset({503})  # is an answer, not an error
    return self._send(Call("GET", "/health/ready", reader(Health), accepted=unavailable))


def session(self: Connection) -> Session:
    """Show whose key this client uses, and what it may do.

    Examples
    --------
    >>> session = client.session()
    >>> session.role
    'admin'
    """
    return self._send(Call("GET", f"{API}/session", reader(Session)))


def operations(self: Connection) -> Operations:
    """Show waiting and running work and the outcomes of forward runs; administrators only.

    Examples
    --------
    >>> operations = client.operations()
    >>> operations.jobs["finished"] > 0
    True
    """
    return self._send(Call("GET", f"{API}/operations", reader(Operations)))


def keys(self: Connection) -> tuple[Key, ...]:
    """List all API keys without their secrets; administrators only.

    Examples
    --------
    >>> created = client.create_key("carla")
    >>> [key.role for key in client.keys() if key.owner == "carla"]
    ['submit']
    """
    return self._send(Call("GET", f"{API}/keys", reader(tuple[Key, ...], "items")))


def create_key(
    self: Connection, owner: str, role: Role = "submit", *, label: str = "", valid_seconds: float | None = None
) -> NewKey:
    """Create an API key; the answer is the only place where its secret can be read. Administrators only.

    Parameters
    ----------
    owner
        Whose jobs it opens; several keys may have one owner.
    label
        What it is for.
    valid_seconds
        Time until it expires [s]; None: never.

    Examples
    --------
    >>> created = client.create_key("anna", "read", label="laptop", valid_seconds=90 * 86400)
    >>> created.view.role, created.key[:4]
    ('read', 'gsw_')
    """
    content = json.dumps(present(owner=owner, role=role, label=label, valid_seconds=valid_seconds))
    return self._send(Call("POST", f"{API}/keys", reader(NewKey), headers=JSON_BODY, content=content))


def revoke_key(self: Connection, key_id: str) -> Key:
    """Revoke an API key, from the next request and permanently; administrators only.

    Examples
    --------
    >>> created = client.create_key("ben")
    >>> revoked = client.revoke_key(created.view.id)
    >>> revoked.state
    'revoked'
    """
    if not key_id:
        raise ValueError("key_id is empty; give the id of a key, the part of 12 digits between its underscores")
    return self._send(Call("POST", f"{API}/keys/{quote(key_id, safe='')}/revoke", reader(Key)))


def links(self: Connection, job_id: str) -> tuple[Key, ...]:
    """List the read-only links to a job, without their secrets, oldest first.

    Examples
    --------
    >>> created = client.create_link(job.id, label="reviewer")
    >>> "reviewer" in [link.label for link in client.links(job.id)]
    True
    """
    return self._send(Call("GET", f"{job_path(job_id)}/links", reader(tuple[Key, ...], "items")))


def create_link(self: Connection, job_id: str, *, label: str = "", valid_days: float = 14) -> NewLink:
    """Create a link that shows one job to people without a key; the answer is the only place where it can be read.

    Parameters
    ----------
    label
        Whom it is for.
    valid_days
        Time until it expires [day].

    Examples
    --------
    >>> created = client.create_link(job.id, valid_days=30)
    >>> created.path.startswith(f"/sign-in?next=/jobs/{job.id}#gsw_")
    True
    """
    content = json.dumps({"label": label, "valid_days": valid_days})
    call = Call("POST", f"{job_path(job_id)}/links", reader(NewLink), headers=JSON_BODY, content=content)
    return self._send(call)


def revoke_link(self: Connection, job_id: str, link_id: str) -> Key:
    """Revoke a read-only link, from the next request and permanently.

    Examples
    --------
    >>> created = client.create_link(job.id)
    >>> revoked = client.revoke_link(job.id, created.view.id)
    >>> revoked.state
    'revoked'
    """
    if not link_id:
        raise ValueError("link_id is empty; give the id of a link")
    return self._send(Call("POST", f"{job_path(job_id)}/links/{quote(link_id, safe='')}/revoke", reader(Key)))


def hooks(self: Connection) -> tuple[Hook, ...]:
    """List the hooks, which are notified when jobs end, and the state of the last message of each.

    Examples
    --------
    >>> hooks = client.hooks()
    >>> len(hooks) >= 0
    True
    """
    return self._send(Call("GET", f"{API}/hooks", reader(tuple[Hook, ...], "items")))


def create_hook(
    self: Connection, target: str, *, job: str | None = None, states: Sequence[EndedState] = ENDED_STATES
) -> NewHook:
    """Notify an address when jobs end; the answer is the only place where its secret can be read.

    Parameters
    ----------
    target
        ``https://...``, or an e-mail address if the service sends e-mail.
    job
        The only job to report, immediately if it has ended; None for all jobs of the key's owner.
    states
        Report only jobs that ended in one of these states.

    Examples
    --------
    >>> created = client.create_hook("https://hooks.invalid/ended", states=["failed"])
    >>> created.view.kind, created.view.states
    ('web', ['failed'])
    >>> client.delete_hook(created.view.id)
    """
    content = json.dumps(present(target=target, job=job, states=list(states)))
    return self._send(Call("POST", f"{API}/hooks", reader(NewHook), headers=JSON_BODY, content=content))


def test_hook(self: Connection, hook_id: str) -> Hook:
    """Send a test message to a hook; the list shows whether it arrived.

    Examples
    --------
    >>> created = client.create_hook("https://hooks.invalid/ended", states=["failed"])
    >>> tested = client.test_hook(created.view.id)
    >>> tested.id == created.view.id
    True
    >>> client.delete_hook(created.view.id)
    """
    return self._send(Call("POST", f"{_hook_path(hook_id)}/test", reader(Hook)))


def delete_hook(self: Connection, hook_id: str) -> None:
    """Remove a hook; messages not sent yet are dropped.

    Examples
    --------
    >>> created = client.create_hook("https://hooks.invalid/ended", states=["failed"])
    >>> client.delete_hook(created.view.id)
    >>> created.view.id in [hook.id for hook in client.hooks()]
    False
    """
    self._send(Call("DELETE", _hook_path(hook_id), nothing))


def _hook_path(hook_id: str) -> str:
    if not hook_id:
        raise ValueError("hook_id is empty; give the id of a hook")
    return f"{API}/hooks/{quote(hook_id, safe='')}"
