"""A verification case: what is verified, against what, how far apart both may be and why, and what it draws.

A case is a function that calculates, with its declaration before it::

    @case(
        "relaxation",
        "Isotropic relaxation",
        shows="Creep at constant strain relieves the stress.",
        given="λ* = 0.1, κ* = 0.02, μ* = 0.005",
        source="Vermeer & Neher (1999), integrated at constant strain",
        reference="p = p₀ (1 + λ* t/(κ* τ))^(−μ*/λ*)",
        allowed="time integration errors, bounded by the tolerance of the driver",
    )
    def relaxation() -> Answer: ...

The reference is computed by the case itself, from a closed form or by an independent integration, or it is a number
that was published by others; it is never a number that this package printed before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray

__all__ = ["Answer", "Case", "Check", "Curve", "Plot", "case", "check"]


@dataclass(frozen=True, slots=True)
class Check:
    """One quantity, calculated and referred to.

    Parameters
    ----------
    quantity, unit
        In words, and the unit of both values; a pure number has an empty one.
    ours, reference
        Shape (n,) each.
    allowed
        Largest admitted difference over ``scale``.
    scale
        What a difference is divided by, in the unit; None: the reference at that place.
    of
        What the scale is, in words; empty for a relative difference, ``absolute`` where the scale is 1.
    """

    quantity: str
    unit: str
    ours: FloatArray
    reference: FloatArray
    allowed: float
    scale: float | None
    of: str

    @property
    def differences(self) -> FloatArray:
        """Differences over the scale, shape (n,)."""
        apart: FloatArray = np.abs(self.ours - self.reference)
        divisor = np.abs(self.reference) if self.scale is None else np.full(apart.shape, self.scale)
        found: FloatArray = np.divide(apart, divisor, out=np.where(apart > 0.0, np.inf, 0.0), where=divisor > 0.0)
        return found

    @property
    def worst(self) -> int:
        """Where the difference is largest; a value that is not finite is."""
        return int(np.argmax(np.nan_to_num(self.differences, nan=np.inf)))

    @property
    def difference(self) -> float:
        """The largest difference over the scale."""
        return float(self.differences[self.worst])

    @property
    def holds(self) -> bool:
        """Whether no difference is larger than what is allowed."""
        return bool(self.difference <= self.allowed)


def check(
    quantity: str,
    unit: str,
    ours: npt.ArrayLike,
    reference: npt.ArrayLike,
    allowed: float,
    *,
    scale: float | None = None,
    of: str = "",
) -> Check:
    """Return a check of one value or of several, whose reference may be one for all; see :class:`Check`.

    Raises
    ------
    ValueError
        A scale without words for it, no value, or values that do not fit together.
    """
    if (scale is None) != (not of):
        raise ValueError(f"{quantity}: a scale and what it is come together, got {scale!r} and {of!r}")
    found = np.atleast_1d(np.asarray(ours, dtype=np.float64)).ravel()
    expected = np.asarray(reference, dtype=np.float64)
    expected = np.broadcast_to(expected.ravel() if expected.size == found.size else expected, found.shape)
    if not found.size:
        raise ValueError(f"{quantity}: at least one value is needed")
    return Check(quantity, unit, found, expected, allowed, scale, of)


@dataclass(frozen=True, slots=True)
class Curve:
    """Ours as a line, the reference as markers; each may be left out.

    ``label`` distinguishes it from the other curves of its plot; shapes (n,) and (m,).
    """

    label: str
    x: FloatArray
    y: FloatArray
    reference_x: FloatArray = field(default_factory=lambda: np.empty(0))
    reference_y: FloatArray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True)
class Plot:
    """A diagram: labels of its axes with their units, and its curves.

    ``downwards`` turns the axis of y, as for settlements and depths; ``dots`` draws ours as dots over whole numbers,
    where a line between them would have no meaning.
    """

    x: str
    y: str
    curves: tuple[Curve, ...]
    log_x: bool = False
    log_y: bool = False
    downwards: bool = False
    dots: bool = False
    caption: str = ""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a case has calculated."""

    checks: tuple[Check, ...]
    plot: Plot


@dataclass(frozen=True, slots=True)
class Case:
    """A declared case.

    Parameters
    ----------
    name
        For the command line and for files: small letters and hyphens.
    title
        What it is.
    shows
        What is verified, a sentence or two.
    given
        Parameters and sizes, so that a reader can repeat it.
    source
        Paper or book, with equation or table where it has one.
    reference
        The closed form, the rate equations in words, or which numbers were published.
    allowed
        Where the admitted difference comes from.
    calculate
        Does it.
    needs
        Modules of an extra without which it is left out.
    """

    name: str
    title: str
    shows: str
    given: str
    source: str
    reference: str
    allowed: str
    calculate: Callable[[], Answer]
    needs: tuple[str, ...] = ()


def case(
    name: str,
    title: str,
    *,
    shows: str,
    given: str,
    source: str,
    reference: str,
    allowed: str,
    needs: tuple[str, ...] = (),
) -> Callable[[Callable[[], Answer]], Case]:
    """Declare the case that a function calculates."""
    return lambda calculate: Case(name, title, shows, given, source, reference, allowed, calculate, needs)
