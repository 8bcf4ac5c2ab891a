"""Series of different units that add up without weights: the unit decides which of them count."""

from __future__ import annotations

from collections.abc import Iterator

from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.weighting import weight_shares
from geoswarm.solver.sentences import Sentence, setting
from geoswarm.solver.units import same_unit
from geoswarm.solver.words import listed, per_cent

__all__ = ["unweighted_units"]

_NAMED = 3
_LITTLE = 0.01


def unweighted_units(problem: Problem) -> Iterator[Sentence]:
    """Yield a warning with the shares of the series, where nothing weighs series of different units."""
    base = {info.name: info.y_unit for info in problem.model.series}
    counted = [o for o in problem.observations if o.weight > 0]
    units = list(dict.fromkeys("no unit" if same_unit(base[o.series], "1") else base[o.series] for o in counted))
    if problem.weighting not in (None, "by_count") or len(units) < 2 or len({o.given_weight for o in counted}) > 1:
        return
    shares = sorted((one for one in weight_shares(problem) if one.weight > 0), key=lambda one: -one.share)
    little = sum(one.share < _LITTLE for one in shares)
    named = [f"{one.series} has {per_cent(one.share)}" for one in shares[:_NAMED] if one.share >= _LITTLE]
    if little:
        named.append(f"{little} of {len(shares)} series {'have' if little > 1 else 'has'} less than 1 %")
    yield (
        f"series of different units ({listed(units)}) add up without weights: if each is missed by the same part of "
        f"its range, {listed(named)} of the objective. ",
        setting("weighting", "by_range"),
        " counts every series alike, by_test every test, by_error every reading by its error",
    )
