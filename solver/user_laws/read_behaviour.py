"""Reads what a library says of a behaviour of MFront: a program of its own, as opening a library executes parts of it.

``python -I -S read_behaviour.py LIBRARY BEHAVIOUR`` writes JSON: the fields of
:class:`geoswarm.solver.user_laws.behaviour.Behaviour`, or ``{"error": ...}``. Only Python's own library is used.
"""

from __future__ import annotations

import ctypes
import json
import sys
from typing import Any

_BOUNDS = {"lower": ("LowerPhysicalBound", "LowerBound"), "upper": ("UpperPhysicalBound", "UpperBound")}
_HYPOTHESES = ("Tridimensional", "PlaneStrain", "Axisymmetrical")


class _Library:
    def __init__(self, path: str, behaviour: str) -> None:
        self._library = ctypes.CDLL(path)
        self._name = behaviour

    def number(self, name: str, default: int | None = None) -> int | None:
        """An unsigned short."""
        try:
            return ctypes.c_ushort.in_dll(self._library, f"{self._name}_{name}").value
        except ValueError:
            return default

    def text(self, name: str) -> str:
        """A text, empty where there is none."""
        try:
            found = ctypes.c_char_p.in_dll(self._library, f"{self._name}_{name}").value
            return "" if found is None else found.decode()
        except ValueError:
            return ""

    def has(self, name: str) -> bool:
        """Whether there is a function."""
        return hasattr(self._library, f"{self._name}_{name}")

    def names(self, what: str, hypothesis: str) -> list[str]:
        """Names of variables, for a hypothesis if they differ there."""
        own = f"{hypothesis}_" if self.number(f"{hypothesis}_n{what}") is not None else ""
        count = self.number(f"{own}n{what}", 0) or 0
        if not count:
            return []
        found = (ctypes.c_char_p * count).in_dll(self._library, f"{self._name}_{own}{what}")
        return [one.decode() for one in found if one is not None]

    def kinds(self, what: str, hypothesis: str, count: int) -> list[int]:
        """Kinds of variables: 0 a number, 1 a symmetric tensor."""
        for own in (f"{hypothesis}_", ""):
            try:
                return list((ctypes.c_int * count).in_dll(self._library, f"{self._name}_{own}{what}Types"))
            except ValueError:
                continue
        return [0] * count

    def bound(self, variable: str, which: str) -> float | None:
        """A limit of a variable; None: there is none."""
        for name in _BOUNDS[which]:
            try:
                return float(ctypes.c_longdouble.in_dll(self._library, f"{self._name}_{variable}_{name}").value)
            except ValueError:
                continue
        return None


def described(path: str, behaviour: str) -> dict[str, Any]:
    """What a library says of a behaviour."""
    library = _Library(path, behaviour)
    if not library.text("mfront_ept"):
        return {"error": f"there is no behaviour '{behaviour}' in it"}
    hypothesis = "Tridimensional" if library.has("Tridimensional") else "PlaneStrain"
    properties = library.names("MaterialProperties", hypothesis)
    elastic: list[str] = []
    if library.number(f"{hypothesis}_requiresStiffnessTensor", library.number("requiresStiffnessTensor", 0)):
        elastic += ["YoungModulus", "PoissonRatio"]
    thermal = "requiresThermalExpansionCoefficientTensor"
    if library.number(f"{hypothesis}_{thermal}", library.number(thermal, 0)):
        elastic.append("ThermalExpansion")
    state = library.names("InternalStateVariables", hypothesis)
    external = library.names("ExternalStateVariables", hypothesis)
    external_kinds = library.kinds("ExternalStateVariables", hypothesis, len(external))
    if library.number("TemperatureRemovedFromExternalStateVariables", 1):
        external, external_kinds = ["Temperature", *external], [0, *external_kinds]
    return {
        "interface": library.text("mfront_interface"),
        "version": library.text("tfel_version"),
        "type": library.number("BehaviourType", -1),
        "symmetry": library.number("SymmetryType", -1),
        "elastic_symmetry": library.number("ElasticSymmetryType", 0),
        "gradients": library.names("Gradients", hypothesis),
        "forces": library.names("ThermodynamicForces", hypothesis),
        "blocks": library.names("TangentOperatorBlocks", hypothesis),
        "hypotheses": [one for one in _HYPOTHESES if library.has(one)],
        "properties": [*elastic, *properties],
        "bounds": {name: [library.bound(name, which) for which in _BOUNDS] for name in [*elastic, *properties]},
        "state": state,
        "state_kinds": library.kinds("InternalStateVariables", hypothesis, len(state)),
        "external": external,
        "external_kinds": external_kinds,
    }


if __name__ == "__main__":
    try:
        found = described(*sys.argv[1:3])
    except OSError as error:
        found = {"error": str(error)}
    sys.stdout.write(json.dumps(found))
