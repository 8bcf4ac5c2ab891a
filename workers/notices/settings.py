"""What the operator allows and gives for telling of jobs that have ended."""

from __future__ import annotations

import ipaddress
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    SecretStr,
    field_validator,
    model_validator,
)

from geoswarm.environment import listed, read_settings
from geoswarm.workers.errors import SettingsError
from geoswarm.workers.secrets import is_loopback

__all__ = ["VARIABLES", "Network", "NoticeSettings"]

Network: TypeAlias = ipaddress.IPv4Network | ipaddress.IPv6Network

VARIABLES = {
    "public_url": "GEOSWARM_PUBLIC_URL",
    "hooks_per_owner": "GEOSWARM_HOOKS_PER_OWNER",
    "hook_networks": "GEOSWARM_HOOK_NETWORKS",
    "hook_seconds": "GEOSWARM_HOOK_SECONDS",
    "smtp_host": "GEOSWARM_SMTP_HOST",
    "smtp_port": "GEOSWARM_SMTP_PORT",
    "smtp_security": "GEOSWARM_SMTP_SECURITY",
    "smtp_user": "GEOSWARM_SMTP_USER",
    "smtp_password": "GEOSWARM_SMTP_PASSWORD",
    "mail_from": "GEOSWARM_MAIL_FROM",
    "mail_domains": "GEOSWARM_MAIL_DOMAINS",
}
"""The variable of each setting."""

PORTS = {"starttls": 587, "tls": 465, "none": 25}


def _small(value: Any) -> Any:
    return listed(value.lower()) if isinstance(value, str) else value


class NoticeSettings(BaseModel):
    """How the end of jobs is announced.

    Attributes
    ----------
    public_url
        Address of the dashboard as readers of messages reach it; None: messages hold no link.
    hooks_per_owner
        Hooks that one owner may have.
    hook_networks
        Networks with private addresses that requests may go to all the same, also without TLS.
    hook_seconds
        Time that one try may take [s].
    smtp_host
        Server that takes e-mail; None: no e-mail is sent.
    smtp_port
        By default that of ``smtp_security``: 587, 465 or 25.
    smtp_security
        ``starttls``, ``tls`` from the first byte, or ``none``.
    smtp_user, smtp_password
        Needed only where the server asks for them.
    mail_from
        Sender.
    mail_domains
        Domains that e-mail may go to, ``*``: any; by default that of the sender.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", hide_input_in_errors=True)

    public_url: str | None = None
    hooks_per_owner: int = Field(20, ge=0)
    hook_networks: Annotated[tuple[str, ...], BeforeValidator(_small)] = ()
    hook_seconds: float = Field(10.0, gt=0, le=120)
    smtp_host: str | None = None
    smtp_port: int | None = Field(None, ge=1, le=65535)
    smtp_security: Literal["starttls", "tls", "none"] = "starttls"
    smtp_user: str | None = None
    smtp_password: SecretStr | None = None
    mail_from: str | None = None
    mail_domains: Annotated[tuple[str, ...], BeforeValidator(_small)] = ()

    @field_validator("public_url")
    @classmethod
    def _is_an_address(cls, value: str | None) -> str | None:
        if value is not None and not value.startswith(("http://", "https://")):
            raise ValueError(f"must be the address of the dashboard, as in https://geoswarm.example.org; got {value!r}")
        return None if value is None else value.rstrip("/")

    @field_validator("hook_networks")
    @classmethod
    def _are_networks(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for text in value:
            try:
                ipaddress.ip_network(text)
            except ValueError:
                raise ValueError(
                    f"must hold networks: {text!r} is not one; accepted: 10.1.0.0/16, 192.168.7.20/32, fd00::/8"
                ) from None
        return value

    @model_validator(mode="after")
    def _mail_is_complete(self) -> NoticeSettings:
        if self.smtp_host is None:
            return self
        if self.mail_from is None or "@" not in self.mail_from:
            raise ValueError(
                f"GEOSWARM_MAIL_FROM must be the sender's address, as in geoswarm@example.org, where"
                f" GEOSWARM_SMTP_HOST is set; got {self.mail_from!r}"
            )
        if (self.smtp_user is None) != (self.smtp_password is None):
            raise ValueError("GEOSWARM_SMTP_USER and GEOSWARM_SMTP_PASSWORD (or its file) must be given together")
        if self.smtp_user is not None and self.smtp_security == "none" and not is_loopback(self.smtp_host):
            raise ValueError(
                "GEOSWARM_SMTP_SECURITY must be starttls or tls where a password goes to another machine; got none"
            )
        return self

    @property
    def networks(self) -> tuple[Network, ...]:
        """Private networks that requests may go to."""
        return tuple(ipaddress.ip_network(text) for text in self.hook_networks)

    @property
    def port(self) -> int:
        """Port of the server for e-mail."""
        return self.smtp_port or PORTS[self.smtp_security]

    def takes_mail_to(self, domain: str) -> bool:
        """Whether e-mail may go to a domain."""
        if self.mail_from is None:
            return False
        domains = self.mail_domains or (self.mail_from.rpartition("@")[2].lower(),)
        return "*" in domains or domain.lower() in domains

    @classmethod
    def from_environment(cls, **overrides: Any) -> NoticeSettings:
        """Read the variables of :data:`VARIABLES`; overrides that are not None win.

        Raises
        ------
        SettingsError
            Names the setting, its value unless it is secret, and what would be accepted.
        """
        return read_settings(cls, VARIABLES, overrides, SettingsError)
