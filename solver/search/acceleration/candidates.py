"""One generation's candidates: each arm is a way to find the next point that is worth a forward run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver.arrays import BoolArray, FloatArray
from solver.search.acceleration.covariance import CovarianceMoves
from solver.search.acceleration.local_models import gauss_newton_point, quadratic_point
from solver.search.acceleration.residual_surface import Components, CubicSurface, ResidualSurface, minimise

__all__ = ["Arms", "Knowledge"]

_BEST_POINTS, _SPREAD_POINTS = 100, 40  # that a surface is fitted to
_RANDOM_STARTS, _STARTS = 64, 14
_CENTRES, _APART = 4, 0.08
_SURFACE_APART, _LOCAL_APART = 0.02, 1e-5
_TRIES = 60


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What the arms learn from: successful evaluations, best first, and where nothing new is to be found.

    Parameters
    ----------
    points, objectives
        In the unit box, shape (n, d), and f, shape (n,).
    residuals
        Shape (n, m); m = 1 when only the objective is known.
    open
        Whether a point is in no finished basin, shape (n,).
    evaluated
        All points so far, failed ones included, shape (N, d).
    admissible
        Whether a point of the unit box may be proposed.
    """

    points: FloatArray
    objectives: FloatArray
    residuals: FloatArray
    open: BoolArray
    evaluated: FloatArray
    admissible: Callable[[FloatArray], bool]

    def selected(self) -> Knowledge:
        """Keep the best points and, evenly over the rest, a few that hold a surface down elsewhere."""
        n = len(self.points)
        if n <= _BEST_POINTS + _SPREAD_POINTS:
            return self
        rest = np.linspace(_BEST_POINTS, n - 1, _SPREAD_POINTS).round().astype(int)
        chosen = np.unique(np.concatenate([np.arange(_BEST_POINTS), rest]))
        return Knowledge(
            self.points[chosen],
            self.objectives[chosen],
            self.residuals[chosen],
            self.open[chosen],
            self.evaluated,
            self.admissible,
        )


@dataclass
class Arms:
    """Ways to propose; ``take`` gives the next point of one of them, or None. Points taken are remembered."""

    knowledge: Knowledge
    random: np.random.Generator
    covariance: CovarianceMoves | None
    taken: list[FloatArray] = field(default_factory=list)
    _minima: dict[float | None, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    _searched: int = 0

    def __post_init__(self) -> None:
        self.knowledge = self.knowledge.selected()
        known = self.knowledge
        n, d = known.points.shape
        self._components = Components.of(known.residuals, d)
        level = float(known.objectives[min(n - 1, d + 1)])
        self._scale = max(float(np.sqrt(level / known.residuals.shape[1])), 1e-150)
        # the scalar surfaces need a floor, else the logarithm of a perfect fit rules them
        self._floor = max(1e-3 * level, 1e-300)
        opened = np.nonzero(known.open)[0]
        best = opened if opened.size else np.arange(n)
        self._bases = known.points[best[:8]]
        self._centres = self._spread_out(best)

    def take(self, arm: str) -> FloatArray | None:
        """Return the next point of an arm; d is the number of parameters, e the number of its centre, best first.

        ``surface:s`` the lowest new minimum of the surface with compression s, ``surface:plain`` without;
        ``gauss_newton:e:reach``, ``quadratic:e:reach`` of the local models; ``scalar_surface`` of log f;
        ``covariance``; ``near`` one of the best; ``far`` from everything.
        """
        kind, _, detail = arm.partition(":")
        point: FloatArray | None
        if kind == "surface":
            point = self._surface_minimum(None if detail == "plain" else float(detail))
        elif kind in ("gauss_newton", "quadratic"):
            number, _, reach = detail.partition(":")
            point = self._local(kind, int(number), float(reach))
        elif kind == "scalar_surface":
            point = self._scalar_surface()
        elif kind == "covariance":
            point = self._covariance()
        elif kind == "near":
            point = self._near_point()
        else:
            point = self._far_point()
        if point is not None:
            self.taken.append(point)
        return point

    def _spread_out(self, best: np.ndarray) -> list[int]:
        centres: list[int] = []
        for i in best.tolist():
            away = all(np.abs(self.knowledge.points[i] - self.knowledge.points[j]).max() > _APART for j in centres)
            if away:
                centres.append(i)
            if len(centres) == _CENTRES:
                break
        return centres

    def _new(self, point: FloatArray, apart: float) -> bool:
        known = self.knowledge
        near = [float(np.abs(known.evaluated - point).max(axis=1).min())]
        near += [float(np.abs(other - point).max()) for other in self.taken]
        return min(near) > apart and known.admissible(point)

    def _surface_minimum(self, compression: float | None) -> FloatArray | None:
        known = self.knowledge
        if compression not in self._minima:
            surface = ResidualSurface(known.points, self._components, self._scale, compression)
            drawn = self.random.random((_RANDOM_STARTS, known.points.shape[1]))
            promising = np.argsort(surface.objective(drawn), kind="stable")[:_STARTS]
            ends, values = minimise(surface, np.concatenate([self._bases, drawn[promising]]))
            order = np.argsort(values, kind="stable")
            self._minima[compression] = ends[order], values[order]
        return next((p for p in self._minima[compression][0] if self._new(p, _SURFACE_APART)), None)

    def _local(self, kind: str, number: int, reach: float) -> FloatArray | None:
        known = self.knowledge
        if number >= len(self._centres):
            return None
        centre = self._centres[number]
        if kind == "gauss_newton":
            point = gauss_newton_point(known.points, self._components.values, centre, reach)
        else:
            found = quadratic_point(known.points, known.objectives, centre, reach)
            if found is None:
                return None
            point = found
        return point if self._new(point, _LOCAL_APART) else None

    def _scalar_surface(self) -> FloatArray | None:
        """The best of many random points around the elite, by a surface of log f and by distance to known points."""
        known, random = self.knowledge, self.random
        d = known.points.shape[1]
        surface = CubicSurface(known.points, np.log(known.objectives + self._floor)[:, None])
        elite = self._bases[:4]
        drawn = [random.random((150, d))]
        for width in (0.2, 0.05, 0.01):
            around = elite[random.integers(len(elite), size=150)]
            drawn.append(around + width * random.standard_normal((150, d)))
        points = np.clip(np.concatenate(drawn), 0.0, 1.0)
        values = surface(points)[:, 0]
        nearest = np.abs(points[:, None, :] - self._occupied()[None]).max(axis=2).min(axis=1)
        weight = (0.95, 0.8, 0.5)[self._searched % 3]
        self._searched += 1
        score = weight * (values - values.min()) / max(float(np.ptp(values)), 1e-12)
        score += (1.0 - weight) * (1.0 - nearest / max(float(nearest.max()), 1e-12))
        order = np.argsort(score, kind="stable")[:_TRIES]
        return next((points[i] for i in order if self._new(points[i], 1e-4)), None)

    def _covariance(self) -> FloatArray | None:
        if self.covariance is None:
            d = self.knowledge.points.shape[1]
            mean = self._bases[0] if self.random.random() < 0.5 else np.asarray(self.random.random(d))
            self.covariance = CovarianceMoves.begin(mean, 0.2)
        for _ in range(20):
            point = self.covariance.ask(self.random)
            if self._new(point, 0.0):
                return point
        return None

    def _near_point(self) -> FloatArray | None:
        """A point around one of the best, at a random distance of all orders: local models need it."""
        known, random = self.knowledge, self.random
        for _ in range(_TRIES):
            base = self._bases[random.integers(min(3, len(self._bases)))]
            width = 0.15 * 10.0 ** (-1.5 * random.random())
            point = np.asarray(np.clip(base + width * random.standard_normal(known.points.shape[1]), 0.0, 1.0))
            if self._new(point, _LOCAL_APART):
                return point
        return None

    def _far_point(self) -> FloatArray | None:
        """The farthest from everything evaluated among random points."""
        points = self.random.random((_TRIES, self.knowledge.points.shape[1]))
        nearest = ((points[:, None, :] - self._occupied()[None]) ** 2).sum(axis=2).min(axis=1)
        return next((points[i] for i in np.argsort(-nearest, kind="stable") if self._new(points[i], 0.0)), None)

    def _occupied(self) -> FloatArray:
        # the selected points suffice here: what matters is the distance to the known regions
        return np.concatenate([self.knowledge.points, *[p[None] for p in self.taken]])
