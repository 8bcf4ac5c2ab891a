"""The way of a material point along several load paths: its states at times, and where something is first reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.element_test.load_paths import Path, between, share_of

__all__ = ["Sample", "Trace"]


@dataclass(frozen=True)
class Sample:
    """States of a material point: ``rows`` (m, w), stress, strain and state variables; ``load_path`` (m,), 0-based."""

    rows: FloatArray
    load_path: IntArray


@dataclass(frozen=True)
class Trace:
    """Paths of load paths that follow one another; time counts from the beginning of the first, day."""

    paths: Sequence[Path]

    @cached_property
    def _starts(self) -> FloatArray:
        return np.cumsum([0.0, *(path.duration for path in self.paths)])

    @cached_property
    def _step_load_path(self) -> IntArray:
        """Load path of each step, shape (k,)."""
        return np.repeat(np.arange(len(self.paths)), [len(path.places) for path in self.paths])

    @cached_property
    def _steps(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Beginning, middle and end of all steps, each (k, w)."""
        paths = self.paths
        return (
            np.concatenate([path.ends[:-1] for path in paths]),
            np.concatenate([path.middles for path in paths]),
            np.concatenate([path.ends[1:] for path in paths]),
        )

    @property
    def everywhere(self) -> Sample:
        """Ends and middles of all steps after the beginning of the first load path, in their order."""
        _, middles, ends = self._steps
        rows = np.stack([middles, ends], axis=1).reshape(-1, ends.shape[1])
        return Sample(rows, np.repeat(self._step_load_path, 2))

    def ends(self, load_paths: IntArray) -> Sample:
        """States at the ends of some load paths."""
        return Sample(np.array([self.paths[load_path].ends[-1] for load_path in load_paths.tolist()]), load_paths)

    def at_times(self, times: FloatArray) -> Sample:
        """States at times (m,), day; at a change of load paths the end of the earlier one; after the end, the end."""
        durations = np.array([path.duration for path in self.paths])[self._step_load_path]
        places = np.concatenate([path.places for path in self.paths])
        starts = self._starts[self._step_load_path]
        finish = starts + places[:, 1] * durations
        times = np.minimum(times, finish[-1])
        step = np.minimum(np.searchsorted(finish, times, side="left"), finish.size - 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            fraction = np.nan_to_num((times - starts[step]) / durations[step])
        return self._at(step, share_of(places[step], durations[step], fraction))

    def where_first(self, functional: FloatArray, values: FloatArray, load_paths: range | None = None) -> Sample:
        """States where a linear ``functional`` (w,) of the state first has given values (m,).

        From the beginning of the first of ``load_paths`` (consecutive; all unless given) it rises to values above the
        one there, and falls to those below. Where a value is never reached, the state that first comes closest to it.
        """
        chosen = (
            slice(None)
            if load_paths is None
            else slice(*np.searchsorted(self._step_load_path, [load_paths.start, load_paths.stop]))
        )
        first, middle, last = (one[chosen] @ functional for one in self._steps)
        nodes = np.append(first[:1], np.stack([middle, last], axis=1).ravel())
        step, share = np.zeros(values.size, dtype=np.int64), np.zeros(values.size)
        for way in (1.0, -1.0):
            mine = values >= nodes[0] if way > 0.0 else values < nodes[0]
            reached = np.maximum.accumulate(way * nodes)
            node = np.searchsorted(reached, way * values[mine], side="left")
            missed = node == nodes.size
            node[missed] = int(np.argmax(way * nodes))
            step[mine] = inside = np.maximum(node - 1, 0) // 2
            low, mid, high = way * first[inside], way * middle[inside], way * last[inside]
            slope, bend = 4.0 * mid - 3.0 * low - high, 2.0 * (low - 2.0 * mid + high)
            rest = way * values[mine] - low
            with np.errstate(divide="ignore", invalid="ignore"):
                root = 2.0 * rest / (slope + np.sqrt(np.maximum(slope**2 + 4.0 * bend * rest, 0.0)))
            root = np.where(np.isfinite(root), np.clip(root, 0.0, 1.0), 0.0)
            at_node = np.where(node == 0, 0.0, np.where(node % 2 == 1, 0.5, 1.0))
            share[mine] = np.where(missed, at_node, np.minimum(root, at_node))
        return self._at(step + (chosen.start or 0), share)

    def _at(self, step: IntArray, share: FloatArray) -> Sample:
        first, middle, last = self._steps
        return Sample(between(first[step], middle[step], last[step], share), self._step_load_path[step])
