"""What a job needs from its workers: kinds of forward model, and registered models with the hash of their files."""

from __future__ import annotations

from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.registry import BUILT_IN
from geoswarm.solver.registered.spec import RegisteredSpec
from geoswarm.solver.warm import OTHER_LAWS, groups_of

__all__ = ["is_need", "needs_of", "registered_need"]

MOST_LETTERS = 100_000


def needs_of(spec: ForwardModelSpec) -> str:
    """Return what a forward model needs, one word each, in order: it runs where all of them are offered.

    A model or soil law of another package is what no agent offers: which version of it would have to be the same is
    not known.
    """
    needs: set[str] = {spec.kind} if spec.kind == "combined" else set()
    for part in spec.by_part().values():
        if isinstance(part, RegisteredSpec):
            needs.add(registered_need(part.model, part.version or ""))
        elif part.kind in BUILT_IN and not part.runs_programs:
            needs.add(part.kind)
        else:
            needs.add(f"foreign:{part.kind}")
        if OTHER_LAWS in groups_of(part):
            needs.add("foreign:law")
    return " ".join(sorted(needs))


def registered_need(model: str, version: str) -> str:
    """Return what a registered model is as a need."""
    return f"registered:{model}:{version}"


def is_need(text: str) -> bool:
    """Whether an agent may offer it."""
    return text in BUILT_IN or text.startswith("registered:")
