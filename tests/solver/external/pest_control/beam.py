"""The control file of cases/beam as it should be read, and what its program calculates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from geoswarm.solver.external.pest_control.case import PestCase, PestObservation, PestPair, PestParameter

__all__ = ["BEAM", "FOLDER", "case", "phi"]

FOLDER = Path(__file__).parent / "cases" / "beam"

BEAM = PestCase(
    FOLDER / "beam.pst",
    (
        PestParameter("e-1", "log", 2e4, 1e3, 1e6, "stiffness"),
        PestParameter("e-2", "tied", 1e4, 1e3, 1e6, "stiffness", tied_to="e-1"),
        PestParameter("load", "none", 1.5, 0.5, 5.0, "loads", 10.0, -5.0),
        PestParameter("load2", "tied", 3.0, 0.5, 9.0, "loads", 10.0, 1.0, "load"),
        PestParameter("span", "fixed", 4.0, 1.0, 10.0, "rest", 2.0, 0.5),
        PestParameter("pi", "none", 0.2, 0.0, 1.0, "rest"),
    ),
    (
        PestObservation("w_1.0", 1.7, 10.0, "defl"),
        PestObservation("w_2.0", 3.1, 5.0, "defl"),
        PestObservation("w_3.5", 5.6, 0.0, "defl"),
        PestObservation("w_3.0", 4.6, 2.0, "defl"),
        PestObservation("north", 11.5, 0.5, "force"),
        PestObservation("south", 32.5, 2.0, "force"),
        PestObservation("spare1", 0.0, 0.0, "spare"),
        PestObservation("spare2", 0.0, 0.0, "spare"),
        PestObservation("w_out", 8.0, 1.0, "defl"),
        PestObservation("r1", 0.25, 3.0, "regul_x"),
    ),
    (PestPair("beam.tpl", "in/beam.dat"), PestPair("span.tpl", "span.dat")),
    (PestPair("defl.ins", "defl.out"), PestPair("forces.ins", "forces.out")),
    ("python3 beam_model --span span.dat",),
    ("PESTMODE estimation is ignored: the problem is an estimation by the method that it names",),
)


def case(**changes: object) -> PestCase:
    """The case with changes."""
    return replace(BEAM, **changes)  # type: ignore[arg-type]


def phi(values: Mapping[str, float]) -> float:
    """PEST's objective, by hand: ``values`` are PEST's, before SCALE and OFFSET."""
    e1, load, pi = values["e-1"], values["load"], values["pi"]
    e2, load2 = e1 * 1e4 / 2e4, load * 3.0 / 1.5
    given = 10.0 * load - 5.0, 10.0 * load2 + 1.0
    factor = sum(given) / (e1 + e2) * 1000.0
    found = {f"w_{x}": factor * x + pi for x in (1.0, 2.0, 3.0, 3.5)}
    found |= {"north": given[0], "south": given[1], "spare1": 1.0, "spare2": 2.0, "w_out": 8.5, "r1": pi}
    return sum((one.weight * (found[one.name] - one.value)) ** 2 for one in BEAM.observations)
