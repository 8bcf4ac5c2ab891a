"""One generation's candidates: each strategy is a way to find the next point that is worth a forward run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.search.acceleration.covariance import CovarianceMoves
from geoswarm.solver.search.acceleration.knowledge import Knowledge
from geoswarm.solver.search.acceleration.local_models import (
    gauss_newton_point,
    neighbour_distance,
    quadratic_point,
)
from geoswarm.solver.search.acceleration.residual_surface import Components, CubicSurface, ResidualSurface, minimise
from geoswarm.solver.search.acceleration.strategies import Local, Plain, Strategy, Surface, Trust
from geoswarm.solver.search.acceleration.trust_region import TrustRegion, missing_direction

__all__ = ["Strategies"]

_RANDOM_STARTS, _STARTS = 64, 14
_CENTRES, _APART, _SCALAR_APART = 4, 0.25, 0.08
_SURFACE_APART, _LOCAL_APART = 0.02, 1e-5
_NEAR_STARTS, _NEAR_APART = 6, 0.1
_DESCENTS, _DESCENT_STEPS, _FLOOR, _GOOD = 40, 8, 1.5, 4.0  # of a valley; the last two: times the best objective
_TRIES, _ASKED, _STEP_DRAWS = 60, 20, 200
_CONTRACTION, _SHORTEST_PROBE = 0.3, 1e-5
_TAKEN_APART = 0.1  # of half the width of the trust region
_PULLED_BACK = (1.0, 0.7, 0.5, 0.3, 0.1)  # parts of a step that are tried where its end is not admissible


@dataclass
class Strategies:
    """Ways to propose; ``take`` gives the next point of one of them, or None. Points taken are remembered.

    The first ``out`` of them were taken for a generation whose results are not known yet.
    """

    knowledge: Knowledge
    random: np.random.Generator
    covariance: CovarianceMoves | None
    region: TrustRegion = field(default_factory=TrustRegion)
    promised: float | None = None
    taken: list[FloatArray] = field(default_factory=list)
    out: int = 0
    _table: FloatArray = field(init=False, default_factory=lambda: np.empty((0, 1)))
    _minima: dict[float | None, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    _surfaces: dict[float | None, ResidualSurface] = field(default_factory=dict)
    _searched: int = 0
    _probed: int = 0
    _stepped: int = 0
    _steps: dict[tuple[float | None, float], tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    _directions: FloatArray = field(default_factory=lambda: np.empty((0, 0)))

    def __post_init__(self) -> None:
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

    def take(self, strategy: Strategy) -> FloatArray | None:
        """Return the next point of a strategy."""
        point = self._point(strategy)
        if point is not None:
            self.taken.append(point)
        return point

    def _point(self, strategy: Strategy) -> FloatArray | None:
        match strategy:
            case Surface(compression):
                return self._surface_minimum(compression)
            case Local(model, centre, reach):
                return self._local(model, centre, reach)
            case Trust(compression, reach):
                return self._trusted(compression, reach)
            case Plain(name):
                return {
                    "valley": self._along_valley,
                    "scalar_surface": self._scalar_surface,
                    "covariance": self._covariance,
                    "near": self._near_point,
                    "far": self._far_point,
                    "partly": self._partly_new_point,
                    "step": self._other_whole_number,
                    "probe": self._probe,
                    "poise": self._poise,
                }[name]()

    @property
    def unexplained(self) -> float:
        """How much the surface of the residuals leaves unexplained, see :class:`ResidualSurface`."""
        return self._surface(None).unexplained

    def _surface(self, compression: float | None) -> ResidualSurface:
        if compression not in self._surfaces:
            surface = ResidualSurface(self.knowledge.points, self._components, self._scale, compression)
            self._surfaces[compression] = surface
        return self._surfaces[compression]

    def _like(self, run: int) -> tuple[FloatArray, IntArray, int]:
        """Points with the same whole numbers as a run, their indices, and its place among them.

        Local models vary the other parameters alone, as soon as there are d + 2 such runs.
        """
        known = self.knowledge
        same = (known.points == known.points[run])[:, known.integer].all(axis=1)
        rows = np.nonzero(same)[0] if same.sum() >= known.points.shape[1] + 2 else np.arange(len(same))
        return known.points[rows], rows, int(np.nonzero(rows == run)[0][0])

    def _spread_out(self, best: np.ndarray) -> list[int]:
        known, centres = self.knowledge, list[int]()
        # models of an objective alone are good nearby only: with centres far apart more runs are needed
        apart = _SCALAR_APART if known.residuals.shape[1] == 1 else _APART
        for i in best.tolist():
            if all(np.abs(known.points[i] - known.points[j]).max() > apart for j in centres):
                centres.append(i)
            if len(centres) == _CENTRES:
                break
        return centres

    def _new(self, candidate: FloatArray, apart: float, from_taken: float = 0.0) -> FloatArray | None:
        """Return the point that would be evaluated, if it may be and lies apart from all others."""
        known = self.knowledge
        point = known.snapped(candidate)
        if _any_within(known.evaluated, point, apart) or _any_within(
            self._taken_points(), point, max(apart, from_taken)
        ):
            return None
        return point if known.admissible(point) else None

    def _taken_points(self) -> FloatArray:
        """All points taken, shape (t, d); kept as one array, as it is asked for far more often than it grows."""
        if len(self._table) != len(self.taken):
            self._table = np.array(self.taken)
        return self._table

    def _first_new(self, candidates: Iterable[FloatArray], apart: float) -> FloatArray | None:
        return next((p for c in candidates if (p := self._new(c, apart)) is not None), None)

    def _surface_minimum(self, compression: float | None) -> FloatArray | None:
        known = self.knowledge
        if compression not in self._minima:
            surface = self._surface(compression)
            drawn = self.random.random((_RANDOM_STARTS, known.points.shape[1]))
            promising = np.argsort(surface.objective(drawn), kind="stable")[:_STARTS]
            ends, values = minimise(surface, np.concatenate([self._bases, drawn[promising]]))
            order = np.argsort(values, kind="stable")
            self._minima[compression] = ends[order], values[order]
        return self._first_new(self._minima[compression][0], _SURFACE_APART)

    def _along_valley(self) -> FloatArray | None:
        """A low point of the surface that is far from all good runs.

        Short descents from random points end on the floor of a valley before they come to its lowest point.
        """
        known = self.knowledge
        ends, values = minimise(
            self._surface(None), self.random.random((_DESCENTS, known.points.shape[1])), iterations=_DESCENT_STEPS
        )
        low = ends[values <= _FLOOR * max(float(known.objectives[0]), float(values.min()))]
        good = known.points[known.objectives <= _GOOD * known.objectives[0]]
        good = np.concatenate([good, *[p[None] for p in self.taken]])
        return self._first_new(low[np.argsort(-_away_from(good, low), kind="stable")], 0.0)

    def _local(self, kind: str, number: int, reach: float) -> FloatArray | None:
        known = self.knowledge
        if number >= len(self._centres):
            return None
        if kind == "around":
            return self._around(self._centres[number], reach)
        points, rows, centre = self._like(self._centres[number])
        if kind != "quadratic":
            values = self._components.values[rows]
            point = gauss_newton_point(points, values, centre, reach)
        else:
            found = quadratic_point(points, known.objectives[rows], centre, reach)
            if found is None:
                return None
            point = found
        return self._new(point, _LOCAL_APART)

    def _around(self, run: int, reach: float) -> FloatArray | None:
        """The lowest new minimum of the surface in the box that reaches so far to all sides of a run."""
        known = self.knowledge
        middle = known.points[run]
        lower, upper = np.maximum(middle - reach, 0.0), np.minimum(middle + reach, 1.0)
        inside = known.points[(np.abs(known.points - middle) <= reach).all(axis=1)][:_NEAR_STARTS]
        drawn = lower + (upper - lower) * self.random.random((_NEAR_STARTS, middle.size))
        ends, values = minimise(self._surface(None), np.concatenate([inside, drawn]), lower, upper)
        return self._first_new(ends[np.argsort(values, kind="stable")], _NEAR_APART * reach)

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
        nearest = _away_from(self._occupied(), points)
        weight = (0.95, 0.8, 0.5)[self._searched % 3]
        self._searched += 1
        score = weight * (values - values.min()) / max(float(np.ptp(values)), 1e-12)
        score += (1.0 - weight) * (1.0 - nearest / max(float(nearest.max()), 1e-12))
        order = np.argsort(score, kind="stable")[:_TRIES]
        return self._first_new(points[order], 1e-4)

    def _covariance(self) -> FloatArray | None:
        if self.covariance is None:
            d = self.knowledge.points.shape[1]
            mean = self._bases[0] if self.random.random() < 0.5 else np.asarray(self.random.random(d))
            self.covariance = CovarianceMoves.begin(mean, 0.2)
        return self._first_new((self.covariance.ask(self.random) for _ in range(_ASKED)), 0.0)

    @property
    def centre(self) -> int | None:
        """The best run of the descent under way, None before its first success."""
        known = self.knowledge
        mine = np.nonzero(known.open & (known.numbers >= self.region.since))[0]
        return int(mine[0]) if mine.size else None

    @property
    def first(self) -> int:
        """The best run of the descent under way, also in a finished basin."""
        return int(np.argmax(self.knowledge.numbers >= self.region.since))

    def missing(self) -> FloatArray | None:
        """Direction that runs in the trust region do not span, those of this generation included."""
        assert self.centre is not None
        made = np.concatenate([self.knowledge.points, *[p[None] for p in self.taken]])
        return missing_direction(made, self.knowledge.points[self.centre], self.region.radius)

    def promise(self) -> tuple[float, float]:
        """Relative decrease of the objective that the surface promises in the trust region, and the step's length."""
        assert self.centre is not None
        ends, values = self._in_region(None, 1.0)
        at = self.knowledge.points[self.centre]
        now = float(self._surface(None).objective(at[None])[0])
        gain = (now - float(values[0])) / max(now, 1e-300)
        return gain, float(np.abs(ends[0] - at).max())

    def _in_region(self, compression: float | None, reach: float) -> tuple[FloatArray, FloatArray]:
        """Minima of a surface in the box of the trust region, lowest first."""
        key = (compression, reach * self.region.radius)
        if key not in self._steps:
            known = self.knowledge
            assert self.centre is not None
            middle, half = known.points[self.centre], reach * self.region.radius
            lower, upper = np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
            inside = known.points[(np.abs(known.points - middle) <= half).all(axis=1)][:4]
            drawn = lower + (upper - lower) * self.random.random((_NEAR_STARTS, middle.size))
            starts = np.concatenate([middle[None], inside, drawn])
            ends, values = minimise(self._surface(compression), starts, lower, upper)
            order = np.argsort(values, kind="stable")
            self._steps[key] = ends[order], values[order]
        return self._steps[key]

    def step(self, compression: float | None, reach: float) -> FloatArray | None:
        """The lowest new minimum in the trust region, pulled back towards its centre where it is not admissible."""
        if self.centre is None:
            return None
        ends, _ = self._in_region(compression, reach)
        middle = self.knowledge.points[self.centre]
        apart = float(_TAKEN_APART * reach * self.region.radius if self.taken else 0.0)
        parts = (middle + part * (end - middle) for end in ends for part in _PULLED_BACK)
        return next((p for c in parts if (p := self._new(c, _LOCAL_APART, apart)) is not None), None)

    def _trusted(self, compression: float | None, reach: float) -> FloatArray | None:
        point = self.step(compression, reach)
        if point is not None:
            self._note(point)
        return point

    def _note(self, point: FloatArray) -> None:
        """Keep the lowest promise of the steps taken."""
        known = self.knowledge
        assert self.centre is not None
        values = self._surface(None).objective(np.stack([known.points[self.centre], point]))
        promised = float(known.objectives[self.centre] - (values[0] - values[1]))
        self.promised = promised if self.promised is None else min(self.promised, promised)

    def _poise(self) -> FloatArray | None:
        """A point in a direction that the runs in the trust region do not span, towards the lower side."""
        if self.centre is None:
            return None
        direction = self.missing()
        if direction is None:
            return None
        middle, half = self.knowledge.points[self.centre], self.region.radius
        for part in (1.0, 0.5, 0.25):
            ends = np.clip(middle + part * half * np.stack([direction, -direction]), 0.0, 1.0)
            if len(self.knowledge.points) > 1:
                ends = ends[np.argsort(self._surface(None).objective(ends), kind="stable")]
            elif self.random.random() < 0.5:
                ends = ends[::-1]
            far = ends[np.abs(ends - middle).max(axis=1) > 0.3 * part * half]
            point = self._first_new(far, _LOCAL_APART)
            if point is not None:
                return point
        return None

    def _near_point(self) -> FloatArray | None:
        """A point around one of the best, at a random distance of all orders: local models need it."""
        known, random = self.knowledge, self.random
        for _ in range(_TRIES):
            base = self._bases[random.integers(min(3, len(self._bases)))]
            width = 0.15 * 10.0 ** (-1.5 * random.random())
            point = np.asarray(np.clip(base + width * random.standard_normal(known.points.shape[1]), 0.0, 1.0))
            found = self._new(point, _LOCAL_APART)
            if found is not None:
                return found
        return None

    def _other_whole_number(self) -> FloatArray | None:
        """One of the best with another value of one integer parameter, the others where the surface is lowest then.

        Between whole numbers a surface knows nothing, so its minima alone may stay at one value.
        """
        known, random = self.knowledge, self.random
        base = self._bases[self._stepped % min(3, len(self._bases))]
        which = np.nonzero(known.integer)[0]
        changed = int(which[random.integers(which.size)])
        self._stepped += 1
        wide = random.random((_STEP_DRAWS // 2, base.size))
        close = base + 0.1 * random.standard_normal((_STEP_DRAWS // 2, base.size))
        points = np.clip(np.concatenate([wide, close]), 0.0, 1.0)
        points[:, changed] = random.random()
        points = known.snapped(points)
        order = np.argsort(self._surface(1.0).objective(points), kind="stable")[:_TRIES]
        return self._first_new(points[order], _LOCAL_APART)

    def _probe(self) -> FloatArray | None:
        """Go on from the best in a direction of its own: the next slopes there will be better."""
        known, random = self.knowledge, self.random
        d = known.points.shape[1]
        centre = known.points[self._centres[0]]
        if self._probed % d == 0:
            self._directions = np.linalg.qr(random.standard_normal((d, d)))[0]
        direction = self._directions[self._probed % d] * (1.0 if self._probed // d % 2 == 0 else -1.0)
        self._probed += 1
        points, _, middle = self._like(self._centres[0])
        length = _CONTRACTION * max(neighbour_distance(points, middle), _SHORTEST_PROBE)
        ends = (np.clip(centre + sign * length * direction, 0.0, 1.0) for sign in (1.0, -1.0))
        return self._first_new(ends, 0.0)

    def _far_point(self) -> FloatArray | None:
        """The farthest from everything evaluated among random points."""
        points = self.random.random((_TRIES, self.knowledge.points.shape[1]))
        nearest = ((points[:, None, :] - self._occupied()[None]) ** 2).sum(axis=2).min(axis=1)
        return self._first_new(points[np.argsort(-nearest, kind="stable")], 0.0)

    def _partly_new_point(self) -> FloatArray | None:
        """The best of all with some of its parameters drawn anew: other basins often share the rest."""
        best, random = self.knowledge.points[0], self.random
        draws = random.random((_TRIES, best.size))
        kept = random.random((_TRIES, best.size)) < 0.5
        return self._first_new(np.where(kept, best, draws), _SURFACE_APART)

    def _occupied(self) -> FloatArray:
        # the selected points suffice here: what matters is the distance to the known regions
        return np.concatenate([self.knowledge.points, *[p[None] for p in self.taken]])


def _any_within(points: FloatArray, point: FloatArray, apart: float) -> bool:
    """Whether a point, shape (d,), differs from one of others, shape (n, d), by at most ``apart`` in each coordinate.

    One coordinate leaves few of thousands to be looked at.
    """
    if len(points) == 0:
        return False
    left = points[np.abs(points[:, 0] - point[0]) <= apart]
    return bool((np.abs(left - point) <= apart).all(axis=1).any())


def _away_from(known: FloatArray, points: FloatArray) -> FloatArray:
    """How far each point, shape (p, d), is from the nearest known one: the largest difference of a coordinate."""
    return np.asarray(np.abs(points[:, None, :] - known[None]).max(axis=2).min(axis=1))
