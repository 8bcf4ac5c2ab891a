"""What laboratory tests measure, from the states of a material point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.laboratory.record import Voids
from geoswarm.solver.laws.base import Law

__all__ = ["MEAN_PRESSURE", "Quantity", "Seen", "pore_pressure", "state_variables", "void_ratio"]


@dataclass(frozen=True)
class Seen:
    """States of a specimen as they are looked at.

    Parameters
    ----------
    rows
        States (m, w): stress, strain and state variables.
    reference
        State from which strains count, a row (w,).
    pore
        Pore pressure, kPa, (m,).
    components
        n, of stress and strain.
    voids
        Void ratio from the strain since the beginning of the test.
    """

    rows: FloatArray
    reference: FloatArray
    pore: FloatArray
    components: int
    voids: Voids

    @property
    def stress(self) -> FloatArray:
        """(m, n), kPa."""
        return self.rows[:, : self.components]

    @property
    def strain(self) -> FloatArray:
        """Strain inside since the reference, (m, n)."""
        n = self.components
        return self.rows[:, n : 2 * n] - self.reference[n : 2 * n]

    @property
    def axial(self) -> FloatArray:
        """Axial stress, (m,), kPa."""
        return self.rows[:, 1]

    @property
    def radial(self) -> FloatArray:
        """Mean of the radial stresses, (m,), kPa."""
        return 0.5 * (self.rows[:, 0] + self.rows[:, 2])

    def engineering(self, strain: FloatArray) -> FloatArray:
        """Engineering strain, (m,): decrease over the value at the reference."""
        return strain if self.voids.fixed else -np.expm1(-strain)


Look: TypeAlias = Callable[[Seen], FloatArray]


@dataclass(frozen=True)
class Quantity:
    """Something that a test measures: its name, description, what axes show, unit, and how it follows from states."""

    name: str
    description: str
    quantity: str
    unit: str
    of: Look


MEAN_PRESSURE = Quantity("p", "Mean effective stress", "p'", "kPa", lambda seen: seen.stress[:, :3].mean(axis=1))


def pore_pressure(description: str) -> Quantity:
    """The pore pressure, as a test understands it."""
    return Quantity("pore_pressure", description, "pore pressure", "kPa", lambda seen: seen.pore)


def _void_ratio(seen: Seen) -> FloatArray:
    n = seen.components
    return seen.voids.ratio(seen.rows[:, n : n + 3].sum(axis=1))


def void_ratio(law: Law, known: bool) -> tuple[Quantity, ...]:
    """The void ratio, where it is ``known`` and the law has no state variable of that name."""
    if not known or any(one.name == "void_ratio" for one in law.state):
        return ()
    return (Quantity("void_ratio", "Void ratio.", "void ratio", "", _void_ratio),)


def state_variables(law: Law, components: int) -> tuple[Quantity, ...]:
    """The state variables of a law."""

    def column(number: int) -> Look:
        return lambda seen: seen.rows[:, number]

    return tuple(
        Quantity(one.name, f"{one.description} State variable of the law.", one.symbol, one.unit, column(number))
        for number, one in enumerate(law.state, start=2 * components)
    )
