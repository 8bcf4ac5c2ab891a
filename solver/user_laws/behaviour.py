"""What a library says of a behaviour of MFront: properties with their limits, state variables, hypotheses."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

from pydantic import Field

from geoswarm.solver.laws.libraries.mfront_bridge import MOST_STATE
from geoswarm.solver.section import Section

__all__ = ["Behaviour", "UnusableBehaviourError", "behaviour_in"]

_PROGRAM = Path(__file__).with_name("read_behaviour.py")
_SECONDS = 60.0


class UnusableBehaviourError(ValueError):
    """A library has no such behaviour, or none that can be a soil law; the message says why."""


class Behaviour(Section):
    """A behaviour as its library describes it."""

    interface: str
    version: str = Field(description="of TFEL, which made it")
    type: int = Field(description="1: small strain, 2: large strain, 3: cohesive zones, 0: general")
    symmetry: int = Field(description="0: isotropic")
    elastic_symmetry: int
    gradients: tuple[str, ...]
    forces: tuple[str, ...]
    blocks: tuple[str, ...] = Field(description="of the tangent, two names each")
    hypotheses: tuple[str, ...]
    properties: tuple[str, ...] = Field(description="material properties in their order")
    bounds: dict[str, tuple[float | None, float | None]] = Field(description="limits of each property")
    state: tuple[str, ...] = Field(description="internal state variables in their order")
    state_kinds: tuple[int, ...] = Field(description="0: a number, 1: a symmetric tensor")
    external: tuple[str, ...]
    external_kinds: tuple[int, ...]

    @property
    def fault(self) -> str | None:
        """Why it cannot be a soil law here, in words."""
        if self.interface != "Generic":
            return f"was made for the interface {self.interface or 'unknown'}; generic behaviours are accepted"
        if self.type != 1 or self.gradients != ("Strain",) or self.forces != ("Stress",) or len(self.blocks) > 2:
            return f"takes {', '.join(self.gradients)}; behaviours from small strain to stress are accepted"
        if self.symmetry != 0 or self.elastic_symmetry != 0:
            return "is orthotropic; isotropic behaviours are accepted, as axes of a material are not known here"
        if "Tridimensional" not in self.hypotheses and not self.plane:
            return "knows neither three dimensions nor plane strain"
        if any(self.external_kinds) or any(kind not in (0, 1) for kind in self.state_kinds):
            return "has state variables that are neither numbers nor symmetric tensors"
        if self.numbers > MOST_STATE:
            return f"has {self.numbers} numbers in its state; at most {MOST_STATE} are accepted"
        return None

    @property
    def plane(self) -> str | None:
        """The hypothesis for plane and axisymmetric bodies; isotropic behaviours do not tell these apart."""
        return next((one for one in ("PlaneStrain", "Axisymmetrical") if one in self.hypotheses), None)

    @property
    def numbers(self) -> int:
        """Numbers in its state, tensors with six."""
        return sum(6 if kind else 1 for kind in self.state_kinds)


@lru_cache(maxsize=64)
def behaviour_in(library: Path, version: str, name: str) -> Behaviour:
    """Read what a library says of a behaviour, in a process of its own.

    Parameters
    ----------
    version
        SHA-256 of the library: another one is read anew.

    Raises
    ------
    UnusableBehaviourError
        There is no such behaviour, or it cannot be a soil law.
    """
    del version
    call = [sys.executable, "-I", "-S", str(_PROGRAM), str(library), name]
    try:
        done = subprocess.run(call, capture_output=True, text=True, check=False, timeout=_SECONDS)
        found = json.loads(done.stdout)
    except (OSError, ValueError, subprocess.TimeoutExpired):
        raise UnusableBehaviourError(f"the library {library} cannot be read: opening it ends the process") from None
    if "error" in found:
        raise UnusableBehaviourError(f"the library {library}: {found['error']}")
    behaviour = Behaviour.model_validate_json(done.stdout)
    if behaviour.fault:
        raise UnusableBehaviourError(f"behaviour {name} {behaviour.fault}")
    return behaviour
