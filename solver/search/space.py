"""The space that a search moves in: bounds, search coordinates, feasibility, and the scatter of a generation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.errors import InfeasibleSpaceError

__all__ = ["SearchSpace", "diversity"]

_DRAWS = 10_000  # bounded search for a feasible point before giving up


@dataclass(frozen=True, slots=True)
class SearchSpace:
    """Free parameters with their bounds.

    Search coordinates are the natural logarithm for parameters on a log scale (as in the published study) and the value
    itself otherwise.

    Parameters
    ----------
    names
        Names of the d free parameters.
    lower, upper
        Bounds, shape (d,), natural values; both belong to the space.
    log
        Whether a parameter is searched on a log scale, shape (d,).
    feasible
        Returns whether a natural parameter vector, shape (d,), satisfies all constraints.
    integer
        Whether a parameter takes whole numbers only, shape (d,); none does if absent. In search coordinates it moves
        on from half a unit below its lower to half a unit above its upper bound, so that all values are equally
        likely, and is rounded in natural values.
    search_lower, search_upper
        Bounds in search coordinates, shape (d,); calculated.
    """

    names: tuple[str, ...]
    lower: FloatArray
    upper: FloatArray
    log: BoolArray
    feasible: Callable[[FloatArray], bool] = field(repr=False)
    integer: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    search_lower: FloatArray = field(init=False, repr=False)
    search_upper: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.integer.size == 0:
            object.__setattr__(self, "integer", np.zeros(self.dimension, dtype=np.bool_))
        for name, bound in (("lower", self.lower - 0.5 * self.integer), ("upper", self.upper + 0.5 * self.integer)):
            ends = self.to_search(bound)
            ends.setflags(write=False)
            object.__setattr__(self, f"search_{name}", ends)

    @property
    def dimension(self) -> int:
        """Number d of free parameters."""
        return len(self.names)

    def to_search(self, natural: FloatArray) -> FloatArray:
        """Convert natural values, shape (..., d), to search coordinates."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.log, np.log(np.where(self.log, natural, 1.0)), natural)

    def to_natural(self, search: FloatArray) -> FloatArray:
        """Convert search coordinates, shape (..., d), to natural values inside the bounds."""
        natural = np.where(self.log, np.exp(np.where(self.log, search, 0.0)), search)
        natural = np.where(self.integer, np.rint(natural), natural)
        return np.clip(natural, self.lower, self.upper)

    def snapped(self, search: FloatArray) -> FloatArray:
        """Round integer parameters of points in search coordinates, shape (..., d); the others stay as they are."""
        return np.where(self.integer, self.to_search(self.to_natural(search)), search)

    def from_unit(self, unit: FloatArray) -> FloatArray:
        """Convert places between the bounds, shape (..., d), 0 to 1 in search coordinates, to natural values."""
        low = self.search_lower
        return self.to_natural(low + unit * (self.search_upper - low))

    def to_unit(self, natural: FloatArray) -> FloatArray:
        """Convert natural values, shape (..., d), to places between the bounds, cut to 0 to 1."""
        low = self.search_lower
        return np.clip((self.to_search(natural) - low) / (self.search_upper - low), 0.0, 1.0)

    def is_feasible(self, search: FloatArray) -> bool:
        """Return whether a point in search coordinates, shape (d,), satisfies all constraints."""
        return self.feasible(self.to_natural(search))

    def draw(self, random: np.random.Generator, initial: FloatArray | None = None) -> FloatArray:
        """Draw a feasible point uniformly in search coordinates, shape (d,).

        ``initial`` (natural values, nan where not given) fixes some of the coordinates.

        Raises
        ------
        InfeasibleSpaceError
            When a bounded number of draws gives no feasible point.
        """
        lower, upper = self.search_lower, self.search_upper
        given = None if initial is None else self.to_search(initial)
        for _ in range(_DRAWS):
            point = lower + random.random(self.dimension) * (upper - lower)
            if given is not None:
                point = np.where(np.isnan(given), point, given)
            if self.is_feasible(point):
                return point
        raise InfeasibleSpaceError(
            f"no point that satisfies the constraints was found in {_DRAWS} draws inside the bounds of "
            f"{', '.join(self.names)}; widen the bounds or relax the constraints"
        )


def diversity(units: FloatArray) -> float:
    """Root mean square distance of a generation from its centroid, relative to points that fill the box evenly.

    Near 1 for a generation that is scattered over the whole space, 0 where all particles are at one point. The
    parameters count alike: sqrt(12 mean_j(mean_i (u_ij - mean_i u_ij)^2)), as the variance of an even distribution over
    a unit interval is 1/12. At most sqrt(3), half of the particles at either end of every parameter.

    Parameters
    ----------
    units
        Places between the bounds, shape (n, d), 0 to 1 in search coordinates.
    """
    return float(np.sqrt(12.0 * units.var(axis=0).mean()))
