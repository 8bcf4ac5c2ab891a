"""Observations of a control file as series: one for each instruction file and observation group.

PEST minimises the sum of (w r)^2. The misfit of a series is the mean of w_h r^2: w_h = w^2 and a weight of the series
equal to the number of its points make the objective PEST's own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from geoswarm.solver.external.pest_control.case import PestCase, PestControlError, PestObservation, PestPair
from geoswarm.solver.external.pest_control.names import new_name, word

__all__ = ["PestSeries", "series_of", "told_x"]

MOST = 10_000
"""Observations of a series; a group with more becomes several."""

_KEYED = re.compile(r"(?:^|[_,;])(?P<key>[a-z]\w*?):(?P<number>[+-]?\d+(?:\.\d*)?(?:e[+-]?\d+)?)(?=$|[_,;])")
_NUMBER = r"(?:\d+(?:\.\d*)?e[+-]\d+|\d+\.\d*e\d+|\d+(?:\.\d+)?)"
_NUMBERED = (
    re.compile(rf"(?P<stem>.*?)(?P<number>(?:(?<![^\W_])[+-])?{_NUMBER})"),
    re.compile(rf"(?P<stem>.*?)(?P<number>[+-]?{_NUMBER})"),
)
"""A hyphen behind a letter or a figure separates, as in ``h-1``; it is a sign if other names have none there."""
_KEYS = ("time", "t", "day", "days", "x", "depth", "distance", "dist", "y", "z", "kper", "step")


@dataclass(frozen=True, slots=True)
class PestSeries:
    """A series: the files, the group, its observations with x, and where x comes from, in words."""

    name: str
    files: PestPair
    group: str
    observations: tuple[PestObservation, ...]
    x: tuple[float, ...]
    x_from: str

    @property
    def counts(self) -> bool:
        """Whether an observation has a weight."""
        return any(one.weight for one in self.observations)


def series_of(case: PestCase, read: Mapping[str, Sequence[str]]) -> tuple[list[PestSeries], list[str]]:
    """Return the series, and notes.

    Parameters
    ----------
    read
        Names, in lower case, that each instruction file reads, by its name in the control file.

    Raises
    ------
    PestControlError
        An observation is read by no instruction file, or by two, or is read and not in the control file.
    """
    owner = _owners(case, read)
    found: list[PestSeries] = []
    notes: list[str] = []
    groups: dict[tuple[str, str], list[PestObservation]] = {}
    for one in case.observations:
        groups.setdefault((owner[one.name], one.group), []).append(one)
    several = {group for file, group in groups if any(g == group and f != file for f, g in groups)}
    pairs = {pair.pest: pair for pair in case.instructions}
    for (file, group), observations in groups.items():
        base = word(group)[:60]
        if group in several:
            base = f"{base}_{word(PurePosixPath(file).stem)[:30]}"
        for start in range(0, len(observations), MOST):
            part = observations[start : start + MOST]
            x, x_from = told_x([one.name for one in part])
            order = sorted(range(len(part)), key=x.__getitem__)
            name = new_name(base, {one.name for one in found})
            series = PestSeries(
                name, pairs[file], group, tuple(part[i] for i in order), tuple(x[i] for i in order), x_from
            )
            found.append(series)
            if not series.counts:
                notes.append(f"observation group {group}: all weights are 0; its series {name} is not observed")
        if re.match(r"l_|less|>@|g_|greater|<@", group):
            notes.append(
                f"observation group {group} is an inequality to PEST++, which counts deviations to one side only; here "
                "both sides count"
            )
        elif group.startswith("regul"):
            notes.append(f"observation group {group} is for regularisation in PEST; here it counts by its weights")
    return found, notes


def _owners(case: PestCase, read: Mapping[str, Sequence[str]]) -> dict[str, str]:
    """Instruction file of each observation."""
    known = {one.name for one in case.observations}
    owner: dict[str, str] = {}
    for file, names in read.items():
        for name in names:
            if name in owner:
                raise PestControlError(f"observation {name} is read by {owner[name]} and by {file}; once is accepted")
            if name not in known:
                raise PestControlError(
                    f"{file} reads {name}, which is not in the observation data of {case.path}; add it there, or "
                    "remove it from the instruction file"
                )
            owner[name] = file
    missing = [one.name for one in case.observations if one.name not in owner]
    if missing:
        raise PestControlError(
            f"{len(missing)} observations are read by no instruction file, the first {missing[0]}; "
            f"instruction files: {', '.join(read)}"
        )
    return owner


def told_x(names: Sequence[str]) -> tuple[list[float], str]:
    """Return x of each observation, from their names where that is possible, and in words where it comes from.

    >>> told_x(["h_10", "h_2.5"])
    ([10.0, 2.5], 'the number at the end of the names')
    >>> told_x(["otype:lst_time:1.0", "otype:lst_time:30.5"])
    ([1.0, 30.5], 'time in the names')
    >>> told_x(["north", "south"])
    ([1.0, 2.0], 'the running number, as the names show nothing else')
    """
    if len(names) > 1:
        keyed = [{found["key"]: float(found["number"]) for found in _KEYED.finditer(name)} for name in names]
        for key in _KEYS:
            values = [pairs[key] for pairs in keyed if key in pairs]
            if len(values) == len(names) and _apart(values):
                return values, f"{key} in the names"
        for form in _NUMBERED:
            matches = [end for end in map(form.fullmatch, names) if end is not None]
            numbers = [float(end["number"]) for end in matches]
            if len(matches) == len(names) and len({end["stem"] for end in matches}) == 1 and _apart(numbers):
                return numbers, "the number at the end of the names"
    return [float(number) for number in range(1, len(names) + 1)], (
        "the running number, as the names show nothing else"
    )


def _apart(values: Iterable[float]) -> bool:
    listed = list(values)
    return len(set(listed)) == len(listed) and all(map(math.isfinite, listed))
