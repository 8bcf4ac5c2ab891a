"""Who asks, and what they may: roles of API keys, and whose jobs they see."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

__all__ = ["LOCAL", "ROLES", "Principal", "Role"]

Role: TypeAlias = Literal["read", "submit", "admin"]

ROLES: tuple[Role, ...] = get_args(Role)
"""Each may what the ones before it may: look at one's own jobs; also submit and steer them; everything, for all."""


@dataclass(frozen=True, slots=True)
class Principal:
    """Who asks.

    Parameters
    ----------
    owner
        Whose jobs these are; None: nobody's, as submitted without a key.
    role
        read, submit or admin.
    key_id
        Public part of the API key, None without one.
    """

    owner: str | None
    role: Role
    key_id: str | None = None

    def may(self, role: Role) -> bool:
        """Whether the role includes another one."""
        return ROLES.index(self.role) >= ROLES.index(role)

    def sees(self, owner: str | None) -> bool:
        """Whether the jobs of an owner are visible."""
        return self.role == "admin" or (owner is not None and owner == self.owner)


LOCAL = Principal(None, "admin")
"""The user of this machine, who can read the database file anyway, and the program itself."""
