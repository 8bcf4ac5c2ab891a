"""Principals: roles of API keys, and whose jobs they see."""

from __future__ import annotations

from dataclasses import dataclass

from geoswarm.records.account import ROLES, Role

__all__ = ["LOCAL", "Principal"]


@dataclass(frozen=True, slots=True)
class Principal:
    """Sender of a request, and its permissions.

    Parameters
    ----------
    owner
        Whose jobs these are; None: nobody's, as submitted without a key.
    role
        agent, read, submit or admin.
    key_id
        Public part of the API key, None without one.
    job_id
        The only job that a read-only link shows; None: all that the role may see.
    """

    owner: str | None
    role: Role
    key_id: str | None = None
    job_id: str | None = None

    def may(self, role: Role) -> bool:
        """Whether the role includes another one; that of an agent includes none, and only an administrator's has it."""
        if "agent" in (self.role, role):
            return role == "agent" and self.role in ("agent", "admin")
        return ROLES.index(self.role) >= ROLES.index(role)

    @property
    def listed(self) -> str | None:
        """Whose jobs lists show: None stands for everybody's, the empty name for nobody's."""
        if self.role == "admin":
            return None
        return "" if self.job_id is not None else self.owner or ""

    def sees(self, owner: str | None, job_id: str | None = None) -> bool:
        """Whether a job of an owner, or something else that is an owner's, is visible."""
        if self.job_id is not None:
            return job_id == self.job_id
        return self.role == "admin" or (self.role != "agent" and owner is not None and owner == self.owner)


LOCAL = Principal(None, "admin")
"""The user of this machine, who can read the database file anyway, and the program itself."""
