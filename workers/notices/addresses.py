"""Which addresses the service may send requests to that somebody else wants it to send.

Without a limit a user could have the service ask whatever only its own network can reach: the database, a cloud's
metadata, a router. So an address must be a public one, or one of a network that the operator names. It is resolved and
judged at every try, and that very address is connected to: a name that answers differently the second time gains
nothing.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Sequence
from typing import TypeAlias
from urllib.parse import SplitResult, urlsplit

from geoswarm.workers.errors import HookRefusedError
from geoswarm.workers.notices.settings import Network

__all__ = ["ForbiddenAddressError", "judge_url", "may_reach", "resolve"]

LONGEST_URL = 500
TRANSLATED = ipaddress.ip_network("64:ff9b::/96")  # IPv4 addresses behind a translator, RFC 6052
NEVER = tuple(
    map(
        ipaddress.ip_network,
        ("192.0.0.0/24", "192.88.99.0/24", "64:ff9b:1::/48", "2001::/32", "2002::/16", "fec0::/10"),
    )
)
"""Of special use, whatever a version of Python knows of them: protocols, relays, tunnels, sites."""

Address: TypeAlias = ipaddress.IPv4Address | ipaddress.IPv6Address


class ForbiddenAddressError(OSError):
    """A name stands for an address that requests may not go to."""


def judge_url(url: str, networks: Sequence[Network]) -> SplitResult:
    """Return the parts of an address for a hook, as far as they can be judged without asking anybody.

    Raises
    ------
    HookRefusedError
    """
    if len(url) > LONGEST_URL or not url.isascii() or not url.isprintable() or " " in url:
        raise HookRefusedError(
            "target", f"at most {LONGEST_URL} printable ASCII characters without spaces are accepted, as in https://..."
        )
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise HookRefusedError("target", f"{url!r} is not an address: {error}") from None
    accepted = ("https", "http") if networks else ("https",)
    if parts.scheme not in accepted or not host:
        raise HookRefusedError("target", f"must be an address like {accepted[0]}://example.org/hook, got {url!r}")
    if parts.username is not None or parts.password is not None:
        raise HookRefusedError("target", "must hold no user name or password: requests are signed")
    if port == 0:
        raise HookRefusedError("target", "port must be 1 to 65535, got 0")
    try:
        literal = ipaddress.ip_address(host)
    except ValueError:
        return parts  # a name: judged when it is resolved
    if not may_reach(literal, networks, encrypted=parts.scheme == "https"):
        raise HookRefusedError("target", f"{host} is not an address that this service may send requests to")
    return parts


def may_reach(address: Address, networks: Sequence[Network], *, encrypted: bool = True) -> bool:
    """Whether requests may go to an address: one of the networks, or a public one over TLS."""
    inner = _embedded(address)
    for candidate in (address, inner):
        if candidate is not None and any(candidate in network for network in networks):
            return True
    return encrypted and _public(address if inner is None else inner)


def resolve(host: str, port: int, networks: Sequence[Network], *, encrypted: bool = True) -> str:
    """Return the first address of a name, all of which must be allowed.

    Raises
    ------
    ForbiddenAddressError
        When one of them is not.
    OSError
        When the name is not known.
    """
    found = [str(entry[4][0]) for entry in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)]
    for text in found:
        if not may_reach(ipaddress.ip_address(text.partition("%")[0]), networks, encrypted=encrypted):
            raise ForbiddenAddressError(
                f"{host} is not an address that this service may send requests to"
                + ("" if encrypted else " without TLS")
            )
    return found[0]


def _public(address: Address) -> bool:
    special = address.is_multicast or address.is_reserved or address.is_unspecified
    return address.is_global and not special and not any(address in network for network in NEVER)


def _embedded(address: Address) -> Address | None:
    """The IPv4 address that an IPv6 address stands for, if it does."""
    if isinstance(address, ipaddress.IPv4Address):
        return None
    if address.ipv4_mapped is not None:
        return address.ipv4_mapped
    if address in TRANSLATED:
        return ipaddress.IPv4Address(int(address) & 0xFFFFFFFF)
    return None
