"""Identity of a worker process, and how others on the same machine see at once that it has died."""

from __future__ import annotations

import hashlib
import os
import secrets
import socket
from dataclasses import dataclass
from functools import cache
from pathlib import Path

__all__ = ["Identity", "is_dead", "this_machine"]


@dataclass(frozen=True, slots=True)
class Identity:
    """A worker process; ``machine`` says where its pid means something, empty: nowhere but in itself."""

    id: str
    host: str
    pid: int
    machine: str
    engine: str

    @classmethod
    def new(cls, engine: str, pid: int | None = None) -> Identity:
        """Identify this process, or its child ``pid``."""
        host = socket.gethostname()
        number = os.getpid() if pid is None else pid
        return cls(f"{host[:50]}-{number}-{secrets.token_hex(4)}", host, number, this_machine(), engine)


@cache
def this_machine() -> str:
    """Return a mark of this boot and pid namespace; empty where the system does not tell (not Linux).

    The host's name is not enough: two containers may share it, and each would take the other's processes for dead.
    """
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        namespace = Path("/proc/self/ns/pid").readlink()
    except OSError:
        return ""
    return hashlib.sha256(f"{boot} {namespace}".encode()).hexdigest()[:16]


def is_dead(pid: int, machine: str) -> bool:
    """Whether the process is known not to exist; False when that cannot be told from here."""
    if not machine or machine != this_machine():
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        return False
    return False
