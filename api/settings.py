"""What the operator of the HTTP service can choose."""

from __future__ import annotations

import ipaddress
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, SecretStr, field_validator

from geoswarm.api.errors import ApiSettingsError
from geoswarm.api.schemas.agents import LONGEST_WAIT
from geoswarm.environment import listed, read_settings
from geoswarm.workers.agents.handed_out import read_list
from geoswarm.workers.errors import ModelsUnavailableError

__all__ = ["API_PREFIX", "ApiSettings", "LOOPBACK_HOSTS"]

LOOPBACK_HOSTS: frozenset[str] = frozenset({"localhost", "127.0.0.1", "[::1]"})
"""Host names under which the service answers when no API key protects it."""

VARIABLES: dict[str, str] = {
    "api_key": "GEOSWARM_API_KEY",
    "allowed_hosts": "GEOSWARM_ALLOWED_HOSTS",
    "trusted_proxies": "GEOSWARM_TRUSTED_PROXIES",
    "max_body_bytes": "GEOSWARM_MAX_BODY_BYTES",
    "body_bytes_per_key": "GEOSWARM_BODY_BYTES_PER_KEY",
    "body_bytes": "GEOSWARM_BODY_BYTES",
    "max_connections": "GEOSWARM_MAX_CONNECTIONS",
    "event_streams_per_key": "GEOSWARM_EVENT_STREAMS_PER_KEY",
    "event_streams": "GEOSWARM_EVENT_STREAMS",
    "requests_at_once": "GEOSWARM_REQUESTS_AT_ONCE",
    "requests_per_second": "GEOSWARM_REQUESTS_PER_SECOND",
    "request_burst": "GEOSWARM_REQUEST_BURST",
    "agent_requests_per_second": "GEOSWARM_AGENT_REQUESTS_PER_SECOND",
    "agent_wait_seconds": "GEOSWARM_AGENT_WAIT_SECONDS",
    "signed_models": "GEOSWARM_SIGNED_MODELS",
    "compute_processes": "GEOSWARM_COMPUTE_PROCESSES",
    "compute_seconds": "GEOSWARM_COMPUTE_SECONDS",
    "compute_memory_mb": "GEOSWARM_COMPUTE_MEMORY_MB",
}


API_PREFIX = "/api/v1"


def _in_small_letters(value: Any) -> Any:
    return listed(value.lower()) if isinstance(value, str) else value


class ApiSettings(BaseModel):
    """Settings of the HTTP service.

    Attributes
    ----------
    api_key
        An administrator's key that is not in the database, to begin with; every route except ``/health`` and
        ``/openapi.json`` then asks for a key.
    require_key
        Ask for a key also when only the database has some.
    allowed_hosts
        Further names in the ``Host`` header to answer to (without port) when no API key is set; loopback names are
        always allowed. This keeps a web page in the user's browser from reaching the service by DNS rebinding.
    trusted_proxies
        Addresses and networks of proxies in front, whose X-Forwarded-For and X-Forwarded-Proto are believed.
    max_body_bytes
        Largest request body that is read, of those that carry a problem or measurements.
    body_bytes_per_key, body_bytes
        What the bodies of unanswered requests of one key, and of all of them, may add up to; one body always fits.
    head_seconds
        Time in which the head of a request must have arrived [s].
    body_seconds
        Time in which a request body must have arrived [s].
    max_connections
        Open connections of this process, fewer where the system allows fewer open files.
    event_streams_per_key, event_streams
        Open event streams of one key and in all, of this process; at most half of the connections.
    requests_at_once
        Unanswered requests of one key, event streams among them.
    requests_per_second, request_burst
        What one API key may ask for in the long run [1/s] (0: anything) and at once, in each process of the service.
    agent_requests_per_second
        The same [1/s] for a key of agents, which all agents of a group may share; twice as many at once.
    agent_wait_seconds
        How long agents are asked to wait for work in one request [s]; less than proxies in between wait for an answer.
    signed_models
        File with the signed list of the registered models that agents may fetch; None: they are given none.
    compute_processes
        Processes for requests that calculate: test runs, statistics, reports, problems that are read; 0: none, these
        requests are worked on in the process of the service.
    compute_seconds, compute_memory_mb
        Time [s] and memory [MiB] that one such request may take.
    compute_wait_seconds
        Time that one may wait for its turn [s].
    heartbeat_seconds
        An event stream whose key or session is no longer valid ends within this time; a silent one sends comments
        more often than this, so that proxies and clients know it is alive.
    poll_seconds
        Interval at which the watched jobs are looked at for new events [s], with one query, however many watch.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    api_key: SecretStr | None = None
    require_key: bool = False
    allowed_hosts: Annotated[frozenset[str], BeforeValidator(_in_small_letters)] = frozenset()
    trusted_proxies: Annotated[tuple[str, ...], BeforeValidator(_in_small_letters)] = ()
    max_body_bytes: int = Field(default=32 * 2**20, ge=1_000)
    body_bytes_per_key: int = Field(default=64 * 2**20, ge=1_000)
    body_bytes: int = Field(default=256 * 2**20, ge=1_000)
    head_seconds: float = Field(default=10.0, gt=0.0)
    body_seconds: float = Field(default=30.0, gt=0.0)
    max_connections: int = Field(default=1000, ge=16)
    event_streams_per_key: int = Field(default=250, ge=1)
    event_streams: int = Field(default=500, ge=1)
    requests_at_once: int = Field(default=300, ge=1)
    requests_per_second: float = Field(default=50.0, ge=0.0, allow_inf_nan=False)
    request_burst: int = Field(default=500, ge=1)
    agent_requests_per_second: float = Field(default=1000.0, ge=0.0, allow_inf_nan=False)
    agent_wait_seconds: float = Field(default=50.0, ge=5.0, le=LONGEST_WAIT)
    signed_models: Path | None = None
    compute_processes: int = Field(default=3, ge=0, le=64)
    compute_seconds: float = Field(default=120.0, gt=0.0)
    compute_memory_mb: float = Field(default=2048.0, ge=256.0)
    compute_wait_seconds: float = Field(default=30.0, gt=0.0)
    heartbeat_seconds: float = Field(default=10.0, gt=0.0, le=20.0)
    poll_seconds: float = Field(default=0.1, gt=0.0, le=10.0)

    @field_validator("api_key")
    @classmethod
    def _key_is_usable(cls, key: SecretStr | None) -> SecretStr | None:
        if key is not None:
            text = key.get_secret_value()
            if len(text) < 8 or not text.isascii() or not text.isprintable() or " " in text:
                raise ValueError("needs at least 8 printable ASCII characters without spaces")
        return key

    @field_validator("signed_models")
    @classmethod
    def _list_can_be_read(cls, file: Path | None) -> Path | None:
        if file is not None:
            try:
                read_list(file)
            except ModelsUnavailableError as error:
                raise ValueError(f"{error}; name a file that 'geoswarm models sign' has made") from None
        return file

    @field_validator("trusted_proxies")
    @classmethod
    def _proxies_are_addresses(cls, proxies: tuple[str, ...]) -> tuple[str, ...]:
        for proxy in proxies:
            try:
                ipaddress.ip_network(proxy)
            except ValueError:
                accepted = "192.0.2.7, 10.0.0.0/8, 2001:db8::/32"
                raise ValueError(
                    f"must hold addresses: {proxy!r} is not an address or network; accepted: {accepted}"
                ) from None
        return proxies

    @property
    def needs_key(self) -> bool:
        """Whether requests are asked for an API key."""
        return self.require_key or self.api_key is not None

    @classmethod
    def from_environment(cls, **overrides: Any) -> ApiSettings:
        """Read the environment variables of :data:`VARIABLES`; hosts and proxies have commas between them.

        The key may also stand in the file that GEOSWARM_API_KEY_FILE names.

        ``overrides`` that are not None win over the environment.

        Raises
        ------
        ApiSettingsError
            Naming the variable, its value unless it is secret, and what it accepts.
        """
        return read_settings(cls, VARIABLES, overrides, ApiSettingsError)
