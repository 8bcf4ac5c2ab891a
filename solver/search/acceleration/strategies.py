"""The strategies of an accelerated search, the ways to propose a point, and the patterns in which they take turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = [
    "BEGIN_PATTERN",
    "COVARIANCE",
    "DESCENT_PATTERN",
    "FAR",
    "LATE_BEGIN_PATTERN",
    "LATE_DESCENT_PATTERN",
    "LATE_PATTERN",
    "NEAR",
    "PARTLY",
    "POISE",
    "RESTARTED_PATTERN",
    "SCALAR_PATTERN",
    "STEP",
    "VECTOR_PATTERN",
    "Strategy",
    "Local",
    "Pattern",
    "Plain",
    "Surface",
    "Trust",
    "polish_pattern",
]


@dataclass(frozen=True, slots=True)
class Surface:
    """The lowest new minimum of the surface of the residuals with so much compression, None: without."""

    compression: float | None = None

    def __str__(self) -> str:
        return "surface:plain" if self.compression is None else f"surface:{self.compression:g}"


@dataclass(frozen=True, slots=True)
class Local:
    """A point near a centre, of which 0 is the best run, as far as ``reach``.

    ``around``: lowest minimum of the surface in a box; ``gauss_newton``, ``quadratic``: of a local model.
    """

    model: Literal["around", "gauss_newton", "quadratic"]
    centre: int
    reach: float

    def __str__(self) -> str:
        return f"{self.model}:{self.centre}:{self.reach:g}"


@dataclass(frozen=True, slots=True)
class Trust:
    """The lowest new minimum of a surface inside the trust region, whose half width is taken ``reach`` times."""

    compression: float | None = None
    reach: float = 1

    def __str__(self) -> str:
        compression = "plain" if self.compression is None else f"{self.compression:g}"
        return f"trust:{compression}:{self.reach:g}"


@dataclass(frozen=True, slots=True)
class Plain:
    """An strategy without settings.

    ``valley``: a low point far from all good runs; ``scalar_surface``: of log f; ``covariance``: a move of an evolution
    strategy; ``near`` one of the best; ``far`` from everything; ``partly``: the best with some parameters drawn anew;
    ``step`` to another value of an integer parameter; ``probe``: a point for better slopes, from the best; ``poise``:
    one in a direction that runs in the trust region do not span.
    """

    name: Literal["valley", "scalar_surface", "covariance", "near", "far", "partly", "step", "probe", "poise"]

    def __str__(self) -> str:
        return self.name


Strategy: TypeAlias = Surface | Local | Trust | Plain
"""A way to propose; as text it is what snapshots keep."""
Pattern: TypeAlias = tuple[Strategy, ...]

VALLEY, SCALAR_SURFACE, COVARIANCE = Plain("valley"), Plain("scalar_surface"), Plain("covariance")
NEAR, FAR, PARTLY, STEP = Plain("near"), Plain("far"), Plain("partly"), Plain("step")
PROBE, POISE = Plain("probe"), Plain("poise")

DESCENT_PATTERN: Pattern = (
    Trust(),
    Local("gauss_newton", 0, 1),
    Trust(1),
    Trust(reach=2),
    Surface(1),
    Surface(),
    Trust(reach=0.3),
    Surface(10),
    Trust(10),
    Local("gauss_newton", 1, 1),
    Surface(0.1),
    FAR,
    VALLEY,
    Trust(0.1),
    Local("around", 0, 0.1),
    Local("gauss_newton", 2, 1),
    Trust(reach=4),
    FAR,
    Local("around", 1, 0.1),
)
VECTOR_PATTERN: Pattern = (
    Surface(1),
    Surface(),
    Local("gauss_newton", 0, 1),
    Surface(10),
    Local("gauss_newton", 1, 1),
    Surface(0.1),
    Local("gauss_newton", 2, 1),
    Local("gauss_newton", 0, 0.4),
    FAR,
    Surface(1),
    COVARIANCE,
    Surface(),
)
BEGIN_PATTERN: Pattern = (FAR,)
SCALAR_PATTERN: Pattern = (
    Local("quadratic", 0, 1),
    SCALAR_SURFACE,
    COVARIANCE,
    Local("quadratic", 0, 0.3),
    Local("quadratic", 1, 1),
    SCALAR_SURFACE,
    COVARIANCE,
    COVARIANCE,
    Local("quadratic", 2, 1),
    FAR,
)
RESTARTED_PATTERN: Pattern = (
    Surface(1),
    FAR,
    Local("gauss_newton", 0, 1),
    SCALAR_SURFACE,
    Surface(),
    COVARIANCE,
    Local("gauss_newton", 1, 1),
    FAR,
    Local("quadratic", 0, 1),
    Local("gauss_newton", 2, 1),
    Local("gauss_newton", 0, 0.4),
    COVARIANCE,
)
LATE_PATTERN: Pattern = (
    Local("around", 0, 0.03),
    Surface(10),
    VALLEY,
    Local("around", 1, 0.1),
    Local("around", 0, 0.1),
    Local("around", 1, 0.03),
    Local("gauss_newton", 0, 1),
    Surface(),
    Local("gauss_newton", 0, 0.4),
    Local("around", 2, 0.1),
)
LATE_BEGIN_PATTERN: Pattern = tuple(strategy for late in LATE_PATTERN[:5] for strategy in (FAR, late))
LATE_DESCENT_PATTERN: Pattern = (*DESCENT_PATTERN[:3], *LATE_PATTERN)


def polish_pattern(particles: int) -> Pattern:
    """Strategies of a polishing generation: at most half of it steps of quadratic models, the rest probes."""
    steps = tuple(Local("quadratic", 0, reach) for reach in (1, 0.3, 0.1))[: max(1, particles // 2)]
    return (*steps, *[PROBE] * (particles - len(steps)))
